"""Interactions between particles.

The same bits on any ranks, errors that reach all ranks, piles that come to rest.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from launching import Result
from same_bits import roles, table, widths
from standing import alike, on_ranks

import motes
from motes.errors import ArgumentError

SCENE = Path(__file__).parents[1] / "scenes" / "meeting.py"
BALANCERS = ("Static", "Pairwise", "Diffusive", "Alone", "PrefixCuts", "Proportional")
THIN = [-0.05, 0.05]  # domains far thinner than the reach; the outer ones hold nearly all particles


@cache
def alone() -> list[list[str]]:
    """Return the scene's frames on one rank."""
    frames = table(on_ranks(1, SCENE, json.dumps([{}])).lines)
    return [frames[0, frame] for frame in range(len(frames))]


def assert_equal(result: Result, variants: list[dict[str, Any]]) -> None:
    """Compare each variant's frames with those of one rank."""
    frames, wanted = table(result.lines), alone()
    assert len(frames) == len(wanted) * len(variants)
    for (variant, frame), row in sorted(frames.items()):
        assert row == wanted[frame], f"{variants[variant]}, frame {frame}"


def run(size: int, variants: list[dict[str, Any]], env: dict[str, str] | None = None) -> None:
    """Run variants in one job and compare them with one rank."""
    assert_equal(on_ranks(size, SCENE, json.dumps(variants), timeout=240, env=env), variants)


def test_the_scene_lives():
    rows = alone()
    assert len({row[0] for row in rows}) == len(rows)
    grains, pebbles, sparks = (int(count) for count in rows[-1][1:])
    assert grains > 250
    assert pebbles > 100
    assert sparks == 400, "the capacity is reached"


@pytest.mark.parametrize("size", [1, pytest.param(2, marks=pytest.mark.slow), 3, 5])
def test_any_ranks_and_roles(size: int):
    variants: list[dict[str, Any]] = [
        {"roles": wish, "space": space} for wish in roles(size) for space in ([-2, 2], THIN)
    ]
    variants += [{"roles": "shared", "space": "fit", "births": "calculators"}, {"roles": "shared"}]
    run(size, variants)


@pytest.mark.parametrize("size", [3, pytest.param(9, marks=pytest.mark.slow)])
def test_any_domains(size: int):
    axes: list[str | None] = ["x", "y", "z", "xz", "xyz", None]
    variants: list[dict[str, Any]] = [
        {"roles": "shared", "axis": axis, "space": space} for axis in axes for space in ([-2, 2], THIN)
    ]
    variants += [{"roles": "shared", "axis": axis, "together": True, "space": [-1, 1]} for axis in axes[2:]]
    run(size, variants if size < 9 else variants[1::2])


@pytest.mark.parametrize("size", [4, pytest.param(6, marks=pytest.mark.slow)])
def test_every_balancer(size: int):
    variants: list[dict[str, Any]] = [
        {"roles": "shared", "space": space, "balancer": name, "together": space == THIN}
        for name in BALANCERS
        for space in ([-2, 2], THIN)
    ]
    variants += [
        {"roles": "shared", "space": [-2, 2], "axis": "xyz", "balancer": name, "combine": combine}
        for name, combine in (("PrefixCuts", "one_by_one"), ("Proportional", "overlapped"))
    ]
    run(size, variants)


@pytest.mark.parametrize(
    ("size", "threads"),
    [(1, 3), pytest.param(1, 2, marks=pytest.mark.slow), pytest.param(3, 2, marks=pytest.mark.slow)],
)
def test_any_threads(size: int, threads: int):
    env = {"MOTES_THREADS": str(threads), "MOTES_GRAIN": "64"}
    run(size, [{"roles": "shared", "space": [-2, 2], "combine": "overlapped"}], env)


@pytest.mark.parametrize("width", ["sse2", "avx2", "avx512"])
def test_any_vector_width(width: str):
    if width not in widths():
        pytest.skip(f"this processor has no {width}")
    run(2, [{"roles": "shared", "space": [-1, 1]}], {"MOTES_SIMD": width})


EMPTY = """
import sys, motes
from motes import shapes
from motes.expressions import column
world = motes.World(seed=1, roles="shared", substeps=3, space=(-2, 2), progress="off")
s, sparks = world.system("s"), world.system("sparks")

def meet():
    if sys.argv[1] == "meets":
        s.gravitate(max_radius=0)
    else:  # random numbers depend on an action's place in the list
        s.kill_old(1e6)

def push(particles):
    particles.velocity[:, 0] += 0.125

with world:
    for frame in world.frames(6):
        s.configure(velocity=shapes.Sphere((0, -3, 0), 4), lifetime=motes.Uniform(0.05, 0.3))
        s.gravity((0, -9.8, 0))
        s.source(shapes.Box((-3, 0.1, -1), (2, 1, 1)), rate=1500, jitter=True)
        meet()
        s.random_acceleration(shapes.Sphere((0, 0, 0), 9))
        if sys.argv[2] == "spawn":
            s.spawn(into=sparks, on="collision", count=1)
            s.spawn(into=sparks, on="birth", count=1)
        s.burst((0.5, 0.5, 0.5))
        meet()
        s.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitution=0.5)
        s.callback(push, where=column("age") > 0.1)
        s.burst(shapes.Box((-3, 0.1, -1), (2, 1, 1)), count=20)
        s.damping((0.5, 0.9, 0.9))
        meet()
        if sys.argv[2] == "kill":  # the dead of a list without meetings go on until the frame ends
            s.kill_expired()
        s.move()
        s.burst((-1, 0.1, 0))
        sparks.move()
        sparks.kill_old(0.2)
        world.step()
        digest = world.digest()
        if "manager" in world.role:
            print(digest, s.count, sparks.count, flush=True)
"""


@pytest.mark.parametrize("events", ["spawn", "kill"])
def test_a_meeting_that_sees_nobody_changes_nothing(events: str):
    wanted = on_ranks(1, EMPTY, "alone", events).lines
    assert len(set(wanted)) == 6
    assert on_ranks(1, EMPTY, "meets", events).lines == wanted
    assert on_ranks(3, EMPTY, "meets", events).lines == wanted


# --- what is refused


READ = """
import time
import motes
world = motes.World(seed=1, roles="shared", substeps={substeps}, space=(-1, 1), progress="off")
s, other = world.system("s"), world.system("other")
with world:
    for frame in world.frames(2):
        s.burst(motes.shapes.Box((-1, -1, -1), (1, 1, 1)), count=50)
        {before}
        {meeting}
        try:
            {read}
        except Exception as error:
            print(error, flush=True)
            time.sleep(1)  # the other ranks print it too
            raise
        world.step()
"""


@pytest.mark.parametrize("substeps", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("meeting", "read"),
    [
        ("s.collide(0.1)", "s.local().__enter__()"),
        pytest.param("s.gravitate()", "s.gather()", marks=pytest.mark.slow),
        pytest.param("s.match_velocity(max_radius=0.2)", "world.digest()", marks=pytest.mark.slow),
        ("other.collide(0.1, other=s, other_radius=0.1)", "s.local().__enter__()"),
    ],
)
def test_particles_are_not_read_behind_a_meeting(substeps: int, meeting: str, read: str):
    text = READ.format(substeps=substeps, before="", meeting=meeting, read=read)
    result = on_ranks(3, text, env={"MOTES_STALL_S": "600"})
    assert result.code == 1
    assert result.out.count("particles of system 's' interact in this frame's list so far") == 3, (
        "on all ranks"
    )


BOTH_SIDES = """
import motes
world = motes.World(seed=1, roles="shared", substeps=1, space=(-1, 1), progress="off")
s = world.system("s")
with world:
    for frame in world.frames(2):
        s.burst(motes.shapes.Box((-1, -1, -1), (1, 1, 1)), count=50)
        with s.local() as p:
            p.velocity[:] = (1, 0, 0)
        before = world.digest()
        s.collide(0.1)
        world.step()
        print(frame, before, world.digest(), flush=True)
"""


def test_particles_are_read_before_a_meeting_and_after_the_frame():
    lines = on_ranks(3, BOTH_SIDES).lines
    assert len(lines) == 2 * 3
    assert len(set(lines)) == 2, "equal on all ranks"
    assert on_ranks(1, BOTH_SIDES).lines == sorted(set(lines))


def test_bad_arguments():
    world, elsewhere = motes.World(progress="off"), motes.World(progress="off")
    s, stranger = world.system("s"), elsewhere.system("t")
    with world:
        for _ in world.frames(1):
            with pytest.raises(ArgumentError, match=r"radius.*above 0, or None"):
                s.collide(radius=0)
            with pytest.raises(ArgumentError, match=r"radius"):
                s.collide(radius=-1)
            with pytest.raises(ArgumentError, match=r"radius"):
                s.collide(radius=float("nan"))
            with pytest.raises(ArgumentError, match=r"restitution"):
                s.collide(0.1, restitution=1.5)
            with pytest.raises(ArgumentError, match=r"friction"):
                s.collide(0.1, friction=-1)
            with pytest.raises(ArgumentError, match=r"other.*another system of the same world"):
                s.collide(0.1, other=s)
            with pytest.raises(ArgumentError, match=r"other.*another system of the same world"):
                s.collide(0.1, other=stranger)
            with pytest.raises(ArgumentError, match=r"other.*another system of the same world"):
                s.collide(0.1, other="s")  # type: ignore[arg-type]
            with pytest.raises(ArgumentError, match=r"other_radius.*unless other= is given"):
                s.collide(0.1, other_radius=0.1)
            with pytest.raises(ArgumentError, match=r"magnitude"):
                s.match_velocity(magnitude=-1)
            world.step()


ODD = """
import motes
world = motes.World(seed=1, roles="shared", substeps=2, space=(-1, 1), progress="off")
s, none = world.system("s"), world.system("none")
with world:
    for frame in world.frames(6):
        s.configure(size={size}, velocity=motes.shapes.Sphere((0, 0, 0), 1))
        s.burst(motes.shapes.Box((-1, -1, -1), (1, 1, 1)), count=50)
        if frame == 2:
            s.emit(position=[(1e30, 0, 0), (-3e38, 1, 0)], velocity=[(3e38, 0, 0), (0, 0, -3e38)])
        {meeting}
        s.move()
        world.step()
        digest = world.digest()
        if "manager" in world.role:
            print(digest, flush=True)
"""


@pytest.mark.parametrize(
    ("meeting", "size"),
    [
        ("s.collide(radius=1e30)", 1),
        ("s.collide()", 0),
        pytest.param("s.collide()", 3, marks=pytest.mark.slow),
        pytest.param("s.collide(radius=1e-30)", 1, marks=pytest.mark.slow),
        ("s.collide(0.1, other=none)", 1),
        pytest.param("s.gravitate(max_radius=0)", 1, marks=pytest.mark.slow),
        ("s.gravitate(max_radius=1e38)", 1),
    ],
)
def test_odd_radii_have_a_result(meeting: str, size: int):
    assert len(set(alike(ODD.format(meeting=meeting, size=size), ranks=(1, 3)))) == 6


FAILS = """
import motes
world = motes.World(seed=1, roles="shared", substeps=2, space=(-1, 1), progress="off")
s = world.system("s")
seen = 0
def look(particles):
    global seen
    seen += 1
    if world.rank == {rank} and seen == {call}:
        raise RuntimeError("the mistake")
with world:
    for frame in world.frames(3):
        s.burst(motes.shapes.Box((-1, -1, -1), (1, 1, 1)), count=50)
        for _ in range(3):
            s.collide(0.1)
            s.callback(look)
        s.move()
        world.step()
"""


@pytest.mark.parametrize(
    ("rank", "call"),
    [pytest.param(0, 3, marks=pytest.mark.slow), (2, 8), pytest.param(3, 12, marks=pytest.mark.slow)],
)
def test_a_callback_that_fails_between_meetings_stops_all(rank: int, call: int):
    result = on_ranks(4, FAILS.format(rank=rank, call=call), env={"MOTES_STALL_S": "600"})
    assert result.code == 1
    assert f"*** motes: rank {rank}" in result.err
    assert "RuntimeError: the mistake" in result.err


# --- physics

PILE = """
import numpy as np, motes
from motes import shapes
RADIUS, LAYERS = 0.02, 20
world = motes.World(seed=3, substeps=20, progress="off")
s = world.system("sand")
wall = 0.2
walls = [((-wall, 0, 0), (1, 0, 0)), ((wall, 0, 0), (-1, 0, 0)),
         ((0, 0, -wall), (0, 0, 1)), ((0, 0, wall), (0, 0, -1))]
planes = [((0, 0, 0), (0, 1, 0)), *walls]
random = np.random.default_rng(1)
grid = np.stack(np.meshgrid(*(np.arange(n) for n in (9, LAYERS, 9)), indexing="ij"), -1).reshape(-1, 3)
start = (grid - (4, -0.6, 4)) * 0.0435 + random.normal(0, 5e-4, grid.shape)

def now():
    all = s.gather()
    order = np.argsort(all.id)
    return all.position[order].astype(float), np.linalg.norm(all.velocity, axis=1).max()

fastest = 0.0
with world:
    for frame in world.frames(168):
        if frame == 0:
            s.emit(position=start.astype(np.float32))
        if frame == 120:
            early, _ = now()
        fastest = max(fastest, now()[1])
        s.gravity((0, -9.81, 0))
        s.collide(radius=RADIUS)
        for plane in planes:
            s.bounce(shapes.Plane(*plane), restitution=0, friction=0.5)
        s.move()
        world.step()
    late, _ = now()
moved = np.linalg.norm(late - early, axis=1)
apart = np.linalg.norm(late[:, None] - late[None], axis=2)[np.triu_indices(len(late), 1)]
overlap = 1 - apart[apart < 2 * RADIUS] / (2 * RADIUS)
print(len(late), np.sort(moved)[-3], moved.mean(), overlap.mean(), fastest, start[:, 1].max())
"""


def test_a_box_of_twenty_layers_comes_to_rest():
    line = on_ranks(1, PILE, timeout=240).lines[0]
    count, most, mean, overlap, fastest, height = map(float, line.split())
    assert count == 9 * 9 * 20
    assert overlap < 0.06, "of those that touch, as a part of the diameter"
    assert fastest < (2 * 9.81 * height) ** 0.5, "nothing is thrown faster than it can fall"
    assert mean < 2 * 1e-4, "metres in two seconds"
    assert most < 0.01, "but for two loose grains on top, which may roll"


GHOSTS = """
import numpy as np, motes, sys
settings = dict(space=(-1, 1), roles="shared", progress="off", log=sys.argv[1])
settings["balancer"] = motes.balance.Static()
with motes.World(seed=1, **settings) as w:
    s = w.system("some")
    s.emit(position=np.random.default_rng(2).uniform(-1, 1, (3000, 3)).astype(np.float32))
    s.gravitate(max_radius=0.1)
    w.step()
"""


def test_ghosts_are_those_within_reach_of_other_domains(tmp_path: Path):
    ended = on_ranks(4, GHOSTS, tmp_path / "log")
    assert ended.code == 0, ended.text
    rows = motes.open_run(tmp_path / "log").load
    x = np.random.default_rng(2).uniform(-1, 1, (3000, 3)).astype(np.float32)[:, 0].astype(np.float64)
    cuts = np.array([-np.inf, -0.5, 0, 0.5, np.inf])
    for _, row in rows.iterrows():
        calculator = int(row["rank"])
        own = x[(x >= cuts[calculator]) & (x < cuts[calculator + 1])]
        others = [other for other in range(4) if other != calculator]
        reached = [np.maximum(cuts[o] - own, own - cuts[o + 1]) <= 0.1 for o in others]
        assert row["n_end"] == len(own)
        assert row["ghosts"] == sum(np.count_nonzero(some) for some in reached)
        messages = sum(bool(some.any()) for some in reached)
        assert row["interaction_bytes"] == 20 * row["ghosts"] + 32 * messages, "an id and a place each"
        assert row["interactions"] == 1 and row["t_interact_s"] > 0


def test_a_refused_read_does_not_end_the_run():
    with motes.World(seed=1, progress="off") as world:
        system = world.system("some")
        for frame in range(2):
            system.burst(motes.shapes.Sphere((0, 0, 0), 1), 10)
            system.collide(0.1)
            for read in (system.gather, world.digest, lambda: system.total(1)):
                with pytest.raises((ArgumentError, ValueError), match="interact in this frame"):
                    read()
            system.move()
            world.step()
            assert len(system.gather()) == system.total(1) == 10 * (frame + 1)


SHARED_OUT = """
import sys
import motes
from motes.expressions import column
from motes.shapes import Box

world = motes.World(seed=3, dt=0.02, substeps=2, space=(-2, 2), roles="shared", progress="off")
s = world.system("s", attributes={"kind": 0})
first, second, both = column("kind") < 0.5, column("kind") >= 0.5, column("kind") < 9
where = {"all": [None], "two": [first, second], "again": [first, both]}[sys.argv[1]]
with world:
    for frame in world.frames(4):
        if frame == 0:
            for kind in 0, 1:
                s.configure(kind=kind, velocity=Box((-9, -9, -9), (9, 9, 9)))
                s.burst(Box((-2, 0, 10 * kind), (2, 0.5, 10 * kind + 0.5)), count=300)
        for each in where:
            s.collide(0.1, where=each)
            if "between" in sys.argv:
                s.move()
        s.move()
        world.step()
        say = (world.digest(), s.total(column("contacts")), s.total(1, where=column("contacts") > 0))
        world.say(" ".join(map(str, say)))
"""


def test_collisions_of_some_count_contacts_as_one_of_all_does():
    """The two kinds are too far apart to touch."""
    assert on_ranks(1, SHARED_OUT, "two").lines == on_ranks(1, SHARED_OUT, "all").lines


@pytest.mark.parametrize("size", [2, 5])
def test_who_has_collided_is_known_wherever_it_goes_next(size: int):
    alike(SHARED_OUT, "again", "between", ranks=(1, size))
