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

from typing import Any

import numpy as np

from .._values import arguments
from ..errors import ArgumentError
from . import _conditions as conditions
from ._conditions import Condition, Node, Region, as_condition, checked, text_of

__all__ = [
    "Condition",
    "Expression",
    "absolute",
    "atan2",
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
    "normalize",
    "sign",
    "sin",
    "smoothstep",
    "sqrt",
    "step",
    "time",
]


def __dir__() -> list[str]:
    return [*__all__]


class Expression:
    """One number or vector per particle, computed from its columns."""

    __slots__ = ("_node", "_size")
    _node: Node
    _size: int

    def __init__(self, node: Node, size: int = 1) -> None:
        """Take the tree; scripts use `column`.

        Args:
            node: an operation and its operands.
            size: the number of operations in it.
        """
        object.__setattr__(self, "_node", node)
        object.__setattr__(self, "_size", checked(size))

    def __add__(self, other: Any) -> Expression:
        """Sum."""
        return _made("add", self, other)

    def __radd__(self, other: Any) -> Expression:
        """Sum."""
        return _made("add", other, self)

    def __sub__(self, other: Any) -> Expression:
        """Difference."""
        return _made("subtract", self, other)

    def __rsub__(self, other: Any) -> Expression:
        """Difference."""
        return _made("subtract", other, self)

    def __mul__(self, other: Any) -> Expression:
        """Product."""
        return _made("multiply", self, other)

    def __rmul__(self, other: Any) -> Expression:
        """Product."""
        return _made("multiply", other, self)

    def __truediv__(self, other: Any) -> Expression:
        """Quotient."""
        return _made("divide", self, other)

    def __rtruediv__(self, other: Any) -> Expression:
        """Quotient."""
        return _made("divide", other, self)

    def __pow__(self, other: Any) -> Expression:
        """Power; of a negative number for whole exponents only."""
        return power(self, other)

    def __rpow__(self, other: Any) -> Expression:
        """Power."""
        return power(other, self)

    def __mod__(self, other: Any) -> Expression:
        """Rest of a division, with the divisor's sign."""
        return _made("modulo", self, other)

    def __rmod__(self, other: Any) -> Expression:
        """Rest of a division, with the divisor's sign."""
        return _made("modulo", other, self)

    def __neg__(self) -> Expression:
        """Negative."""
        return _made("negate", self)

    def __abs__(self) -> Expression:
        """Absolute value."""
        return _made("absolute", self)

    def sqrt(self) -> Expression:
        """Return the square root, as `motes.expressions.sqrt` does."""
        return _made("square_root", self)

    def floor(self) -> Expression:
        """Return the largest integer that is not above."""
        return _made("floor", self)

    def length(self) -> Expression:
        """Return the length of a vector: one number per particle."""
        return _made("length", self)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **keywords: Any) -> Any:
        """Let NumPy's functions and arithmetic make expressions."""
        from ._numpy_calls import numpy_ufunc

        return numpy_ufunc(ufunc, method, inputs, keywords)

    def __array_function__(self, function: Any, _: Any, args: Any, keywords: Any) -> Any:
        """Let `numpy.where`, `clip`, `dot` and `cross` make expressions."""
        from ._numpy_calls import numpy_function

        return numpy_function(function, args, keywords)

    def __getitem__(self, index: int) -> Expression:
        """Component 0, 1 or 2 of a vector."""
        index = arguments.integer("index", index, low=0, high=2)
        return Expression(("component", self._node, index), self._size)

    x = property(lambda self: self[0], doc="First component.")
    y = property(lambda self: self[1], doc="Second component.")
    z = property(lambda self: self[2], doc="Third component.")

    def __lt__(self, other: Any) -> Condition:
        """Compare."""
        return _compare("less", self, other)

    def __le__(self, other: Any) -> Condition:
        """Compare."""
        return _compare("less_equal", self, other)

    def __gt__(self, other: Any) -> Condition:
        """Compare."""
        return _compare("greater", self, other)

    def __ge__(self, other: Any) -> Condition:
        """Compare."""
        return _compare("greater_equal", self, other)

    def __eq__(self, other: object) -> Condition:  # type: ignore[override]
        """Compare: a condition for each particle, not True or False."""
        return _compare("equal", self, other)

    def __ne__(self, other: object) -> Condition:  # type: ignore[override]
        """Compare: a condition for each particle, not True or False."""
        return ~_compare("equal", self, other)

    __hash__ = None  # type: ignore[assignment]

    def __bool__(self) -> bool:
        """Refuse: an expression has one value per particle."""
        raise ArgumentError("expression", self, "compared and given to where=, not tested in Python")

    def __setattr__(self, name: str, _: object) -> None:
        """Refuse: values do not change."""
        raise AttributeError(f"an expression does not change: {name!r} cannot be assigned")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the tree."""
        return Expression, (self._node, self._size)

    def __repr__(self) -> str:
        """Show the expression."""
        return text_of(self._node)


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


def noise(position: Any, time: Any = 0, *, octaves: int = 1, field: int = 0) -> Expression:
    """Make smooth random numbers over space and time.

    Gradient noise, as in `curl_noise`. Its mean is 0, its root mean square 1/3, and few values are outside of
    -1..1.

    Args:
        position: a vector or an expression of one, in cells of edge length 1: `column("position") / 0.5`
            makes cells of 0.5 m. Times 2^octaves, it should stay below 1e6.
        time: from one whole number to the next all numbers become new ones.
        octaves: 1 to 8; each adds details of half the size and half the strength of the one before.
        field: 0 to 65535, which of the fields of random numbers; the same in each run and system.

    Returns:
        One number per particle.
    """
    octaves = arguments.integer("octaves", octaves, low=1, high=8)
    field = arguments.integer("field", field, high=65535)
    at, when = as_expression("position", position), as_expression("time", time)
    return Expression(("noise", at._node, when._node, octaves, field), 3 * at._size + when._size + 1)


def sin(angle: Any) -> Expression:
    """Return the sine.

    Args:
        angle: radians; beyond 1e9 it counts as 0.
    """
    return _made("sine", angle)


def cos(angle: Any) -> Expression:
    """Return the cosine.

    Args:
        angle: radians; beyond 1e9 it counts as 0.
    """
    return _made("cosine", angle)


def atan2(y: Any, x: Any) -> Expression:
    """Return the angle from the x axis to (x, y), in radians, -pi..pi.

    Args:
        y: a number or an expression.
        x: a number or an expression.
    """
    return _made("angle", y, x)


def exp(a: Any) -> Expression:
    """Return e to the power of a.

    Args:
        a: a number or an expression; of vectors, component by component.
    """
    return _made("exponential", a)


def log(a: Any) -> Expression:
    """Return the natural logarithm: -infinity of 0, NaN of negative numbers.

    Args:
        a: a number or an expression; of vectors, component by component.
    """
    return _made("logarithm", a)


def power(a: Any, b: Any) -> Expression:
    """Return a to the power of b, as `a ** b` does.

    Args:
        a: a number or an expression; of a negative one the result is NaN unless b is a whole number.
        b: a number or an expression.
    """
    if isinstance(b, (int, float, np.integer, np.floating)) and b == 2:
        return _made("square", a)
    return _made("power", a, b)


def sqrt(a: Any) -> Expression:
    """Return the square root: NaN of negative numbers.

    Args:
        a: a number or an expression; of vectors, component by component.
    """
    return _made("square_root", a)


def floor(a: Any) -> Expression:
    """Return the largest integer that is not above.

    Args:
        a: a number or an expression; of vectors, component by component.
    """
    return _made("floor", a)


def absolute(a: Any) -> Expression:
    """Return the absolute value, as `abs(a)` does.

    Args:
        a: a number or an expression; of vectors, component by component.
    """
    return _made("absolute", a)


def sign(a: Any) -> Expression:
    """Return -1, 0 or 1.

    Args:
        a: a number or an expression; of vectors, component by component.
    """
    return _made("sign", a)


def minimum(a: Any, b: Any) -> Expression:
    """Return the smaller of two, component by component; NaN where either is.

    Args:
        a: a number or an expression, or a vector.
        b: likewise.
    """
    return _made("minimum", a, b)


def maximum(a: Any, b: Any) -> Expression:
    """Return the larger of two, component by component; NaN where either is.

    Args:
        a: a number or an expression, or a vector.
        b: likewise.
    """
    return _made("maximum", a, b)


def clamp(a: Any, low: Any, high: Any) -> Expression:
    """Return a within low..high, component by component.

    Args:
        a: a number or an expression, or a vector.
        low: the least value.
        high: the largest value.
    """
    return minimum(maximum(a, low), high)


def mix(a: Any, b: Any, part: Any) -> Expression:
    """Return a + (b - a) part.

    Args:
        a: the result where part is 0: a number or an expression, or a vector.
        b: the result where part is 1.
        part: a number or an expression.
    """
    return _made("mix", a, b, part)


def step(edge: Any, a: Any) -> Expression:
    """Return 1 where a >= edge, else 0.

    Args:
        edge: where the result jumps.
        a: a number or an expression.
    """
    return _made("step", edge, a)


def smoothstep(low: Any, high: Any, a: Any) -> Expression:
    """Return 0 where a <= low, 1 where a >= high, and t^2 (3 - 2t) between, t being the part of the way.

    Args:
        low: where the rise begins.
        high: where it ends.
        a: a number or an expression.
    """
    return _made("smoothstep", low, high, a)


def choose(condition: Condition | Region, yes: Any, no: Any) -> Expression:
    """Return one of two values for each particle.

    Args:
        condition: a comparison of columns, or a shape, which holds the particles in it.
        yes: the result where the condition holds.
        no: the result elsewhere.
    """
    held, a, b = as_condition("condition", condition), as_expression("yes", yes), as_expression("no", no)
    return Expression(("choose", held._node, a._node, b._node), held._size + a._size + b._size + 1)


def dot(a: Any, b: Any) -> Expression:
    """Return the dot product of two vectors: one number.

    Args:
        a: a vector or an expression of one.
        b: a vector or an expression of one.
    """
    return _made("dot", a, b)


def cross(a: Any, b: Any) -> Expression:
    """Return the cross product of two vectors.

    Args:
        a: a vector or an expression of one.
        b: a vector or an expression of one.
    """
    return _made("cross", a, b)


def length(a: Any) -> Expression:
    """Return the length of a vector: one number.

    Args:
        a: a vector or an expression of one.
    """
    return _made("length", a)


def normalize(a: Any) -> Expression:
    """Return a vector divided by its length: NaN where that is 0.

    Args:
        a: a vector or an expression of one.
    """
    return _made("normalize", a)


def as_expression(argument: str, value: Any) -> Expression:
    """Return `value`, an expression, a number or a vector."""
    if isinstance(value, Expression):
        return value
    if isinstance(value, (bool, Condition, Region)):
        raise ArgumentError(argument, value, "a number, 3 numbers or an expression of columns")
    value = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    if isinstance(value, (int, float, np.integer, np.floating)):
        numbers: tuple[float, ...] = (arguments.number(argument, value),)
    else:
        named = argument == "color" or (isinstance(value, str) and argument in ("yes", "no"))
        numbers = (arguments.color if named else arguments.triple)(argument, value)
    if any(abs(v) > 3e38 for v in numbers):
        raise ArgumentError(argument, value, "within the range of float32")
    return Expression(("constant", numbers))


def node_of(expression: Expression) -> Node:
    """Return the tree of an expression, which can be compared and hashed."""
    return expression._node


def constant_of(expression: Expression) -> float | tuple[float, ...] | None:
    """Return the number or vector that an expression is, or None if it depends on columns."""
    operation, *operands = expression._node
    if operation != "constant":
        return None
    numbers: tuple[float, ...] = operands[0]
    return numbers[0] if len(numbers) == 1 else numbers


def _made(operation: str, *operands: Any) -> Expression:
    parts = [as_expression("operand", operand) for operand in operands]
    size = conditions.size_of(operation, [part._size for part in parts])
    return Expression((operation, *(part._node for part in parts)), size)


def _compare(operation: str, a: Any, b: Any) -> Condition:
    left, right = as_expression("operand", a), as_expression("operand", b)
    return Condition((operation, left._node, right._node), left._size + right._size + 1)
