"""Domains along a Hilbert or Morton curve: the same bits, and what logs record about the domains."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes import balance
from motes.analysis.view import View
from motes.errors import ArgumentError

GRAINS = """
import motes
from motes import balance
from motes.shapes import Box, Sphere

WAYS = [
    dict(axis="hilbert", space=(-2, 2), balancer=balance.Pairwise(0.01, min_particles=1)),
    dict(axis="morton", space=(-1, 1.5), balancer=balance.PrefixCuts(0.01, min_particles=1)),
    dict(axis="hilbert", space=(-2, 2), births="calculators",
         balancer=balance.Diffusive(0.01, manager=False, min_particles=1)),
]
ENDS = [{}, {"y": (-2, 2)}, dict.fromkeys("xyz", (-2.0, 2.0))]
for periodic in ENDS:
    for way in WAYS:
        world = motes.World(seed=4, dt=1 / 48, periodic=periodic, roles="shared", progress="off", **way)
        grains = world.system("grains")
        dust = world.system("dust", domains_of=grains)
        with world:
            for frame in world.frames(8):
                grains.configure(velocity=Box((-3, -2, -4), (3, 4, 2)), size=(0.25,) * 3)
                grains.source(Box((-1.8, -1, -2.5), (2, 0, 2)), rate=48 * 25)
                grains.spawn(dust, on="death", count=2)
                grains.contact(200, friction=0.4)
                grains.match_velocity(0.3, max_radius=0.4)
                grains.kill_old(0.12)
                grains.move()
                dust.gravitate(0.01, 0.1, max_radius=0.5)
                dust.move()
                world.step()
            digest = world.digest()
            if world.rank == 0:
                print(digest, [s.count for s in world.systems], flush=True)
"""


def test_curves_change_no_bit():
    alone = on_ranks(1, GRAINS)
    assert alone.code == 0, alone.text
    digests = [line.split()[0] for line in alone.lines]
    assert len(set(digests)) == 3, "one for each kind of space"
    for ranks in (2, 3, 5):
        assert on_ranks(ranks, GRAINS).lines == alone.lines, ranks


def test_a_curve_needs_space_with_ends():
    for space in (None, "fit"):
        world = motes.World(axis="hilbert", space=space)
        with pytest.raises(ArgumentError, match=r"space must be \(low, high\), m, for axis='hilbert'"):
            world.system("a")
        world.system("b", space=(0, 1))
        world.system("c", axis="x")
    with pytest.raises(ArgumentError, match=r"space must be .*axis='morton'"):
        motes.World(periodic={"x": (0, 1), "y": (0, 1)}).system("a", axis="morton")
    motes.World(periodic=dict.fromkeys("xyz", (0, 1))).system("a", axis="morton")
    with pytest.raises(ArgumentError, match="'xyz', 'hilbert', 'morton' or None, got 'hilbret'.*'hilbert'"):
        motes.World(axis="hilbret")  # type: ignore[arg-type]


RUN = """
import sys
import motes
from motes import balance, shapes

for name, balancer in {"Static": None, "PrefixCuts": balance.PrefixCuts(0.02),
                       "Proportional": balance.Proportional([3, 1, 2])}.items():
    world = motes.World(seed=1, space=(-3, 3), axis="hilbert", roles="shared", progress="off",
                        balancer=balancer, log=f"{sys.argv[1]}/{name}")
    drops = world.system("drops")
    with world:
        for frame in world.frames(10):
            drops.configure(velocity=motes.Normal((2, 0, 0), (6, 3, 3)))
            drops.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=24 * 1000)
            drops.gravity((0, -9.81, 0))
            drops.kill_old(0.4)
            drops.move()
            world.step()
        assert drops.axis == "hilbert" and drops.cuts.shape == (2,)
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, motes.Run]:
    """Return runs on three ranks with domains along a curve."""
    log = tmp_path_factory.mktemp("curves")
    ended = on_ranks(3, RUN, log)
    assert ended.code == 0, ended.text
    return {name: motes.open_run(log / name) for name in ("Static", "PrefixCuts", "Proportional")}


def counts_of(run: Any) -> np.ndarray:
    return run.load.pivot(index="frame", columns="rank", values="n_end").to_numpy(float)


def test_logs_tell_places_along_the_curve(runs: dict[str, motes.Run]):
    run = runs["Proportional"]
    assert run.axis("drops") == "hilbert" and set(run.balance["axis"]) == {"hilbert"}
    last = counts_of(run)[-1]
    np.testing.assert_allclose(last / last.sum(), [3 / 6, 1 / 6, 2 / 6], atol=0.05)
    ends = run.load.pivot(index="frame", columns="rank", values="domain_hi").to_numpy()
    assert ((ends[:, :2] > 0) & (ends[:, :2] < 1)).all() and np.isnan(ends[:, 2]).all()
    places = run.density[[f"x_q{q:02d}" for q in range(17)]].to_numpy()
    assert ((places >= 0) & (places < 1)).all() and (np.diff(places, axis=1) >= 0).all()
    assert run.summary()["moved_to_balance"] > 0


def test_replays_move_cuts_along_the_curve(runs: dict[str, motes.Run]):
    run = runs["Static"]
    np.testing.assert_array_equal(counts_of(run.replay(balance.Static())), counts_of(run))
    predicted = counts_of(run.replay(balance.Proportional([3, 1, 2])))
    real = counts_of(runs["Proportional"])
    assert (np.abs(predicted - real)[3:] / real[3:].sum(axis=1, keepdims=True)).max() < 0.08
    for balancer in (balance.Pairwise(), balance.Diffusive(), balance.Greedy(), balance.CostAware()):
        assert len(run.replay(balancer).frames) == 10


def test_curves_are_plotted_and_watched(runs: dict[str, motes.Run]):
    run = runs["PrefixCuts"]
    axes = run.plot.domains()
    assert "position along the Hilbert curve" in axes.get_ylabel()
    low, high = axes.get_ylim()
    assert low > -0.5 and high < 1.5
    moved = run.plot.given().figure.axes[1]
    assert moved.get_ylabel() == "moved to the right (fraction of the Hilbert curve)"
    shown = View(run.path, run.facts)
    shown.read()
    lines = shown.lines(80, plain=True)
    at = next(i for i, line in enumerate(lines) if "domains of drops" in line)
    assert [name for name in lines[at - 1] if name in "012|"] == ["0", "|", "1", "|", "2"]
    assert lines[at].startswith("0 ") and lines[at].endswith(" 1")
