"""Distributions of newborn particles' attributes, for `System.configure`."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._values import arguments, colors
from .._values.curves import Curve
from .._values.values import Value, value
from ..errors import ArgumentError
from ..shapes import Shape, native_of

__all__ = [
    "AlongNormal",
    "Drawn",
    "Normal",
    "State",
    "SurfaceColor",
    "Uniform",
    "along_normal",
    "distribution",
    "surface_color",
]

Drawn: TypeAlias = Union[ArrayLike, Shape, Curve, "Uniform", "Normal", "AlongNormal", "SurfaceColor"]
"""A value, or a distribution from which each particle's value is drawn."""

MOST = 1e37  # limit of parameters: neither lo..hi of twice that width nor 7 sigma overflows float32


@value()
class Uniform(Value):
    """Drawn uniformly from lo..hi.

    If lo and hi are vectors, each component is drawn independently. If they are numbers and the attribute is
    a vector, one number is drawn for all components: `size=Uniform(0.1, 0.2)` keeps particles round.
    """

    lo: ArrayLike | Curve
    """The smallest value: a number or a vector."""
    hi: ArrayLike | Curve
    """The largest value: a number or a vector."""
    _may_move = True

    def __post_init__(self) -> None:
        """Copy numbers and vectors; `distribution`, which knows the attribute, checks them."""
        self.__dict__.update(lo=_kept(self.lo), hi=_kept(self.hi))


@value()
class Normal(Value):
    """Drawn from a normal distribution.

    If mean and sigma are vectors, each component is drawn independently. If they are numbers and the
    attribute is a vector, one number is drawn for all components: `size=Normal(0.1, 0.01)` keeps particles
    round.
    """

    mean: ArrayLike | Curve
    """The mean: a number or a vector."""
    sigma: ArrayLike | Curve
    """The standard deviation, >= 0: a number or a vector."""
    _may_move = True

    def __post_init__(self) -> None:
        """Copy numbers and vectors; `distribution`, which knows the attribute, checks them."""
        self.__dict__.update(mean=_kept(self.mean), sigma=_kept(self.sigma))


def _kept(value: Any) -> Any:
    """Return a value's numbers as a tuple or float: later changes of an array have no effect."""
    if isinstance(value, (np.ndarray, list, tuple)):
        try:
            numbers = arguments.floats("", value, np.float64, "")
        except ArgumentError:
            return value  # refused later with the attribute's name
        return tuple(numbers.tolist()) if numbers.ndim == 1 else value
    return float(value) if isinstance(value, (np.integer, np.floating)) else value


@value()
class AlongNormal(Value):
    """A vector along the mesh's outward normal where a particle is born: `motes.along_normal`."""

    length: float | Curve
    """The vector's length; negative: inwards."""
    _may_move = True

    def __post_init__(self) -> None:
        """Check the length."""
        self.__dict__["length"] = _in_float32("length", arguments.number("length", self.length))


@value()
class SurfaceColor(Value):
    """The mesh's colour where a particle is born: `motes.surface_color`."""


def along_normal(length: float | Curve) -> AlongNormal:
    """Give newborn particles a vector along the emitting mesh's normal where each is born.

    For `configure`, as in `configure(velocity=motes.along_normal(2.0))`. Births in other shapes or inside a
    mesh are errors. Normals point to the side from which a triangle's corners appear anticlockwise.

    Args:
        length: the vector's length in the attribute's unit, for velocity m/s; negative: inwards.

    Returns:
        A value that `configure` accepts for attributes of three numbers.
    """
    return AlongNormal(length)


def surface_color() -> SurfaceColor:
    """Give newborn particles the emitting mesh's colour where each is born.

    For `configure`, as in `configure(color=motes.surface_color())`. The mesh must have `colors`; they are
    interpolated between vertices.

    Returns:
        A value that `configure` accepts for attributes of three numbers.
    """
    return SurfaceColor()


class State(TypedDict, total=False):
    """The built-in attributes that newborn particles can be given."""

    velocity: Drawn
    velocity_b: Drawn
    up: Drawn
    rotational_velocity: Drawn
    color: Drawn
    alpha: Drawn
    size: Drawn
    mass: Drawn
    age: Drawn
    lifetime: Drawn
    position_b: Drawn
    up_b: Drawn
    orientation: ArrayLike | Literal["random"]
    spin: Drawn


def distribution(attribute: str, width: int, value: Any) -> _core.Distribution:
    """Return the engine's distribution of an attribute with `width` numbers per particle: 1, 3 or 4."""
    if width == 4:
        return _orientation(attribute, value)
    if isinstance(value, Shape):
        if width != 3:
            raise ArgumentError(
                attribute, value, "a number, Uniform or Normal: it has one number per particle"
            )
        return _core.Distribution.shape(native_of(value))
    if isinstance(value, Uniform):
        lo, hi, alike = _pair(attribute, width, value.lo, value.hi)
        if any(a > b for a, b in zip(lo, hi, strict=True)):
            raise ArgumentError(attribute, value, "drawn from lo <= hi")
        return _core.Distribution.uniform(lo, hi, alike)
    if isinstance(value, Normal):
        mean, sigma, alike = _pair(attribute, width, value.mean, value.sigma)
        if any(s < 0 for s in sigma):
            raise ArgumentError(attribute, value, "drawn with sigma >= 0")
        return _core.Distribution.normal(mean, sigma, alike)
    if isinstance(value, (AlongNormal, SurfaceColor)):
        if width != 3:
            raise ArgumentError(attribute, value, "a number: it has one per particle, a surface gives three")
        if isinstance(value, SurfaceColor):
            return _core.Distribution.surface_color()
        assert isinstance(value.length, float)  # curves have been evaluated
        return _core.Distribution.along_normal(value.length)
    return _core.Distribution.value(_numbers(attribute, width, value, endless=attribute == "lifetime"))


def _orientation(attribute: str, value: Any) -> _core.Distribution:
    if isinstance(value, str) and value == "random":
        return _core.Distribution.rotation()
    allowed = "a quaternion (x, y, z, w) other than 0, or 'random'"
    try:
        numbers = arguments.floats(attribute, value, np.float64, allowed)
    except ArgumentError:
        raise ArgumentError(attribute, value, allowed, known=("random",)) from None
    length = float(np.linalg.norm(numbers)) if numbers.shape == (4,) else 0.0
    if not 0 < length < MOST:
        raise ArgumentError(attribute, value, allowed)
    return _core.Distribution.value((numbers / length).tolist())


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _pair(attribute: str, width: int, first: Any, second: Any) -> tuple[list[float], list[float], bool]:
    """Return two parameters as numbers, and whether one draw is used for all components of a vector."""
    alike = width == 3 and _is_number(first) and _is_number(second)
    if alike:
        first, second = (first,) * 3, (second,) * 3
    return _numbers(attribute, width, first), _numbers(attribute, width, second), alike


def _numbers(attribute: str, width: int, value: Any, *, endless: bool = False) -> list[float]:
    if width == 1:
        return [_in_float32(attribute, arguments.number(attribute, value, finite=not endless))]
    if isinstance(value, (int, float, np.integer, np.floating)) and attribute == "size":
        value = (value, value, value)  # a scalar size applies to all axes
    numbers = arguments.triple(attribute, _vector(attribute, value), pair=attribute != "color")
    return [_in_float32(attribute, v) for v in numbers]


def _vector(attribute: str, value: Any) -> Any:
    return colors.named(attribute, value) if attribute == "color" and isinstance(value, str) else value


def _in_float32(attribute: str, value: float) -> float:
    if abs(value) > MOST and value != float("inf"):
        raise ArgumentError(attribute, value, f"within {MOST:g}")
    return value
