"""Expressions of columns: what `where=` tests and what `set` computes, run by the engine for each particle.

`motes.column("age") > 2`, `motes.column("velocity").length() * 0.5`, `Box(...) & ~Sphere(...)`. An
expression is a value: it is recorded and hashed like any other argument. Vectors work component by component.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from . import _core, arguments
from .errors import ArgumentError
from .shapes import Shape, as_shape

__all__ = ["Condition", "Expression", "as_condition", "as_expression", "column", "maximum", "minimum"]

# An instruction before its column's and shape's numbers are known: operation and operand.
Step = tuple[str, Any]
Steps = tuple[Step, ...]
Program = list[tuple[str, int, float]]

MOST_STEPS = 256  # operations of one expression


class Expression:
    """A number or a vector a particle, computed from its columns."""

    __array_ufunc__ = None  # NumPy arrays leave the arithmetic to this class

    def __init__(self, parts: Callable[[Columns], list[Steps]], text: str, size: int = 1) -> None:
        """Take what gives the components' steps for a system's columns; scripts use `column`."""
        self._parts = parts
        self._text = text
        self._size = _checked(size)

    def __add__(self, other: Any) -> Expression:
        """Sum."""
        return _two("add", "{} + {}", self, other)

    def __radd__(self, other: Any) -> Expression:
        """Sum."""
        return _two("add", "{} + {}", other, self)

    def __sub__(self, other: Any) -> Expression:
        """Difference."""
        return _two("subtract", "{} - {}", self, other)

    def __rsub__(self, other: Any) -> Expression:
        """Difference."""
        return _two("subtract", "{} - {}", other, self)

    def __mul__(self, other: Any) -> Expression:
        """Product."""
        return _two("multiply", "{} * {}", self, other)

    def __rmul__(self, other: Any) -> Expression:
        """Product."""
        return _two("multiply", "{} * {}", other, self)

    def __truediv__(self, other: Any) -> Expression:
        """Quotient."""
        return _two("divide", "{} / {}", self, other)

    def __rtruediv__(self, other: Any) -> Expression:
        """Quotient."""
        return _two("divide", "{} / {}", other, self)

    def __neg__(self) -> Expression:
        """Negative."""
        return _one("negate", "-{}", self)

    def __abs__(self) -> Expression:
        """Absolute value."""
        return _one("absolute", "abs({})", self)

    def sqrt(self) -> Expression:
        """Square root."""
        return _one("square_root", "{}.sqrt()", self)

    def floor(self) -> Expression:
        """Largest whole number that is not above."""
        return _one("floor", "{}.floor()", self)

    def length(self) -> Expression:
        """Length of a vector."""

        def parts(columns: Columns) -> list[Steps]:
            squares = [(*p, *p, ("multiply", 0)) for p in self._parts(columns)]
            total = squares[0]
            for square in squares[1:]:
                total = (*total, *square, ("add", 0))
            return [(*total, ("square_root", 0))]

        return Expression(parts, f"{self._text}.length()", 6 * self._size + 3)

    def __getitem__(self, index: int) -> Expression:
        """Component 0, 1 or 2 of a vector."""
        index = arguments.integer("index", index, low=0, high=2)

        def parts(columns: Columns) -> list[Steps]:
            all_parts = self._parts(columns)
            if index >= len(all_parts):
                raise ArgumentError("index", index, f"0: {self._text} has one number a particle")
            return [all_parts[index]]

        return Expression(parts, f"{self._text}[{index}]", self._size)

    x = property(lambda self: self[0], doc="First component.")
    y = property(lambda self: self[1], doc="Second component.")
    z = property(lambda self: self[2], doc="Third component.")

    def __lt__(self, other: Any) -> Condition:
        """Compare."""
        return _compare("less", "{} < {}", self, other)

    def __le__(self, other: Any) -> Condition:
        """Compare."""
        return _compare("less_equal", "{} <= {}", self, other)

    def __gt__(self, other: Any) -> Condition:
        """Compare."""
        return _compare("less", "{1} > {0}", other, self)

    def __ge__(self, other: Any) -> Condition:
        """Compare."""
        return _compare("less_equal", "{1} >= {0}", other, self)

    def __eq__(self, other: object) -> Condition:  # type: ignore[override]
        """Compare: a condition, not a truth."""
        return _compare("equal", "{} == {}", self, other)

    def __ne__(self, other: object) -> Condition:  # type: ignore[override]
        """Compare: a condition, not a truth."""
        return ~_compare("equal", "{} == {}", self, other)

    __hash__ = None  # type: ignore[assignment]

    def __bool__(self) -> bool:
        """Refuse: an expression has a value for each particle only."""
        raise ArgumentError("expression", self, "compared and given to where=, not tested in Python")

    def __repr__(self) -> str:
        """Show the expression."""
        return self._text


class Condition:
    """A truth a particle: combine with & | ~, give it to `where=`."""

    def __init__(self, steps: Callable[[Columns], Steps], text: str, size: int = 1) -> None:
        """Take what gives the steps for a system's columns."""
        self._steps = steps
        self._text = text
        self._size = _checked(size)

    def __and__(self, other: Any) -> Condition:
        """Both."""
        return _combine("both", "({} & {})", self, as_condition("&", other))

    def __or__(self, other: Any) -> Condition:
        """At least one."""
        return _combine("either", "({} | {})", self, as_condition("|", other))

    __rand__ = __and__
    __ror__ = __or__

    def __invert__(self) -> Condition:
        """Not."""
        return Condition(
            lambda columns: (*self._steps(columns), ("invert", 0)), f"~{self._text}", self._size + 1
        )

    def __bool__(self) -> bool:
        """Refuse: a condition has a truth for each particle only. Write & | ~ instead of and, or, not."""
        raise ArgumentError(
            "condition", self, "combined with & | ~ and given to where=, not tested in Python"
        )

    def __repr__(self) -> str:
        """Show the condition."""
        return self._text


Columns = Mapping[str, tuple[int, int]]
"""A system's columns: name -> (first component, width)."""


def column(name: str) -> Expression:
    """Return the column of that name, as the particle has it when the action runs."""
    if not isinstance(name, str):
        raise ArgumentError("name", name, "a column's name")

    def parts(columns: Columns) -> list[Steps]:
        if name not in columns:
            raise ArgumentError("column", name, f"one of {', '.join(columns)}")
        first, width = columns[name]
        return [(("column", first + i),) for i in range(width)]

    return Expression(parts, f"column({name!r})")


def minimum(a: Any, b: Any) -> Expression:
    """Return the smaller of two, component by component."""
    return _two("minimum", "minimum({}, {})", a, b)


def maximum(a: Any, b: Any) -> Expression:
    """Return the larger of two, component by component."""
    return _two("maximum", "maximum({}, {})", a, b)


def as_expression(argument: str, value: Any) -> Expression:
    """Return `value`, an expression, a number or three numbers."""
    if isinstance(value, Expression):
        return value
    if isinstance(value, (bool, Condition, Shape)):
        raise ArgumentError(argument, value, "a number, 3 numbers or an expression of columns")
    if isinstance(value, (int, float, np.integer, np.floating)):
        numbers: tuple[float, ...] = (arguments.number(argument, value),)
    else:
        numbers = arguments.triple(argument, value)
    if any(abs(v) > 3e38 for v in numbers):
        raise ArgumentError(argument, value, "within the range of float32")
    return Expression(lambda _: [(("constant", v),) for v in numbers], repr(value))


def as_condition(argument: str, value: Any) -> Condition:
    """Return `value`, a condition or a shape that holds the particle."""
    if isinstance(value, Condition):
        return value
    if isinstance(value, Shape):
        return Condition(lambda _: (("inside", value),), repr(value))
    if isinstance(value, (tuple, list)):
        return as_condition(argument, as_shape(argument, value))
    raise ArgumentError(argument, value, "a shape or a comparison of columns")


def compile_steps(steps: Steps, shapes: list[_core.Shape]) -> Program:
    """Add the shapes that the steps name to `shapes`, and return the engine's instructions."""
    program: Program = []
    for operation, operand in steps:
        if operation == "inside":
            shapes.append(operand.core)
            program.append((operation, len(shapes) - 1, 0.0))
        elif operation == "constant":
            program.append((operation, 0, operand))
        else:
            program.append((operation, operand, 0.0))
    return program


def compile_condition(value: Any, columns: Columns, shapes: list[_core.Shape]) -> Program:
    """Compile `where`, or nothing where it is None."""
    if value is None:
        return []
    return compile_steps(as_condition("where", value)._steps(columns), shapes)


def compile_values(
    name: str, value: Any, width: int, columns: Columns, shapes: list[_core.Shape]
) -> list[Program]:
    """Compile what `set` gives an attribute of `width` numbers; one number serves all components."""
    parts = as_expression(name, value)._parts(columns)
    if len(parts) not in (1, width):
        raise ArgumentError(name, value, "a number or an expression of one number a particle")
    parts = parts * width if len(parts) == 1 else parts
    return [compile_steps(part, shapes) for part in parts]


def _checked(size: int) -> int:
    if size > MOST_STEPS:
        raise ArgumentError("expression", f"{size} operations", f"of at most {MOST_STEPS} operations")
    return size


def _one(operation: str, text: str, a: Expression) -> Expression:
    return Expression(
        lambda at: [(*p, (operation, 0)) for p in a._parts(at)], text.format(a._text), a._size + 1
    )


def _two(operation: str, text: str, a: Any, b: Any) -> Expression:
    left, right = as_expression("operand", a), as_expression("operand", b)

    def parts(columns: Columns) -> list[Steps]:
        return [(*p, *q, (operation, 0)) for p, q in _pairs(left, right, columns)]

    return Expression(parts, f"({text.format(left._text, right._text)})", left._size + right._size + 1)


def _compare(operation: str, text: str, a: Any, b: Any) -> Condition:
    left, right = as_expression("operand", a), as_expression("operand", b)

    def steps(columns: Columns) -> Steps:
        pairs = _pairs(left, right, columns)
        if len(pairs) != 1:
            raise ArgumentError(
                "comparison", f"{left} with {right}", "of one number a particle: use [0], length()"
            )
        return (*pairs[0][0], *pairs[0][1], (operation, 0))

    return Condition(steps, f"({text.format(left._text, right._text)})", left._size + right._size + 1)


def _combine(operation: str, text: str, a: Condition, b: Condition) -> Condition:
    return Condition(
        lambda at: (*a._steps(at), *b._steps(at), (operation, 0)),
        text.format(a._text, b._text),
        a._size + b._size + 1,
    )


def _pairs(a: Expression, b: Expression, columns: Columns) -> list[tuple[Steps, Steps]]:
    left, right = a._parts(columns), b._parts(columns)
    if len(left) != len(right) and 1 not in (len(left), len(right)):
        raise ArgumentError("operand", b, f"a number or a vector, as {a}")
    width = max(len(left), len(right))
    left, right = (p * width if len(p) == 1 else p for p in (left, right))
    return list(zip(left, right, strict=True))
