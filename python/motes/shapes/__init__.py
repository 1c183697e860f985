"""Regions of space as values: where particles are born, die or bounce, and distributions to sample from.

Units are metres. Samples are uniform by length, area or volume. Wherever a shape is expected, a vector of 3
numbers, or 2 for (x, y, 0), counts as a `Point`. Paper: section 4, after D. McAllister's Particle System API
(his "domains").
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
    from .._values.materials import Material
    from ._mesh import Mesh
    from ._outlines import Picture, Text

__all__ = [
    "Blob",
    "Box",
    "Cone",
    "Cylinder",
    "Disc",
    "Line",
    "Material",
    "Mesh",
    "Picture",
    "Plane",
    "Point",
    "Rectangle",
    "Shape",
    "Sphere",
    "Text",
    "Triangle",
    "Union",
]


class Shape(Region, Value):
    """Base of all shapes."""

    def _set(self, **fields: Any) -> None:
        numbers: list[float] = []
        for number in fields.values():
            if type(number) is tuple:
                numbers.extend(number)
            else:
                numbers.append(number)
        state = self.__dict__
        state.update(fields)
        state["_native"] = _core.Shape(type(self).__name__, numbers)  # checks the numbers

    @property
    def measure(self) -> float:
        """Length, area or volume in m, m^2 or m^3; 0 for a point, infinite for a plane and a blob.

        A shape with equal radii is a curve or a surface and measured as such. A union's measure is the sum of
        its parts'.
        """
        return self._native.measure()

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return which points are inside the shape.

        Shapes without volume (point, line, triangle, rectangle, disc) contain no points. A plane contains the
        half-space below it, a blob the points within one sigma of its centre, a union the points in any of
        its parts.

        Args:
            points: (n, 3) or (3,), m; points with 2 numbers have z = 0.

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
        """Draw random points from the shape, uniform by measure. A plane returns its `point`.

        Args:
            n: number of points.
            seed: 0..2^64-1; the same seed gives the same points.

        Returns:
            float32 (n, 3), m.
        """
        n = arguments.integer("n", n, high=2**32 - 1)
        return self._native.sample(n, arguments.integer("seed", seed, high=2**64 - 1))

    def __or__(self, other: Shape | ArrayLike) -> Union:
        """Return the union of two shapes: `a | b | c` is one union of three."""
        try:
            return Union(self, as_shape("shapes", other))
        except ArgumentError:
            return NotImplemented

    def __and__(self, other: Any) -> Condition:
        """Return the condition that a particle is inside this shape and satisfies `other`."""
        both: Condition = as_condition("shape", self) & other
        return both

    __rand__ = __and__

    def __invert__(self) -> Condition:
        """Return the condition that a particle is outside this shape."""
        return ~as_condition("shape", self)

    def __ror__(self, other: ArrayLike) -> Union:
        """Return the union of a vector, as a `Point`, and this shape."""
        try:
            return Union(as_shape("shapes", other), self)
        except ArgumentError:
            return NotImplemented


@value(init=False)
class Point(Shape):
    """A single point.

    Attributes:
        p: the point's coordinates, m.
    """

    p: Triple

    def __init__(self, p: ArrayLike) -> None:
        """Make a point from its coordinates."""
        self._set(p=arguments.triple("p", p))


@value(init=False)
class Line(Shape):
    """A line segment.

    Attributes:
        p0: one end, m.
        p1: the other end, m.
    """

    p0: Triple
    p1: Triple

    def __init__(self, p0: ArrayLike, p1: ArrayLike) -> None:
        """Make a segment from its two ends."""
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
        """Make a triangle from three corners that are not on one line."""
        self._set(p0=arguments.triple("p0", p0), p1=arguments.triple("p1", p1), p2=arguments.triple("p2", p2))


@value(init=False)
class Rectangle(Shape):
    """The parallelogram `origin` + a `u` + b `v`, a and b in 0..1.

    Attributes:
        origin: a corner, m.
        u: one edge from the corner, m.
        v: the other edge from the corner, m.
    """

    origin: Triple
    u: Triple
    v: Triple

    def __init__(self, origin: ArrayLike, u: ArrayLike, v: ArrayLike) -> None:
        """Make a parallelogram from a corner and the two edges that start there."""
        self._set(
            origin=arguments.triple("origin", origin), u=arguments.triple("u", u), v=arguments.triple("v", v)
        )


@value(init=False)
class Disc(Shape):
    """A flat ring around `center`, perpendicular to `normal`."""

    center: Triple
    """The centre, m."""
    normal: Triple
    """A vector perpendicular to the disc; any length."""
    radius: float
    """The outer radius, m."""
    inner_radius: float = 0
    """The hole's radius, m."""

    def __init__(self, center: ArrayLike, normal: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Make a disc from its centre, normal (any length), outer and inner radius."""
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
    """Any point of the plane, m."""
    normal: Triple
    """A vector pointing out of the half-space that the plane contains; any length."""

    def __init__(self, point: ArrayLike, normal: ArrayLike) -> None:
        """Make a plane from one of its points and its normal (any length)."""
        self._set(point=arguments.triple("point", point), normal=arguments.triple("normal", normal))


@value(init=False)
class Box(Shape):
    """The axis-aligned box between two corners."""

    low: Triple
    """The corner with the lowest coordinates, m."""
    high: Triple
    """The corner with the highest coordinates, m."""

    def __init__(self, low: ArrayLike, high: ArrayLike) -> None:
        """Make a box from its corners with the lowest and the highest coordinates."""
        self._set(low=arguments.triple("low", low), high=arguments.triple("high", high))


@value(init=False)
class Cylinder(Shape):
    """The cylinder around the axis from `p0` to `p1`, or the pipe between two radii.

    With equal radii it is an open tube without thickness: sampled by area, and containing no points.
    """

    p0: Triple
    """One end of the axis, m."""
    p1: Triple
    """The other end, m."""
    radius: float
    """The outer radius, m."""
    inner_radius: float = 0
    """The pipe's inner radius, m."""

    def __init__(self, p0: ArrayLike, p1: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Make a cylinder from the two ends of its axis, outer and inner radius."""
        self._set(
            p0=arguments.triple("p0", p0),
            p1=arguments.triple("p1", p1),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


@value(init=False)
class Cone(Shape):
    """The cone from `apex` to the disc around `base`, or the space between two cones with the same apex.

    With equal radii it is only the lateral surface: sampled by area, and containing no points.
    """

    apex: Triple
    """The tip, m."""
    base: Triple
    """The centre of the base, m."""
    radius: float
    """The outer radius at the base, m."""
    inner_radius: float = 0
    """The radius of the inner cone at the base, m."""

    def __init__(self, apex: ArrayLike, base: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Make a cone from its tip, the base's centre, and the outer and inner radius at the base."""
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
    """The centre, m."""
    radius: float
    """The outer radius, m."""
    inner_radius: float = 0
    """The cavity's radius, m."""

    def __init__(self, center: ArrayLike, radius: float, inner_radius: float = 0) -> None:
        """Make a ball or shell from its centre, outer and inner radius."""
        self._set(
            center=arguments.triple("center", center),
            radius=arguments.number("radius", radius, low=0),
            inner_radius=arguments.number("inner_radius", inner_radius, low=0),
        )


@value(init=False)
class Blob(Shape):
    """A cloud without a border: coordinates are normally distributed around `center` with deviation `sigma`.

    It contains the points within one sigma of its centre, and has no surface to bounce off.
    """

    center: Triple
    """The centre, m."""
    sigma: float
    """The standard deviation of each coordinate, m."""

    def __init__(self, center: ArrayLike, sigma: float) -> None:
        """Make a blob from its centre and the standard deviation of each coordinate in metres."""
        self._set(center=arguments.triple("center", center), sigma=arguments.number("sigma", sigma, low=0))


@value(init=False)
class Union(Shape):
    """Several shapes as one, also written `a | b`; nested unions are flattened.

    It contains the points in any of its parts; particles bounce off the part that is hit first, even inside
    other parts. `sample` chooses a part with a probability proportional to its measure (m, m^2 and m^3 count
    equally), or with equal probability if all measures are 0 or one is infinite. Overlaps are sampled once
    per part.
    """

    shapes: tuple[Shape, ...]
    """The parts, none of them a union."""

    def __init__(self, *shapes: Shape | ArrayLike) -> None:
        """Make a union of its parts.

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
    if name == "Mesh":  # its module imports this one
        from ._mesh import Mesh

        return Mesh
    if name == "Material":
        from .._values.materials import Material

        return Material
    if name in ("Picture", "Text"):
        from . import _outlines

        return getattr(_outlines, name)
    raise missing("motes.shapes", name, __all__)


def __dir__() -> list[str]:
    return [*__all__]


def native_of(shape: Shape) -> _core.Shape:
    """Return the engine's shape; for use elsewhere in the package."""
    return shape._native


def as_shapes(argument: str, value: Any) -> Shape:
    """Return `value` as a shape; a list of shapes becomes their union."""
    if not isinstance(value, (list, tuple)) or not any(isinstance(part, Shape) for part in value):
        return as_shape(argument, value)
    parts = [as_shape(f"{argument}[{i}]", part) for i, part in enumerate(value)]
    return parts[0] if len(parts) == 1 else Union(*parts)


def as_shape(argument: str, value: Any) -> Shape:
    """Return `value` as a shape; a vector becomes a `Point`."""
    if isinstance(value, Shape):
        return value
    try:
        return Point(arguments.triple(argument, value))
    except ArgumentError:
        raise ArgumentError(argument, value, "a shape or 3 finite numbers", hint=arguments.PAIR) from None
