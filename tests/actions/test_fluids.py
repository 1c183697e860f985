"""`fluid` against known results: the density of still water, the front of a breaking dam."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

import motes
from motes.shapes import Box

SPACING = 0.05  # m
MARTIN_MOYCE = [
    (0.832, 1.217),
    (1.219, 1.474),
    (1.997, 2.292),
    (2.547, 2.995),
    (3.345, 4.134),
    (4.034, 4.944),
]
"""Time * sqrt(2 g / width) and front / width for a column of water twice as high as wide (2.25 inches).

Martin and Moyce (1952), "An experimental study of the collapse of liquid columns on a rigid horizontal
plane", figure 3.
"""


def poured(
    counts: tuple[int, int, int], tank: Box, frames: int, substeps: int
) -> Iterator[NDArray[np.float64]]:
    """Release a block of water in a tank; yield positions after each frame."""
    grid = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), -1).reshape(-1, 3)
    jitter = np.random.default_rng(2).uniform(-1e-3, 1e-3, grid.shape)
    world = motes.World(seed=1, substeps=substeps, progress="off")
    water = world.system("water")
    with world:
        for frame in world.frames(frames):
            if frame == 0:
                water.emit(
                    position=(grid + 0.5) * SPACING + jitter, mass=np.full(len(grid), 1000 * SPACING**3)
                )
            water.gravity((0, -9.81, 0))
            water.fluid(radius=2 * SPACING, rest_density=1000)
            water.bounce(tank, restitution=0, friction=0)
            water.move()
            world.step()
            yield water.gather().position.astype(np.float64)


def test_still_water_is_as_dense_in_all_layers():
    """Sub-steps must be short: excess density falls with their square."""
    wide = 6 * SPACING
    *_, x = poured((6, 16, 6), Box((0, 0, 0), (wide, 9, wide)), 60, substeps=60)
    radius2 = (2 * SPACING) ** 2
    apart2 = ((x[:, None] - x[None]) ** 2).sum(axis=2)
    spread = 315 / (64 * np.pi * radius2**4.5) * np.clip(radius2 - apart2, 0, None) ** 3
    density = 1000 * SPACING**3 * spread.sum(axis=1)
    inner = (np.abs(x[:, ::2] - wide / 2) < 1.2 * SPACING).all(axis=1)
    layer = (x[:, 1] / SPACING).astype(int)
    layers = [density[inner & (layer == one)].mean() for one in range(layer.max() - 1)]  # below the surface
    assert len(layers) >= 6
    np.testing.assert_allclose(layers, 1000, rtol=0.03)


def test_a_dam_breaks_as_fast_as_in_experiments():
    """The lattice must settle before it builds up pressure: the front starts late, then moves as measured."""
    wide = 10
    width = wide * SPACING
    times, fronts = [], []
    tank = Box((0, 0, 0), (9, 9, 4 * SPACING))
    for frame, x in enumerate(poured((wide, 2 * wide, 4), tank, 15, substeps=20)):
        times.append((frame + 1) / 24 * math.sqrt(2 * 9.81 / width))
        fronts.append((np.sort(x[:, 0])[-3] + SPACING / 2) / width)
    measured_at, measured = np.transpose(MARTIN_MOYCE)
    late = np.interp([2.0, 3.0], fronts, times) - np.interp([2.0, 3.0], measured, measured_at)
    assert (np.abs(late) < 0.6).all()
    speed = 2 / np.subtract(*np.interp([4.0, 2.0], fronts, times))
    known = 2 / np.subtract(*np.interp([4.0, 2.0], measured, measured_at))
    assert abs(speed / known - 1) < 0.1


@pytest.mark.parametrize("other", [1.0, 1e-3])
def test_what_is_denser_than_the_liquid_by_itself_does_not_explode(other: float):
    """A mass of 1 kg within 0.1 m has 1.6 times the density of water at rest: pairs meet, slowly."""
    dice = np.random.default_rng(3)
    middle = 2.0 * np.stack(np.unravel_index(np.arange(64), (4, 4, 4)), axis=1)
    way = dice.normal(size=(64, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    apart, speed = dice.uniform(0.02, 0.12, (64, 1)), 0.02
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        s.emit(position=middle - way * apart / 2, velocity=way * speed, mass=np.full(64, 1.0))
        s.emit(position=middle + way * apart / 2, velocity=-way * speed, mass=np.full(64, other))
        for _ in world.frames(48):
            s.fluid(radius=0.1, rest_density=1000)
            s.move()
            world.step()
            p = s.gather()
            moved = np.linalg.norm(p.velocity.astype(float), axis=1) * world.dt
            assert moved.max() < 0.1, "nobody is pushed farther than the reach"
        momentum = (p.mass[:, None].astype(float) * p.velocity).sum(axis=0)
    np.testing.assert_allclose(momentum, speed * ((1 - other) * way).sum(axis=0), atol=1e-4)
