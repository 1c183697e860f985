"""Replays and savings against exact runs: virtual clusters, whose clocks have no noise."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import motes
from motes.balance import Balancer, Diffusive, Pairwise, PrefixCuts, Static
from motes_lab.cluster import Cluster, FastEthernet, Modern, Network, Node, simulate
from motes_lab.cluster.simulate import record

LOADS = Path(__file__).parents[2] / "docs" / "lab" / "scripts" / "replay_loads.py"
NODES = [Node("fast", cores=2, count=2), Node("slow", 0.6, cores=2, count=1)]
POLICIES = {type(one).__name__: one for one in (Static(), Pairwise(), Diffusive(), PrefixCuts())}
SKIP = 10  # first frames, in which speeds are learned

Runs = Callable[[str, str], motes.Run]


@pytest.fixture(scope="module")
def runs(simulated_replay: Path, tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """Return a function that simulates a load ("drift", "jet", ...) under a policy."""
    folder = tmp_path_factory.mktemp("exact")

    @cache
    def scene(load: str) -> Path:
        record(folder / f"{load}.motes", LOADS, [load])
        return folder / f"{load}.motes"

    @cache
    def run(load: str, policy: str) -> motes.Run:
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
            return simulate(
                scene(load),
                Cluster(NODES, Modern()),
                log=folder / f"{load}-{policy}",
                balancer=POLICIES[policy],
                scale=1000.0,
            )

    return run


def mean_frame_s(run: motes.Run, first: int = SKIP) -> float:
    ends = run.times.pivot(index="frame", columns="rank", values="wall_s").cumsum().max(axis=1)
    return float((ends.iloc[-1] - ends.loc[first - 1]) / (len(ends) - first))


def later(run: motes.Run, column: str) -> float:
    return float(run.frames.loc[run.frames["frame"] >= SKIP, column].mean())


@pytest.mark.parametrize("recorded", ["Static", "PrefixCuts"])
@pytest.mark.parametrize("load", ["drift", "jet"])
def test_a_replay_is_within_a_tenth_of_the_exact_run(runs: Runs, load: str, recorded: str) -> None:
    """Moving particles and looking for cuts costs more here than balance gains, so both must be known."""
    log = runs(load, recorded)
    for name, policy in POLICIES.items():
        real, guess = runs(load, name), log.replay(policy)
        assert later(guess, "t_frame_s") == pytest.approx(mean_frame_s(real), rel=0.1), name
        assert later(guess, "exchanged") == pytest.approx(later(real, "exchanged"), rel=0.2), name
        low, high = (later(guess, f"t_frame_{end}_s") for end in ("low", "high"))
        assert low <= mean_frame_s(real) <= high, name


def test_replays_frames_add_up_to_the_run(runs: Runs) -> None:
    log = runs("jet", "Static")
    ends = log.times.groupby("rank")["wall_s"].sum().max()
    assert log.replay(Static()).frames["t_frame_s"].sum() == pytest.approx(ends, rel=1e-6)


def test_explain_says_where_balancing_loses(runs: Runs) -> None:
    log = runs("drift", "Static")
    told = log.explain()
    best = min(mean_frame_s(runs("drift", name)) for name in POLICIES if name != "Static")
    true = 1 - best / mean_frame_s(log)
    assert true < -0.05, "the case is one in which balancing loses"
    assert told.saving == pytest.approx(true, abs=0.05)
    assert told.low <= true <= told.high
    assert "balancing would lose here" in str(told)


STILL = """
import motes
from motes.shapes import Box, Sphere

world = motes.World(seed=1, space=(-8, 8), progress="off")
system = world.system("particles")
with world:
    for frame in world.frames(40):
        if frame == 0:
            system.burst(Box((-8, -1, -1), (8, 1, 1)), count=8000)
        system.random_acceleration(Sphere((0, 0, 0), 0.01))
        world.step()
"""


@pytest.mark.parametrize(("slow", "network"), [(0.25, Modern()), (0.5, FastEthernet())])
def test_saving_knows_the_speeds_of_machines(
    slow: float, network: Network, simulated_replay: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two calculators: mean seconds would promise 38 and 25 %; particles / sum of speeds is 60 and 33 %."""
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    (tmp_path / "scene.py").write_text(STILL)
    record(tmp_path / "scene.motes", tmp_path / "scene.py")
    cluster = Cluster([Node("fast", count=3), Node("slow", slow)], network)

    def run(balancer: Balancer) -> motes.Run:
        log = tmp_path / type(balancer).__name__
        return simulate(tmp_path / "scene.motes", cluster, log=log, balancer=balancer, scale=1000.0)

    log = run(Static())
    told = log.explain()
    best = run(getattr(motes.balance, told.balancer)())
    true = 1 - mean_frame_s(best) / mean_frame_s(log)
    assert true == pytest.approx(1 - 2 * slow / (1 + slow), abs=0.03)
    assert told.saving == pytest.approx(true, abs=0.03)
    assert told.low <= true <= told.high
    assert f"{told.balancer} would save {round(100 * told.saving)} % (" in str(told)
    assert "of a run as short as this one" in str(told), (
        "in 40 frames, moving particles costs half of it or more"
    )


def test_a_log_tells_what_moving_particles_costs(runs: Runs) -> None:
    """Costs of measured.costs, also where nobody migrates or looks for cuts: 30, 20 and 2 ns, 1000-fold."""
    for load, policy in (("step", "Static"), ("drift", "PrefixCuts")):
        last = runs(load, policy).load.groupby("rank").last()
        for column, nanoseconds in (("pack_each_s", 30), ("unpack_each_s", 20), ("search_each_s", 2)):
            found = last[column].to_numpy()
            wanted = 1e-6 * nanoseconds / np.array([1, 1, 0.6, 0.6])
            np.testing.assert_allclose(found, wanted, rtol=0.02, err_msg=f"{load}: {column}")
        assert last["migrant_bytes"].between(28, 40).all()
    links = runs("step", "Static").links
    apart = links[(links["rank"] == 3) & (links["other"] == 4)]
    assert apart["message_s"].item() == pytest.approx(1.5e-6, rel=0.1)
    assert apart["byte_s"].item() == pytest.approx(8 / 200e9, rel=0.4)
    together = links[(links["rank"] == 4) & (links["other"] == 5)]
    assert together["byte_s"].item() == pytest.approx(1 / 400e6, rel=0.1)


def test_a_log_tells_how_far_particles_move(runs: Runs) -> None:
    density = runs("wave", "Static").density
    ways = density[density["frame"] > 0][[f"way_q{k}" for k in range(8)]].to_numpy()
    assert set(np.unique(ways[~np.isnan(ways)])) == {16.0, 16.0 - 400}, "16 cells a frame, on a ring of 400"
