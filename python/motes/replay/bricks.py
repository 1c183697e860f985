"""Distribution of particles in bricks, and the cuts between bricks; density.py does this for slabs.

A log records how each calculator's particles are distributed along every cut axis, but not how the axes
correlate. Within a brick, axes are assumed to be independent, and particles to be uniform between two
quantiles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import numpy.typing as npt

from .. import _core
from .density import Density

__all__ = ["Cloud", "Tree"]

Floats = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]
Cuts = npt.NDArray[np.float32]
Box = tuple[Floats, Floats]

BINS = {1: 16, 2: 16, 3: 8}
"""Bins of a calculator's particles per axis, by the number of cut axes; at most 512 cells in all."""
FINE = 1024
"""Scale of cell counts for the core, which takes integers: one particle counts as this many."""


class Tree:
    """Tree of cuts between bricks, in the order of the domains; each cut has an axis and halves its node."""

    def __init__(self, axes: Sequence[int], at: npt.ArrayLike) -> None:
        """`axes`: 0, 1 or 2 for each cut; `at`: position of each cut, m."""
        self.axes = list(axes)
        self.at: Cuts = np.asarray(at, np.float32)

    def __len__(self) -> int:
        """Return the number of cuts."""
        return len(self.axes)

    def nodes(self) -> Iterator[tuple[int, int, Box]]:
        """Yield all nodes, down to single domains: first domain, last + 1, and (low, high), (3,) each."""
        todo = [(0, len(self) + 1, (np.full(3, -np.inf), np.full(3, np.inf)))]
        while todo:
            first, last, (low, high) = todo.pop()
            yield first, last, (low, high)
            if last - first > 1:
                middle = first + (last - first) // 2
                axis, at = self.axes[middle - 1], float(self.at[middle - 1])
                below, above = high.copy(), low.copy()
                below[axis] = above[axis] = at
                todo += [(first, middle, (low, below)), (middle, last, (above, high))]

    def boxes(self) -> Box:
        """Return the lower and upper ends of all domains, (domains, 3) each."""
        low, high = np.empty((2, len(self) + 1, 3))
        for first, last, ends in self.nodes():
            if last - first == 1:
                low[first], high[first] = ends
        return low, high

    @staticmethod
    def of_boxes(low: Floats, high: Floats) -> Tree:
        """Return the cuts that make these domains, (domains, 3) each; ValueError if there are none."""
        axes, at = [0] * (len(low) - 1), np.zeros(len(low) - 1, np.float32)
        todo = [(0, len(low))]
        while todo:
            first, last = todo.pop()
            if last - first < 2:
                continue
            middle = first + (last - first) // 2
            below, above = high[first:middle].max(axis=0), low[middle:last].min(axis=0)
            fits = np.flatnonzero((below == above) & np.isfinite(below))
            if not len(fits):
                raise ValueError("these domains do not come from bisecting space")
            axes[middle - 1], at[middle - 1] = int(fits[0]), below[fits[0]]
            todo += [(first, middle), (middle, last)]
        return Tree(axes, at)


class Cloud:
    """Cells whose particles are uniformly distributed within each cell."""

    def __init__(self, low: Floats, high: Floats, count: Floats) -> None:
        """`low`, `high`: ends of cells (m, 3), equal along axes that are not cut; `count`: particles (m,)."""
        self.low, self.high, self.count = low, high, count

    @property
    def total(self) -> float:
        """Total number of particles."""
        return float(self.count.sum())

    @staticmethod
    def none() -> Cloud:
        """Return a cloud without particles."""
        return Cloud(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))

    @staticmethod
    def of_quantiles(quantiles: Floats, counts: npt.ArrayLike, axes: Sequence[int]) -> Cloud:
        """Combine reports: quantiles (n, axes, q) along these axes, NaN if no particles, and counts (n,)."""
        counts = np.asarray(counts, np.float64)
        known = ~np.isnan(quantiles).any(axis=(1, 2)) & (counts > 0)
        bins = BINS[len(axes)]
        ends = quantiles[known][:, :, :: (quantiles.shape[2] - 1) // bins]
        places = list(product(range(bins), repeat=len(axes)))
        low, high = np.zeros((2, len(ends), len(places), 3))
        for a, axis in enumerate(axes):
            bin_of = [place[a] for place in places]
            low[:, :, axis] = ends[:, a, :-1][:, bin_of]
            high[:, :, axis] = ends[:, a, 1:][:, bin_of]
        count = np.repeat(counts[known] / len(places), len(places))
        return Cloud(low.reshape(-1, 3), high.reshape(-1, 3), count)

    def clipped(self, box: Box) -> Cloud:
        """Return the part of the cloud inside a box."""
        low, high = np.maximum(self.low, box[0]), np.minimum(self.high, box[1])
        width = self.high - self.low
        spread = np.where(width > 0, (high - low) / np.where(width > 0, width, 1), 1.0)
        here = (width > 0) | ((self.low >= box[0]) & (self.low < box[1]))
        part = np.where(here, np.clip(spread, 0, 1), 0).prod(axis=1)
        some = part > 0
        return Cloud(low[some], high[some], (self.count * part)[some])

    def parts(self, tree: Tree) -> list[Cloud]:
        """Return the part of the cloud in each domain."""
        return [self.clipped(box) for box in zip(*tree.boxes(), strict=True)]

    def domains(self, tree: Tree) -> Counts:
        """Return the number of particles in each domain, as integers that sum to the rounded total."""
        ends = np.cumsum([0.0, *(part.total for part in self.parts(tree))])
        counts: Counts = np.diff(np.rint(ends)).astype(np.int64)
        return counts

    def overlaps(self, ours: Tree, theirs: Tree) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Floats]:
        """Return the overlaps of two trees: our domain, their domain, particles in both; no zeros."""
        pairs = [
            (mine, other, both.total)
            for mine, part in enumerate(self.parts(ours))
            for other, both in enumerate(part.parts(theirs))
            if both.total > 0
        ]
        mine, other, n = zip(*pairs, strict=True) if pairs else ((), (), ())
        return np.array(mine, np.intp), np.array(other, np.intp), np.array(n, np.float64)

    def around(self, tree: Tree) -> float:
        """Return the particles within 1/100 of the cloud's extent from a cut, summed over the cuts."""
        if not len(self.count):
            return 0.0
        near = (self.high.max(axis=0) - self.low.min(axis=0)) / 100
        total = 0.0
        for first, last, (low, high) in tree.nodes():
            if last - first > 1:
                cut = first + (last - first) // 2 - 1
                axis, at = tree.axes[cut], float(tree.at[cut])
                below, above = low.copy(), high.copy()
                below[axis], above[axis] = max(at - near[axis], low[axis]), min(at + near[axis], high[axis])
                total += self.clipped((below, above)).total
        return total

    def divided(self, costs: Floats, shares: Floats, tree: Tree) -> Tree:
        """Return the cuts that give each domain its share, computed as in the engine."""
        cells = [
            (
                part.low.astype(np.float32),
                part.high.astype(np.float32),
                np.rint(part.count * FINE).astype(np.uint64),
            )
            for part in self.parts(tree)
        ]
        return Tree(tree.axes, _core.tree_cuts(cells, costs, shares, tree.axes, tree.at))

    def quantiles(self, tree: Tree, parts: int, axis: int) -> Floats:
        """Return each domain's quantiles along an axis, (domains, parts + 1); NaN without particles."""
        return np.array([part._along(axis, parts) for part in self.parts(tree)])

    def _along(self, axis: int, parts: int) -> Floats:
        if round(self.total) <= 0:
            return np.full(parts + 1, np.nan)
        low, high = self.low[:, axis], self.high[:, axis]
        x = np.linspace(low.min(), high.max(), 16 * parts + 1)
        width = np.where(high > low, high - low, 1e-300)
        below = (self.count * np.clip((x[:, None] - low) / width, 0, 1)).sum(axis=1)
        below[-1] = self.total
        return Density(x, below).place(self.total * np.arange(parts + 1) / parts)

    @staticmethod
    def exchange(before: npt.ArrayLike, after: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Return the minimum that each calculator sends and receives: the difference of its counts."""
        after = np.asarray(after, np.float64)
        before = np.asarray(before, np.float64)
        before = before * (after.sum() / max(before.sum(), 1e-300))
        return np.maximum(before - after, 0.0), np.maximum(after - before, 0.0)
