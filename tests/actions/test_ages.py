"""Ages are exact between frames, for any step, any number of sub-steps and any elapsed time."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import motes
from motes import expressions as ex
from motes.expressions import column


def world(dt: float, substeps: int = 1) -> motes.World:
    return motes.World(seed=1, dt=dt, substeps=substeps, progress="off")


@pytest.mark.parametrize(
    ("dt", "substeps", "frames"),
    [
        (1 / 24, 1, 1500),
        (1 / 24, 20, 500),
        (1 / 30, 40, 300),
        (0.1, 1, 1000),
        (0.1, 3, 300),
        (1 / 24, 200, 100),
    ],
)
def test_an_age_is_the_frames_times_their_length(dt, substeps, frames):
    w = world(dt, substeps)
    s = w.system("s")
    with w:
        for frame in w.frames(frames):
            if frame == 0:
                s.emit(position=[(0, 0, 0)])
            s.move()
            w.step()
            (age,) = s.gather().age
            assert age == np.float32((frame + 1) * dt), frame


@pytest.mark.parametrize("start_frames", [10_000, 345_600])
def test_an_age_of_hours_is_exact_with_many_sub_steps(start_frames):
    dt, substeps = 1 / 24, 100
    w = world(dt, substeps)
    s = w.system("s")
    with w:
        for frame in w.frames(20):
            if frame == 0:
                s.emit(position=[(0, 0, 0)], age=[start_frames * dt])
            s.move()
            w.step()
            assert s.gather().age[0] == np.float32((start_frames + frame + 1) * dt)


@pytest.mark.parametrize(
    ("dt", "substeps"), [(1 / 24, 1), (0.1, 1), (1 / 25, 8), (1 / 30, 7), (1001 / 24000, 3)]
)
def test_particles_die_in_the_frame_that_their_limit_says(dt, substeps):
    """A particle is in as many pictures as its limit has frames: `kill_old`, a lifetime, an expression."""
    for lives in (1, 7, 24, 100):
        w = world(dt, substeps)
        old, expired, asked = (w.system(name) for name in ("old", "expired", "asked"))
        counts = []
        with w:
            for frame in w.frames(lives + 2):
                for s in (old, expired, asked):
                    if frame == 0:
                        s.emit(position=[(0, 0, 0)], lifetime=[lives * dt])
                old.kill_old(lives * dt)
                expired.kill_expired()
                asked.sink(motes.shapes.Sphere((0, 0, 0), 9), where=column("age") >= lives * dt)
                for s in (old, expired, asked):
                    s.move()
                w.step()
                counts.append([s.count for s in (old, expired, asked)])
        assert counts == [[1, 1, 1]] * lives + [[0, 0, 0]] * 2


def test_births_in_sub_steps_and_before_a_frame_keep_their_distance():
    """Births in each sub-step, births with given ages, and jittered births."""
    dt, substeps, frames = 1 / 24, 5, 400
    w = world(dt, substeps)
    each, chosen, spread = (w.system(name) for name in ("each", "chosen", "spread"))
    starts = np.random.default_rng(2).uniform(-3, 3, 200).astype(np.float32)
    first: NDArray[np.float32] | None = None
    with w:
        for frame in w.frames(frames):
            if frame == 0:
                each.source((0, 0, 0), rate=substeps / dt)
                chosen.emit(position=np.zeros((200, 3)), age=starts)
                spread.source((0, 0, 0), rate=100 / dt, jitter=True)
            for s in (each, chosen, spread):
                s.move()
            w.step()
            if frame == 0:
                first = np.array(spread.gather().age)
        ages = [np.array(s.gather().age, np.float64) for s in (each, chosen, spread)]
    passed = frames * dt
    assert (ages[0] == np.float32([(frames - k / substeps) * dt for k in range(substeps)])).all()
    unit = np.spacing(np.float32(passed + 3)).astype(float)
    assert np.abs(ages[1] - (starts.astype(float) + passed)).max() <= 4 * unit
    assert first is not None
    assert np.abs(ages[2] - (first.astype(float) + passed - dt)).max() <= 4 * unit


def test_a_trail_is_left_at_the_same_ages_after_hours():
    """`trail` emits at multiples of an age: drifting ages would skip or double some."""
    dt = 1 / 24
    w = world(dt)
    s, left = w.system("s"), w.system("left")
    with w:
        for frame in w.frames(48):
            if frame == 0:
                s.emit(position=[(0, 0, 0)], age=[240_000 * dt])
            s.trail(left, every=0.5)
            s.move()
            w.step()
            assert left.count == (frame + 1) // 12, frame


def test_an_age_that_an_action_sets_counts_from_there():
    dt = 0.1
    w = world(dt)
    s = w.system("s")
    with w:
        for frame in w.frames(30):
            if frame == 0:
                s.emit(position=np.zeros((2, 3)))
            if frame == 7:
                s.set(age=0, where=ex.column("age") > 0.5)
            s.move(where=ex.time() < 2.05)
            w.step()
            passed = min(frame + 1, 21) - (7 if frame >= 7 else 0)
            assert (s.gather().age == np.float32(passed * dt)).all()
