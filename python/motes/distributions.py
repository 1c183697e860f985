"""How newborn particles get their attributes (System.configure)."""

from __future__ import annotations

from typing import Any, TypeAlias, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _core, arguments
from .curves import Curve
from .errors import ArgumentError
from .shapes import Shape
from .values import Value, value

__all__ = ["Drawn", "Normal", "State", "Uniform", "distribution"]

Drawn: TypeAlias = Union[ArrayLike, Shape, Curve, "Uniform", "Normal"]
"""A value, or what each particle's value is drawn from."""

MOST_ALIKE = 1e12  # of numbers that stand for a vector
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
    """Drawn from a normal distribution, each component independently.

    Mean and standard deviation are numbers, or vectors for an attribute of three.
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


def distribution(attribute: str, width: int, value: Any) -> _core.Distribution:
    """Turn a value, shape, Uniform or Normal into the engine's; `width` is 1 or 3 numbers per particle."""
    if isinstance(value, Shape):
        if width != 3:
            raise ArgumentError(
                attribute, value, "a number, Uniform or Normal: it has one number per particle"
            )
        return _core.Distribution.shape(value.core)
    if isinstance(value, Uniform):
        if width == 3 and _is_number(value.lo) and _is_number(value.hi):
            return _alike(attribute, value)
        lo, hi = _numbers(attribute, width, value.lo), _numbers(attribute, width, value.hi)
        if any(a > b for a, b in zip(lo, hi, strict=True)):
            raise ArgumentError(attribute, value, "drawn from lo <= hi")
        return _core.Distribution.uniform(lo, hi)
    if isinstance(value, Normal):
        mean, sigma = _numbers(attribute, width, value.mean), _numbers(attribute, width, value.sigma)
        if any(s < 0 for s in sigma):
            raise ArgumentError(attribute, value, "drawn with sigma >= 0")
        return _core.Distribution.normal(mean, sigma)
    return _core.Distribution.value(_numbers(attribute, width, value, endless=attribute == "lifetime"))


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _alike(attribute: str, value: Uniform) -> _core.Distribution:
    """Return a vector's distribution with one draw for all components: points on a line."""
    ends = [
        arguments.number(attribute, end, low=-MOST_ALIKE, high=MOST_ALIKE) for end in (value.lo, value.hi)
    ]
    if ends[0] > ends[1]:
        raise ArgumentError(attribute, value, "drawn from lo <= hi")
    return _core.Distribution.shape(_core.Shape("Line", [number for end in ends for number in (end,) * 3]))


def _numbers(attribute: str, width: int, value: Any, *, endless: bool = False) -> list[float]:
    if width == 1:
        return [_in_float32(attribute, arguments.number(attribute, value, finite=not endless))]
    if isinstance(value, (int, float, np.integer, np.floating)) and attribute == "size":
        value = (value, value, value)  # a size of one number is the same along all axes
    numbers = arguments.triple(attribute, value, pair=attribute != "color")
    return [_in_float32(attribute, v) for v in numbers]


def _in_float32(attribute: str, value: float) -> float:
    if abs(value) > MOST and value != float("inf"):
        raise ArgumentError(attribute, value, f"within {MOST:g}")
    return value
