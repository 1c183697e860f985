"""Workloads that isolate one effect each: a step, a wave, jumping hot spots, a slow rank, noise."""

from __future__ import annotations

import numpy as np

from .base import Counts, Floats, Workload, laid

__all__ = ["HotSpots", "Noise", "SlowRank", "Step", "Wave"]

JUMPS = (0.15, 0.7, 0.4, 0.9, 0.25, 0.6)
"""Successive positions of the hot spot, as fractions of the row."""


class _Even(Workload):
    """All particles are born in the first frame, evenly distributed."""

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, (2 sheets, cells); None: no births.

        Args:
            frame: frame index, from 0.
        """
        return _of_both(laid(np.ones(self.cells), self.particles)) if frame == 0 else None


class Step(Workload):
    """After a quarter of the frames the number of particles doubles, with all births in 1/16 of the row."""

    name = "step"

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, (2 sheets, cells); None: no births.

        Args:
            frame: frame index, from 0.
        """
        half = self.particles // 2
        if frame == 0:
            return _of_both(laid(np.ones(self.cells), self.particles - half))
        if frame == max(self.frames // 4, 1):
            return _of_both(laid(np.arange(self.cells) < self.cells // 16, half), crowd=True)
        return None


class Wave(Workload):
    """A density wave of one period travels through the row twice."""

    name = "wave"

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, (2 sheets, cells); None: no births.

        Args:
            frame: frame index, from 0.
        """
        if frame:
            return None
        angle = 2 * np.pi * np.arange(self.cells) / self.cells
        return _of_both(laid(1 + 0.9 * np.sin(angle), self.particles))

    def shifts(self, frame: int) -> tuple[int, int]:
        """Return by how many cells each sheet moves in a frame.

        Args:
            frame: frame index, from 0.
        """
        by = max(round(2 * self.cells / self.frames), 1)
        return by, by


class HotSpots(Workload):
    """Half of all particles are in a spot that jumps to another place after every sixth of the frames."""

    name = "hot_spots"

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, (2 sheets, cells); None: no births.

        Args:
            frame: frame index, from 0.
        """
        if frame:
            return None
        half = self.particles // 2
        off = (np.arange(self.cells) + 0.5) / self.cells - JUMPS[0]
        crowd = laid(np.exp(-0.5 * (off / 0.03) ** 2), half)
        return np.stack([laid(np.ones(self.cells), self.particles - half), crowd])

    def shifts(self, frame: int) -> tuple[int, int]:
        """Return by how many cells each sheet moves in a frame.

        Args:
            frame: frame index, from 0.
        """
        every = max(self.frames // len(JUMPS), 1)
        if frame == 0 or frame % every:
            return 0, 0
        before, after = (JUMPS[(frame // every - back) % len(JUMPS)] for back in (1, 0))
        return 0, round((after - before) * self.cells)


class SlowRank(_Even):
    """In the middle third of the frames, the middle calculator runs at a third of its speed."""

    name = "slow_rank"
    disturbed = True

    def slowdown(self, frame: int, calculators: int) -> Floats:
        """Return each calculator's fraction of its undisturbed speed in a frame, (calculators,).

        Args:
            frame: frame index, from 0.
            calculators: number of calculators.
        """
        parts = np.ones(calculators)
        if self.frames // 3 <= frame < 2 * self.frames // 3:
            parts[calculators // 2] = 1 / 3
        return parts


class Noise(_Even):
    """Machines randomly lose up to 20 % of their speed, one in 25 a further half: nothing to balance."""

    name = "noise"
    disturbed = True

    def slowdown(self, frame: int, calculators: int) -> Floats:
        """Return each calculator's fraction of its undisturbed speed in a frame, (calculators,).

        Args:
            frame: frame index, from 0.
            calculators: number of calculators.
        """
        random = np.random.Generator(np.random.Philox(key=(1, frame)))
        parts = 1 - 0.2 * random.random(calculators)
        parts[random.random(calculators) < 1 / 25] *= 0.5
        return parts


def _of_both(counts: Counts, *, crowd: bool = False) -> Counts:
    """Return both sheets, with these particles in one of them."""
    none = np.zeros_like(counts)
    return np.stack([none, counts] if crowd else [counts, none])
