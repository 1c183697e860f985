"""Expressions of columns, evaluated per particle: for `where=`, `set` and sums.

`column("age") > 2`, `column("velocity").length() * 0.5`, `Box(...) & ~Sphere(...)`. An expression
is an immutable value, recorded and hashed like any other argument. Operations on vectors work component by
component; a number and a vector combine as in NumPy.

The functions here take expressions, numbers and vectors. Given NumPy arrays or plain numbers alone, they
return float32 arrays at once, computed by the same kernels: `exp(numpy.linspace(0, 1, 5))`. Arrays of vectors
have three components in their last axis. The equivalent NumPy functions also take expressions:
`numpy.sin(column("age"))`. The engine computes in float32, with the same bits on every machine;
errors are at most 2 units in the last place (sin and cos: for arguments up to 1e6). Division by 0, the
logarithm of a negative number and the like give infinities and NaN, as IEEE 754 says.
"""

from __future__ import annotations

from ..errors import ArgumentError
from ._conditions import Condition
from ._expression import Expression
from ._functions import (
    absolute,
    atan2,
    choose,
    clamp,
    cos,
    cross,
    dot,
    exp,
    floor,
    length,
    log,
    maximum,
    minimum,
    mix,
    noise,
    normalize,
    power,
    ramp,
    sign,
    sin,
    smoothstep,
    sqrt,
    step,
    where,
)
from ._pairs import a, b, normal, r, relative_velocity

__all__ = [
    "Condition",
    "Expression",
    "a",
    "absolute",
    "atan2",
    "b",
    "choose",
    "clamp",
    "column",
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
    "normal",
    "normalize",
    "power",
    "r",
    "ramp",
    "relative_velocity",
    "sign",
    "sin",
    "smoothstep",
    "sqrt",
    "step",
    "time",
    "where",
]


def __dir__() -> list[str]:
    return [*__all__]


def column(name: str) -> Expression:
    """Return the expression for an attribute of a particle.

    Args:
        name: the attribute's name: "age", "position" or one that the script declared. "id" is the particle's
            number, which never changes: remainders (`column("id") % 7`) and comparisons with numbers are
            exact, anything else rounds ids above 2^24 to float32.

    Returns:
        The column, with its values at the time the action runs.
    """
    if not isinstance(name, str):
        raise ArgumentError("name", name, "a column's name")
    return Expression(("column", str(name)))


def time() -> Expression:
    """Return the expression for the animation's time.

    Actions use the time at the start of the current (sub)step, conditions of `spawn` and `sort` the time at
    the start of the frame, and sums `world.time`.

    Returns:
        The time in seconds.
    """
    return Expression(("time",))
