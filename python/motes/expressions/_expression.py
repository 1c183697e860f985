"""Expression: a tree of operations on columns, built by arithmetic and comparisons."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._values import arguments
from ..errors import ArgumentError
from . import _conditions as conditions
from ._conditions import Condition, Node, Region, Tree, as_condition

__all__ = ["Expression", "apply", "as_expression", "choose", "constant_of", "node_of", "noise", "power"]


class Expression(Tree):
    """One number or vector per particle, computed from its columns."""

    __slots__ = ()

    def __add__(self, other: Any) -> Expression:
        """Sum."""
        return apply("add", self, other)

    def __radd__(self, other: Any) -> Expression:
        """Sum."""
        return apply("add", other, self)

    def __sub__(self, other: Any) -> Expression:
        """Difference."""
        return apply("subtract", self, other)

    def __rsub__(self, other: Any) -> Expression:
        """Difference."""
        return apply("subtract", other, self)

    def __mul__(self, other: Any) -> Expression:
        """Product."""
        return apply("multiply", self, other)

    def __rmul__(self, other: Any) -> Expression:
        """Product."""
        return apply("multiply", other, self)

    def __truediv__(self, other: Any) -> Expression:
        """Quotient."""
        return apply("divide", self, other)

    def __rtruediv__(self, other: Any) -> Expression:
        """Quotient."""
        return apply("divide", other, self)

    def __pow__(self, other: Any) -> Expression:
        """Power; NaN for a negative base unless the exponent is an integer."""
        return power(self, other)

    def __rpow__(self, other: Any) -> Expression:
        """Power."""
        return power(other, self)

    def __mod__(self, other: Any) -> Expression:
        """Remainder of a division, with the divisor's sign."""
        return apply("modulo", self, other)

    def __rmod__(self, other: Any) -> Expression:
        """Remainder of a division, with the divisor's sign."""
        return apply("modulo", other, self)

    def __neg__(self) -> Expression:
        """Negative."""
        return apply("negate", self)

    def __abs__(self) -> Expression:
        """Absolute value."""
        return apply("absolute", self)

    def sqrt(self) -> Expression:
        """Return the square root, like `motes.expressions.sqrt`."""
        return apply("square_root", self)

    def floor(self) -> Expression:
        """Return the largest integer <= the value."""
        return apply("floor", self)

    def length(self) -> Expression:
        """Return the length of a vector: one number per particle."""
        return apply("length", self)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **keywords: Any) -> Any:
        """Let NumPy's functions and arithmetic build expressions."""
        from ._numpy_calls import numpy_ufunc

        return numpy_ufunc(ufunc, method, inputs, keywords)

    def __array_function__(self, function: Any, _: Any, args: Any, keywords: Any) -> Any:
        """Let `numpy.where`, `clip`, `dot` and `cross` build expressions."""
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
        """Compare per particle: returns a condition, not a bool."""
        return _compare("equal", self, other)

    def __ne__(self, other: object) -> Condition:  # type: ignore[override]
        """Compare per particle: returns a condition, not a bool."""
        return ~_compare("equal", self, other)

    __hash__ = None  # type: ignore[assignment]

    def __bool__(self) -> bool:
        """Raise: an expression has one value per particle."""
        raise ArgumentError("expression", self, "compared and passed to where=, not tested in Python")


def power(a: Any, b: Any) -> Expression:
    """Return a to the power of b, like `a ** b`.

    Args:
        a: a number or an expression; if negative, the result is NaN unless b is an integer.
        b: a number or an expression.
    """
    if isinstance(b, (int, float, np.integer, np.floating)) and b == 2:
        return apply("square", a)
    return apply("power", a, b)


def as_expression(argument: str, value: Any) -> Expression:
    """Return `value`, an expression, a number or a vector, as an expression."""
    if isinstance(value, Expression):
        return value
    if isinstance(value, (bool, Condition, Region)):
        raise ArgumentError(argument, value, "a number, 3 numbers or an expression of columns")
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, (tuple, list)) and any(isinstance(part, Expression) for part in value):
        return _vector(argument, value)
    if isinstance(value, (int, float, np.integer, np.floating)):
        numbers: tuple[float, ...] = (arguments.number(argument, value),)
    else:
        if argument == "orientation":
            return Expression(("constant", _quaternion(value)))
        named = argument == "color" or (isinstance(value, str) and argument in ("yes", "no"))
        numbers = (arguments.color if named else arguments.triple)(argument, value)
    if any(abs(v) > 3e38 for v in numbers):
        raise ArgumentError(argument, value, "within the range of float32")
    return Expression(("constant", numbers))


def _quaternion(value: Any) -> tuple[float, ...]:
    allowed = "a quaternion (x, y, z, w) other than 0"
    numbers = arguments.floats("orientation", value, np.float64, allowed)
    length = float(np.linalg.norm(numbers)) if numbers.shape == (4,) else 0.0
    if not 0 < length < 1e37:
        raise ArgumentError("orientation", value, allowed)
    return tuple((numbers / length).tolist())


def _vector(argument: str, parts: Sequence[Any]) -> Expression:
    """Return the vector whose components are expressions or numbers."""
    if len(parts) not in (2, 3):
        raise ArgumentError(argument, parts, "3 numbers or expressions of one number; 2 stand for (x, y, 0)")
    made_of = [as_expression(argument, part) for part in (*parts, 0)[:3]]
    return Expression(("vector", *(part._node for part in made_of)), sum(part._size for part in made_of))


def noise(position: Any, time: Any = 0, *, octaves: int = 1, field: int = 0) -> Expression:
    """Return smooth random numbers over space and time.

    This is gradient noise, as in `curl_noise`, with mean 0 and root mean square 1/3; few values are outside
    -1..1.

    Args:
        position: a vector or an expression of one, in cells of edge length 1: `column("position") / 0.5`
            makes cells of 0.5 m. Its coordinates times 2^octaves should stay below 1e6.
        time: the field changes completely between one integer and the next.
        octaves: 1 to 8; each adds details of half the size and half the strength of the previous one.
        field: number of the random field, 0 to 65535; the same number gives the same field in every run and
            system.

    Returns:
        One number per particle.
    """
    octaves = arguments.integer("octaves", octaves, low=1, high=8)
    field = arguments.integer("field", field, high=65535)
    at, when = as_expression("position", position), as_expression("time", time)
    return Expression(("noise", at._node, when._node, octaves, field), 3 * at._size + when._size + 1)


def choose(condition: Condition | Region, yes: Any, no: Any) -> Expression:
    """Return one of two values for each particle.

    Args:
        condition: a comparison of columns, or a shape, which is true for particles inside it.
        yes: the result where the condition holds.
        no: the result elsewhere.
    """
    held, a, b = as_condition("condition", condition), as_expression("yes", yes), as_expression("no", no)
    return Expression(("choose", held._node, a._node, b._node), held._size + a._size + b._size + 1)


def node_of(expression: Expression) -> Node:
    """Return an expression's tree, which can be compared and hashed."""
    return expression._node


def constant_of(expression: Expression) -> float | tuple[float, ...] | None:
    """Return the value of a constant expression; None if it depends on columns."""
    operation, *operands = expression._node
    if operation != "constant":
        return None
    numbers: tuple[float, ...] = operands[0]
    return numbers[0] if len(numbers) == 1 else numbers


def apply(operation: str, *operands: Any) -> Expression:
    """Return the expression that applies an operation to its operands."""
    parts = [as_expression("operand", operand) for operand in operands]
    size = conditions.size_of(operation, [part._size for part in parts])
    return Expression((operation, *(part._node for part in parts)), size)


def _compare(operation: str, a: Any, b: Any) -> Condition:
    left, right = as_expression("operand", a), as_expression("operand", b)
    return Condition((operation, left._node, right._node), left._size + right._size + 1)
