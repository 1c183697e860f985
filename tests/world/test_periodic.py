"""Periodic space: positions wrap, particles interact across it, and bits depend on no rank or domain."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from launching import mpirun, python, said
from same_bits import table
from standing import alike, on_ranks

import motes
from motes import expressions as ex
from motes.errors import ArgumentError
from motes.shapes import Box

SCENE = Path(__file__).parents[1] / "scenes" / "periodic.py"
BOX = {"x": (0, 10), "z": (-2.5, 2.5)}


def world_of(**arguments: Any) -> motes.World:
    """Make a world with periodic space BOX and no progress output."""
    return motes.World(**{"seed": 1, "periodic": BOX, "progress": "off", **arguments})


# --- wrapping


def flown(substeps: int) -> tuple[motes.Particles, motes.Particles, Any]:
    """Return particles after 20 frames of straight flight, wrapped and unwrapped, and exact positions."""
    dice = np.random.default_rng(4)
    start = np.float32(dice.uniform(-30, 30, (500, 3)))
    velocity = np.float32(dice.uniform(-40, 40, (500, 3)))
    world = world_of(substeps=substeps, dt=0.125)
    s = world.system("s")
    with world:
        for frame in world.frames(20):
            if frame == 0:
                s.emit(position=start, velocity=velocity)
            s.move()
            world.step()
        wrapped, whole = s.gather(), s.gather(unwrapped=True)
    return wrapped, whole, start + 20 * 0.125 * velocity.astype(float)


@pytest.mark.parametrize("substeps", [1, 4])
def test_unwrapped_particles_fly_straight(substeps):
    wrapped, whole, wanted = flown(substeps)
    assert whole.position.dtype == np.float64 and "crossings" not in dir(whole)
    assert (np.abs(whole.position - wanted).max(axis=0) < (3e-5, 1e-3, 3e-5)).all()
    for axis, (low, high) in ((0, BOX["x"]), (2, BOX["z"])):
        assert ((wrapped.position[:, axis] >= low) & (wrapped.position[:, axis] < high)).all()
        assert np.abs(wrapped.crossings[:, axis]).max() > 10
    assert (wrapped.crossings[:, 1] == 0).all()
    assert np.abs(wrapped.position[:, 1]).max() > 50, "y is not periodic"


EVERYWHERE = """
import sys
import numpy as np
import motes
from motes import shapes
from motes.expressions import column

def far(p):
    p.position[:] += np.float32(100.25)

world = motes.World(seed=3, periodic={"x": (-1, 2), "y": (0, 0.5)}, axis="x", substeps=2, progress="off",
                    births=sys.argv[1])
s, children = world.system("s"), world.system("children")

def check(when):
    for system in (s, children):
        inside = (column("position").x >= -1) & (column("position").x < 2)
        inside &= (column("position").y >= 0) & (column("position").y < 0.5)
        assert system.total(1, where=inside) == system.total(1), when

with world:
    for frame in world.frames(4):
        s.configure(velocity=shapes.Sphere((0, 0, 0), 20))
        before = shapes.Sphere((0, 7, 0), 4)
        s.source(shapes.Sphere((0.5, 0, 0), 4), rate=2400, jitter=True, moving_from=before)
        s.burst(shapes.Box((-9, -9, -9), (9, 9, 9)), count=100)
        s.emit(position=[(2, 0.5, 1), (-1, 0, 0), (1e9, -1e9, 0)])
        s.spawn(into=children, on="birth", count=2)
        s.move(where=column("velocity").x > 0)
        s.callback(far, where=column("age") == 0)
        s.set(position=column("position") * (3, -2, 1))
        s.kill_old(0.1)
        if frame == 2:
            s.callback(far)
        world.step()
        check("a frame")
        with s.local() as p:
            p.position[:, :2] -= np.float32(7.5)
        check("local")
        digest = world.digest()
        print(digest, s.count, children.count) if "manager" in world.role else None
"""


def test_positions_are_inside_wherever_they_come_from():
    manager, calculators = (alike(EVERYWHERE, births) for births in ("manager", "calculators"))
    assert manager == calculators
    assert len(set(manager)) == 4


def test_the_newborn_are_inside_before_they_move():
    world = world_of()
    still, jittered = world.system("still"), world.system("jittered")
    with world:
        still.source(Box((-30, 0, -30), (30, 1, 30)), 2400)
        jittered.configure(velocity=(300, 0, 90))
        jittered.source(Box((3, 0, -1), (7, 1, 1)), 2400, jitter=True)
        world.step()
        for system in world.systems:
            x, _, z = system.gather().position.T
            assert len(x) > 50 and (x >= 0).all() and (x < 10).all() and (z >= -2.5).all() and (z < 2.5).all()


def test_what_is_nowhere_stays_there():
    world = world_of()
    s = world.system("s")
    with world:
        s.burst((0, 0, 0), count=4)
        with s.local() as p:
            p.position[:] = [(np.inf, 0, 0), (np.nan, 0, np.nan), (3e37, 0, -3e37), (-0.0, 0, 2.5)]
        world.step()
        position = s.gather().position
        wrapped = s.gather(unwrapped=True).position
    assert np.isinf(position[0, 0]) and np.isnan(position[1, [0, 2]]).all()
    assert 0 <= position[2, 0] < 10 and -2.5 <= position[2, 2] < 2.5
    assert (position[3] == (0, 0, -2.5)).all()
    assert wrapped[2, 0] == pytest.approx(3e37) and wrapped[3, 2] == 2.5


def test_gathered_particles_can_be_emitted_again_wrapped_or_not():
    world = world_of()
    s, again, straight = (world.system(name) for name in ("s", "again", "straight"))
    with world:
        s.emit(position=[(27.5, 1, 4), (-14, 2, 0)])
        world.step()
        again.emit(s.gather())
        straight.emit(s.gather(unwrapped=True))
        world.step()
        found = [one.gather(unwrapped=True).position.tolist() for one in world.systems]
    assert found == [[[27.5, 1, 4], [-14, 2, 0]]] * 3


def test_cuts_divide_the_period():
    line = alike(
        "import motes\n"
        'w = motes.World(seed=1, periodic={"z": (2, 5)}, axis="z", roles="shared", progress="off")\n'
        's = w.system("s")\nwith w: print("cuts", s.cuts.tolist()) if w.rank == 0 else None',
        ranks=(3,),
    )[0]
    assert line == "cuts [3.0, 4.0]"


def test_a_streak_stays_where_its_particle_is():
    """A wrapped particle's streak follows its velocity, and does not cross the whole space."""
    camera = motes.Camera((5, 0, 20), look_at=(5, 0, 0), fov_deg=60)
    world = world_of(renderer=motes.Renderer(200, 80, camera=camera, shutter=1))
    s = world.system("s")
    with world:
        s.emit(position=[(9.9, 0, 0)], velocity=[(6, 0, 0)])
        s.move()
        lit = np.flatnonzero(world.render().pixels[..., :3].any(axis=(0, 2)))
        assert s.gather().position[0, 0] < 1
    assert len(lit) > 0 and np.ptp(lit) < 20


# --- the same bits


@cache
def alone() -> list[list[str]]:
    """Return the frames of the scene on one rank."""
    frames = table(on_ranks(1, SCENE, json.dumps([{}])).lines)
    return [frames[0, frame] for frame in range(len(frames))]


def test_the_scene_lives():
    rows = alone()
    assert len({row[0] for row in rows}) == len(rows)
    *others, sheet = map(int, rows[-1][1:])
    assert min(others) > 100 and 20 < sheet < 108, rows[-1]


@pytest.mark.parametrize("size", [1, pytest.param(2, marks=pytest.mark.slow), 3, 5])
def test_any_domains(size):
    variants: list[dict[str, Any]] = [
        {"axis": axis, "balancer": balancer}
        for axis, balancer in (
            ("x", None),
            ("y", "PrefixCuts"),
            ("z", "Diffusive"),
            ("xz", None),
            ("xyz", "PrefixCuts"),
            (None, None),
        )
    ]
    variants = variants if size < 5 else variants[1::2]
    frames = table(on_ranks(size, SCENE, json.dumps(variants), timeout=240).lines)
    assert len(frames) == len(variants) * len(alone())
    for (variant, frame), row in sorted(frames.items()):
        assert row == alone()[frame], f"{variants[variant]}, frame {frame}"


def test_a_run_goes_on_from_a_checkpoint(tmp_path):
    place = str(tmp_path / "checkpoints")
    assert mpirun(3, SCENE, json.dumps([{"checkpoint": place, "dies": 7}])).code != 0
    again = json.dumps([{"checkpoint": place, "axis": "xz"}])
    rest = table(on_ranks(2, SCENE, again, env={"MOTES_ANYWAY": "1"}).lines)
    assert min(frame for _, frame in rest) in (4, 6)
    assert all(row == alone()[frame] for (_, frame), row in rest.items())


# --- messages

OF_A_CHECKPOINT = """
import sys, motes
ends = float(sys.argv[2])
world = motes.World(seed=1, periodic={"x": (0, ends)}, checkpoint=sys.argv[1], log=sys.argv[3])
s = world.system("s")
with world:
    for frame in world.frames(1):
        s.burst((0, 0, 0))
        world.step()
"""


def test_files_say_the_ends_and_a_checkpoint_of_others_is_refused(tmp_path):
    assert python(OF_A_CHECKPOINT, tmp_path / "c", 5, tmp_path / "log").code == 0
    assert json.loads((tmp_path / "log" / "run.json").read_text())["periodic"] == {"x": [0, 5]}
    other = python(OF_A_CHECKPOINT, tmp_path / "c", 6, tmp_path / "log2", env={"MOTES_ANYWAY": "1"})
    assert other.code != 0
    assert said(other.err, "World(periodic=...) was {'x': [0.0, 5.0]} and is {'x': [0.0, 6.0]}")


def test_ranks_with_other_periods_are_told():
    text = """
import motes
from mpi4py import MPI
world = motes.World(seed=1, periodic={"x": (0, 5 + MPI.COMM_WORLD.rank // 2)}, progress="off")
with world:
    pass
"""
    result = on_ranks(3, text)
    assert result.code != 0
    assert "World(periodic=...) is \"{'x': [0.0, 6.0]}\" on rank 2" in result.err


@pytest.mark.parametrize(
    "ends",
    [
        "x",
        ("x", 0, 1),
        {"w": (0, 1)},
        {0: (0, 1)},
        {"x": 1},
        {"x": (0, 1, 2)},
        {"x": (1, 1)},
        {"x": (2, 1)},
        {"x": (0, np.inf)},
        {"x": (np.nan, 1)},
        {"x": (1e8, 1e8 + 1)},
        {"xz": (0, 1)},
        {"x": "01"},
    ],
)
def test_ends_that_are_none(ends):
    with pytest.raises(ArgumentError, match="periodic"):
        world_of(periodic=ends)


def test_none_and_an_empty_dict_mean_the_same():
    for ends in (None, {}):
        world = world_of(periodic=ends)
        s = world.system("s", attributes={"crossings": 1.0})
        with world:
            s.emit(position=[(1e6, 0, 0)])
            world.step()
            assert s.gather(unwrapped=True).position.tolist() == [[1e6, 0, 0]]


def test_reaches_above_half_a_period():
    world = world_of()
    s, other = world.system("s"), world.system("other")
    with pytest.raises(ArgumentError, match="crossings"):
        world.system("taken", attributes={"crossings": 0.0})
    too_far = [
        lambda: s.collide(1.26),
        lambda: s.collide(1, other=other, other_radius=1.6),
        lambda: s.contact(1000, radius=1.26),
        lambda: s.fluid(2.6, 1000),
        lambda: s.gravitate(),
        lambda: s.gravitate(max_radius=2.6),
        lambda: s.gravitate(far="cells"),
        lambda: s.match_velocity(max_radius=2.51),
        lambda: s.match_rotational_velocity(),
        lambda: s.pairs(lambda p: None, 2.51),
        lambda: s.interact(2.51, velocity=ex.normal),
        lambda: s.tie(motes.Ties([(0, 1), (1, 2)], [1, 2.51])),
    ]
    with world:
        for call in too_far:
            with pytest.raises(ArgumentError, match="periodic"):
                call()
        assert s.recorded == []
        s.collide(1.25)
        s.collide(1, other=other, other_radius=1.5)
        s.gravitate(max_radius=2.5)
        s.follow()
        s.tie(motes.Ties([(0, 1)], 2.5))
        with pytest.raises(ArgumentError, match="unwrapped"):
            s.gather(unwrapped=1)


@pytest.mark.parametrize(
    ("axis", "space"),
    [("x", (2, 5)), ("x", (0.5, 1.5)), ("xz", (0.2, 0.8)), ("hilbert", (2, 5)), ("x", (-1, 0))],
)
def test_a_space_that_contradicts_the_periods(axis: str, space: tuple[float, float]):
    periodic = {"x": (0, 1), "z": (0, 0.5)} | ({"y": (0, 1)} if axis == "hilbert" else {})
    with pytest.raises(ArgumentError, match="space must be within or around"):
        motes.World(seed=1, axis=axis, space=space, periodic=periodic)
    world = motes.World(seed=1, axis="y", space="fit", periodic=periodic)
    with pytest.raises(ArgumentError, match="space must be within or around"):
        world.system("s", axis=axis, space=space)


@pytest.mark.parametrize(
    ("axis", "space"),
    [
        *[("x", (0, 1)), ("x", (0.2, 0.3)), ("x", (-5, 5)), ("x", "fit"), ("x", None)],
        *[("y", (2, 5)), ("xy", (2, 5)), (None, (2, 5)), ("morton", (2, 5))],
    ],
)
def test_a_space_along_axes_without_a_period(axis: str, space: Any):
    world = motes.World(seed=1, axis=axis, space=space, periodic={"x": (0, 1)}, progress="off")
    s = world.system("s")
    with world:
        s.burst((0.5, 3, 0), 4)
        world.step()
        assert len(s.gather()) == 4


def test_what_the_engine_keeps_is_not_set():
    world = world_of(dt=0.5)
    plain = world.system("plain", attributes={"ribbon_count": 0.0})
    for name in ("s", "again", "over"):
        world.system(name, sprite=motes.Sprite("ribbon", width=0.1, length=2))
    _, s, again, over = world.systems
    with world:
        for name in ("crossings", "ribbon_count", "ribbon_3", "ribbon_crossings"):
            value = 1.0 if name == "ribbon_count" else (1.0, 0, 0)
            for call in (
                lambda name=name, value=value: s.set(**{name: value}),
                lambda name=name, value=value: s.apply(motes.actions.Set(attribute=name, value=value)),
                lambda name=name, value=value: s.law(set={name: value}),
                lambda name=name, value=value: s.interact(0.1, set={"mass": 1.0, name: value}),
                lambda name=name, value=value: s.configure(mass=1, **{name: value}),
                lambda name=name, value=value: s.emit(position=[(0, 0, 0)], **{name: [value]}),
                lambda name=name, value=value: again.emit(s.gather(), **{name: [value]}),
            ):
                with pytest.raises(ArgumentError, match="may set|an attribute of 's'"):
                    call()
        assert s.recorded == [] == again.recorded
        plain.set(ribbon_count=2.0)
        with pytest.raises(ArgumentError, match="may set"):
            plain.set(crossings=(0, 0, 0))
        for _ in range(4):
            s.emit(position=[(9.5, 0, 0)], velocity=[(3, 0, 0)])
            s.move()
            world.step()
        rows = s.gather()
        assert rows.crossings.any() and rows.ribbon_count.any()
        again.emit(rows)
        over.emit(**rows.columns())
        world.step()
        for name in ("position", "crossings", "ribbon_count", "ribbon_crossings"):
            for one in (again, over):
                np.testing.assert_array_equal(getattr(one.gather(), name), getattr(s.gather(), name))
