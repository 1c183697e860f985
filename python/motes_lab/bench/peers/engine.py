"""The engine as a peer, called as a script calls it."""

from __future__ import annotations

from types import TracebackType

import numpy as np

from motes import World
from motes.shapes import Box, Plane

from .scene import DT, FRICTION, GUST, LIFE, NAMES, RESTITUTION, Columns

__all__ = ["Engine"]


class Engine:
    """A world with one system of flakes; leave its `with` block, or close() it."""

    def __init__(self, particles: int, steps: int, threads: int) -> None:
        """Make the particles."""
        self._world = World(seed=1, dt=DT, progress="off", threads=threads)
        self._flakes = self._world.system("flakes")
        self._world.open()
        self._frames = self._world.frames(steps + 1)
        next(self._frames)
        self._flakes.configure(velocity=Box((-1, -2, -1), (1, -1, 1)))
        self._flakes.burst(Box((-50, 0.1, -50), (50, 50, 50)), count=particles)
        self._flakes.move()
        self._world.step()

    def __enter__(self) -> Engine:
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End the run."""
        self._world.close()

    def step(self, number: np.uint32) -> None:
        """Record the list and run it."""
        next(self._frames)
        flakes = self._flakes
        flakes.random_acceleration(Box(tuple(-a for a in GUST), GUST))
        flakes.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=RESTITUTION, friction=FRICTION)
        flakes.kill_old(LIFE)
        flakes.move()
        self._world.step()

    def columns(self) -> Columns:
        """Copy the particles."""
        with self._flakes.local() as flakes:
            columns = [*flakes.position.T, *flakes.velocity.T, flakes.age]
            return np.array(columns, dtype=np.float32).reshape(len(NAMES), -1)
