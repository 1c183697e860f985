"""Domains as a script sees them: slabs, bricks, parts of the ids, and systems that share domains."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from standing import alike, on_ranks

import motes
from motes import balance
from motes.errors import ArgumentError

SCRIPT = """
import sys
import numpy as np
import motes
from motes.shapes import Box

class Orders(motes.balance.Balancer):
    def decide(self, load):
        return motes.balance.Orders([(0, 1, 10)])

world = motes.World(seed=4, progress="off", {options})
{systems}
with world:
    for frame in world.frames(6):
        for s in world.systems:
            s.configure(velocity=Box((-3, -2, -4), (3, 4, 2)))
            s.source(Box((-2, -1, -2), (2, 0, 2)), rate=24000)
            s.move()
        world.step()
    digest = world.digest()
    if world.rank == 0:
        for s in world.systems:
            print(s.name, s.cuts.tolist())
        print(digest)
"""


def lines(size: int, options: str, systems: str = "a = world.system('a')") -> list[str]:
    """Run the script on `size` ranks and return the lines that it prints."""
    return on_ranks(size, SCRIPT.format(options=options, systems=systems)).lines


@pytest.mark.parametrize("axis", ["", "xx", "w", "xyzz", "X", 0, ["x"], True, "x y", "id"])
def test_an_axis_that_is_none(axis: Any):
    for call in (lambda: motes.World(axis=axis), lambda: motes.World().system("a", axis=axis)):
        with pytest.raises(ArgumentError, match=r"axis must be 'x', 'y', 'z', 'xy', .* or None, got"):
            call()


@pytest.mark.parametrize("axis", ["xy", "zyx", None])
@pytest.mark.parametrize("balancer", [balance.Pairwise(), balance.Diffusive()])
def test_balancers_that_need_slabs(axis: str | None, balancer: balance.Balancer):
    with pytest.raises(ArgumentError, match=r"balancer must be Static, PrefixCuts, Proportional, .*axis="):
        motes.World(axis=axis, balancer=balancer)
    world = motes.World(balancer=balancer)
    with pytest.raises(ArgumentError, match=r"balancer must be Static"):
        world.system("a", axis=axis)
    world.system("a", axis="z")


def test_the_axes_are_a_set():
    world = motes.World(axis="zx")
    assert world.system("a").axis == "xz"
    assert world.system("b", axis=None).axis is None
    assert world.system("c", axis="y").axis == "y"
    assert world.system("d", axis="world").axis == "xz"


def test_who_shares_domains_cuts_the_same():
    world = motes.World(axis="x", space=(0, 1))
    sand = world.system("sand", axis="yz", space="fit")
    water = world.system("water", domains_of=sand)
    assert water.axis == "yz"
    world.system("oil", domains_of=water, axis="zy", space="fit")
    with pytest.raises(ArgumentError, match="axis must be 'yz', that of 'sand', whose domains it shares"):
        world.system("air", domains_of=water, axis="x")
    with pytest.raises(ArgumentError, match="space must be 'fit', that of 'sand'"):
        world.system("air", domains_of=sand, space=(0, 1))
    for other in (motes.World().system("sand"), "sand", 0):
        with pytest.raises(ArgumentError, match="domains_of must be None or an earlier system of this world"):
            world.system("air", domains_of=other)  # type: ignore[arg-type]


def test_cuts_of_bricks_name_their_axes():
    with motes.World(axis="xy", progress="off") as world:
        system = world.system("a")
        assert system.cuts.dtype.names == ("axis", "at") and system.cuts.shape == (0,)
        assert world.system("b", axis=None).cuts.dtype == np.float32


def test_equal_bricks():
    told = lines(6, "axis='xz', space=(-2, 2), roles='shared'")
    # Three of six domains are below x = 0: one of them below z = -2/3, and z divides the other two again.
    assert told[0].startswith("a [('z', -0.66")
    assert [word for word in told[0] if word in "xz"] == ["z", "z", "x", "z", "z"]


@pytest.mark.parametrize("axis", ["x", "xy", "xyz", None])
def test_shares_are_kept(tmp_path: Path, axis: str | None):
    log = tmp_path / "log"
    options = (
        f"axis={axis!r}, roles='shared', balancer=motes.balance.Proportional([1, 2, 3]), log={str(log)!r}"
    )
    lines(3, options)
    run = motes.open_run(log)
    last = run.load[run.load["frame"] == 5].sort_values("rank")
    assert np.allclose(last["n_end"] / last["n_end"].sum() * 6, [1, 2, 3], rtol=0.1)
    names = {"x": "x", "xy": "xy", "xyz": "xyz", None: "id"}
    assert run.axis("a") == names[axis]
    assert set(run.balance["axis"]) <= set("xyz") | {"id"} and len(run.balance)
    has = {name for name in run.load if name.startswith("domain_")}
    assert len(run.replay(balance.PrefixCuts()).load) == len(run.load)
    others = {"domain_y_lo", "domain_y_hi"} if "y" in names[axis] else set()  # two cuts: across x and y
    assert {name for name in has if run.load[name].notna().any()} == {"domain_lo", "domain_hi"} | others


def test_orders_are_for_slabs():
    script = SCRIPT.format(options="axis='xy', balancer=Orders()", systems="a = world.system('a')")
    failed = on_ranks(4, script)
    assert failed.code != 0
    assert "a plan must be shares where domains are not slabs" in failed.err


@pytest.mark.parametrize("axis", ["x", "zx", None])
@pytest.mark.parametrize("combine", ["together", "one_by_one", "overlapped"])
def test_shared_domains_stay_the_same(axis: str | None, combine: str):
    systems = "a = world.system('a')\nb = world.system('b', axis='y')\nc = world.system('c', domains_of=a)"
    balancer = "motes.balance.PrefixCuts(0.001, min_particles=1)"
    options = f"axis={axis!r}, combine={combine!r}, roles='shared', space='fit', balancer={balancer}"
    told = lines(3, options, systems)
    cuts = {line.split(" ", 1)[0]: line.split(" ", 1)[1] for line in told[:3]}
    assert cuts["a"] == cuts["c"] != cuts["b"]
    assert told[3] == lines(1, options, systems)[3]


@pytest.mark.parametrize(("combine", "ranks"), [("overlapped", 3), ("overlapped", 5), ("one_by_one", 3)])
def test_births_of_a_later_system_may_fit_domains_of_one_that_meets(combine, ranks):
    """The manager is also a calculator: it must not use new cuts before the other ranks know them."""
    script = f"""
import motes
from motes.shapes import Sphere

world = motes.World(seed=1, combine="{combine}", roles="shared", space="fit", progress="off")
first = world.system("first")
second = world.system("second", domains_of=first)
with world:
    for frame in world.frames(3):
        second.burst((0.5, 2.5, 1.4))
        if frame > 0:
            first.burst(Sphere((0, 2.5, 1), 1), count=200)
        first.collide(0.05)
        first.move()
        second.move()
        world.step()
    world.say(world.digest())
"""
    alike(script, ranks=(1, ranks))
