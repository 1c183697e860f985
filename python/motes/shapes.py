"""Regions of space as values: where particles are born, drawn from, killed, bounced.

Units are metres. Points of sampled shapes are uniform by measure. A 3-tuple stands for a `Point` wherever a
shape is asked for. Paper: section 4, after D. McAllister's Particle System API (his "domains").
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, arguments
from .errors import ArgumentError

if TYPE_CHECKING:
    from .expressions import Condition

__all__ = [
    "Blob",
    "Box",
    "Cone",
    "Cylinder",
    "Disc",
    "Line",
    "Plane",
    "Point",
    "Rectangle",
    "Shape",
    "Sphere",
    "Triangle",
    "Union",
    "as_shape",
]


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
        """Length, area or volume in m, m^2 or m^3; 0 for a point, infinite for a plane and a blob.

        Equal radii leave a curve or a surface, measured as such. A union has the sum of its parts.
        """
        return self.core.measure()

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Say of each of the points, (n, 3) or (3,), whether the shape holds it: bool (n,) or ().

        Shapes without volume (point, line, triangle, rectangle, disc) hold none; a plane holds the half-space
        below it, a blob what is within one sigma of its centre, a union what any of its parts holds.
        """
        array = arguments.floats("points", points, np.float32, "an array of shape (n, 3) or (3,)")
        if array.ndim not in (1, 2) or array.shape[-1] != 3:
            raise ArgumentError("points", points, "an array of shape (n, 3) or (3,)")
        inside = self.core.contains(np.atleast_2d(array))
        return inside if array.ndim == 2 else inside[0]

    def sample(self, n: int, seed: int = 0) -> NDArray[np.float32]:
        """Draw n points, float32 (n, 3); the same seed gives the same points. A plane gives its own point."""
        n = arguments.integer("n", n, high=2**32 - 1)
        return self.core.sample(n, arguments.integer("seed", seed, high=2**64 - 1))

    def __or__(self, other: Shape | ArrayLike) -> Union:
        """Unite two shapes: `a | b | c` is one union of three."""
        try:
            return Union(self, as_shape("shapes", other))
        except ArgumentError:
            return NotImplemented

    def __and__(self, other: Any) -> Condition:
        """Make the condition that this shape and another, or a comparison, hold the particle."""
        both: Condition = _condition(self) & other
        return both

    __rand__ = __and__

    def __invert__(self) -> Condition:
        """Make the condition that this shape does not hold the particle."""
        return ~_condition(self)

    def __ror__(self, other: ArrayLike) -> Union:
        """Unite three numbers, a point, with this shape."""
        try:
            return Union(as_shape("shapes", other), self)
        except ArgumentError:
            return NotImplemented

    def __eq__(self, other: object) -> bool:
        """Equal kind, numbers and parts."""
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


class Triangle(Shape):
    """The triangle between three points."""

    __slots__ = ()

    def __init__(self, p0: ArrayLike, p1: ArrayLike, p2: ArrayLike) -> None:
        """Take the three corners, which span an area."""
        self._set(p0=arguments.triple("p0", p0), p1=arguments.triple("p1", p1), p2=arguments.triple("p2", p2))


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


class Cylinder(Shape):
    """The cylinder around the axis from `p0` to `p1`, or the pipe between two radii.

    With equal radii it is an open tube without thickness: drawn by area, and it holds nothing.
    """

    __slots__ = ()

    def __init__(self, p0: ArrayLike, p1: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Take the axis's two ends, the outer and the inner radius."""
        self._set(
            p0=arguments.triple("p0", p0),
            p1=arguments.triple("p1", p1),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


class Cone(Shape):
    """The cone from `apex` to the disc around `base`, or what lies between two cones with the same apex.

    Radii are those at the base. With equal radii it is the side alone: drawn by area, and it holds nothing.
    """

    __slots__ = ()

    def __init__(self, apex: ArrayLike, base: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Take the tip, the base's centre, the outer and the inner radius there."""
        self._set(
            apex=arguments.triple("apex", apex),
            base=arguments.triple("base", base),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


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


class Blob(Shape):
    """A cloud without border: each coordinate is normal with deviation `sigma` around `center`.

    It holds what is within one sigma of its centre, and has no surface to bounce off.
    """

    __slots__ = ()

    def __init__(self, center: ArrayLike, sigma: float) -> None:
        """Take the centre and the standard deviation of each coordinate in metres."""
        self._set(center=arguments.triple("center", center), sigma=arguments.number("sigma", sigma, low=0))


class Union(Shape):
    """Several shapes as one, also written `a | b`; a union among them counts as its parts.

    It holds what any part holds, and is bounced off at the part that is met first, inside other parts too.
    Points are drawn from a part picked by measure, where m, m^2 and m^3 count alike, or with equal chances
    where all measures are 0 or one is infinite. Where parts overlap, points there count for each.
    """

    __slots__ = ()

    def __init__(self, *shapes: Shape | ArrayLike) -> None:
        """Take the shapes; three numbers are a point."""
        parts: list[Shape] = []
        for value in shapes:
            shape = as_shape("shapes", value)
            parts.extend(shape.shapes if isinstance(shape, Union) else (shape,))
        if not parts:
            raise ArgumentError("shapes", shapes, "one shape or more")
        self._fields = {"shapes": tuple(parts)}
        self.core = _core.Shape.united([part.core for part in parts])

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """The parts, none of them a union."""
        parts: tuple[Shape, ...] = self._fields["shapes"]
        return parts

    def __hash__(self) -> int:
        """Hash of the parts."""
        return hash((Union, self.shapes))

    def __repr__(self) -> str:
        """Show the call that makes this shape."""
        return f"Union({', '.join(map(repr, self.shapes))})"


def _condition(shape: Shape) -> Condition:
    from .expressions import as_condition  # which is made of shapes itself

    return as_condition("shape", shape)


def as_shape(argument: str, value: Any) -> Shape:
    """Return `value`, a shape or three numbers for a `Point`."""
    if isinstance(value, Shape):
        return value
    try:
        return Point(arguments.triple(argument, value))
    except ArgumentError:
        raise ArgumentError(argument, value, "a shape or 3 finite numbers") from None
