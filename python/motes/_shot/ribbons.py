"""Ribbons as lines: a particle's position and its earlier ones, as far back as the ribbon is long."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["columns_of_trace", "lines_of"]

TRACED = 16
"""Earlier positions of a particle: `kTraced` in cpp/particles/trace.h, which also says when they are kept."""

Array = NDArray[Any]


def columns_of_trace() -> tuple[str, ...]:
    """Return the names of the columns that hold earlier positions, and of their number."""
    return ("ribbon_count", *(f"ribbon_{slot}" for slot in range(TRACED)))


def lines_of(
    column: Callable[[str], Array], length: float, frame: int, dt: float
) -> tuple[Array, Array, Array]:
    """Return the points of all lines (n, 3), how far along its ribbon each is, 0..1, and lines' counts."""
    every = max(math.ceil(length / dt / (TRACED - 1) - 1e-6), 1)
    ages = np.array([frame % every + back * every for back in range(TRACED)]) * dt
    slots = [(frame // every + TRACED - back) % TRACED for back in range(TRACED)]
    position, kept = column("position"), np.minimum(column("ribbon_count"), TRACED).astype(np.int64)
    points = np.stack([position, *(column(f"ribbon_{slot}") for slot in slots)], axis=1).astype(np.float64)
    oldest = np.where(kept > 0, ages[kept - 1], 0)
    reach = np.minimum(oldest, length)
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.where(reach[:, None] > 0, np.concatenate([[0.0], ages]) / reach[:, None], 0)
    shown = (np.arange(TRACED + 1) <= kept[:, None]) & (along < 1 + 1e-9)
    shown[:, 1:] &= ages > 0  # age 0: the particle itself
    shown[:, 0] = True
    # The first point beyond the end, if there is one, moves to the end.
    for back in range(1, TRACED + 1):
        before = points[:, back - 1] if ages[back - 1] > 0 and back > 1 else position
        start = along[:, back - 1] if back > 1 else np.zeros(len(along))
        beyond = (back <= kept) & (along[:, back] > 1 + 1e-9) & (start < 1 - 1e-9)
        part = np.where(beyond, (1 - start) / np.where(beyond, along[:, back] - start, 1), 0)[:, None]
        points[:, back] = np.where(
            beyond[:, None], before + (points[:, back] - before) * part, points[:, back]
        )
        along[:, back] = np.where(beyond, 1, along[:, back])
        shown[:, back] |= beyond & (ages[back - 1] > 0)
    single = shown.sum(axis=1) == 1  # a line has two points
    points[single, 1], shown[single, 1] = position[single], True
    along[single, 1] = 1
    return points[shown].astype(np.float32), along[shown], shown.sum(axis=1)
