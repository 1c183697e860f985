"""What all recorders of actions have."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

from .base import Action, Where
from .targets import Set

__all__ = ["Recording"]


class Recording(ABC):
    """Where a script tells all particles of a system what to do."""

    @abstractmethod
    def apply(self, action: Action | Sequence[Action]) -> None:
        """Record an action, or each of a list."""

    @abstractmethod
    def _record(self, action: Action, depth: int = 3) -> None:
        """Record an action; `depth` calls of the package stand between the script and the engine."""

    def set(self, *, where: Where = None, **attributes: Any) -> None:
        """Set attributes to values, or to expressions of columns, in turn. Records `actions.Set` for each.

        Args:
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.
            **attributes: by name a number, a vector or an expression: `s.set(heat=column("age") * 2)`.
        """
        for name, value in attributes.items():
            self._record(Set(attribute=name, value=value, where=where), 2)
