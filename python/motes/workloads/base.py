"""What a workload is: where its particles are in each frame, as numbers and as a script's parts."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._values import arguments
from ..errors import ArgumentError
from ..expressions import choose, column, floor
from .optimum import Best, best_cuts

if TYPE_CHECKING:
    from .._particles.particles import Particles
    from .._system.system import System

__all__ = ["Workload", "laid", "vector"]

Counts = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

CROWD_AT = 1.5
"""The second sheet's y; the first one's is 0.5."""


class Workload:
    """Particles in the middles of a row of cells, each 1 m wide, and how they move in each frame.

    They lie in two sheets, the even ones and a crowd. All of it is known before a run, so the best cuts are,
    too; and a script plays the same on any ranks.

    Attributes:
        name: of the workload.
        frames: how many it has.
        cells: in the row, along x from 0 to `cells` metres.
        particles: in all, once all are born.
        disturbed: whether machines are slower in some frames.
    """

    name = ""
    disturbed = False

    def __init__(self, *, frames: int = 60, cells: int = 1000, particles: int = 200_000) -> None:
        """Make it.

        Args:
            frames: how many, from 2 on.
            cells: in the row, from 32 on.
            particles: in all.
        """
        self.frames = arguments.integer("frames", frames, low=2, high=10**6)
        self.cells = arguments.integer("cells", cells, low=32, high=2**22)
        self.particles = arguments.integer("particles", particles, low=1, high=2**40)
        self._last: tuple[Any, Best] = (None, Best(np.zeros(0, np.int64), 0.0))  # often the next is the same

    @abstractmethod
    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, before they move, (2 sheets, cells); None: none.

        Args:
            frame: which, from 0 on.
        """

    def shifts(self, frame: int) -> tuple[int, int]:
        """Return the cells by which each sheet moves in a frame, around the end of the row.

        Args:
            frame: which, from 0 on.
        """
        return 0, 0

    def slowdown(self, frame: int, calculators: int) -> Floats:
        """Return the part of its speed that each calculator has in a frame, (calculators,).

        Args:
            frame: which, from 0 on.
            calculators: how many.
        """
        return np.ones(calculators)

    @cached_property
    def _sheets(self) -> list[tuple[Counts, Counts]]:
        """Of each frame: what acts, and what is there at its end, summed over the sheets."""
        found, now = [], np.zeros((2, self.cells), np.int64)
        for frame in range(self.frames):
            newborn = self.born(frame)
            acting = now if newborn is None else now + newborn
            now = np.stack([np.roll(one, by) for one, by in zip(acting, self.shifts(frame), strict=True)])
            found.append((acting.sum(axis=0), now.sum(axis=0)))
        return found

    def births(self, frame: int) -> Counts:
        """Return the particles born in a frame, in each cell, int64 (cells,).

        Args:
            frame: which, from 0 on.
        """
        newborn = self.born(frame)
        return np.zeros(self.cells, np.int64) if newborn is None else newborn.sum(axis=0)

    def acting(self, frame: int) -> Counts:
        """Return the particles that a frame's actions work on, where they are then, int64 (cells,).

        Args:
            frame: which, from 0 on.
        """
        return self._sheets[frame][0]

    def counts(self, frame: int) -> Counts:
        """Return the particles in each cell at a frame's end, int64 (cells,).

        Args:
            frame: which, from 0 on.
        """
        return self._sheets[frame][1]

    def optimum(self, frame: int, speeds: npt.ArrayLike) -> Best:
        """Return the best cuts of a frame, and the seconds of its slowest calculator with them.

        Args:
            frame: which.
            speeds: particles per second of each undisturbed calculator.
        """
        rates = np.asarray(speeds, np.float64)
        rates = rates * self.slowdown(frame, len(rates))
        counts = self.acting(frame)
        key = (counts.tobytes(), rates.tobytes())
        if key != self._last[0]:
            self._last = key, best_cuts(counts, rates)
        return self._last[1]

    @property
    def world(self) -> dict[str, Any]:
        """What `World` is to be given."""
        return {"seed": 1, "dt": 1.0, "space": (0.0, float(self.cells)), "axis": "x"}

    def step(self, system: System, frame: int) -> None:
        """Record a frame's births and actions.

        Args:
            system: whose.
            frame: which, from 0 on.
        """
        newborn = self.born(frame)
        if newborn is not None:
            system.emit(position=_places(newborn))
        even, crowd = self.shifts(frame)
        if even or crowd:
            at = column("position")
            further = at.x + (even if even == crowd else choose(at.y < 1, even, crowd))
            system.set(position=vector(further - self.cells * floor(further / self.cells), at.y, 0.0))

    def verify(self, particles: Particles, steps: int) -> bool:
        """Return whether each cell has the particles that it must have.

        Args:
            particles: all of the system's, as `System.gather` returns them.
            steps: frames that have run.
        """
        x = particles.position[:, 0]
        cell = np.floor(x).astype(np.int64)
        if not np.array_equal(x, cell + np.float32(0.5)) or len(cell) != self.counts(steps - 1).sum():
            return False
        found = np.bincount(np.clip(cell, 0, self.cells - 1), minlength=self.cells)
        return bool(np.array_equal(found, self.counts(steps - 1)))

    def __repr__(self) -> str:
        """Show what it is."""
        return f"<{self.name}: {self.particles} particles in {self.cells} cells, {self.frames} frames>"


def laid(weights: npt.ArrayLike, particles: int) -> Counts:
    """Divide particles among cells by weight, in whole numbers that add up, int64 (cells,).

    Args:
        weights: of the cells, from 0 on, on any scale.
        particles: all of them.
    """
    given = np.asarray(weights, np.float64)
    if not (given.sum() > 0) or (given < 0).any():
        raise ArgumentError("weights", weights, "numbers from 0 on, not all 0")
    below = np.rint(np.cumsum(given) * (particles / given.sum())).astype(np.int64)
    below[-1] = particles
    counts: Counts = np.diff(below, prepend=0)
    return counts


def _places(sheets: Counts) -> npt.NDArray[np.float32]:
    """Return the positions of particles in the middles of their cells, float32 (n, 3)."""
    rows = []
    for number, sheet in enumerate(sheets):
        x = np.repeat(np.arange(len(sheet)), sheet) + 0.5
        rows.append(np.stack([x, np.full(len(x), CROWD_AT if number else 0.5), np.zeros(len(x))], axis=1))
    return np.concatenate(rows).astype(np.float32)


def vector(x: Any, y: Any, z: Any) -> Any:
    """Return a vector of three expressions."""
    return x * np.array((1.0, 0.0, 0.0)) + y * np.array((0.0, 1.0, 0.0)) + z * np.array((0.0, 0.0, 1.0))
