"""Children: particles that others leave behind when something happens to them, or from time to time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from . import _core, arguments
from ._run import script_lines
from .actions.base import Where
from .conditions import Columns, as_condition, condition_of
from .errors import ArgumentError
from .expressions import column, floor
from .values import says_near_names

if TYPE_CHECKING:
    from .system import System
    from .world import World

__all__ = ["Children"]

EVENTS = ("birth", "death", "collision", "frame")
ROUNDING = 2**-10  # of a trail's interval: what passes as one frame ends and the next begins passes once


class Children:
    """Rules by which particles emit others. `System` has them."""

    world: World
    _index: int
    _columns: Columns
    _list: list[Any]
    _lines: list[script_lines.Line]

    @says_near_names
    def spawn(
        self,
        into: System,
        *,
        on: Literal["birth", "death", "collision", "frame"],
        count: int,
        inherit_velocity: float = 0,
        where: Where = None,
    ) -> None:
        """Let events of this frame emit particles of another system.

        Children are born at the end of this frame, where the parent is then, with the attributes that
        `into.configure` has set so far. They are numbered in the order of the parents' ids.

        Args:
            into: the system that gets the children.
            on: "birth", "death", "collision" (with what it bounces off), or "frame" (being alive at its end);
                a particle counts once per rule and frame.
            count: children for each parent.
            inherit_velocity: the part of the parent's velocity that is added to a child's.
            where: which parents: those in a shape, or for which a comparison of columns holds; None: all.
        """
        self._spawn("spawn", into, on, count, inherit_velocity, where)

    @says_near_names
    def trail(
        self,
        into: System,
        *,
        every: float,
        count: int = 1,
        inherit_velocity: float = 0,
        where: Where = None,
    ) -> None:
        """Let particles leave particles of another system behind at regular ages.

        They do so in the frames in which their age passes a multiple of `every`, up to half a frame early:
        once per frame at most. As `spawn(on="frame")`, which says where children are born and with what.

        Args:
            into: the system that gets the children.
            every: seconds of a parent's age from one time to the next.
            count: children each time.
            inherit_velocity: the part of the parent's velocity that is added to a child's.
            where: which parents: those in a shape, or for which a comparison of columns holds; None: all.
        """
        every = arguments.number("every", every, low=1e-6, high=1e6)
        passed, half = column("age") / every + ROUNDING, self.world.dt / 2 / every
        passing = floor(passed + half) > floor(passed - half)
        chosen = passing if where is None else passing & as_condition("where", where)
        self._spawn("trail", into, "frame", count, inherit_velocity, chosen)

    def _spawn(
        self, call: str, into: System, on: str, count: int, inherit_velocity: float, where: Where
    ) -> None:
        world = self.world
        if not isinstance(into, Children) or into.world is not world:
            raise ArgumentError("into", into, "a system of the same world")
        shapes: list[_core.Shape] = []
        spawn = _core.Spawn(
            into=into._index,
            on=arguments.choice("on", on, EVENTS),
            count=arguments.integer("count", count, low=1, high=1_000_000),
            inherit_velocity=arguments.number("inherit_velocity", inherit_velocity, low=-1e6, high=1e6),
            state=into._state_now(),
            where=condition_of(where, self._columns, shapes),
            shapes=shapes,
        )
        engine = world._begin(call)
        try:
            engine.record_spawn(self._index, spawn)
            self._list.append(spawn)
            self._lines.append(script_lines.running_line(3))
            into._has_births = True
        finally:
            world._usage.end()
