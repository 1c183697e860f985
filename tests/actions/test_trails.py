"""Trails: what particles leave behind in each frame, or each time their age reaches a multiple."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from standing import alike

import motes
from motes.expressions import column


def run(
    frames: int, *, dt: float = 0.25, substeps: int = 1, **options: Any
) -> tuple[motes.Particles, list[int]]:
    """Let two particles fly along x; return what they left behind, and its count after each frame."""
    world = motes.World(seed=1, dt=dt, substeps=substeps, progress="off")
    rockets, smoke = world.system("rockets"), world.system("smoke")
    born = []
    with world:
        for frame in world.frames(frames):
            if frame == 0:
                rockets.emit(position=[(0, 0, 0), (0, 5, 0)], velocity=[(8, 0, 0), (4, 0, 0)])
            rockets.move()
            rockets.trail(smoke, **options)
            world.step()
            born.append(smoke.born)
        return smoke.gather(), born


@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize("dt", [0.25, 0.1, 1 / 24])
def test_particles_leave_children_as_their_age_passes_multiples(dt: float, substeps: int):
    frames = round(3 / dt)
    found, born = run(frames, dt=dt, substeps=substeps, every=0.5)
    assert len(found) == 2 * 6  # at 0.5, 1.0, ... 3.0 s
    for y, speed in ((0, 8), (5, 4)):
        x = np.sort(found.position[found.position[:, 1] == y][:, 0])
        np.testing.assert_allclose(x, speed * 0.5 * np.arange(1, 7), atol=speed * dt / 2 + 1e-4)
    counts = np.diff([0, *born])
    assert set(counts.tolist()) <= {0, 2}


@pytest.mark.parametrize(
    "every", [Fraction(3, 2), Fraction(5, 2), Fraction(7, 2), Fraction(12), Fraction(5, 4)]
)
@pytest.mark.parametrize(
    ("dt", "substeps"),
    [(Fraction(1, 24), 1), (Fraction(1, 24), 3), (Fraction(1, 10), 1), (Fraction(1, 30), 1)],
)
def test_trails_leave_children_at_each_multiple_once(every: Fraction, dt: Fraction, substeps: int) -> None:
    """Also if every other multiple lies halfway between two frames; `every` is in frames here."""
    world = motes.World(seed=1, dt=float(dt), substeps=substeps, progress="off")
    s, left = world.system("s"), world.system("left")
    frames = []
    with world:
        s.burst((0, 0, 0))
        for frame in world.frames(120):
            s.move()
            s.trail(left, every=float(every * dt))
            world.step()
            frames += [frame] * (left.born - len(frames))
    half = Fraction(1, 2)
    assert frames == [
        frame
        for frame in range(120)
        if math.floor((frame + 1 + half) / every) > math.floor((frame + 1 - half) / every)
    ]


def test_short_times_leave_one_child_in_each_frame():
    found, born = run(8, every=1e-3, count=3)
    assert born == [6 * (k + 1) for k in range(8)]
    x = np.unique(found.position[found.position[:, 1] == 0][:, 0])
    np.testing.assert_allclose(x, 2.0 * np.arange(1, 9), atol=1e-5)


def test_trails_take_conditions_and_velocities():
    found, _ = run(8, every=0.5, where=column("position").y > 1, inherit_velocity=0.25)
    assert len(found) == 4
    np.testing.assert_allclose(found.velocity[:, 0], 1.0)


def test_the_dead_leave_nothing():
    world = motes.World(seed=1, dt=0.25, progress="off")
    s, smoke = world.system("s"), world.system("smoke")
    with world:
        for frame in world.frames(4):
            if frame == 0:
                s.emit(position=[(0, 0, 0), (9, 0, 0)])
            s.kill_old(0.3, where=column("position").x > 5)
            s.move()
            s.spawn(into=smoke, on="frame", count=1)
            world.step()
        p = smoke.gather()
    assert sorted(p.position[:, 0].tolist()) == [0] * 4 + [9] * 2


def test_wrong_trails_are_refused():
    world = motes.World(seed=1, progress="off")
    s, other = world.system("s"), motes.World(seed=2, progress="off").system("other")
    with world:
        for arguments, message in (
            ({"into": s, "every": 0}, "every must be a finite number in 1e-06..1e.06, got 0"),
            ({"into": other, "every": 1}, "into must be a system of the same world"),
            ({"into": s, "every": 1, "count": 0}, "count must be an integer in 1..1e.06"),
            ({"into": s, "every": 1, "where": 3}, "where must be a shape or a comparison"),
        ):
            with pytest.raises(motes.ArgumentError, match=message):
                s.trail(**arguments)  # type: ignore[arg-type]
        assert s.recorded == []


SCRIPT = """
import motes
from motes.shapes import Sphere

world = motes.World(seed=3, progress="off", substeps=2)
s, smoke = world.system("s"), world.system("smoke", axis="y")
s.configure(velocity=Sphere((0, 0, 0), 5))
with world:
    for frame in world.frames(8):
        s.burst(Sphere((0, 0, 0), 1.5), count=300)
        s.kill_old(0.2)
        s.collide(radius=0.02)
        s.move()
        s.trail(smoke, every=0.1, count=2, inherit_velocity=0.5)
        smoke.move()
        world.step()
        digest = world.digest()
        if world.rank == 0:
            print(digest, smoke.born)
"""


def test_trails_are_the_same_on_any_ranks():
    assert int(alike(SCRIPT, ranks=(1, 2, 3, 5))[-1].split()[1]) > 1000
