"""The parameters of the snow list, and the comparison of two runs of it."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["DT", "FRICTION", "GUST", "LIFE", "NAMES", "RESTITUTION", "Columns", "Peer", "disagreement"]

Columns = NDArray[np.float32]
"""Seven rows, one for each of NAMES, with one column per particle."""

NAMES = ("x", "y", "z", "vx", "vy", "vz", "age")
DT = 1 / 24
GUST = (2.0, 1.0, 2.0)
"""Accelerations are drawn from -GUST to GUST, m/s^2."""
RESTITUTION = 0.1
FRICTION = 0.5
LIFE = 1e6
"""Seconds; ages are compared with it, but no particle dies."""


class Peer(Protocol):
    """Particles that take steps of the list."""

    def step(self, number: np.uint32) -> None:
        """Take one step; `number` differs from step to step."""

    def columns(self) -> Columns:
        """Copy the particles."""


def disagreement(start: Columns, end: Columns, other: Columns) -> str:
    """Return how two runs from the same start differ by more than chance explains; else "".

    The change of each column since the start must have the same mean and standard deviation in both.
    """
    ours, theirs = end.astype(float) - start, other.astype(float) - start
    chance = 5 / np.sqrt(start.shape[1])
    for name, one, two in zip(NAMES, ours, theirs, strict=True):
        spread = _spread(one)
        if abs(one.mean() - two.mean()) > (0.01 + chance) * spread + 1e-4:
            return f"{name} changed by {two.mean():.4g} on average, the engine's by {one.mean():.4g}"
        if abs(spread - _spread(two)) > (0.03 + 2 * chance) * spread + 1e-4:
            return f"changes of {name} spread by {_spread(two):.4g}, the engine's by {spread:.4g}"
    if other[1].min() < -1e-3:
        return f"a particle is {-other[1].min():.3g} m below the ground"
    return ""


def _spread(values: NDArray[Any]) -> float:
    return float(values.std())
