"""Time and noise in expressions, and the treatment of NaN and infinities."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from test_expressions import STATE, Array, computed, one

import motes
from motes import expressions as ex
from motes.expressions import column
from motes.shapes import Box


def test_time_is_that_of_the_start_of_each_substep():
    world = motes.World(seed=1, dt=0.5, substeps=4, progress="off")
    s = world.system("s", attributes={"last": -1.0, "total": 0.0, "late": 0.0})
    seen: list[int] = []
    with world:
        for frame in world.frames(3):
            if frame == 0:
                s.burst((0, 0, 0))
            assert s.total(ex.time()) == world.time
            s.set(last=ex.time(), total=column("total") + ex.time())
            s.set(late=column("late") + 1, where=ex.time() >= 1.2)
            s.callback(lambda p: seen.append(len(p)), where=ex.time() >= 1.2)
            world.step()
        p = s.gather()
    times = np.arange(12) * 0.125
    assert p.last.tolist() == [times[-1]]
    assert p.total.tolist() == [times.sum()]
    assert p.late.tolist() == [len(seen)] == [(times >= 1.2).sum()]


def test_time_limits_children():
    world = motes.World(seed=1, dt=0.5, substeps=2, progress="off")
    s, children = world.system("s"), world.system("children")
    with world:
        for _ in world.frames(4):
            s.emit(position=[(0, 0, 0), (1, 0, 0)])
            s.spawn(into=children, on="birth", count=1, where=ex.time() > 0.9)
            world.step()
    assert children.born == 4  # two each in the frames at 1.0 and 1.5 s


@pytest.mark.parametrize("kind", ["gravitate", "follow"])
def test_time_limits_meetings_by_substep(kind: str):
    def pushed(where: Any) -> Array:
        world = motes.World(seed=1, dt=0.5, substeps=2, progress="off")
        s = world.system("s")
        with world:
            for frame in world.frames(2):
                if frame == 0:
                    s.emit(position=[(0, 0, 0), (1, 0, 0)])
                getattr(s, kind)(1, 0.5, max_radius=2, where=where)
                world.step()
            return s.gather().velocity[0, 0]

    each = pushed(ex.time() < 0.1)  # one sub-step of four; nothing moves, so all push equally
    assert each > 0
    for since, substeps in ((0.2, 3), (0.3, 2), (0.6, 1), (0.8, 0)):
        assert pushed(ex.time() > since) == pytest.approx(substeps * each, rel=1e-5)


def test_noise_of_columns_is_the_same_in_each_run_and_system():
    def run(seed: int, shift: float = 0) -> Array:
        world = motes.World(seed=seed, progress="off")
        world.system("first")
        s = world.system("second", attributes={"v": 0.0})
        with world:
            s.emit(position=STATE["position"])
            s.set(v=ex.noise(column("position") / 2, 1.25, octaves=2, field=4) + shift)
            world.step()
            return s.gather().v

    first = run(1)
    np.testing.assert_array_equal(first, run(2))
    assert 0.1 < np.sqrt(np.mean(first**2)) < 0.6
    assert np.abs(first).max() < 1.6
    still, octave = one(ex.noise(column("position") / 2)), one(ex.noise(column("position") / 2, field=4))
    assert abs(np.corrcoef(still, octave)[0, 1]) < 0.25
    times = computed([ex.noise(column("position"), t) for t in (0, 0.001, 1)], [1] * 3)
    assert 0 < np.abs(times[1] - times[0]).max() < 0.01
    assert np.abs(times[2] - times[0]).max() > 0.3


def test_nan_stays_nan():
    nan = ex.sqrt(column("heat") * 0 - 1)
    for value in (
        *(
            ex.minimum(nan, 1),
            ex.minimum(1, nan),
            ex.maximum(nan, 1),
            ex.maximum(1, nan),
            ex.clamp(nan, 0, 1),
        ),
        *(
            ex.floor(nan),
            ex.sign(nan),
            ex.sin(nan),
            ex.cos(nan),
            ex.exp(nan),
            ex.log(nan),
            nan**2,
            nan % 2,
            2 % nan,
        ),
        *(
            ex.atan2(nan, 1),
            ex.mix(nan, 1, 0.5),
            ex.mix(0, 1, nan),
            ex.smoothstep(0, 1, nan),
            nan**1.5,
            abs(nan),
        ),
        *(ex.noise(column("position"), nan), ex.dot((nan_of(nan)), (1, 0, 0)), ex.length(nan_of(nan))),
    ):
        assert math.isnan(motes_total(value)), value
    assert motes_total(ex.step(0, nan)) == 0  # comparisons with NaN are false
    assert motes_total(nan**0) == 3


def nan_of(nan: ex.Expression) -> ex.Expression:
    return column("position") * nan


def motes_total(value: ex.Expression) -> float:
    world = motes.World(seed=1, progress="off")
    s = world.system("s", attributes={"heat": 0.5})
    with world:
        s.burst(Box((0, 0, 0), (1, 1, 1)), count=3)
        world.step()
        return float(s.total(value))
