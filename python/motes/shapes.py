"""Regions of space as values: where particles are born, drawn from, killed, bounced.

Units are metres. Points of sampled shapes are uniform by measure. A 3-tuple stands for a `Point` wherever a
shape is asked for. Paper: section 4, after D. McAllister's Particle System API (his "domains").
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, arguments
from .errors import ArgumentError

__all__ = ["Box", "Disc", "Line", "Plane", "Point", "Rectangle", "Shape", "Sphere", "as_shape"]


class Shape:
    """What all shapes can do."""

    __slots__ = ("_fields", "core")

    core: _core.Shape
    """The engine's value; for the package itself."""

    def _set(self, **fields: Any) -> None:
        numbers: list[float] = []
        for value in fields.values():
            numbers.extend(value if isinstance(value, tuple) else (value,))
        self._fields = fields
        self.core = _core.Shape(type(self).__name__, numbers)

    @property
    def measure(self) -> float:
        """Length, area or volume in m, m^2 or m^3; 0 for a point, infinite for a plane."""
        return self.core.measure()

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Say of each of the points, (n, 3) or (3,), whether the shape holds it: bool (n,) or ().

        Shapes without volume (point, line, rectangle, disc) hold none; a plane holds the half-space below it.
        """
        array = np.asarray(points, np.float32)
        if array.ndim not in (1, 2) or array.shape[-1] != 3:
            raise ArgumentError("points", points, "an array of shape (n, 3) or (3,)")
        inside = self.core.contains(np.atleast_2d(array))
        return inside if array.ndim == 2 else inside[0]

    def sample(self, n: int, seed: int = 0) -> NDArray[np.float32]:
        """Draw n points, float32 (n, 3); the same seed gives the same points. A plane gives its own point."""
        return self.core.sample(arguments.integer("n", n), arguments.integer("seed", seed, high=2**64 - 1))

    def __eq__(self, other: object) -> bool:
        """Equal kind and numbers."""
        return isinstance(other, Shape) and self.core == other.core

    def __hash__(self) -> int:
        """Hash of kind and numbers."""
        return hash((type(self), tuple(self.core.numbers)))

    def __repr__(self) -> str:
        """Show the call that makes this shape."""
        words = ", ".join(f"{name}={value!r}" for name, value in self._fields.items())
        return f"{type(self).__name__}({words})"


class Point(Shape):
    """A single point `p`."""

    __slots__ = ()

    def __init__(self, p: ArrayLike) -> None:
        """Take the point's coordinates."""
        self._set(p=arguments.triple("p", p))


class Line(Shape):
    """The segment from `p0` to `p1`."""

    __slots__ = ()

    def __init__(self, p0: ArrayLike, p1: ArrayLike) -> None:
        """Take the two ends."""
        self._set(p0=arguments.triple("p0", p0), p1=arguments.triple("p1", p1))


class Rectangle(Shape):
    """The parallelogram `origin` + a `u` + b `v`, a and b in 0..1."""

    __slots__ = ()

    def __init__(self, origin: ArrayLike, u: ArrayLike, v: ArrayLike) -> None:
        """Take a corner and the two edges that start there."""
        self._set(
            origin=arguments.triple("origin", origin), u=arguments.triple("u", u), v=arguments.triple("v", v)
        )


class Disc(Shape):
    """A flat ring around `center`, perpendicular to `normal`."""

    __slots__ = ()

    def __init__(self, center: ArrayLike, normal: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Take the centre, the normal (any length), the outer and the inner radius."""
        self._set(
            center=arguments.triple("center", center),
            normal=arguments.triple("normal", normal),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


class Plane(Shape):
    """The plane through `point`; it contains the half-space on the side away from `normal`."""

    __slots__ = ()

    def __init__(self, point: ArrayLike, normal: ArrayLike) -> None:
        """Take any point of the plane and its normal (any length)."""
        self._set(point=arguments.triple("point", point), normal=arguments.triple("normal", normal))


class Box(Shape):
    """The axis-aligned box between two corners."""

    __slots__ = ()

    def __init__(self, low: ArrayLike, high: ArrayLike) -> None:
        """Take the corner with the lowest and the one with the highest coordinates."""
        self._set(low=arguments.triple("low", low), high=arguments.triple("high", high))


class Sphere(Shape):
    """The ball around `center`, or the thick shell between two radii."""

    __slots__ = ()

    def __init__(self, center: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Take the centre, the outer and the inner radius."""
        self._set(
            center=arguments.triple("center", center),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


def as_shape(argument: str, value: Any) -> Shape:
    """Return `value`, a shape or three numbers for a `Point`."""
    if isinstance(value, Shape):
        return value
    try:
        return Point(arguments.triple(argument, value))
    except ArgumentError:
        raise ArgumentError(argument, value, "a shape or 3 finite numbers") from None
