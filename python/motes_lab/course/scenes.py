"""A game on real ranks: a script plays its load, and hidden extra work imitates its machines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from motes.errors import ArgumentError

from .._engine import arguments
from . import policies
from ._secret import PRACTICE
from .grading import task
from .policies import MADE, practice

if TYPE_CHECKING:
    from motes import System

__all__ = ["Scene"]

PASSES = 4
"""How often a machine at full speed takes the square roots of all coordinates per frame."""


class Scene:
    """An evening's load for a script, on ranks that are as fast as its hidden machines.

    Attributes:
        frames: number of frames.
        options: arguments with which the evening's policy is made.
    """

    def __init__(self, evening: int | str, game: int = 0, *, key: str = PRACTICE) -> None:
        """Make a load.

        Args:
            evening: 1 to 6, or the task's name.
            game: index of the evening's hidden load, from 0 on; the first two evenings have one.
            key: decides the hidden loads.

        Raises:
            ArgumentError: for an evening or a game that does not exist.
        """
        number = task(evening).evening
        games = len(MADE[number][1]) if number in MADE else 1
        arguments.integer("game", game, low=0, high=games - 1)
        chosen = policies.game(number, game, key) if number in MADE else practice(number, key)
        self._load, self._speeds = chosen.workload, chosen.machine.speeds
        self.frames, self.options = chosen.workload.frames, dict(chosen.options)

    @property
    def world(self) -> dict[str, Any]:
        """Arguments for `World`."""
        return self._load.world

    def step(self, system: System, frame: int, *, rank: int) -> None:
        """Record a frame's births and actions.

        Args:
            system: the particles.
            frame: its number, from 0 on.
            rank: this process's rank, less than the number of machines.
        """
        if rank >= len(self._speeds):
            raise ArgumentError("rank", rank, f"below {len(self._speeds)}: there are no more machines")
        part = self._load.slowdown(frame, len(self._speeds))[rank]
        passes = round(PASSES / (self._speeds[rank] * part))

        def work(particles: Any) -> None:
            """Take as long as the hidden machine would; change nothing."""
            for _ in range(passes):
                np.sqrt(np.abs(particles.position))

        system.callback(work)
        self._load.step(system, frame)
