"""The base of all actions: a value that a script records and the engine runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from .. import _core, arguments
from ..errors import ArgumentError
from ..expressions import Columns, Condition, as_condition, compile_condition
from ..shapes import Shape

__all__ = ["Action", "Where", "as_action", "at_least_0"]


Where = Shape | Condition | None


@dataclass(frozen=True, kw_only=True)
class Action:
    """Base of all actions. `where` limits one to particles in a shape, or for which a comparison holds."""

    where: Where = None

    _call: ClassVar[tuple[str, list[float], list[_core.Shape]]]
    _made: ClassVar[_core.Action]

    def _set(self, name: str, numbers: list[float], *shapes: Shape) -> None:
        if self.where is not None:
            as_condition("where", self.where)
        cores = [shape.core for shape in shapes]
        object.__setattr__(self, "_call", (name, numbers, cores))
        object.__setattr__(self, "_made", _core.Action(name, numbers, cores))  # checks the arguments

    def compiled(self, columns: Columns) -> _core.Action:
        """Return the engine's value for a system with these columns."""
        if self.where is None:
            return self._made
        name, numbers, own = self._call
        shapes = list(own)
        where = compile_condition(self.where, columns, shapes)
        return _core.Action(name, numbers, shapes, where)


def as_action(value: Any) -> Action:
    """Return `value`, which must be an action."""
    if not isinstance(value, Action):
        raise ArgumentError("action", value, "an action of motes.actions, or a list of them")
    return value


def at_least_0(argument: str, value: Any) -> float:
    """Return `value`, a number >= 0 that may be infinite."""
    return arguments.number(argument, value, low=0, finite=False)
