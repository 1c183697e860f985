"""Expressions of columns: what `where=` tests and what `set` computes, run by the engine for each particle.

`motes.column("age") > 2`, `motes.column("velocity").length() * 0.5`, `Box(...) & ~Sphere(...)`. An
expression is a value: it is recorded and hashed like any other argument. Vectors work component by component.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _core, arguments
from .conditions import Columns, Condition, Node, Program, Region, as_condition, checked, components, text_of
from .conditions import program_of as _program_of
from .errors import ArgumentError

__all__ = ["Condition", "Expression", "as_condition", "as_expression", "column", "maximum", "minimum"]


class Expression:
    """One number or vector per particle, computed from its columns."""

    __slots__ = ("_node", "_size")
    __array_ufunc__ = None  # NumPy arrays leave the arithmetic to this class

    _node: Node
    _size: int

    def __init__(self, node: Node, size: int = 1) -> None:
        """Take the tree and its number of operations; scripts use `column`."""
        object.__setattr__(self, "_node", node)
        object.__setattr__(self, "_size", checked(size))

    def __add__(self, other: Any) -> Expression:
        """Sum."""
        return _two("add", self, other)

    def __radd__(self, other: Any) -> Expression:
        """Sum."""
        return _two("add", other, self)

    def __sub__(self, other: Any) -> Expression:
        """Difference."""
        return _two("subtract", self, other)

    def __rsub__(self, other: Any) -> Expression:
        """Difference."""
        return _two("subtract", other, self)

    def __mul__(self, other: Any) -> Expression:
        """Product."""
        return _two("multiply", self, other)

    def __rmul__(self, other: Any) -> Expression:
        """Product."""
        return _two("multiply", other, self)

    def __truediv__(self, other: Any) -> Expression:
        """Quotient."""
        return _two("divide", self, other)

    def __rtruediv__(self, other: Any) -> Expression:
        """Quotient."""
        return _two("divide", other, self)

    def __neg__(self) -> Expression:
        """Negative."""
        return _one("negate", self)

    def __abs__(self) -> Expression:
        """Absolute value."""
        return _one("absolute", self)

    def sqrt(self) -> Expression:
        """Square root."""
        return _one("square_root", self)

    def floor(self) -> Expression:
        """The largest integer that is not above."""
        return _one("floor", self)

    def length(self) -> Expression:
        """Length of a vector."""
        return Expression(("length", self._node), 6 * self._size + 3)

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
    """Return the column of that name, as the particle has it when the action runs."""
    if not isinstance(name, str):
        raise ArgumentError("name", name, "a column's name")
    return Expression(("column", str(name)))


def minimum(a: Any, b: Any) -> Expression:
    """Return the smaller of two, component by component."""
    return _two("minimum", a, b)


def maximum(a: Any, b: Any) -> Expression:
    """Return the larger of two, component by component."""
    return _two("maximum", a, b)


def as_expression(argument: str, value: Any) -> Expression:
    """Return `value`, an expression, a number or a vector."""
    if isinstance(value, Expression):
        return value
    if isinstance(value, (bool, Condition, Region)):
        raise ArgumentError(argument, value, "a number, 3 numbers or an expression of columns")
    if isinstance(value, (int, float, np.integer, np.floating)):
        numbers: tuple[float, ...] = (arguments.number(argument, value),)
    else:
        numbers = arguments.triple(argument, value, pair=argument != "color")
    if any(abs(v) > 3e38 for v in numbers):
        raise ArgumentError(argument, value, "within the range of float32")
    return Expression(("constant", numbers))


def constant_of(expression: Expression) -> float | tuple[float, ...] | None:
    """Return the number or vector that an expression is, or None if it depends on columns."""
    operation, *operands = expression._node
    if operation != "constant":
        return None
    numbers: tuple[float, ...] = operands[0]
    return numbers[0] if len(numbers) == 1 else numbers


def compile_values(
    name: str, value: Any, width: int, columns: Columns, shapes: list[_core.Shape]
) -> list[Program]:
    """Compile what `set` gives an attribute of `width` numbers; one number serves all components."""
    parts = components_of(name, value, columns, shapes)
    if len(parts) not in (1, width):
        raise ArgumentError(name, value, "a number or an expression of one number per particle")
    return parts * width if len(parts) == 1 else parts


def components_of(name: str, value: Any, columns: Columns, shapes: list[_core.Shape]) -> list[Program]:
    """Compile the components of an expression: one, or three."""
    return [_program_of(part, shapes) for part in components(as_expression(name, value)._node, columns)]


def _one(operation: str, a: Expression) -> Expression:
    return Expression((operation, a._node), a._size + 1)


def _two(operation: str, a: Any, b: Any) -> Expression:
    left, right = as_expression("operand", a), as_expression("operand", b)
    return Expression((operation, left._node, right._node), left._size + right._size + 1)


def _compare(operation: str, a: Any, b: Any) -> Condition:
    left, right = as_expression("operand", a), as_expression("operand", b)
    return Condition((operation, left._node, right._node), left._size + right._size + 1)
