"""Callbacks: functions of the script that run on each calculator's particles, or on pairs of them."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core, arguments
from ._run import script_lines
from .actions.base import Where
from .conditions import Columns, condition_of
from .errors import ArgumentError
from .pairs import Pairs
from .particles import LocalParticles
from .values import says_near_names

if TYPE_CHECKING:
    from .world import World

__all__ = ["Callbacks"]


class Callbacks:
    """Calls of the script's functions, at their place in the list. `System` has them."""

    world: World
    name: str
    _index: int
    _attributes: dict[str, tuple[int, int]]
    _columns: Columns
    _list: list[Any]
    _lines: list[script_lines.Line]
    _callbacks: list[Callable[[Any], object]]

    @says_near_names
    def callback(self, function: Callable[[LocalParticles], object], *, where: Where = None) -> None:
        """Call a function here in the list, on each calculator, with views of its particles.

        It must treat each particle by itself, and not depend on how many there are: newborn particles may
        come in a separate call. It is called in each sub-step. It cannot record, step or read systems.

        Args:
            function: takes `LocalParticles`.
            where: it sees only the particles in a shape or for which a comparison holds: their columns are
                copies, which are written back afterwards, and it is not called if there are none. None: all
                particles.
        """
        if not callable(function):
            raise ArgumentError("function", function, "a function of particles")
        shapes: list[_core.Shape] = []
        callback = _core.Callback(
            name=_name_of(function),
            number=len(self._callbacks),
            where=condition_of(where, self._columns, shapes),
            shapes=shapes,
        )
        self._record_function("callback", function, partial(_core.Engine.record_callback, callback=callback))

    def _record_function(
        self, call: str, function: Callable[[Any], object], record: Callable[..., None]
    ) -> None:
        world = self.world
        engine = world._begin(call)
        try:
            if world._recording is not None:
                world._recording.refuse(world.frame, f"'{self.name}' calls {_name_of(function)} back")
            record(engine, self._index)
            self._callbacks.append(function)
            self._list.append(function)
            self._lines.append(script_lines.running_line(3))
        finally:
            world._usage.end()

    def _called(self, number: int, begin: int, chosen: Any, pairs: Any) -> NDArray[np.float32] | None:
        if pairs is not None:
            return self._call_pairs(number, pairs)
        self._call_back(number, begin, chosen)
        return None

    def _call_back(self, number: int, begin: int, chosen: NDArray[np.uint32] | None) -> None:
        engine = self.world._engine_for("callback")
        function = self._callbacks[number]
        view = LocalParticles(engine, self._index, self._attributes, begin, chosen)
        try:
            with self.world._usage.callback(f"{_name_of(function)!r} of system {self.name!r}"):
                function(view)
            view._write_back()
        finally:
            if view._close():
                engine.release_views(self._index)

    @says_near_names
    def pairs(self, function: Callable[[Pairs], object], radius: float, *, where: Where = None) -> None:
        """Call a function here in the list, on each calculator, with the pairs within a radius. Paper 3.1.5.

        Each pair is seen from both of its particles. The changes that the function returns are added in the
        order of the pairs; it must treat each pair by itself.

        Args:
            function: takes `Pairs`; returns the changes of velocity of the own particles, m/s, shape (n, 3),
                or None for no change.
            radius: m.
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.
        """
        if not callable(function):
            raise ArgumentError("function", function, "a function of pairs")
        name = _name_of(function)
        shapes: list[_core.Shape] = []
        condition = condition_of(where, self._columns, shapes)
        numbers = [arguments.number("radius", radius, low=0), len(self._callbacks), zlib.crc32(name.encode())]
        action = _core.Action("pairs", numbers, shapes, condition)
        self._record_function("pairs", function, partial(_core.Engine.record_action, action=action))

    def _call_pairs(self, number: int, arrays: tuple[NDArray[Any], ...]) -> NDArray[np.float32] | None:
        function = self._callbacks[number]
        pairs = Pairs(*arrays)
        with self.world._usage.callback(f"{_name_of(function)!r} of system {self.name!r}"):
            changes = function(pairs)
        return None if changes is None else pairs._checked(changes)


def _name_of(function: object) -> str:
    return str(getattr(function, "__qualname__", type(function).__name__))
