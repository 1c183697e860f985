"""Functions of expressions: of numbers, of vectors, and choices between values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .._values.curves import Combined, Curve
from ..errors import ArgumentError
from ._arrays import takes_arrays
from ._conditions import Condition, Region
from ._expression import Expression, apply, as_expression
from ._expression import choose as choose_values
from ._expression import noise as noise_of
from ._expression import power as power_of

__all__ = [
    "absolute",
    "atan2",
    "choose",
    "clamp",
    "cos",
    "cross",
    "dot",
    "exp",
    "floor",
    "length",
    "log",
    "maximum",
    "minimum",
    "mix",
    "noise",
    "normalize",
    "power",
    "ramp",
    "sign",
    "sin",
    "smoothstep",
    "sqrt",
    "step",
    "where",
]


def by_component(function: Callable[[Any], Expression]) -> Callable[..., Any]:
    """Decorate a function of one operand: document the operand, and take arrays, too."""
    operand = "a: a number, a vector or an expression; vectors are handled component by component."
    function.__doc__ = f"{function.__doc__}\n\nArgs:\n    {operand}\n"
    return takes_arrays()(function)


@takes_arrays()
def sin(angle: Any) -> Expression:
    """Return the sine.

    Args:
        angle: radians; treated as 0 beyond 1e9.
    """
    return apply("sine", angle)


@takes_arrays()
def cos(angle: Any) -> Expression:
    """Return the cosine.

    Args:
        angle: radians; treated as 0 beyond 1e9.
    """
    return apply("cosine", angle)


@takes_arrays()
def atan2(y: Any, x: Any) -> Expression:
    """Return the angle from the x axis to (x, y), in radians, -pi..pi.

    Args:
        y: a number or an expression.
        x: a number or an expression.
    """
    return apply("angle", y, x)


@by_component
def exp(a: Any) -> Expression:
    """Return e to the power of a."""
    return apply("exponential", a)


@by_component
def log(a: Any) -> Expression:
    """Return the natural logarithm: -infinity for 0, NaN for negative numbers."""
    return apply("logarithm", a)


@by_component
def sqrt(a: Any) -> Expression:
    """Return the square root: NaN for negative numbers."""
    return apply("square_root", a)


@by_component
def floor(a: Any) -> Expression:
    """Return the largest integer <= a."""
    return apply("floor", a)


@by_component
def absolute(a: Any) -> Expression:
    """Return the absolute value, like `abs(a)`."""
    return apply("absolute", a)


@by_component
def sign(a: Any) -> Expression:
    """Return -1, 0 or 1."""
    return apply("sign", a)


@takes_arrays()
def minimum(a: Any, b: Any) -> Expression:
    """Return the smaller of two, component by component; NaN where either is.

    Args:
        a: a number, a vector or an expression.
        b: a number, a vector or an expression.
    """
    return apply("minimum", a, b)


@takes_arrays()
def maximum(a: Any, b: Any) -> Expression:
    """Return the larger of two, component by component; NaN where either is.

    Args:
        a: a number, a vector or an expression.
        b: a number, a vector or an expression.
    """
    return apply("maximum", a, b)


@takes_arrays()
def clamp(a: Any, low: Any, high: Any) -> Expression:
    """Return a within low..high, component by component.

    Args:
        a: a number, a vector or an expression.
        low: the smallest value.
        high: the largest value.
    """
    within: Expression = minimum(maximum(a, low), high)
    return within


@takes_arrays()
def mix(a: Any, b: Any, part: Any) -> Expression:
    """Return the linear interpolation a + (b - a) part.

    Args:
        a: the result where part is 0: a number, a vector or an expression.
        b: the result where part is 1.
        part: a number or an expression.
    """
    return apply("mix", a, b, part)


@takes_arrays()
def step(edge: Any, a: Any) -> Expression:
    """Return 1 where a >= edge, else 0.

    Args:
        edge: where the result jumps.
        a: a number or an expression.
    """
    return apply("step", edge, a)


@takes_arrays()
def smoothstep(low: Any, high: Any, a: Any) -> Expression:
    """Return t^2 (3 - 2t) with t = (a - low) / (high - low), at most 1 and at least 0.

    With low < high it is 0 where a <= low and 1 where a >= high; with low > high it falls: 1 where a <= high
    and 0 where a >= low.

    Args:
        low: where the rise begins.
        high: where the rise ends.
        a: a number or an expression.
    """
    return apply("smoothstep", low, high, a)


@takes_arrays()
def ramp(curve: Curve, at: Any) -> Expression:
    """Return a curve's value at one number per particle, as in `ramp(fire, column("age") / 2)`.

    To shift the curve per particle, add an attribute to `at`. To combine several curves, use `choose` or
    `mix`.

    Args:
        curve: a `motes.Curve`, or curves combined with `+`, `-` and `*`; evaluated at `at` instead of time.
        at: a number or an expression; before the first key and for NaN, the result is the first value.

    Raises:
        ArgumentError: `curve` is not a curve, or has so many keys that the expression is too long.
    """
    if isinstance(curve, Combined):
        a, b = (
            ramp(one, at) if isinstance(one, Curve) else as_expression("curve", one) for one in curve.both
        )
        return a + b if curve.operation == "+" else a - b if curve.operation == "-" else a * b
    if not isinstance(curve, Curve):
        raise ArgumentError("curve", curve, "a motes.Curve")
    number = maximum(minimum(at, curve.times[-1]), curve.times[0])
    value: Any = curve.keys[0][1]
    for key, start in enumerate(curve.times):
        end = curve.times[key + 1] if key + 1 < len(curve.times) else start
        if end == start and key + 1 < len(curve.times):
            continue  # a jump
        part = (number - start) * (1 / (end - start)) if end > start else 0.0
        value = choose_values(number >= start, _piece(curve.polynomial(key), part), value)
    return as_expression("curve", value)


def _piece(powers: list[tuple[float, ...]], part: Any) -> Any:
    """Return a polynomial by Horner's rule, omitting terms whose coefficients are all 0."""
    total: Any = None
    for factors in reversed(powers[1:]):
        if total is not None:
            total = total * part
        if any(factors):
            one = as_expression("curve", factors if len(factors) > 1 else factors[0])
            total = one if total is None else total + one
    first = powers[0] if len(powers[0]) > 1 else powers[0][0]
    return first if total is None else total * part + first


@takes_arrays("a", "b")
def dot(a: Any, b: Any) -> Expression:
    """Return the dot product of two vectors: one number.

    Args:
        a: a vector or an expression of one.
        b: a vector or an expression of one.
    """
    return apply("dot", a, b)


@takes_arrays("a", "b")
def cross(a: Any, b: Any) -> Expression:
    """Return the cross product of two vectors.

    Args:
        a: a vector or an expression of one.
        b: a vector or an expression of one.
    """
    return apply("cross", a, b)


@takes_arrays("a")
def length(a: Any) -> Expression:
    """Return the length of a vector: one number.

    Args:
        a: a vector or an expression of one.
    """
    return apply("length", a)


@takes_arrays("a")
def normalize(a: Any) -> Expression:
    """Return a vector divided by its length: NaN where the length is 0.

    Args:
        a: a vector or an expression of one.
    """
    return apply("normalize", a)


power = takes_arrays()(power_of)
noise = takes_arrays("position")(noise_of)


def choose(condition: Condition | Region, yes: Any, no: Any) -> Expression:
    """Return one of two values for each particle.

    Args:
        condition: a comparison of columns, a shape, which is true for particles inside it, or an array
            of booleans.
        yes: the result where the condition holds.
        no: the result elsewhere.
    """
    if isinstance(condition, (np.ndarray, np.bool_)):
        if condition.dtype != np.bool_:
            raise ArgumentError(
                "condition", condition, "an array of booleans, a comparison of columns or a shape"
            )
        return np.where(condition, np.float32(yes), np.float32(no))[()]  # type: ignore[return-value]
    return choose_values(condition, yes, no)


def where(condition: Condition | Region, yes: Any, no: Any) -> Expression:
    """Return one of two values for each particle or pair, like `choose`.

    Args:
        condition: a comparison, or a shape, which is true for particles inside it.
        yes: the result where the condition holds.
        no: the result elsewhere.
    """
    return choose(condition, yes, no)
