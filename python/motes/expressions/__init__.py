"""Expressions of columns: what `where=` tests, `set` computes and sums add up, for each particle.

`motes.column("age") > 2`, `motes.column("velocity").length() * 0.5`, `Box(...) & ~Sphere(...)`. An
expression is a value: it is recorded and hashed like any other argument. Vectors work component by component,
and one number goes with a vector as in NumPy.

The functions here take expressions, numbers and vectors. NumPy's own of the same meaning do, too:
`numpy.sin(column("age"))`. The engine computes in float32, with the same bits on every machine; errors are at
most 2 units in the last place (sin and cos: for arguments up to 1e6). Division by 0, the logarithm of a
negative number and the like give infinities and NaN, as IEEE 754 says.
"""

from __future__ import annotations

from ..errors import ArgumentError
from ._conditions import Condition
from ._expression import Expression, choose, noise
from ._functions import (
    absolute,
    atan2,
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
    normalize,
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
    """Make the expression that is a particle's attribute.

    Args:
        name: of the attribute: "age", "position", a user's own.

    Returns:
        The column, with the values that particles have when the action runs.
    """
    if not isinstance(name, str):
        raise ArgumentError("name", name, "a column's name")
    return Expression(("column", str(name)))


def time() -> Expression:
    """Make the expression that is the animation's time.

    It is the time at the start of the (sub)step in which the action runs; in the conditions of `spawn` and
    `sort` at the start of the frame; in sums it is `world.time`.

    Returns:
        Seconds.
    """
    return Expression(("time",))
