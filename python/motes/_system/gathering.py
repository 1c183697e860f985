"""Gathering: copies of all particles of a system, for `System.gather`."""

from __future__ import annotations

from typing import Any

from .._particles.particles import Particles
from .._values import arguments
from .._values.space import unwrap
from ..errors import ArgumentError
from .system_state import SystemState

__all__ = ["gathered"]


def gathered(state: SystemState, to: Any, unwrapped: Any) -> Particles:
    """Copy all particles of a system. Collective."""
    if not isinstance(to, (int, str)) or isinstance(to, bool) or to not in (0, "all"):
        raise ArgumentError("to", to, "0 or 'all'", known=("all",))
    unwraps = arguments.flag("unwrapped", unwrapped)
    session = state.session
    engine = session.begin("gather()", reads=True)
    try:
        columns = engine.gather(state.index, to == "all")
    finally:
        session.end_conversation(engine)
    return Particles(unwrap(columns, session.settings.periodic) if unwraps and columns else columns)
