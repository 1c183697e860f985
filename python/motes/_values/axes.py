"""What domains cut, by name: axes of space, a curve through its cells, or the ids of particles."""

from __future__ import annotations

__all__ = ["AXES", "BY_ID", "CURVES", "are_bricks", "bits_of", "in_a_row"]

AXES = ("x", "y", "z", "xy", "xz", "yz", "xyz")
CURVES = ("hilbert", "morton")
BY_ID = "id"  # the name of axis=None in logs and in the core

_CURVE_BITS = {"morton": 1 << 4, "hilbert": 1 << 5}


def are_bricks(axes: str) -> bool:
    """Return whether domains of these axes are bricks, each with six faces."""
    return len(axes) > 1 and set(axes) <= set("xyz")


def in_a_row(axes: str) -> bool:
    """Return whether domains of these axes lie in a row: neighbours can give each other particles."""
    return axes in ("x", "y", "z", *CURVES)


def bits_of(axes: str) -> int:
    """Return the axes as the core takes them."""
    if axes in _CURVE_BITS:
        return _CURVE_BITS[axes]
    return sum(1 << "xyz".index(letter) for letter in axes if axes != BY_ID)
