"""Replays of bricks and of particles dealt out by id: the core's policies, run on the log."""

from __future__ import annotations

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes import _core
from motes.balance import Diffusive, Pairwise, Proportional, Static
from motes.replay.bricks import Cloud, Tree

BRICKS = """
import sys
import motes
from motes import balance, shapes

class Rising(balance.Balancer):
    def decide(self, load):
        return balance.Targets([1.0 + c for c in range(len(load))])

log, axis = sys.argv[1], None if sys.argv[2] == "none" else sys.argv[2]
for name in ("Static", "Proportional", "Rising"):
    fixed = balance.Proportional([5, 1, 2, 4, 3])
    settings = dict(balancer={"Static": None, "Rising": Rising()}.get(name, fixed), log=f"{log}/{name}")
    world = motes.World(seed=1, space=(-3, 3), axis=axis, roles="shared", progress="off", **settings)
    drops = world.system("drops")
    with world:
        for frame in world.frames(10):
            drops.configure(velocity=motes.Normal((2, 0, 0), (6, 3, 3)))
            drops.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=24 * 2000)
            drops.gravity((0, -9.81, 0))
            drops.kill_old(0.4)
            drops.move()
            world.step()
"""


class Rising(motes.balance.Balancer):
    """A user-defined balancer that gives each calculator more than the one before."""

    def decide(self, load: motes.balance.LoadTable) -> motes.balance.Targets:
        return motes.balance.Targets([1.0 + c for c in range(len(load))])


SHARES: dict[str, motes.balance.Balancer] = {
    "Static": Static(),
    "Proportional": Proportional([5, 1, 2, 4, 3]),
    "Rising": Rising(),
}


@pytest.fixture(scope="module", params=["xz", "xyz", "none"])
def bricks(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[str, motes.Run]:
    """Return runs on five ranks, in bricks or by id, with balancers that ignore measured times."""
    log = tmp_path_factory.mktemp("bricks")
    on_ranks(5, BRICKS, log, request.param, timeout=60)
    return {name: motes.open_run(log / name) for name in SHARES}


def counts_of(run: motes.Run) -> np.ndarray:
    return run.load.pivot(index="frame", columns="rank", values="n_end").to_numpy(float)


def test_a_replay_of_bricks_that_stay_is_the_run(bricks: dict[str, motes.Run]) -> None:
    run = bricks["Static"]
    again = run.replay(Static())
    np.testing.assert_array_equal(counts_of(again), counts_of(run))
    ends = [name for name in run.load if name.startswith("domain_")]
    np.testing.assert_allclose(again.load[ends], run.load[ends], rtol=1e-6)
    np.testing.assert_array_equal(again.frames["exchanged"], run.frames["exchanged"])
    busy = run.load["n_start"] + run.load["created"] > 0  # times of idle calculators do not count
    np.testing.assert_allclose(again.load["t_compute_s"][busy], run.load["t_compute_s"][busy], rtol=1e-6)


@pytest.mark.parametrize("recorded", SHARES)
@pytest.mark.parametrize("name", SHARES)
def test_a_replay_of_bricks_predicts_the_run(bricks: dict[str, motes.Run], recorded: str, name: str) -> None:
    real, predicted = bricks[name], bricks[recorded].replay(SHARES[name])
    off = np.abs(counts_of(predicted) - counts_of(real))[3:] / real.frames["particles"].to_numpy()[3:, None]
    assert off.max() < (0.02 if recorded == name else 0.08), "of all particles"
    np.testing.assert_array_equal(predicted.frames["particles"], real.frames["particles"])
    assert list(predicted.density.columns) == list(real.density.columns)
    table = predicted.density
    for axis in ("x", *real.axis("drops")[1:]) if real.axis("drops") != "id" else ("x",):
        places = table[[f"{axis}_q{q:02d}" for q in range(17)]].to_numpy()
        assert (np.diff(places[table["n"] > 0], axis=1) >= 0).all()
    again = predicted.replay(Static())
    assert len(again.frames) == len(real.frames), "a replay can be replayed"


def test_policies_of_the_core_divide_them_by_given_powers(bricks: dict[str, motes.Run]) -> None:
    run = bricks["Static"]
    machine = [4.0, 1.0, 1.0, 2.0, 2.0]
    predicted = run.replay(Proportional(machine))
    last = counts_of(predicted)[-1]
    np.testing.assert_allclose(last / last.sum(), np.array(machine) / sum(machine), atol=0.05)
    axis = run.axis("drops")
    assert set(predicted.balance["axis"].dropna()) <= ({"id"} if axis == "id" else set(axis))


def test_what_bricks_cannot_do_is_refused(bricks: dict[str, motes.Run]) -> None:
    run = bricks["Static"]
    for balancer in (Pairwise(), Diffusive(), Diffusive(manager=False)):
        with pytest.raises(motes.ArgumentError, match=r"domains of 'drops' are not slabs"):
            run.replay(balancer)
    if run.axis("drops") == "id":
        return
    narrow = [name for name in run.density if not name.startswith("z_q")]
    bare = motes.Run(run.facts, {"load": run.load, "frames": run.frames, "density": run.density[narrow]})
    with pytest.raises(motes.LogError, match="quantiles along"):
        bare.replay(Static())


@pytest.mark.parametrize("count", range(1, 10))
def test_a_tree_is_found_from_its_domains(count: int) -> None:
    random = np.random.default_rng(count)

    def divide(count: int, low: np.ndarray, high: np.ndarray) -> list[tuple[int, float]]:
        if count < 2:
            return []
        axis = int(random.integers(3))
        at = np.float32(low[axis] + (high[axis] - low[axis]) * random.uniform(0.1, 0.9))
        below, above = high.copy(), low.copy()
        below[axis] = above[axis] = at
        left, right = divide(count // 2, low, below), divide(count - count // 2, above, high)
        return [*left, (axis, float(at)), *right]

    cuts = divide(count, np.full(3, -8.0), np.full(3, 8.0))
    tree = Tree([axis for axis, _ in cuts], [at for _, at in cuts])
    again = Tree.of_boxes(*tree.boxes())
    assert again.axes == tree.axes
    np.testing.assert_array_equal(again.at, tree.at)


def test_a_cloud_divides_its_particles() -> None:
    random = np.random.default_rng(3)
    places = random.normal(0, [2, 1, 0.5], (20_000, 3)).astype(np.float32)
    tree = Tree([2, 0, 2], [0.1, -0.3, -0.2])
    low, high = tree.boxes()
    here = [((places >= a) & (places < b)).all(axis=1) for a, b in zip(low, high, strict=True)]
    quantiles = np.array([[_core.quantiles(places[one, axis], 16) for axis in (0, 2)] for one in here], float)
    cloud = Cloud.of_quantiles(quantiles, [one.sum() for one in here], [0, 2])
    np.testing.assert_array_equal(cloud.domains(tree), [one.sum() for one in here])
    other = Tree([0, 2, 0], [-1.0, 0.0, 1.0])
    found = cloud.domains(other)
    real = [((places >= a) & (places < b)).all(axis=1).sum() for a, b in zip(*other.boxes(), strict=True)]
    np.testing.assert_allclose(found, real, atol=0.02 * len(places))
    mine, theirs, n = cloud.overlaps(tree, other)
    np.testing.assert_allclose(np.bincount(mine, n), cloud.domains(tree), atol=1)
    np.testing.assert_allclose(np.bincount(theirs, n), found, atol=1)
    after = cloud.divided(np.ones(4), np.array([1.0, 1.0, 1.0, 2.0]), tree)
    np.testing.assert_allclose(cloud.domains(after), [4000, 4000, 4000, 8000], atol=2)
