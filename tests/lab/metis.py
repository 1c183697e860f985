"""An arena balancer that uses METIS: `pip install pymetis`, `motes arena --balancer metis.py:Metis`."""

import numpy as np
import pymetis

from motes.balance import Balancer, LoadTable, Targets

PIECES = 64
"""Vertices per calculator, each with an equal part of its particles."""


class Metis(Balancer):
    """Sets shares by a METIS partition, weighted by the calculators' speeds."""

    def decide(self, load: LoadTable) -> Targets:
        """Partition a path, whose vertices weigh as much as their particles, into a part per calculator."""
        count = len(load) * PIECES
        weights = np.repeat(np.maximum(load.particles // PIECES, 1), PIECES).astype(np.int64)
        ends = [[v for v in (i - 1, i + 1) if 0 <= v < count] for i in range(count)]
        starts = np.cumsum([0, *map(len, ends)])
        speeds = np.where(np.isfinite(load.speed) & (load.speed > 0), load.speed, np.nan)
        speeds = np.where(np.isnan(speeds), 1.0 if np.isnan(speeds).all() else np.nanmean(speeds), speeds)
        _, part = pymetis.part_graph(
            len(load),
            pymetis.CSRAdjacency(starts.tolist(), [v for pair in ends for v in pair]),
            vweights=weights.tolist(),
            tpwgts=(speeds / speeds.sum()).tolist(),
        )
        return Targets(np.bincount(part, weights, minlength=len(load)))
