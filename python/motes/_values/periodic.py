"""Periodic space: along some axes positions wrap at the ends of an interval, and crossings are counted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ArgumentError
from . import arguments

__all__ = ["CROSSINGS", "Period", "ends_of", "half_period", "periods_of", "unwrap"]

CROSSINGS = "crossings"
"""The attribute that counts crossings, in systems of periodic worlds."""

FARTHEST = 1e9  # metres


class Period(NamedTuple):
    """The half-open interval [low, high) of an axis, whose ends are float32s as positions are."""

    axis: int
    low: float
    high: float


def periods_of(value: Any) -> tuple[Period, ...]:
    """Return the periods of `World(periodic=...)`, in the order x, y, z; none for None."""
    allowed = "None or a dict of axes 'x', 'y', 'z' and their (low, high), m"
    if value is None:
        return ()
    if not isinstance(value, Mapping):
        raise ArgumentError("periodic", value, allowed)
    for axis in value:
        if axis not in ("x", "y", "z"):
            raise ArgumentError("periodic", axis, allowed)
    return tuple(_period(axis, value[axis]) for axis in "xyz" if axis in value)


def _period(axis: str, ends: Any) -> Period:
    if isinstance(ends, str) or not isinstance(ends, (tuple, list)) or len(ends) != 2:
        raise ArgumentError(f"periodic[{axis!r}]", ends, "(low, high), m")
    low, high = (
        float(np.float32(arguments.number(f"periodic[{axis!r}]", end, low=-FARTHEST, high=FARTHEST)))
        for end in ends
    )
    if not low < high:
        raise ArgumentError(f"periodic[{axis!r}]", ends, "(low, high) with low < high, as float32s")
    return Period("xyz".index(axis), low, high)


def ends_of(periods: tuple[Period, ...]) -> dict[str, list[float]]:
    """Return the ends of each periodic axis by its name, as files say them."""
    return {"xyz"[axis]: [low, high] for axis, low, high in periods}


def half_period(periods: tuple[Period, ...]) -> float:
    """Return half of the shortest period, m: the farthest that particles may see each other."""
    return min((period.high - period.low) / 2 for period in periods)


def unwrap(columns: dict[str, NDArray[Any]], periods: tuple[Period, ...]) -> dict[str, NDArray[Any]]:
    """Return columns with the positions of particles that never wrapped, float64, and without crossings."""
    position = columns["position"].astype(np.float64)
    for axis, low, high in periods:
        position[:, axis] += columns[CROSSINGS][:, axis] * (high - low)
    kept = {name: column for name, column in columns.items() if not periods or name != CROSSINGS}
    return {**kept, "position": position}
