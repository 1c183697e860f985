"""Base class of all actions: values that a script records and the engine runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .. import _core
from .._values import arguments
from .._values.curves import Number
from .._values.values import Value, value
from ..errors import ArgumentError
from ..expressions._compiling import components_of
from ..expressions._conditions import Columns, Condition, as_condition, condition_of, zero_divisor_of
from ..expressions._expression import Expression, as_expression, node_of
from ..shapes import Shape, as_shape, native_of

__all__ = ["Action", "PerParticle", "Reaching", "Where", "as_action", "as_where", "at_least_0", "compiled"]


Where = Shape | Condition | None
"""Type of `where=`: a shape, a condition on columns, or None for all particles."""


@value(kw_only=True)
class Action(Value):
    """Base of all actions.

    Attributes:
        where: which particles to act on: those inside a shape, or those that satisfy a comparison of columns;
            None: all.
    """

    where: Where = None
    _may_move = True

    def _set(self, name: str, **fields: Any) -> None:
        """Store the checked fields and build the engine's action: numbers by name, shapes in order.

        `walls`: shapes, and four numbers for each (see `Contact`).
        """
        numbers: dict[str, Any] = {}
        shapes: list[_core.Shape] = []
        more: dict[str, Any] = {}
        for key, field in fields.items():
            if isinstance(field, Shape):
                shapes.append(native_of(field))
            elif key == "walls":
                shapes.extend(native_of(wall) for wall, _ in field)
                more[key] = [given for _, given in field]
            else:
                numbers[key] = field if key != "ramp" else _flat(field)
        state = self.__dict__
        state.update(fields)
        if self.where is not None:
            state["where"] = as_where(self.where)
        state["_call"] = (name, numbers, shapes, more)
        state["_made"] = _core.Action(name, numbers, shapes, **more)

    def _compiled(self, columns: Columns, others: Columns | None = None) -> _core.Action:
        """Return the engine's action for a system with these columns, and for the other system's columns."""
        if self.where is None:
            native: _core.Action = self.__dict__["_made"]
            return native
        name, numbers, own, more = self.__dict__["_call"]
        shapes = list(own)
        where = condition_of(self.where, columns, shapes)
        return _core.Action(name, numbers, shapes, where, **more)


@value(kw_only=True)
class PerParticle(Action):
    """Base of actions whose numbers may be expressions, with a value for each particle."""

    def _set_each(self, name: str, **fields: tuple[int, Any, Callable[[str, Any], Any]]) -> None:
        """Store the fields, and build the engine's action if none of them is an expression.

        Each field is given as (width, value, check).
        """
        values = {key: _of_particle(key, given, check) for key, (_, given, check) in fields.items()}
        if not any(isinstance(one, Expression) for one in values.values()):
            self._set(name, **values)
            return
        self.__dict__.update(values, where=as_where(self.where))
        self.__dict__["_each"] = (name, {key: width for key, (width, _, _) in fields.items()})

    def _key(self) -> tuple[Any, ...]:
        """Return the key for comparing and hashing; `==` on expressions would build a condition."""
        return tuple(node_of(one) if isinstance(one, Expression) else one for one in super()._key())

    def _compiled(self, columns: Columns, others: Columns | None = None) -> _core.Action:
        """Return the engine's action for a system with these columns."""
        if "_each" not in self.__dict__:
            return super()._compiled(columns, others)
        name, widths = self.__dict__["_each"]
        shapes: list[_core.Shape] = []
        where = condition_of(self.where, columns, shapes)
        values: list[Any] = []
        for field, width in widths.items():
            given = self.__dict__[field]
            parts: list[Any] = [[("constant", 0, number)] for number in _flat(given)]
            if isinstance(given, Expression):
                parts = components_of(field, given, columns, shapes)
            if len(parts) != width:
                vector = "a vector: 3 numbers, or an expression of them"
                raise ArgumentError(field, given, vector if width == 3 else "one number per particle")
            values += parts
        return _core.Action(f"{name}_by", {}, shapes, where, values=values)


@value()
class Reaching(Action):
    """Base of actions whose radius may be passed positionally, and all else by name."""

    radius: Number


def compiled(action: Action, columns: Columns, others: Columns | None = None) -> _core.Action:
    """Return the engine's action for a system with these columns; for use elsewhere in the package."""
    return action._compiled(columns, others)


def as_action(value: Any) -> Action:
    """Return `value`; raise if it is not an action."""
    if not isinstance(value, Action):
        raise ArgumentError("action", value, "an action of motes.actions, or a list of them")
    return value


def as_where(value: Any) -> Where:
    """Return `value` as a shape (a vector becomes a `Point`), a condition or None."""
    if value is None or isinstance(value, (Shape, Condition)):
        return value
    if isinstance(value, (tuple, list)):
        return as_shape("where", value)
    return as_condition("where", value)  # raises if it is not a condition


def at_least_0(argument: str, value: Any) -> float:
    """Return `value` as a float >= 0, which may be infinite."""
    return arguments.number(argument, value, low=0, finite=False)


def _of_particle(argument: str, given: Any, check: Callable[[str, Any], Any]) -> Any:
    """Return an expression, also a vector with expressions as components; check anything else."""
    parts = given if isinstance(given, (tuple, list)) else (given,)
    if not any(isinstance(part, Expression) for part in parts):
        return check(argument, given)
    expression = as_expression(argument, given)
    zero = zero_divisor_of(node_of(expression))
    if zero is not None:
        raise ArgumentError(argument, zero, "no division by 0")
    return expression


def _flat(field: Any) -> list[float]:
    if not isinstance(field, tuple):
        return [field]
    return [number for part in field for number in _flat(part)]
