"""Children: particles that other particles emit on events or at regular ages."""

from __future__ import annotations

from .. import _core
from .._run import script_lines
from .._values import arguments
from ..actions.base import Where
from ..errors import ArgumentError
from ..expressions import column, floor
from ..expressions._conditions import as_condition, condition_of
from .system_state import SystemState

__all__ = ["Children"]

EVENTS = ("birth", "death", "collision", "frame")
ROUNDING = 2**-10  # fraction of a trail's interval, added so that a multiple between two frames counts once


class Children:
    """Records rules by which particles emit others."""

    def __init__(self, state: SystemState) -> None:
        """Store the system whose particles are the parents."""
        self._state = state

    def trail(
        self,
        children: SystemState | None,
        into: object,
        every: float,
        count: int,
        inherit_velocity: float,
        where: Where,
    ) -> None:
        """Record that particles emit others at regular ages: `System.trail`."""
        every = arguments.number("every", every, low=1e-6, high=1e6)
        half = self._state.session.settings.dt / 2 / every
        passed = column("age") / every + ROUNDING
        passing = floor(passed + half) > floor(passed - half)
        chosen = passing if where is None else passing & as_condition("where", where)
        self.spawn("trail", children, into, "frame", count, inherit_velocity, chosen)

    def spawn(
        self,
        call: str,
        children: SystemState | None,
        into: object,
        on: str,
        count: int,
        inherit_velocity: float,
        where: Where,
    ) -> None:
        """Record that events emit particles: `System.spawn`; `into`: the script's argument, for errors."""
        system = self._state
        session = system.session
        if children is None or children.session is not session:
            raise ArgumentError("into", into, "a system of the same world")
        shapes: list[_core.Shape] = []
        spawn = _core.Spawn(
            into=children.index,
            on=arguments.choice("on", on, EVENTS),
            count=arguments.integer("count", count, low=1, high=1_000_000),
            inherit_velocity=arguments.number("inherit_velocity", inherit_velocity, low=-1e6, high=1e6),
            state=children.state_now(),
            where=condition_of(where, system.columns, shapes),
            shapes=shapes,
        )
        engine = session.begin(call)
        try:
            engine.record_spawn(system.index, spawn)
            system.add(spawn, script_lines.running_line(3))
            children.has_births = True
        finally:
            session.end()
