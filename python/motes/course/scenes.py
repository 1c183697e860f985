"""A game on real ranks: its load as a script's parts, its machines as work that no log names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .._values import arguments
from ..errors import ArgumentError
from ._secret import PRACTICE
from .grading import task
from .policies import GAMES, practice

if TYPE_CHECKING:
    from .._system.system import System

__all__ = ["Scene"]

PASSES = 12
"""Square roots of all coordinates that a machine at full speed takes per frame."""


class Scene:
    """An evening's load for a script, on ranks that are as quick as its hidden machines.

    Attributes:
        frames: how many it has.
        options: what the evening's policy is made with.
    """

    def __init__(self, evening: int | str, game: int = 0, *, key: str = PRACTICE) -> None:
        """Make it.

        Args:
            evening: 1 to 6, or the task's name.
            game: which one of the evening's hidden loads, from 0 on; the first two evenings have one.
            key: decides the hidden loads.

        Raises:
            ArgumentError: for an evening or a game that does not exist.
        """
        number = task(evening).evening
        games = GAMES[number](key) if number in GAMES else [practice(number, key)]
        chosen = games[arguments.integer("game", game, low=0, high=len(games) - 1)]
        self._load, self._speeds = chosen.workload, chosen.machine.speeds
        self.frames, self.options = chosen.workload.frames, dict(chosen.options)

    @property
    def world(self) -> dict[str, Any]:
        """What `World` is to be given."""
        return self._load.world

    def step(self, system: System, frame: int, *, rank: int) -> None:
        """Record a frame's births and actions.

        Args:
            system: whose.
            frame: which, from 0 on.
            rank: this process's rank, below the number of machines.
        """
        if rank >= len(self._speeds):
            raise ArgumentError("rank", rank, f"below {len(self._speeds)}: there are no more machines")
        part = self._load.slowdown(frame, len(self._speeds))[rank]
        passes = round(PASSES / (self._speeds[rank] * part))

        def work(particles: Any) -> None:
            """Take as long as the machine does; changes nothing."""
            for _ in range(passes):
                np.sqrt(np.abs(particles.position))

        system.callback(work)
        self._load.step(system, frame)
