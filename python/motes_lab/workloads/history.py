"""A workload on machines of given speeds, as a history for `motes.replay.simulate`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from motes.replay.density import Density
from motes.replay.history import Moment

from .base import Workload

__all__ = ["Planned"]


class Planned:
    """The history of a workload: one system, initially cut into equal domains.

    Attributes:
        ranks: one per calculator, from 0.
        systems: name of the only system.
        axes: axis along which its domains are cut.
        frames: frame numbers.
    """

    def __init__(self, workload: Workload, speeds: npt.ArrayLike) -> None:
        """Set the workload and the machines.

        Args:
            workload: the workload.
            speeds: particles per second of each undisturbed calculator, in the order of domains.
        """
        self._workload, self._speeds = workload, np.asarray(speeds, np.float64)
        calculators = len(self._speeds)
        self.ranks, self.systems, self.axes = list(range(calculators)), ["particles"], ["x"]
        self.frames = list(range(workload.frames))
        even = np.arange(1, calculators) / calculators
        self._places: dict[int, tuple[Density, Density]] = {}
        self._cuts = (even * workload.cells).astype(np.float32)

    def moment(self, k: int, system: int) -> Moment:
        """Return the k-th frame.

        Args:
            k: index of the frame in the history.
            system: index of the system.
        """
        speeds = self._speeds * self._workload.slowdown(k, len(self._speeds))
        if k not in self._places:
            self._places[k] = (
                Density.in_cells(self._workload.counts(k)),
                Density.in_cells(self._workload.births(k)),
            )
        density, births = self._places[k]
        return Moment(density, births, 0, self._cuts, speeds, np.zeros(len(speeds)))
