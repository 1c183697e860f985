"""Key frames: numbers and vectors that change with the animation's time."""

from __future__ import annotations

import math
from bisect import bisect_right
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ArgumentError
from . import arguments
from .values import Moving, Value, key_of, moves, value

__all__ = ["Curve", "Number", "Vector", "integrals", "moving_part"]

MOST_AT_ONCE = 4_000_000_000
Key = float | tuple[float, float, float]


@value(init=False)
class Curve(Value, Moving):
    """A number or a vector that changes with time: key frames (time in s, value), in ascending order.

    `interpolation`: "linear", "smooth" (halts at each key: t^2 (3 - 2t) of the way, with a slope of 0 at both
    of its ends) or "hold" (jumps at keys). A camera on a smooth path of several keys stops at each.
    Before the first key it has the first value, after the last one the last. Two keys at one time make a
    jump.

    It may stand for a number or a vector in actions, in `configure`, `Uniform` and `Normal`, for the rate of
    `source`, and in cameras, renderers and lights. What is recorded is its value at `world.time`, the start
    of the frame, for all sub-steps; `curve(t)` gives it anywhere else, as in `Sphere(path(world.time), 1)`.
    """

    keys: tuple[tuple[float, Key], ...]
    """Times, s, and values: numbers or vectors."""
    interpolation: Literal["linear", "smooth", "hold"] = "linear"
    """What happens between two keys: "linear", "smooth" or "hold"."""

    def __init__(self, keys: Any, interpolation: Literal["linear", "smooth", "hold"] = "linear") -> None:
        """Take the key frames and what happens between them."""
        kept: list[tuple[float, Key]] = []
        for time, given in _pairs(keys):
            t = arguments.number("keys", time)
            if kept and t < kept[-1][0]:
                raise ArgumentError("keys", keys, "times in ascending order")
            kept.append((t, _number(given)))
        if len({isinstance(v, tuple) for _, v in kept}) > 1:
            raise ArgumentError("keys", keys, "either numbers or vectors")
        interpolation = arguments.choice("interpolation", interpolation, ("linear", "smooth", "hold"))
        self.__dict__.update(keys=tuple(kept), interpolation=interpolation)
        self.__dict__["times"] = tuple(t for t, _ in kept)

    def __call__(self, time: float) -> Any:
        """Return the value at a time, in seconds: a float, or a tuple of 3."""
        time = arguments.number("time", time, finite=False)
        after = bisect_right(self.times, time)
        if after == 0:
            return self.keys[0][1]
        start, a = self.keys[after - 1]
        if after == len(self.keys) or self.interpolation == "hold":
            return a
        end, b = self.keys[after]
        part = (time - start) / (end - start)
        if self.interpolation == "smooth":
            part = part * part * (3 - 2 * part)
        if isinstance(a, tuple) and isinstance(b, tuple):
            x, y, z = (p + (q - p) * part for p, q in zip(a, b, strict=True))
            return (x, y, z)
        assert isinstance(a, float) and isinstance(b, float)
        return a + (b - a) * part

    def integral(self, low: float, high: float) -> float:
        """Return the integral over time; of numbers only.

        Args:
            low: seconds.
            high: seconds, at least `low`.
        """
        if isinstance(self.keys[0][1], tuple):
            raise ArgumentError("curve", self, "of numbers: a vector has no integral here")
        low, high = arguments.number("low", low), arguments.number("high", high)
        return self._until(high) - self._until(low)

    def _until(self, time: float) -> float:
        """Return the integral from the first key to `time`; negative before it."""
        numbers: list[float] = [v for _, v in self.keys if isinstance(v, float)]
        total = (min(time, self.times[0]) - self.times[0]) * numbers[0]
        for k, start in enumerate(self.times):
            if time <= start:
                break
            last = k + 1 == len(numbers)
            end = math.inf if last else self.times[k + 1]
            a, b = numbers[k], numbers[k if last or self.interpolation == "hold" else k + 1]
            length = min(time, end) - start
            # The part of the way at the end, and the integral of the interpolation up to there.
            part = 1.0 if time >= end else 0.0 if last else length / (end - start)
            rise = part * part * (1 - part / 2) if self.interpolation == "smooth" else part / 2
            total += length * (a + (b - a) * rise)
        return total


Number: TypeAlias = float | Curve
"""A number, or what it is at each time."""
Vector: TypeAlias = ArrayLike | Curve
"""A vector, or what it is at each time."""


def _pairs(keys: Any) -> list[tuple[Any, Any]]:
    try:
        pairs = [(time, given) for time, given in keys]
    except Exception:  # any: this runs methods of users' classes
        pairs = []
    if not pairs:
        raise ArgumentError("keys", keys, "a list of (time, value), at least one")
    return pairs


def _number(given: ArrayLike) -> Key:
    if isinstance(given, (bool, int, float, np.integer, np.floating)):
        return arguments.number("keys", given)
    return arguments.triple("keys", given)


def integrals(rate: Curve, frame: int, dt: float, substeps: int) -> tuple[list[float], float]:
    """Return the integral of a rate until a frame's start and until the end of each sub-step, in particles.

    They count from 0 s or from the first key, whichever is earlier, so none is negative. The second value
    is the number that they are rounded like: times are rounded, too, so where a rate sets in late the
    integral is small, but no more exact than one that began at 0 s.
    """
    numbers = [v for _, v in rate.keys if isinstance(v, float) and 0 <= v <= 1e12]
    if len(numbers) < len(rate.keys):
        raise ArgumentError("rate", rate, "particles per second, in 0..1e12, at all times")
    begin = min(0.0, rate.times[0])
    ends = [(frame + substep / substeps) * dt for substep in range(substeps + 1)]
    until = [max(0.0, rate.integral(begin, end)) for end in ends]
    if max(after - before for before, after in pairwise(until)) > MOST_AT_ONCE:
        raise ArgumentError("rate", rate, f"at most {MOST_AT_ONCE} particles in a step")
    return until, max(numbers) * (ends[-1] - begin)


def moving_part(given: Any) -> tuple[float, ...]:
    """Return the times of the keys of a curve, or of the curves in a value's fields."""
    if isinstance(given, Moving):
        return given.times
    if isinstance(given, Value) and moves(given):
        return tuple(time for field in key_of(given) for time in moving_part(field))
    return ()
