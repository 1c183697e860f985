"""Distribution of particles along one axis: the cumulative count as a function of position."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _core

__all__ = ["Density", "exchange"]

Floats = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]


class Density:
    """Cumulative number of particles, linear between ascending positions; equal positions make a jump."""

    def __init__(self, x: Floats, below: Floats) -> None:
        """`x`: ascending positions (m,); `below`: particles below each, from 0 to the total (m,)."""
        self.x = x
        self.below = below

    @property
    def total(self) -> float:
        """Total number of particles."""
        return float(self.below[-1]) if len(self.below) else 0.0

    def count_below(self, places: npt.ArrayLike) -> Floats:
        """Return the number of particles with x < place for each place, which may be infinite."""
        places = np.asarray(places, np.float64)
        if not len(self.x):
            return np.zeros(len(places))
        right = np.searchsorted(self.x, places, side="left")
        inside = (right > 0) & (right < len(self.x))
        at = np.clip(right, 1, max(len(self.x) - 1, 1)) if len(self.x) > 1 else np.zeros(len(places), int)
        x0, x1 = self.x[at - 1], self.x[at]
        width = np.where(x1 > x0, x1 - x0, 1.0)
        part = np.where(inside, (places - x0) / width, 0.0)
        between = self.below[at - 1] + part * (self.below[at] - self.below[at - 1])
        return np.where(right == 0, 0.0, np.where(right == len(self.x), self.total, between))

    def place(self, counts: npt.ArrayLike) -> Floats:
        """Return the place with this many particles below it, the inverse of `count_below`."""
        return np.interp(np.asarray(counts, np.float64), self.below, self.x)

    def around(self, cuts: npt.NDArray[np.float32]) -> float:
        """Return the particles within 1/100 of the particles' extent from a cut, summed over the cuts."""
        near = (self.x[-1] - self.x[0]) / 100 if len(self.x) else 0.0
        return float((self.count_below(cuts + near) - self.count_below(cuts - near)).sum())

    def domains(self, cuts: npt.NDArray[np.float32]) -> Counts:
        """Return the number of particles in each domain, as integers that sum to the rounded total."""
        ends = np.concatenate([[0.0], self.count_below(cuts), [self.total]])
        counts: Counts = np.diff(np.rint(ends)).astype(np.int64)
        return counts

    def histograms(self, cuts: npt.NDArray[np.float32]) -> list[tuple[npt.NDArray[np.float32], Counts]]:
        """Return the histogram (edges, counts) of each domain, as a calculator would report it."""
        beyond = np.nextafter(self._jumps(), np.float32(np.inf))
        places = np.unique(np.concatenate([self.x.astype(np.float32), beyond, cuts]))
        below = np.rint(self.count_below(places))
        starts = np.searchsorted(places, cuts)
        firsts = np.concatenate([[0], starts])
        lasts = np.concatenate([starts, [max(len(places) - 1, 0)]])
        pairs = []
        for first, last in zip(firsts, lasts, strict=True):
            edges = places[first : last + 1].copy()
            counts = np.diff(below[first : last + 1]).astype(np.int64)
            if len(counts):  # the last bin is closed, so it must end before the next domain
                edges[-1] = max(edges[-2], np.nextafter(edges[-1], np.float32(-np.inf)))
            pairs.append((edges if len(counts) else edges[:0], counts))
        return pairs

    def _jumps(self) -> npt.NDArray[np.float32]:
        """Return the positions of jumps, and the last position."""
        shared = np.append(self.x[1:] == self.x[:-1], True) if len(self.x) else np.zeros(0, bool)
        places: npt.NDArray[np.float32] = self.x[shared].astype(np.float32)
        return places

    def quantiles(self, cuts: npt.NDArray[np.float32], parts: int) -> Floats:
        """Return each domain's quantiles, (domains, parts + 1); NaN where there are no particles."""
        ends = np.concatenate([[0.0], self.count_below(cuts), [self.total]])
        low, high = ends[:-1, None], ends[1:, None]
        if self.total <= 0:
            return np.full((len(low), parts + 1), np.nan)
        places = self.place(low + (high - low) * np.arange(parts + 1) / parts)
        return np.where(np.diff(np.rint(ends))[:, None] > 0, places, np.nan)

    def overlaps(
        self, ours: npt.NDArray[np.float32], theirs: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Floats]:
        """Return the overlaps of two sets of cuts: our domain, their domain, particles in both; no zeros."""
        ends = np.sort(np.concatenate([ours, theirs]))
        below = np.concatenate([[0.0], self.count_below(ends), [self.total]])
        # A piece's left end determines its owner; the first piece starts at -infinity.
        left = np.concatenate([[-np.inf], ends])
        n = np.diff(below)
        some = n > 0
        mine = np.searchsorted(ours, left, side="right")[some]
        other = np.searchsorted(theirs, left, side="right")[some]
        return mine, other, n[some]

    def divided(
        self, costs: Floats, shares: Floats, cuts: npt.NDArray[np.float32]
    ) -> npt.NDArray[np.float32]:
        """Return the cuts that give each domain its share, computed as in the engine."""
        return _core.prefix_cuts(self.histograms(cuts), costs, shares, cuts)

    @staticmethod
    def exchange(before: npt.ArrayLike, after: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Return the result of the function `exchange`."""
        return exchange(before, after)

    @staticmethod
    def none() -> Density:
        """Return a density without particles."""
        return Density(np.zeros(0), np.zeros(0))

    @staticmethod
    def in_cells(counts: npt.ArrayLike) -> Density:
        """Return the density of particles, (cells,), at the centres of cells that are 1 m wide."""
        below = np.concatenate([[0], np.cumsum(counts)]).astype(np.float64)
        if not below[-1]:
            return Density.none()
        x = np.arange(len(below) - 1) + 0.5
        return Density(np.repeat(x, 2), np.stack([below[:-1], below[1:]], axis=1).ravel())

    @staticmethod
    def of_quantiles(quantiles: Floats, counts: npt.ArrayLike) -> Density:
        """Combine calculators' reports: quantiles (n, q), NaN if no particles, and counts (n,)."""
        counts = np.asarray(counts, np.float64)
        known = ~np.isnan(quantiles).any(axis=1) & (counts > 0)
        x, n = quantiles[known], counts[known]
        before = np.cumsum(n) - n
        parts = np.arange(quantiles.shape[1]) / max(quantiles.shape[1] - 1, 1)
        below = before[:, None] + n[:, None] * parts
        return Density(np.maximum.accumulate(x.ravel()), below.ravel())


def exchange(before: npt.ArrayLike, after: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Return the minimum that each calculator sends and receives if particles keep their order.

    `before`: particles per calculator before they moved and cuts changed; `after`: at the frame's end.
    """
    after = np.asarray(after, np.float64)
    before = np.asarray(before, np.float64)
    before = before * (after.sum() / max(before.sum(), 1e-300))  # assumes equal death rates everywhere
    starts, ends = np.cumsum(before)[:-1], np.cumsum(after)[:-1]
    ranks = np.sort(np.concatenate([starts, ends]))
    left = np.concatenate([[0.0], ranks])
    n = np.diff(np.concatenate([left, [after.sum()]]))
    source = np.searchsorted(starts, left, side="right")
    to = np.searchsorted(ends, left, side="right")
    n = np.where(source != to, n, 0.0)
    sent: Floats = np.bincount(source, n, len(after)).astype(np.float64)
    received: Floats = np.bincount(to, n, len(after)).astype(np.float64)
    return sent, received
