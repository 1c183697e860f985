"""How newborn particles get their attributes (System.configure)."""

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
"""A value, or what each particle's value is drawn from."""

MOST = 1e37  # no draw leaves float32's range: neither a range of twice that, nor 7 sigma


@value()
class Uniform(Value):
    """Drawn uniformly from lo..hi.

    The ends are vectors, and each component is drawn by itself; or numbers, and where a vector stands one
    number is drawn for all three: `size=Uniform(0.1, 0.2)` keeps particles round.
    """

    lo: ArrayLike | Curve
    """The least value: a number or a vector."""
    hi: ArrayLike | Curve
    """The largest value: a number or a vector."""
    _may_move = True

    def __post_init__(self) -> None:
        """Keep numbers and tuples; they are checked where the attribute is known."""
        self.__dict__.update(lo=_kept(self.lo), hi=_kept(self.hi))


@value()
class Normal(Value):
    """Drawn from a normal distribution.

    Mean and standard deviation are vectors, and each component is drawn by itself; or numbers, and where a
    vector stands one number is drawn for all three: `size=Normal(0.1, 0.01)` keeps particles round.
    """

    mean: ArrayLike | Curve
    """The mean: a number or a vector."""
    sigma: ArrayLike | Curve
    """The standard deviation: a number or a vector, 0 or more."""
    _may_move = True

    def __post_init__(self) -> None:
        """Keep numbers and tuples; they are checked where the attribute is known."""
        self.__dict__.update(mean=_kept(self.mean), sigma=_kept(self.sigma))


def _kept(value: Any) -> Any:
    """Return the numbers of a value, so that later changes of an array have no effect."""
    if isinstance(value, (np.ndarray, list, tuple)):
        try:
            numbers = arguments.floats("", value, np.float64, "")
        except ArgumentError:
            return value  # refused when it is used, with the attribute's name
        return tuple(numbers.tolist()) if numbers.ndim == 1 else value
    return float(value) if isinstance(value, (np.integer, np.floating)) else value


@value()
class AlongNormal(Value):
    """A vector along the outward normal of the mesh where a particle is born: `motes.along_normal`."""

    length: float | Curve
    """Its length; negative: inwards."""
    _may_move = True

    def __post_init__(self) -> None:
        """Check the length."""
        self.__dict__["length"] = _in_float32("length", arguments.number("length", self.length))


@value()
class SurfaceColor(Value):
    """The colour of the mesh where a particle is born: `motes.surface_color`."""


def along_normal(length: float | Curve) -> AlongNormal:
    """Give newborn particles a vector along the normal of the mesh that emits them, where each is born.

    For `configure`, as in `configure(velocity=motes.along_normal(2.0))`: births on other shapes, or from the
    inside of a mesh, are an error. Normals point to where a triangle's corners run anticlockwise.

    Args:
        length: of the vector, in the attribute's unit, for velocity m/s; negative: inwards.

    Returns:
        What `configure` takes for an attribute of three numbers.
    """
    return AlongNormal(length)


def surface_color() -> SurfaceColor:
    """Give newborn particles the colour that the mesh that emits them has where each is born.

    For `configure`, as in `configure(color=motes.surface_color())`. The mesh must have `colors`; between
    vertices they are mixed.

    Returns:
        What `configure` takes for an attribute of three numbers.
    """
    return SurfaceColor()


class State(TypedDict, total=False):
    """Attributes that newborn particles can get, besides a system's own."""

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
    """Turn a value, shape, Uniform or Normal into the engine's; `width` is 1, 3 or 4 numbers per particle."""
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
    """Return two values as numbers, and whether one draw counts for all components of a vector."""
    alike = width == 3 and _is_number(first) and _is_number(second)
    if alike:
        first, second = (first,) * 3, (second,) * 3
    return _numbers(attribute, width, first), _numbers(attribute, width, second), alike


def _numbers(attribute: str, width: int, value: Any, *, endless: bool = False) -> list[float]:
    if width == 1:
        return [_in_float32(attribute, arguments.number(attribute, value, finite=not endless))]
    if isinstance(value, (int, float, np.integer, np.floating)) and attribute == "size":
        value = (value, value, value)  # a size of one number is the same along all axes
    numbers = arguments.triple(attribute, _vector(attribute, value), pair=attribute != "color")
    return [_in_float32(attribute, v) for v in numbers]


def _vector(attribute: str, value: Any) -> Any:
    return colors.named(attribute, value) if attribute == "color" and isinstance(value, str) else value


def _in_float32(attribute: str, value: float) -> float:
    if abs(value) > MOST and value != float("inf"):
        raise ArgumentError(attribute, value, f"within {MOST:g}")
    return value
