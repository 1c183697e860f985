"""Callbacks: functions of the script that the recorded list calls with particles or pairs of particles."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._particles.particles import LocalParticles, close_views, write_back
from .._run import script_lines
from .._values import arguments
from ..actions.base import Where
from ..errors import ArgumentError
from ..expressions._conditions import condition_of
from .pairs import Pairs, changes_of
from .system_state import SystemState

__all__ = ["Callbacks"]


class Callbacks:
    """Records functions of the script, and calls them when the engine reaches them in the list."""

    def __init__(self, state: SystemState) -> None:
        """Create the recorder of a system's callbacks."""
        self._state = state

    def callback(self, function: Callable[[LocalParticles], object], where: Where) -> None:
        """Record a function that takes particles: `System.callback`."""
        if not callable(function):
            raise ArgumentError("function", function, "a function of particles")
        shapes: list[_core.Shape] = []
        callback = _core.Callback(
            name=_name_of(function),
            number=len(self._state.functions),
            where=condition_of(where, self._state.columns, shapes),
            shapes=shapes,
        )
        self._record("callback", function, partial(_core.Engine.record_callback, callback=callback))

    def pairs(self, function: Callable[[Pairs], object], radius: float, where: Where) -> None:
        """Record a function that takes pairs: `System.pairs`."""
        if not callable(function):
            raise ArgumentError("function", function, "a function of pairs")
        shapes: list[_core.Shape] = []
        condition = condition_of(where, self._state.columns, shapes)
        reach, number = arguments.number("radius", radius, low=0), len(self._state.functions)
        if self._state.session.settings.periodic:
            from .reach import check_reach

            check_reach("radius", reach, self._state.session.settings.periodic)
        numbers = {"radius": reach, "number": number, "name": zlib.crc32(_name_of(function).encode())}
        action = _core.Action("pairs", numbers, shapes, condition)
        self._record("pairs", function, partial(_core.Engine.record_action, action=action))

    def called(self, number: int, begin: int, chosen: Any, pairs: Any) -> NDArray[np.float32] | None:
        """Call this frame's function `number`, for the engine; return the changes of a function of pairs."""
        system = self._state
        function = system.functions[number]
        engine = system.session.engine_for("callback")
        with system.session.usage.callback(f"{_name_of(function)!r} of system {system.name!r}"):
            if pairs is not None:
                return changes_of(Pairs(*pairs), function)
            view = LocalParticles(engine, system.index, system.attributes, begin, chosen)
            try:
                function(view)
                write_back(view)
            finally:
                if close_views(view):
                    engine.release_views(system.index)
        return None

    def _record(self, call: str, function: Callable[[Any], object], record: Callable[..., None]) -> None:
        system = self._state
        session = system.session
        engine = session.begin(call)
        try:
            if session.recording is not None:
                session.recording.refuse(
                    session.frame, f"'{system.name}' calls the function {_name_of(function)}"
                )
            record(engine, system.index)
            system.functions.append(function)
            system.add(function, script_lines.running_line(4))
        finally:
            session.end()


def _name_of(function: object) -> str:
    return str(getattr(function, "__qualname__", type(function).__name__))
