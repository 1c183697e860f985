"""What all recorders of actions have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from ..actions.base import Action, Where, as_action
from ..actions.targets import Set

__all__ = ["Record", "Recording"]


class Record(Protocol):
    """Records an action."""

    def __call__(self, action: Action, depth: int = 3) -> None:
        """Record it; `depth` calls of the package stand between the script and the engine."""


class Recording:
    """Where a script tells particles what to do: a method per action, which makes it and hands it on.

    It knows nothing of systems: who inherits it says what records.
    """

    def __init__(self, record: Record) -> None:
        """Take what records."""
        self._record = record

    def apply(self, action: Action | Sequence[Action]) -> None:
        """Record an action, or each of a list.

        Args:
            action: an action of `motes.actions`, or a list of them.
        """
        for one in action if isinstance(action, (list, tuple)) else (action,):
            self._record(as_action(one), 2)

    def set(self, *, where: Where = None, **attributes: Any) -> None:
        """Set attributes to values, or to expressions of columns, in turn. Records `actions.Set` for each.

        Args:
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.
            **attributes: by name a number, a vector or an expression: `s.set(heat=column("age") * 2)`.
        """
        for name, value in attributes.items():
            self._record(Set(attribute=name, value=value, where=where), 2)
