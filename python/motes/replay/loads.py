"""Synthetic loads for comparing balancers without a cluster: each isolates one effect that real runs mix."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np

from .._values import arguments
from .density import Density
from .history import Floats, Moment

__all__ = ["LOADS", "Synthetic", "synthetic"]

Load: TypeAlias = Literal["halves", "alternating", "step", "hot_spot"]


class Synthetic:
    """A history computed from formulas: one system of particles on the axis 0..1, cut into equal domains."""

    def __init__(
        self,
        frames: int,
        speeds: Callable[[int], Floats],
        shape: Callable[[int], Floats],
        *,
        calculators: int,
        particles: int,
    ) -> None:
        """Set the formulas; scripts call `motes.replay.synthetic`.

        Args:
            frames: number of frames.
            speeds: function from the frame to the machines' speeds, particles/s.
            shape: function from the frame to the relative density at equidistant points in 0..1.
            calculators: number of calculators.
            particles: number of particles.
        """
        self.ranks = list(range(calculators))
        self.systems = ["particles"]
        self.axes = ["x"]
        self.frames = list(range(frames))
        self._speeds = speeds
        self._shape = shape
        self._particles = particles
        self._cuts = np.linspace(0, 1, calculators + 1)[1:-1].astype(np.float32)

    def moment(self, k: int, system: int) -> Moment:
        """Return the k-th frame; all particles are born in the first.

        Args:
            k: index of the frame in the history.
            system: index of the system.
        """
        shape = self._shape(k)
        below = np.concatenate([[0.0], np.cumsum((shape[1:] + shape[:-1]) / 2)])
        density = Density(np.linspace(0, 1, len(shape)), below * (self._particles / below[-1]))
        none = Density(np.zeros(0), np.zeros(0))
        speeds = self._speeds(k)
        return Moment(density, none if k else density, 0, self._cuts, speeds, np.zeros(len(speeds)))


def synthetic(
    load: Literal["halves", "alternating", "step", "hot_spot"],
    *,
    calculators: int = 16,
    particles: int = 3_200_000,
    frames: int = 100,
) -> Synthetic:
    """Return a load that shows one effect.

    Args:
        load: "halves": the first half of the machines is twice as fast as the second. "alternating": every
            other machine is twice as fast. "step": equal machines; after a tenth of the frames, half of all
            particles are within a fifth of the axis. "hot_spot": equal machines; such a cluster moves from
            end to end.
        calculators: number of calculators, from 1 to thousands.
        particles: number of particles.
        frames: number of frames.

    Returns:
        The history, for `simulate` and `compare`.
    """
    name: Load = arguments.choice("load", load, tuple(LOADS))
    return LOADS[name](calculators, particles, frames)


def _halves(calculators: int, particles: int, frames: int) -> Synthetic:
    speeds = np.where(np.arange(calculators) < calculators / 2, 2e7, 1e7)
    return _even(speeds, particles, frames)


def _alternating(calculators: int, particles: int, frames: int) -> Synthetic:
    return _even(np.where(np.arange(calculators) % 2 == 0, 2e7, 1e7), particles, frames)


def _even(speeds: Floats, particles: int, frames: int) -> Synthetic:
    return Synthetic(
        frames, lambda _: speeds, lambda _: np.ones(2), calculators=len(speeds), particles=particles
    )


def _step(calculators: int, particles: int, frames: int) -> Synthetic:
    return _crowd(calculators, particles, frames, lambda k: 0.25 if k >= frames // 10 else None)


def _hot_spot(calculators: int, particles: int, frames: int) -> Synthetic:
    return _crowd(calculators, particles, frames, lambda k: 0.1 + 0.8 * k / frames)


def _crowd(calculators: int, particles: int, frames: int, center: Callable[[int], float | None]) -> Synthetic:
    """Return a load with half of the particles around a centre (sigma 0.05), and the others spread evenly."""
    x = np.linspace(0, 1, 4097)

    def shape(k: int) -> Floats:
        at = center(k)
        if at is None:
            return np.ones(len(x))
        crowd = np.exp(-0.5 * ((x - at) / 0.05) ** 2)
        even: Floats = np.full(len(x), 1.0) + crowd * (len(x) / crowd.sum())
        return even

    speeds = np.full(calculators, 1e7)
    return Synthetic(frames, lambda _: speeds, shape, calculators=calculators, particles=particles)


LOADS: dict[Load, Callable[[int, int, int], Synthetic]] = {
    "halves": _halves,
    "alternating": _alternating,
    "step": _step,
    "hot_spot": _hot_spot,
}
"""Loads by name: functions (calculators, particles, frames) -> history."""
