"""Distributions of numbers in place of a vector: one draw for all components."""

from __future__ import annotations

import math

import numpy as np
import pytest

import motes


@pytest.fixture
def world():
    return motes.World(seed=1, progress="off")


def test_a_uniform_of_numbers_is_one_number_where_a_vector_stands(world):
    s = world.system("a", attributes={"wind": (0, 0, 0)})
    with world:
        s.configure(size=motes.Uniform(0.1, 0.3), color=motes.Uniform(0, 1), velocity=motes.Uniform(-2, 2))
        s.configure(
            wind=motes.Uniform(5, 5), up=motes.Uniform((0, 0, 0), (1, 1, 1)), mass=motes.Uniform(1, 2)
        )
        s.burst((0, 0, 0), count=20_000)
        world.step()
        p = s.gather()
    for name, low, high in (("size", 0.1, 0.3), ("color", 0, 1), ("velocity", -2, 2)):
        column = getattr(p, name)
        assert (column == column[:, :1]).all(), name
        assert low <= column.min() < column.max() <= np.float32(high)
        assert column.mean() == pytest.approx((low + high) / 2, abs=0.02 * (high - low))
        assert column.std() == pytest.approx((high - low) / math.sqrt(12), rel=0.02)
    assert (p.wind == 5).all()
    assert (p.up[:, 0] != p.up[:, 1]).mean() > 0.99, "each component of a vector is drawn by itself"
    assert abs(np.corrcoef(p.size[:, 0], p.color[:, 0])[0, 1]) < 0.05
    with pytest.raises(motes.ArgumentError, match="size must be drawn"):
        s.configure(size=motes.Uniform(2, 1))
    with pytest.raises(motes.ArgumentError, match=r"velocity must be within 1e\+37"):
        s.configure(velocity=motes.Uniform(0, 1e38))


def test_a_normal_of_numbers_is_one_number_where_a_vector_stands(world):
    s = world.system("a")
    with world:
        s.configure(size=motes.Normal(0.2, 0.02), velocity=motes.Normal(-1, 2), mass=motes.Normal(2, 0.1))
        s.configure(up=motes.Normal((0, 1, 0), (1, 1, 1)), color=motes.Normal(0.5, 0))
        s.burst((0, 0, 0), count=20_000)
        world.step()
        p = s.gather()
    for name, mean, sigma in (("size", 0.2, 0.02), ("velocity", -1, 2)):
        column = getattr(p, name)
        assert (column == column[:, :1]).all(), name
        assert column.mean() == pytest.approx(mean, abs=0.03 * sigma)
        assert column.std() == pytest.approx(sigma, rel=0.02)
    assert (p.color == 0.5).all()
    assert (p.up[:, 0] != p.up[:, 2]).mean() > 0.99, "each component of a vector is drawn by itself"
    with pytest.raises(motes.ArgumentError, match="size must be drawn with sigma >= 0"):
        s.configure(size=motes.Normal(2, -1))
