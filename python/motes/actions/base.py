"""Base class of all actions: values that a script records and the engine runs."""

from __future__ import annotations

from typing import Any

from .. import _core
from .._values import arguments
from .._values.curves import Number
from .._values.values import Value, value
from ..errors import ArgumentError
from ..expressions._conditions import Columns, Condition, as_condition, condition_of
from ..shapes import Shape, as_shape, native_of

__all__ = ["Action", "Reaching", "Where", "as_action", "as_where", "at_least_0", "compiled"]


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


def _flat(field: Any) -> list[float]:
    if not isinstance(field, tuple):
        return [field]
    return [number for part in field for number in _flat(part)]
