"""`motes.euler`: angles to quaternions, against matrices."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import motes
from motes.errors import ArgumentError


def matrix(q: Any) -> np.ndarray:
    x, y, z, w = np.float64(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def about(axis: int, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turn, (i, j) = np.eye(3), ((1, 2), (2, 0), (0, 1))[axis]
    turn[i, i] = turn[j, j] = c
    turn[i, j], turn[j, i] = -s, s
    return turn


def test_x_then_y_then_z_about_fixed_axes():
    for x, y, z in np.random.default_rng(1).uniform(-800, 800, (300, 3)):
        wanted = about(2, z) @ about(1, y) @ about(0, x)
        np.testing.assert_allclose(matrix(motes.euler(x, y, z)), wanted, atol=1e-12)
    half = math.sqrt(0.5)
    assert motes.euler(0, 90, 0) == pytest.approx((0, half, 0, half), abs=1e-15)
    assert motes.euler(0) == (0, 0, 0, 1) and motes.euler(z=180, x=0) == pytest.approx(
        (0, 0, 1, 0), abs=1e-15
    )


def test_arrays_broadcast():
    q = motes.euler(np.arange(5)[:, None], [0, 45, 90])
    assert q.shape == (5, 3, 4) and q.dtype == np.float32
    np.testing.assert_array_equal(q[2, 1], np.float32(motes.euler(2, 45)))
    np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1, atol=1e-7)


def test_particles_take_it():
    world = motes.World(progress="off")
    s = world.system("all")
    with world:
        s.configure(orientation=motes.euler(0, 90))
        s.burst((0, 0, 0), count=1)
        s.emit(position=np.zeros((2, 3)), orientation=motes.euler([0, 90], 0, 0))
        world.step()
        p = s.gather()
        np.testing.assert_allclose(p.orientation[0], motes.euler(0, 90), atol=1e-7)
        np.testing.assert_allclose(p.orientation[2], motes.euler(90), atol=1e-7)
        s.set(orientation=motes.euler(0, 0, 90))
        world.step()
        np.testing.assert_allclose(s.gather().orientation, [motes.euler(0, 0, 90)] * 3, atol=1e-7)
        with pytest.raises(ArgumentError, match="orientation"):
            s.set(orientation=(0, 0, 0, 0))
        with pytest.raises(ArgumentError, match="orientation"):
            s.set(orientation=(0, 0, 1))
        with pytest.raises(ArgumentError, match="velocity must be 3"):
            s.set(velocity=motes.euler(0, 0, 90))


@pytest.mark.parametrize("wrong", ["x", math.nan, math.inf, None, True, 1j, [1, "a"], {}])
def test_wrong_angles_are_named(wrong: Any):
    with pytest.raises(ArgumentError, match="y must be finite angles"):
        motes.euler(0, wrong)


def test_shapes_that_do_not_broadcast_are_named():
    with pytest.raises(ArgumentError, match="broadcast"):
        motes.euler([1, 2], [1, 2, 3])
