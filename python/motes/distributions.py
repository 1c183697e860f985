"""How newborn particles get their attributes (System.configure)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _core, arguments
from .errors import ArgumentError
from .shapes import Shape

__all__ = ["Normal", "Uniform", "distribution"]

MOST = 1e37  # no draw leaves float32: neither a range of twice that, nor 7 sigma


class Uniform:
    """Drawn uniformly from lo..hi, each component by itself."""

    def __init__(self, lo: ArrayLike, hi: ArrayLike) -> None:
        """Take the ends: numbers, or 3 numbers each for vectors."""
        self.lo, self.hi = lo, hi

    def __repr__(self) -> str:
        """Show the call."""
        return f"Uniform({self.lo!r}, {self.hi!r})"


class Normal:
    """Drawn from a normal distribution, each component by itself."""

    def __init__(self, mean: ArrayLike, sigma: ArrayLike) -> None:
        """Take mean and standard deviation: numbers, or 3 numbers each for vectors."""
        self.mean, self.sigma = mean, sigma

    def __repr__(self) -> str:
        """Show the call."""
        return f"Normal({self.mean!r}, {self.sigma!r})"


def distribution(attribute: str, width: int, value: Any) -> _core.Distribution:
    """Turn a value, shape, Uniform or Normal into the engine's; `width` is 1 or 3 numbers a particle."""
    if isinstance(value, Shape):
        if width != 3:
            raise ArgumentError(attribute, value, "a number, Uniform or Normal: it has one number a particle")
        return _core.Distribution.shape(value.core)
    if isinstance(value, Uniform):
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


def _numbers(attribute: str, width: int, value: Any, *, endless: bool = False) -> list[float]:
    if width == 1:
        return [_in_float32(attribute, arguments.number(attribute, value, finite=not endless))]
    if isinstance(value, (int, float, np.integer, np.floating)) and attribute == "size":
        value = (value, value, value)  # a size of one number is the same along all axes
    return [_in_float32(attribute, v) for v in arguments.triple(attribute, value)]


def _in_float32(attribute: str, value: float) -> float:
    if abs(value) > MOST and value != float("inf"):
        raise ArgumentError(attribute, value, f"within {MOST:g}")
    return value
