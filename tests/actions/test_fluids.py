"""`fluid` against known results: the density of still water, the front of a breaking dam."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
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
