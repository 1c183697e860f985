"""Workloads that each show one thing: a step, a wave, hot spots that jump, a slowed rank, noise."""

from __future__ import annotations

import numpy as np

from .base import Counts, Floats, Workload, laid

__all__ = ["HotSpots", "Noise", "SlowRank", "Step", "Wave"]

JUMPS = (0.15, 0.7, 0.4, 0.9, 0.25, 0.6)
"""Where the hot spot is, one after the other, as parts of the row."""


class _Even(Workload):
    """All particles are born in the first frame, evenly spread."""

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, (2 sheets, cells); None: none.

        Args:
            frame: which, from 0 on.
        """
        return _of_both(laid(np.ones(self.cells), self.particles)) if frame == 0 else None


class Step(Workload):
    """After a quarter of the frames as many as there are burst into a corner: a sixteenth of the row."""

    name = "step"

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, (2 sheets, cells); None: none.

        Args:
            frame: which, from 0 on.
        """
        half = self.particles // 2
        if frame == 0:
            return _of_both(laid(np.ones(self.cells), self.particles - half))
        if frame == max(self.frames // 4, 1):
            return _of_both(laid(np.arange(self.cells) < self.cells // 16, half), crowd=True)
        return None


class Wave(Workload):
    """One period of a wave passes through the row twice."""

    name = "wave"

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, (2 sheets, cells); None: none.

        Args:
            frame: which, from 0 on.
        """
        if frame:
            return None
        angle = 2 * np.pi * np.arange(self.cells) / self.cells
        return _of_both(laid(1 + 0.9 * np.sin(angle), self.particles))

    def shifts(self, frame: int) -> tuple[int, int]:
        """Return the cells by which each sheet moves in a frame.

        Args:
            frame: which, from 0 on.
        """
        by = max(round(2 * self.cells / self.frames), 1)
        return by, by


class HotSpots(Workload):
    """Half of all particles are in a spot that jumps to another place every sixth of the frames."""

    name = "hot_spots"

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, (2 sheets, cells); None: none.

        Args:
            frame: which, from 0 on.
        """
        if frame:
            return None
        half = self.particles // 2
        off = (np.arange(self.cells) + 0.5) / self.cells - JUMPS[0]
        crowd = laid(np.exp(-0.5 * (off / 0.03) ** 2), half)
        return np.stack([laid(np.ones(self.cells), self.particles - half), crowd])

    def shifts(self, frame: int) -> tuple[int, int]:
        """Return the cells by which each sheet moves in a frame.

        Args:
            frame: which, from 0 on.
        """
        every = max(self.frames // len(JUMPS), 1)
        if frame == 0 or frame % every:
            return 0, 0
        before, after = (JUMPS[(frame // every - back) % len(JUMPS)] for back in (1, 0))
        return 0, round((after - before) * self.cells)


class SlowRank(_Even):
    """In the middle third of the frames the middle calculator has a third of its speed."""

    name = "slow_rank"
    disturbed = True

    def slowdown(self, frame: int, calculators: int) -> Floats:
        """Return the part of its speed that each calculator has in a frame, (calculators,).

        Args:
            frame: which, from 0 on.
            calculators: how many.
        """
        parts = np.ones(calculators)
        if self.frames // 3 <= frame < 2 * self.frames // 3:
            parts[calculators // 2] = 1 / 3
        return parts


class Noise(_Even):
    """All machines lose up to 20 % of their speed by chance, and one in 25 half of it: nothing to balance."""

    name = "noise"
    disturbed = True

    def slowdown(self, frame: int, calculators: int) -> Floats:
        """Return the part of its speed that each calculator has in a frame, (calculators,).

        Args:
            frame: which, from 0 on.
            calculators: how many.
        """
        random = np.random.Generator(np.random.Philox(key=(1, frame)))
        parts = 1 - 0.2 * random.random(calculators)
        parts[random.random(calculators) < 1 / 25] *= 0.5
        return parts


def _of_both(counts: Counts, *, crowd: bool = False) -> Counts:
    """Return both sheets, one of which has these particles."""
    none = np.zeros_like(counts)
    return np.stack([none, counts] if crowd else [counts, none])
