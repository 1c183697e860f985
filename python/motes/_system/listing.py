"""Listing: adds actions to a system's list."""

from __future__ import annotations

from collections.abc import Callable

from .. import _core
from .._run import script_lines
from .._values.values import at, moves
from ..actions.base import Action, compiled
from ..actions.between import Contact, compiled_for_clumps, counterpart_of
from ..actions.targets import Set
from ..errors import ArgumentError
from .system_state import SystemState, engine_sets

__all__ = ["Listing"]


class Listing:
    """Records actions in the engine and in the list that `System.recorded` returns."""

    def __init__(self, state: SystemState, state_of: Callable[[object], SystemState | None]) -> None:
        """Store the system; `state_of` maps a script's System to its SystemState, anything else to None."""
        self._state = state
        self._state_of = state_of

    def record(self, action: Action) -> None:
        """Record an action for the script's line that called the system's method."""
        system = self._state
        session = system.session
        for name in (action.attribute,) if isinstance(action, Set) else getattr(action, "set", None) or ():
            if name in system.engine_attributes:
                raise engine_sets("set", name)
        if moves(action):
            action = at(action, session.time)
        if session.settings.periodic:
            from .reach import check_action

            check_action(action, session.settings.periodic)
        engine = session.begin(type(action).__name__)
        try:
            line = script_lines.running_line(2)
            given = getattr(action, "other", None)
            if given is None:
                engine.record_action(system.index, self._compiled(action))
            else:
                other = self._state_of(given)
                if other is None or other.session is not session or other is system:
                    raise ArgumentError("other", given, "another system of the same world")
                native = self._compiled(action, other)
                if isinstance(action, Contact):
                    its = _contact_of(other, counterpart_of(action), "other_radius")
                    engine.record_interaction(system.index, other.index, native, its)
                else:
                    engine.record_interaction(system.index, other.index, native)
                other.add(action, line)
            system.add(action, line)
        finally:
            session.end()

    def _compiled(self, action: Action, other: SystemState | None = None) -> _core.Action:
        if isinstance(action, Contact):
            return _contact_of(self._state, action, "radius")
        return compiled(action, self._state.columns, None if other is None else other.columns)


def _contact_of(system: SystemState, action: Contact, argument: str) -> _core.Action:
    """Return the engine's contact for a system's particles. `argument`: the name of their radius."""
    clump = system.newborn.clump
    if clump is None:
        return compiled(action, system.columns)
    if action.radius is not None:
        raise ArgumentError(argument, action.radius, "None for clumps, whose spheres have radii of their own")
    alone = [entry for entry in system.entries if isinstance(entry, Contact) and entry.other is None]
    if alone and argument == "radius" and action.other is None:
        raise ArgumentError(
            "contact", action, "recorded once per frame for clumps, and once per other system"
        )
    return compiled_for_clumps(action, clump, system.columns)
