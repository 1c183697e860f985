"""NumPy: whole columns, one operation after the other, with as few temporary arrays as possible."""

from __future__ import annotations

import numpy as np

from .scene import DT, FRICTION, GUST, LIFE, RESTITUTION, Columns

__all__ = ["Run"]


class Run:
    """Particles as columns."""

    def __init__(self, start: Columns, threads: int) -> None:
        """Keep the particles."""
        self._all = start
        self._random = np.random.Generator(np.random.SFC64(1))  # NumPy's fastest
        self._room = np.empty_like(start[0])
        self.killed = 0

    def step(self, number: np.uint32) -> None:
        """Take one step."""
        position, velocity, age = self._all[:3], self._all[3:6], self._all[6]
        room = self._room
        for v, gust in zip(velocity, GUST, strict=True):
            self._random.random(out=room, dtype=np.float32)
            room *= np.float32(2 * gust * DT)
            room -= np.float32(gust * DT)
            v += room
        np.multiply(velocity[1], np.float32(DT), out=room)
        room += position[1]
        hit = room < 0
        for v, factor in zip(velocity, (1 - FRICTION, -RESTITUTION, 1 - FRICTION), strict=True):
            np.multiply(v, np.float32(factor), out=v, where=hit)
        self.killed += int(np.count_nonzero(age >= np.float32(LIFE)))
        for x, v in zip(position, velocity, strict=True):
            np.multiply(v, np.float32(DT), out=room)
            x += room
        age += np.float32(DT)

    def columns(self) -> Columns:
        """Copy the particles."""
        return self._all.copy()
