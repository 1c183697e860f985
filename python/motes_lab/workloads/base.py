"""Base class of workloads: particle counts in each frame, and the script that produces them."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from motes.errors import ArgumentError
from motes.expressions import choose, column, floor

from .._engine import arguments
from .optimum import Best, best_cuts

if TYPE_CHECKING:
    from motes import Particles, System
    from motes.replay import History

__all__ = ["Workload", "laid", "vector"]

Counts = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

CROWD_AT = 1.5
"""y of the second sheet, m; the first sheet's is 0.5."""


class Workload:
    """Particles at the centres of a row of cells, each 1 m wide, and their motion in each frame.

    They form two sheets: evenly distributed particles and a crowd. All counts are known before a run, and so
    are the best cuts; a script gives the same result on any ranks.

    Attributes:
        name: name of the workload.
        frames: number of frames.
        cells: number of cells in the row, along x from 0 to `cells` metres.
        particles: total number of particles, once all are born.
        disturbed: whether machines are slower in some frames.
    """

    name = ""
    disturbed = False
    _last: tuple[Any, Best] = (None, Best(np.zeros(0, np.int64), 0.0))  # often the next is equal

    def __init__(self, *, frames: int = 60, cells: int = 1000, particles: int = 200_000) -> None:
        """Make the workload.

        Args:
            frames: number of frames, at least 2.
            cells: number of cells in the row, at least 32.
            particles: total number of particles.
        """
        self.frames = arguments.integer("frames", frames, low=2, high=10**6)
        self.cells = arguments.integer("cells", cells, low=32, high=2**22)
        self.particles = arguments.integer("particles", particles, low=1, high=2**40)

    @abstractmethod
    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, before they move, (2 sheets, cells); None: no births.

        Args:
            frame: frame index, from 0.
        """

    def shifts(self, frame: int) -> tuple[int, int]:
        """Return by how many cells each sheet moves in a frame, wrapping around the row's end.

        Args:
            frame: frame index, from 0.
        """
        return 0, 0

    def slowdown(self, frame: int, calculators: int) -> Floats:
        """Return each calculator's fraction of its undisturbed speed in a frame, (calculators,).

        Args:
            frame: frame index, from 0.
            calculators: number of calculators.
        """
        return np.ones(calculators)

    @cached_property
    def _sheets(self) -> list[tuple[Counts, Counts]]:
        """Per frame: particles acted on, and particles at its end, in each cell, summed over the sheets."""
        found, now = [], np.zeros((2, self.cells), np.int64)
        for frame in range(self.frames):
            newborn = self.born(frame)
            acting = now if newborn is None else now + newborn
            now = np.stack([np.roll(one, by) for one, by in zip(acting, self.shifts(frame), strict=True)])
            found.append((acting.sum(axis=0), now.sum(axis=0)))
        return found

    def births(self, frame: int) -> Counts:
        """Return the number of particles born in each cell in a frame, int64 (cells,).

        Args:
            frame: frame index, from 0.
        """
        newborn = self.born(frame)
        return np.zeros(self.cells, np.int64) if newborn is None else newborn.sum(axis=0)

    def acting(self, frame: int) -> Counts:
        """Return the number of particles in each cell when a frame's actions run, int64 (cells,).

        Args:
            frame: frame index, from 0.
        """
        return self._sheets[frame][0]

    def counts(self, frame: int) -> Counts:
        """Return the number of particles in each cell at a frame's end, int64 (cells,).

        Args:
            frame: frame index, from 0.
        """
        return self._sheets[frame][1]

    def fixed_s(self, frame: int, speeds: npt.ArrayLike) -> Floats:
        """Return each calculator's seconds of other work in a frame, which no cut changes, (calculators,).

        Args:
            frame: frame index, from 0.
            speeds: particles per second of each undisturbed calculator.
        """
        return np.zeros(len(np.asarray(speeds)))

    def history(self, speeds: npt.ArrayLike) -> History:
        """Return the workload on these machines as a history for `motes.replay.simulate`.

        Args:
            speeds: particles per second of each undisturbed calculator.
        """
        from .history import Planned

        return Planned(self, speeds)

    def optimum(self, frame: int, speeds: npt.ArrayLike) -> Best:
        """Return a frame's best cuts, and the seconds of its slowest calculator with them.

        Args:
            frame: frame index, from 0.
            speeds: particles per second of each undisturbed calculator.
        """
        rates = np.asarray(speeds, np.float64)
        rates = rates * self.slowdown(frame, len(rates))
        counts, fixed_s = self.acting(frame), self.fixed_s(frame, speeds)
        key = (counts.tobytes(), rates.tobytes(), fixed_s.tobytes())
        if key != self._last[0]:
            self._last = key, best_cuts(counts, rates, fixed_s)
        return self._last[1]

    @property
    def world(self) -> dict[str, Any]:
        """Keyword arguments for `World`."""
        return {"seed": 1, "dt": 1.0, "space": (0.0, float(self.cells)), "axis": "x"}

    def step(self, system: System, frame: int) -> None:
        """Record a frame's births and actions.

        Args:
            system: the system that plays the workload.
            frame: frame index, from 0.
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
        """Return whether each cell has the expected number of particles.

        Args:
            particles: all particles of the system, as returned by `System.gather`.
            steps: number of frames that have run.
        """
        x = particles.position[:, 0]
        cell = np.floor(x).astype(np.int64)
        if not np.array_equal(x, cell + np.float32(0.5)) or len(cell) != self.counts(steps - 1).sum():
            return False
        found = np.bincount(np.clip(cell, 0, self.cells - 1), minlength=self.cells)
        return bool(np.array_equal(found, self.counts(steps - 1)))

    def __repr__(self) -> str:
        """Show name, particles, cells and frames."""
        return f"<{self.name}: {self.particles} particles in {self.cells} cells, {self.frames} frames>"


def laid(weights: npt.ArrayLike, particles: int) -> Counts:
    """Distribute particles over cells by weight, in integers that sum to the total, int64 (cells,).

    Args:
        weights: weights of the cells, >= 0, on any scale.
        particles: total number of particles.
    """
    given = np.asarray(weights, np.float64)
    if not (given.sum() > 0) or (given < 0).any():
        raise ArgumentError("weights", weights, "numbers >= 0, not all 0")
    below = np.rint(np.cumsum(given) * (particles / given.sum())).astype(np.int64)
    below[-1] = particles
    counts: Counts = np.diff(below, prepend=0)
    return counts


def _places(sheets: Counts) -> npt.NDArray[np.float32]:
    """Return the positions of particles at the centres of their cells, float32 (n, 3)."""
    rows = []
    for number, sheet in enumerate(sheets):
        x = np.repeat(np.arange(len(sheet)), sheet) + 0.5
        rows.append(np.stack([x, np.full(len(x), CROWD_AT if number else 0.5), np.zeros(len(x))], axis=1))
    return np.concatenate(rows).astype(np.float32)


def vector(x: Any, y: Any, z: Any) -> Any:
    """Return the vector of three scalar expressions."""
    return x * np.array((1.0, 0.0, 0.0)) + y * np.array((0.0, 1.0, 0.0)) + z * np.array((0.0, 0.0, 1.0))
