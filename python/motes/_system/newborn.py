"""Newborn: the attributes that newborn particles of a system get, as set by `configure`."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._values.curves import moving_part
from .._values.values import Moving, Value, at
from ..errors import ArgumentError
from .distributions import distribution

if TYPE_CHECKING:
    from .._values.clump import Clump

__all__ = ["Newborn"]


class Newborn:
    """A distribution for each attribute that was set; those with curves are evaluated in each frame."""

    def __init__(
        self, name: str, attributes: Mapping[str, tuple[int, int]], engine_attributes: Collection[str] = ()
    ) -> None:
        """Store the system's name, each attribute's index and width, and the attributes set by the engine."""
        self._name = name
        self._attributes = attributes
        self._not_set = {"position", *engine_attributes}
        self._given: dict[int, _core.Distribution] = {}
        self._state: list[tuple[int, _core.Distribution]] = []
        self._moving: dict[str, Moving | Value] = {}
        self.clump: Clump | None = None
        """The template of the system's clumps; None: its particles are no clumps."""

    def configure(self, state: Mapping[str, Any]) -> None:
        """Set attributes of newborn particles from here on; attributes set earlier remain."""
        distributions = {}
        for attribute, value in state.items():
            if attribute not in self._attributes or attribute in self._not_set:
                names = [name for name in self._attributes if name not in self._not_set]
                allowed = f"an attribute of '{self._name}': {', '.join(names)}"
                raise ArgumentError("configure", attribute, allowed, known=names)
            moving = moving_part(value)
            index, width = self._attributes[attribute]
            for time in moving:
                distributions[index] = distribution(attribute, width, at(value, time))
            if not moving:
                distributions[index] = distribution(attribute, width, value)
        self._given.update(distributions)
        for attribute, value in state.items():
            self._moving.pop(attribute, None)
            if moving_part(value):
                self._moving[attribute] = value
        self._sort()

    def state_at(self, time: float) -> list[tuple[int, _core.Distribution]]:
        """Return the distributions for particles born in the frame that starts at `time` (s)."""
        for attribute, value in self._moving.items():
            index, width = self._attributes[attribute]
            self._given[index] = distribution(attribute, width, at(value, time))
        if self._moving:
            self._sort()
        return self._state

    def state(self) -> tuple[dict[int, bytes], dict[str, Any], list[list[float]]]:
        """Return the state set so far, for pickling."""
        given = {index: one.to_bytes() for index, one in self._given.items()}
        spheres = [] if self.clump is None else np.asarray(self.clump.spheres).tolist()
        return given, dict(self._moving), spheres

    def restore(self, state: Sequence[Any]) -> None:
        """Restore the state that `state` returned in an earlier run; ({}, {}) resets everything."""
        given, moving, *spheres = state
        self.clump = None
        if spheres and spheres[0]:
            from .._values.clump import as_clump

            self.clump = as_clump(spheres[0])
        self._given = {index: _core.Distribution.from_bytes(text) for index, text in given.items()}
        self._moving = dict(moving)
        self._sort()

    def _sort(self) -> None:
        self._state = sorted(self._given.items(), key=lambda pair: pair[0])
