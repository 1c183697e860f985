"""Key frames: numbers and vectors that change with the animation's time."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ArgumentError
from . import arguments
from .values import Moving, Value, at, joined, key_of, moves, times_of, value

__all__ = ["Combined", "Curve", "Joined", "Number", "Vector", "integrals", "moving_part"]

MOST_AT_ONCE = 4_000_000_000
Key = float | tuple[float, float, float]
Interpolation: TypeAlias = Literal["linear", "smooth", "hold", "spline"]
INTERPOLATIONS = ("linear", "smooth", "hold", "spline")


@value(init=False)
class Curve(Value, Moving):
    """A number or a vector that changes with time: key frames (time in s, value), in ascending order.

    `interpolation`: "linear"; "smooth" (eases in and out between keys as t^2 (3 - 2t), with slope 0 at each
    key); "hold" (jumps at keys); or "spline" (cubic with continuous slope, monotone between keys and so
    within their range: M. Steffen, 1990). A camera on a smooth path stops at each key; on a spline it eases
    in at the first key and out at the last.
    Before the first key the curve has the first value, after the last key the last value. Two keys at the
    same time make a jump. A value may be a colour as text.

    `+`, `-` and `*` combine curves with numbers, vectors and curves, component by component.

    A curve can replace a number or a vector in actions, `configure`, `Uniform`, `Normal`, the rate of
    `source`, cameras, renderers and lights, and a component of such a vector: `(0, Curve(...), 0)`. All
    sub-steps of a frame use its value at `world.time`, the frame's start. Elsewhere, call it:
    `Sphere(path(world.time), 1)`.
    """

    keys: tuple[tuple[float, Key], ...]
    """Times, s, and values: numbers or vectors."""
    interpolation: Interpolation = "linear"
    """How values change between two keys: "linear", "smooth", "hold" or "spline"."""

    def __init__(
        self, keys: Any, interpolation: Literal["linear", "smooth", "hold", "spline"] = "linear"
    ) -> None:
        """Check the key frames and the interpolation."""
        kept: list[tuple[float, Key]] = []
        for time, given in _pairs(keys):
            t = arguments.number("keys", time)
            if kept and t < kept[-1][0]:
                raise ArgumentError("keys", keys, "times in ascending order")
            kept.append((t, _number(given)))
        if len({isinstance(v, tuple) for _, v in kept}) > 1:
            raise ArgumentError("keys", keys, "either numbers or vectors")
        interpolation = arguments.choice("interpolation", interpolation, INTERPOLATIONS)
        self.__dict__.update(keys=tuple(kept), interpolation=interpolation)
        self.__dict__["times"] = tuple(t for t, _ in kept)
        components = zip(*(v if isinstance(v, tuple) else (v,) for _, v in kept), strict=True)
        self.__dict__["_components"] = [list(one) for one in components]
        spline = interpolation == "spline"
        self.__dict__["_slopes"] = [_slopes(self.times, one) if spline else None for one in self._components]

    @property
    def _components(self) -> list[list[float]]:
        components: list[list[float]] = self.__dict__["_components"]
        return components

    def __call__(self, time: float) -> Any:
        """Return the value at a time, in seconds: a float, or a tuple of 3."""
        time = arguments.number("time", time, finite=False)
        after = bisect_right(self.times, time)
        if after == 0:
            return self.keys[0][1]
        start, a = self.keys[after - 1]
        if after == len(self.keys) or self.interpolation == "hold":
            return a
        length = self.times[after] - start
        part = (time - start) / length
        at = [self._between(c, after - 1, part, length) for c in range(len(self._components))]
        return tuple(at) if isinstance(a, tuple) else at[0]

    def _between(self, component: int, key: int, part: float, length: float) -> float:
        """Return a component at the fraction `part` of the interval after `key`, which is `length` s long."""
        p, q = self._components[component][key : key + 2]
        slopes = self.__dict__["_slopes"][component]
        if slopes is not None:
            leave, arrive = slopes[key][1] * length, slopes[key + 1][0] * length
            left = 1 - part
            way = (q - p) * part * part * (3 - 2 * part)
            return float(p + way + part * left * (leave * left - arrive * part))
        if self.interpolation == "smooth":
            part = part * part * (3 - 2 * part)
        return p + (q - p) * part

    def polynomial(self, key: int) -> list[tuple[float, ...]]:
        """Return the coefficients of powers 0 to 3 of the fraction of the interval from a key to the next.

        Args:
            key: the key's number; after the last key the curve is constant.
        """
        columns = []
        for component, numbers in enumerate(self._components):
            p = numbers[key]
            rise = numbers[key + 1] - p if key + 1 < len(numbers) and self.interpolation != "hold" else 0.0
            slopes = self.__dict__["_slopes"][component]
            if slopes is not None and key + 1 < len(numbers):
                length = self.times[key + 1] - self.times[key]
                leave, arrive = slopes[key][1] * length, slopes[key + 1][0] * length
                columns.append((p, leave, 3 * rise - 2 * leave - arrive, leave + arrive - 2 * rise))
            elif self.interpolation == "smooth":
                columns.append((p, 0.0, 3 * rise, -2 * rise))
            else:
                columns.append((p, rise, 0.0, 0.0))
        return list(zip(*columns, strict=True))

    def in_vector(self, components: Sequence[Any]) -> Curve:
        """Return the curve of a vector of which this curve is a component.

        Args:
            components: 2 to 4 numbers or curves of numbers, this one among them.
        """
        return Joined(components)

    def integral(self, low: float, high: float) -> float:
        """Return the integral over time; the curve must be of numbers.

        Args:
            low: seconds.
            high: seconds, at least `low`.
        """
        if self._is_vector:
            raise ArgumentError("curve", self, "a curve of numbers: curves of vectors have no integral")
        low, high = arguments.number("low", low), arguments.number("high", high)
        return self._until(high) - self._until(low)

    @property
    def _is_vector(self) -> bool:
        return isinstance(self(self.times[0]), tuple)

    def _until(self, time: float) -> float:
        """Return the integral from the first key to `time`; negative before it."""
        numbers = self._components[0]
        total = (min(time, self.times[0]) - self.times[0]) * numbers[0]
        for k, start in enumerate(self.times):
            if time <= start:
                break
            last = k + 1 == len(numbers)
            end = math.inf if last else self.times[k + 1]
            a, b = numbers[k], numbers[k if last or self.interpolation == "hold" else k + 1]
            length = min(time, end) - start
            # The fraction of the interval that is integrated, and the interpolation's mean over it.
            part = 1.0 if time >= end else 0.0 if last else length / (end - start)
            cubic = self.interpolation in ("smooth", "spline")
            rise = part * part * (1 - part / 2) if cubic else part / 2
            total += length * (a + (b - a) * rise)
            if self.interpolation == "spline" and not last:
                total += length * (end - start) * part * self._bend(k, part)
        return total

    def _bend(self, key: int, part: float) -> float:
        """Return the integral of a spline's slope terms over the fractions 0..`part`, divided by part^2."""
        slopes = self.__dict__["_slopes"][0]
        leave, arrive = slopes[key][1], slopes[key + 1][0]
        whole = leave * (1 / 2 - part * (2 / 3 - part / 4)) - arrive * part * (1 / 3 - part / 4)
        return float(whole)

    def __add__(self, other: Operand) -> Curve:
        """Add a number, a vector or a curve."""
        return Combined("+", self, other)

    def __radd__(self, other: Operand) -> Curve:
        """Add to a number or a vector."""
        return Combined("+", other, self)

    def __sub__(self, other: Operand) -> Curve:
        """Subtract a number, a vector or a curve."""
        return Combined("-", self, other)

    def __rsub__(self, other: Operand) -> Curve:
        """Subtract from a number or a vector."""
        return Combined("-", other, self)

    def __mul__(self, other: Operand) -> Curve:
        """Multiply by a number, a vector or a curve."""
        return Combined("*", self, other)

    def __rmul__(self, other: Operand) -> Curve:
        """Multiply a number or a vector."""
        return Combined("*", other, self)

    def __neg__(self) -> Curve:
        """Negate the curve."""
        return Combined("*", -1, self)


Number: TypeAlias = float | Curve
"""A number, or a curve of numbers."""
Vector: TypeAlias = ArrayLike | Curve | Sequence[Number]
"""A vector, a curve of vectors, or a vector with curves of numbers as components."""
Operand: TypeAlias = Vector
"""What a curve can be combined with."""

# Positive nodes of 8-point Gauss-Legendre quadrature over -1..1, and their weights: exact up to degree 15.
NODES = (
    (0.18343464249564980494, 0.36268378337836198297),
    (0.52553240991632898582, 0.31370664587788728734),
    (0.79666647741362673959, 0.22238103445337447054),
    (0.96028985649753623168, 0.10122853629037625915),
)


class Combined(Curve):
    """Two curves, or a curve and a number or vector, added, subtracted or multiplied."""

    _fields: ClassVar[dict[str, str]] = {"operation": "str", "a": "Operand", "b": "Operand"}
    __match_args__ = ("operation", "a", "b")
    _defaults: ClassVar[dict[str, Any]] = {}

    def __init__(self, operation: str, a: Operand, b: Operand) -> None:
        """Check the operation, "+", "-" or "*", and its operands."""
        first, second = _operand(a), _operand(b)
        operation = arguments.choice("operation", operation, ("+", "-", "*"))
        both = [one.times for one in (first, second) if isinstance(one, Curve)]
        self.__dict__.update(operation=operation, a=first, b=second)
        self.__dict__["times"] = tuple(sorted({time for times in both for time in times}))
        for time in self.times:
            if not all(map(math.isfinite, _parts(self(time)))):
                raise ArgumentError("operand", b, "one that keeps the curve finite")

    @property
    def operation(self) -> str:
        """The operation: "+", "-" or "*"."""
        return str(self.__dict__["operation"])

    @property
    def both(self) -> tuple[Key | Curve, Key | Curve]:
        """The two operands."""
        return self.__dict__["a"], self.__dict__["b"]

    def __call__(self, time: float) -> Any:
        """Return the value at a time, in seconds: a float, or a tuple of 3."""
        a, b = (_parts(one(time) if isinstance(one, Curve) else one) for one in self.both)
        wide = max(len(a), len(b))
        pairs = zip(a * (wide // len(a)), b * (wide // len(b)), strict=True)
        if self.operation == "*":
            values = tuple(p * q for p, q in pairs)
        else:
            sign = 1 if self.operation == "+" else -1
            values = tuple(p + sign * q for p, q in pairs)
        return values if wide > 1 else values[0]

    def _until(self, time: float) -> float:
        """Return the integral from the first key to `time`; negative before it."""
        first, last = self.times[0], self.times[-1]
        total = (min(time, first) - first) * self._limit(first, after=False)
        for start, end in pairwise(self.times):
            if time > start:
                total += self._piece(start, min(end, time))
        return total + max(time - last, 0.0) * self._limit(last, after=True)

    def _limit(self, time: float, *, after: bool) -> float:
        """Return the constant value before the first key, `time`, or with `after`, after the last key."""
        return float(self(math.nextafter(time, math.inf if after else -math.inf)))

    def _piece(self, start: float, end: float) -> float:
        middle, half = (start + end) / 2, (end - start) / 2
        total = sum(
            weight * (self(middle - half * node) + self(middle + half * node)) for node, weight in NODES
        )
        return float(half * total)


class Joined(Curve):
    """A vector with curves of numbers among its components.

    The others are checked where the vector is used.
    """

    _fields: ClassVar[dict[str, str]] = {"components": "Sequence[Any]"}
    __match_args__ = ("components",)
    _defaults: ClassVar[dict[str, Any]] = {}

    def __init__(self, components: Sequence[Any]) -> None:
        """Store the components; raise ArgumentError if one is a curve of vectors."""
        for i, one in enumerate(components):
            if isinstance(one, Curve) and one._is_vector:
                raise ArgumentError(f"vector[{i}]", one, "a number or a curve of numbers")
        self.__dict__.update(components=tuple(components), times=tuple(times_of(components)))

    @property
    def _is_vector(self) -> bool:
        return True

    def __call__(self, time: float) -> Any:
        """Return the vector at a time, in seconds."""
        time = arguments.number("time", time, finite=False)
        return tuple(at(one, time) for one in self.__dict__["components"])


def _operand(given: Any) -> Key | Curve:
    """Return the operand `given`, checked: a curve, a number or a vector."""
    given = joined(given)
    if isinstance(given, Curve):
        return given
    try:
        return _number(given)
    except ArgumentError:
        raise ArgumentError("operand", given, "a number, a vector or a motes.Curve") from None


def _parts(one: Any) -> tuple[float, ...]:
    return one if isinstance(one, tuple) else (one,)


def _slopes(times: tuple[float, ...], numbers: list[float]) -> list[tuple[float, float]]:
    """Return a spline's slopes before and after each key (M. Steffen, 1990).

    They are 0 at the first and the last key, and at jumps.
    """
    slopes = []
    for k, here in enumerate(numbers):
        before = times[k] - times[k - 1] if k > 0 else 0.0
        after = times[k + 1] - times[k] if k + 1 < len(times) else 0.0
        slope = 0.0
        if before > 0 and after > 0:
            arrive, leave = (here - numbers[k - 1]) / before, (numbers[k + 1] - here) / after
            if arrive * leave > 0:
                through = abs(arrive * after + leave * before) / (before + after)
                least = min(abs(arrive), abs(leave), through / 2)
                slope = 2 * least if arrive > 0 else -2 * least
        slopes.append((slope, slope))
    return slopes


def _pairs(keys: Any) -> list[tuple[Any, Any]]:
    try:
        pairs = [(time, given) for time, given in keys]
    except Exception:  # of any kind: this runs methods of users' classes
        pairs = []
    if not pairs:
        raise ArgumentError("keys", keys, "a list of (time, value), at least one")
    return pairs


def _number(given: ArrayLike) -> Key:
    if isinstance(given, (bool, int, float, np.integer, np.floating)):
        return arguments.number("keys", given)
    return arguments.color("keys", given) if isinstance(given, str) else arguments.triple("keys", given)


def integrals(rate: Curve, frame: int, dt: float, substeps: int) -> tuple[list[float], float]:
    """Return the integrals of a rate until a frame's start and until the end of each sub-step, in particles.

    They start at 0 s or at the first key, whichever is earlier, so none is negative. The second value is the
    magnitude that determines their rounding error: times are rounded, so the integral of a rate that sets in
    late is small, but no more exact than that of a rate that began at 0 s.
    """
    numbers = [v for v in map(rate, rate.times) if isinstance(v, float) and 0 <= v <= 1e12]
    if len(numbers) < len(rate.times):
        raise ArgumentError("rate", rate, "particles per second, in 0..1e12, at all times")
    begin = min(0.0, rate.times[0])
    ends = [(frame + substep / substeps) * dt for substep in range(substeps + 1)]
    until = [max(0.0, rate.integral(begin, end)) for end in ends]
    if min(after - before for before, after in pairwise(until)) < 0:
        raise ArgumentError("rate", rate, "particles per second, in 0..1e12, at all times")
    if max(after - before for before, after in pairwise(until)) > MOST_AT_ONCE:
        raise ArgumentError("rate", rate, f"at most {MOST_AT_ONCE} particles in a step")
    return until, max(numbers) * (ends[-1] - begin)


def moving_part(given: Any) -> tuple[float, ...]:
    """Return the key times of a curve, or of the curves in a value's fields, s."""
    if isinstance(given, Moving):
        return given.times
    if isinstance(given, Value) and moves(given):
        return tuple(time for field in key_of(given) for time in moving_part(field))
    return ()
