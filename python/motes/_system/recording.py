"""Recording: the base class of all recorders of actions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from ..actions.base import Action, Where, as_action
from ..actions.targets import Set

__all__ = ["Record", "Recording"]


class Record(Protocol):
    """Records an action."""

    def __call__(self, action: Action, depth: int = 3) -> None:
        """Record it; the script's line is `depth` calls up the stack."""


class Recording:
    """Base of classes with one method per action, which creates the action and passes it to `record`.

    It is independent of systems: subclasses supply the function that records.
    """

    def __init__(self, record: Record) -> None:
        """Store the function that records actions."""
        self._record = record

    def apply(self, action: Action | Sequence[Action]) -> None:
        """Record an action, or each action of a list.

        Args:
            action: an action of `motes.actions`, or a list of them.
        """
        for one in action if isinstance(action, (list, tuple)) else (action,):
            self._record(as_action(one), 2)

    def set(self, *, where: Where = None, **attributes: Any) -> None:
        """Set attributes to values, or to expressions of columns, in turn. Records `actions.Set` for each.

        Args:
            where: which particles: those inside a shape, or those that satisfy a comparison of columns; None:
                all.
            **attributes: a number, a vector or an expression for each: `s.set(heat=column("age") * 2)`.
        """
        for name, value in attributes.items():
            self._record(Set(attribute=name, value=value, where=where), 2)
