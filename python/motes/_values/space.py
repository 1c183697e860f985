"""The axes that domains cut, and periodic space.

Domains cut axes of space, a curve through its cells, or the ids of particles. Along periodic axes, positions
wrap at the ends of an interval, and crossings are counted.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import ArgumentError

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["AXES", "BY_ID", "CROSSINGS", "CURVES", "Period", "are_bricks", "bits_of", "ends_of"]
__all__ += ["half_period", "in_a_row", "periods_of", "unwrap"]

AXES = ("x", "y", "z", "xy", "xz", "yz", "xyz")
CURVES = ("hilbert", "morton")
BY_ID = "id"  # the name of axis=None in logs and in the core

_CURVE_BITS = {"morton": 1 << 4, "hilbert": 1 << 5}

CROSSINGS = "crossings"
"""The attribute that counts crossings, in systems of periodic worlds."""

FARTHEST = 1e9  # metres


class Period(NamedTuple):
    """The half-open interval [low, high) of a periodic axis; its ends are float32 values, like positions."""

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
    import numpy as np  # late, because programs that only read logs do not need it

    from . import arguments

    low, high = (
        float(np.float32(arguments.number(f"periodic[{axis!r}]", end, low=-FARTHEST, high=FARTHEST)))
        for end in ends
    )
    if not low < high:
        raise ArgumentError(f"periodic[{axis!r}]", ends, "(low, high) with low < high, as float32s")
    return Period("xyz".index(axis), low, high)


def ends_of(periods: tuple[Period, ...]) -> dict[str, list[float]]:
    """Return {axis: [low, high]} for the periodic axes, as written to files."""
    return {"xyz"[axis]: [low, high] for axis, low, high in periods}


def half_period(periods: tuple[Period, ...]) -> float:
    """Return half of the shortest period, m: the largest possible reach of interactions."""
    return min((period.high - period.low) / 2 for period in periods)


def unwrap(columns: dict[str, NDArray[Any]], periods: tuple[Period, ...]) -> dict[str, NDArray[Any]]:
    """Return columns with unwrapped positions, float64, and without the column of crossings."""
    position = columns["position"].astype("float64")
    for axis, low, high in periods:
        position[:, axis] += columns[CROSSINGS][:, axis] * (high - low)
    kept = {name: column for name, column in columns.items() if not periods or name != CROSSINGS}
    return {**kept, "position": position}


def are_bricks(axes: str) -> bool:
    """Return whether domains of these axes are bricks, each with six faces."""
    return len(axes) > 1 and set(axes) <= set("xyz")


def in_a_row(axes: str) -> bool:
    """Return whether domains of these axes lie in a row, where neighbours can exchange load pairwise."""
    return axes in ("x", "y", "z", *CURVES)


def bits_of(axes: str) -> int:
    """Return the core's bit mask of axes."""
    if axes in _CURVE_BITS:
        return _CURVE_BITS[axes]
    return sum(1 << "xyz".index(letter) for letter in axes if axes != BY_ID)
