"""Regions of space as values: where particles are born, killed or bounced, and what is drawn from them.

Units are metres. Points of sampled shapes are uniform by measure. A vector, 3 numbers or 2 for (x, y, 0),
stands for a `Point` wherever a shape is asked for. Paper: section 4, after D. McAllister's Particle System
API (his "domains").
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._values import arguments
from .._values.arguments import Triple
from .._values.values import Value, value
from ..errors import ArgumentError, missing
from ..expressions._conditions import Condition, Region, as_condition

if TYPE_CHECKING:
    from ._mesh import Mesh

__all__ = [
    "Blob",
    "Box",
    "Cone",
    "Cylinder",
    "Disc",
    "Line",
    "Mesh",
    "Plane",
    "Point",
    "Rectangle",
    "Shape",
    "Sphere",
    "Triangle",
    "Union",
]


class Shape(Region, Value):
    """What all shapes can do."""

    def _set(self, **fields: Any) -> None:
        numbers: list[float] = []
        for number in fields.values():
            if type(number) is tuple:
                numbers.extend(number)
            else:
                numbers.append(number)
        state = self.__dict__
        state.update(fields)
        state["_native"] = _core.Shape(type(self).__name__, numbers)  # which checks the numbers

    @property
    def measure(self) -> float:
        """Length, area or volume in m, m^2 or m^3; 0 for a point, infinite for a plane and a blob.

        Equal radii leave a curve or a surface, measured as such. A union has the sum of its parts.
        """
        return self._native.measure()

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Tell which points the shape holds.

        Shapes without volume (point, line, triangle, rectangle, disc) hold none; a plane holds the half-space
        below it, a blob what is within one sigma of its centre, a union what any of its parts holds.

        Args:
            points: (n, 3) or (3,), m; points of 2 numbers lie at z = 0.

        Returns:
            bool (n,), or () for one point.
        """
        allowed = "an array of shape (n, 3) or (3,)"
        array = arguments.floats("points", points, np.float32, allowed)
        if array.ndim not in (1, 2) or array.shape[-1] not in (2, 3):
            raise ArgumentError("points", points, allowed, hint=arguments.PAIR)
        array = arguments.with_z(array)
        inside = self._native.contains(np.atleast_2d(array))
        return inside if array.ndim == 2 else inside[0]

    def sample(self, n: int, seed: int = 0) -> NDArray[np.float32]:
        """Draw points of the shape, uniformly by measure. A plane gives its own point.

        Args:
            n: how many.
            seed: 0..2^64-1; the same seed gives the same points.

        Returns:
            float32 (n, 3), m.
        """
        n = arguments.integer("n", n, high=2**32 - 1)
        return self._native.sample(n, arguments.integer("seed", seed, high=2**64 - 1))

    def __or__(self, other: Shape | ArrayLike) -> Union:
        """Unite two shapes: `a | b | c` is one union of three."""
        try:
            return Union(self, as_shape("shapes", other))
        except ArgumentError:
            return NotImplemented

    def __and__(self, other: Any) -> Condition:
        """Make the condition that this shape and another, or a comparison, hold the particle."""
        both: Condition = as_condition("shape", self) & other
        return both

    __rand__ = __and__

    def __invert__(self) -> Condition:
        """Make the condition that this shape does not hold the particle."""
        return ~as_condition("shape", self)

    def __ror__(self, other: ArrayLike) -> Union:
        """Unite a vector, which is a point, with this shape."""
        try:
            return Union(as_shape("shapes", other), self)
        except ArgumentError:
            return NotImplemented


@value(init=False)
class Point(Shape):
    """A single point.

    Attributes:
        p: its coordinates, m.
    """

    p: Triple

    def __init__(self, p: ArrayLike) -> None:
        """Take the point's coordinates."""
        self._set(p=arguments.triple("p", p))


@value(init=False)
class Line(Shape):
    """A segment.

    Attributes:
        p0: one end, m.
        p1: the other end, m.
    """

    p0: Triple
    p1: Triple

    def __init__(self, p0: ArrayLike, p1: ArrayLike) -> None:
        """Take the two ends."""
        self._set(p0=arguments.triple("p0", p0), p1=arguments.triple("p1", p1))


@value(init=False)
class Triangle(Shape):
    """The triangle between three points."""

    p0: Triple
    """A corner, m."""
    p1: Triple
    """A corner, m."""
    p2: Triple
    """A corner, m."""

    def __init__(self, p0: ArrayLike, p1: ArrayLike, p2: ArrayLike) -> None:
        """Take the three corners, which span an area."""
        self._set(p0=arguments.triple("p0", p0), p1=arguments.triple("p1", p1), p2=arguments.triple("p2", p2))


@value(init=False)
class Rectangle(Shape):
    """The parallelogram `origin` + a `u` + b `v`, a and b in 0..1.

    Attributes:
        origin: a corner, m.
        u: an edge that starts there, m.
        v: the other edge that starts there, m.
    """

    origin: Triple
    u: Triple
    v: Triple

    def __init__(self, origin: ArrayLike, u: ArrayLike, v: ArrayLike) -> None:
        """Take a corner and the two edges that start there."""
        self._set(
            origin=arguments.triple("origin", origin), u=arguments.triple("u", u), v=arguments.triple("v", v)
        )


@value(init=False)
class Disc(Shape):
    """A flat ring around `center`, perpendicular to `normal`."""

    center: Triple
    """Its middle, m."""
    normal: Triple
    """What it is perpendicular to; any length."""
    radius: float
    """The outer radius, m."""
    inner_radius: float = 0
    """The radius of its hole, m."""

    def __init__(self, center: ArrayLike, normal: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Take the centre, the normal (any length), the outer and the inner radius."""
        self._set(
            center=arguments.triple("center", center),
            normal=arguments.triple("normal", normal),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


@value(init=False)
class Plane(Shape):
    """The plane through `point`; it contains the half-space on the side opposite to `normal`."""

    point: Triple
    """Any point of it, m."""
    normal: Triple
    """What points away from the half-space that it contains; any length."""

    def __init__(self, point: ArrayLike, normal: ArrayLike) -> None:
        """Take any point of the plane and its normal (any length)."""
        self._set(point=arguments.triple("point", point), normal=arguments.triple("normal", normal))


@value(init=False)
class Box(Shape):
    """The axis-aligned box between two corners."""

    low: Triple
    """The corner with the lowest coordinates, m."""
    high: Triple
    """The corner with the highest coordinates, m."""

    def __init__(self, low: ArrayLike, high: ArrayLike) -> None:
        """Take the corner with the lowest and the one with the highest coordinates."""
        self._set(low=arguments.triple("low", low), high=arguments.triple("high", high))


@value(init=False)
class Cylinder(Shape):
    """The cylinder around the axis from `p0` to `p1`, or the pipe between two radii.

    With equal radii it is an open tube without thickness: drawn by area, and it holds nothing.
    """

    p0: Triple
    """An end of its axis, m."""
    p1: Triple
    """The other end, m."""
    radius: float
    """The outer radius, m."""
    inner_radius: float = 0
    """The radius of the pipe's inside, m."""

    def __init__(self, p0: ArrayLike, p1: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Take the axis's two ends, the outer and the inner radius."""
        self._set(
            p0=arguments.triple("p0", p0),
            p1=arguments.triple("p1", p1),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


@value(init=False)
class Cone(Shape):
    """The cone from `apex` to the disc around `base`, or what lies between two cones with the same apex.

    Radii are those at the base. With equal radii it is the side alone: drawn by area, and it holds nothing.
    """

    apex: Triple
    """Its tip, m."""
    base: Triple
    """The middle of its base, m."""
    radius: float
    """The outer radius at the base, m."""
    inner_radius: float = 0
    """The radius of the inner cone at the base, m."""

    def __init__(self, apex: ArrayLike, base: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Take the tip, the base's centre, the outer and the inner radius there."""
        self._set(
            apex=arguments.triple("apex", apex),
            base=arguments.triple("base", base),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


@value(init=False)
class Sphere(Shape):
    """The ball around `center`, or the thick shell between two radii."""

    center: Triple
    """Its middle, m."""
    radius: float
    """The outer radius, m."""
    inner_radius: float = 0
    """The radius of its hollow, m."""

    def __init__(self, center: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Take the centre, the outer and the inner radius."""
        self._set(
            center=arguments.triple("center", center),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


@value(init=False)
class Blob(Shape):
    """A cloud without border: each coordinate is normally distributed around `center` with deviation `sigma`.

    It holds what is within one sigma of its centre, and has no surface to bounce off.
    """

    center: Triple
    """Its middle, m."""
    sigma: float
    """The standard deviation of each coordinate, m."""

    def __init__(self, center: ArrayLike, sigma: float) -> None:
        """Take the centre and the standard deviation of each coordinate in metres."""
        self._set(center=arguments.triple("center", center), sigma=arguments.number("sigma", sigma, low=0))


@value(init=False)
class Union(Shape):
    """Several shapes as one, also written `a | b`; a union among them counts as its parts.

    It holds what any part holds; particles bounce off the part that is hit first, even inside other parts.
    Points are drawn from a part chosen in proportion to its measure, where m, m^2 and m^3 count equally, or
    with equal chances if all measures are 0 or one is infinite. Where parts overlap, points are drawn for
    each.
    """

    shapes: tuple[Shape, ...]
    """The parts, none of them a union."""

    def __init__(self, *shapes: Shape | ArrayLike) -> None:
        """Take the parts.

        Args:
            *shapes: shapes; a vector is a point.
        """
        parts: list[Shape] = []
        for given in shapes:
            shape = as_shape("shapes", given)
            parts.extend(shape.shapes if isinstance(shape, Union) else (shape,))
        if not parts:
            raise ArgumentError("shapes", shapes, "one shape or more")
        self.__dict__.update(
            shapes=tuple(parts), _native=_core.Shape.united([part._native for part in parts])
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the parts."""
        return Union, self.shapes

    def __repr__(self) -> str:
        """Show the call that makes this shape."""
        return f"Union({', '.join(map(repr, self.shapes))})"


def __getattr__(name: str) -> Any:
    if name == "Mesh":  # whose module needs this one
        from ._mesh import Mesh

        return Mesh
    raise missing("motes.shapes", name, __all__)


def __dir__() -> list[str]:
    return [*__all__]


def native_of(shape: Shape) -> _core.Shape:
    """Return what the engine takes for a shape, for the rest of the package."""
    return shape._native


def as_shape(argument: str, value: Any) -> Shape:
    """Return `value`, a shape or a vector for a `Point`."""
    if isinstance(value, Shape):
        return value
    try:
        return Point(arguments.triple(argument, value))
    except ArgumentError:
        raise ArgumentError(argument, value, "a shape or 3 finite numbers", hint=arguments.PAIR) from None
