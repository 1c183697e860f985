"""Optimal cuts of a row of cells, the bound for any balancer."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from motes.errors import ArgumentError

__all__ = ["Best", "best_cuts"]

Counts = npt.NDArray[np.int64]


class Best(NamedTuple):
    """The best cuts and their time.

    Attributes:
        starts: first cell of each calculator except the first, ascending, int64 (calculators - 1,).
        seconds: time of the slowest calculator.
    """

    starts: Counts
    seconds: float


def best_cuts(counts: npt.ArrayLike, speeds: npt.ArrayLike, fixed_s: npt.ArrayLike | None = None) -> Best:
    """Divide a row of cells among a row of calculators to minimise the slowest calculator's time.

    The result is exact. For a bound on the time, a greedy pass gives each calculator as many cells as fit.
    Bisection narrows the bound among times that some run of cells takes on some calculator, until no such
    time is left between the last bound that suffices and the last that does not (chains-on-chains: A. Pinar
    and C. Aykanat, J. Parallel Distrib. Comput. 64, 2004).

    Args:
        counts: particles in each cell, integers (cells,).
        speeds: particles per second of each calculator, above 0, in the order of their domains.
        fixed_s: seconds of other work of each calculator, which no cut changes; None: there is none.

    Returns:
        Where each calculator's run of cells begins, and the time of the slowest calculator.

    Raises:
        ArgumentError: for negative counts or seconds, or speeds that are not positive.
    """
    whole = np.asarray(counts, np.int64)
    rates = np.asarray(speeds, np.float64)
    if whole.ndim != 1 or (whole < 0).any():
        raise ArgumentError("counts", counts, "a list of whole numbers >= 0")
    if rates.ndim != 1 or not len(rates) or not (np.isfinite(rates) & (rates > 0)).all():
        raise ArgumentError("speeds", speeds, "a list of finite numbers above 0")
    other = np.zeros(len(rates)) if fixed_s is None else np.asarray(fixed_s, np.float64)
    if other.shape != rates.shape or not (np.isfinite(other) & (other >= 0)).all():
        raise ArgumentError("fixed_s", fixed_s, "a list of seconds >= 0, one per calculator")
    below = [0, *np.cumsum(whole).tolist()]
    machines = list(zip(rates.tolist(), other.tolist(), strict=True))
    starts = [len(whole)] * (len(machines) - 1)  # the first takes all cells
    enough = max(below[-1] / rates[0] + other[0], float(other.max()))
    even = (below[-1] + float(other @ rates)) / float(rates.sum())
    least = max(even * (1 - 1e-9), float(other.max()))
    while least < enough:
        bound = (least + enough) / 2
        if not least < bound < enough:
            bound = least
        ends, longer = _reach(below, machines, bound)
        if ends[-1] < len(whole):
            least = longer
        else:
            starts = ends[:-1]
            runs = zip([0, *starts], ends, machines, strict=True)
            enough = max((below[end] - below[start]) / rate + more for start, end, (rate, more) in runs)
    return Best(np.array(starts, np.int64), enough)


def _reach(below: list[int], machines: list[tuple[float, float]], bound: float) -> tuple[list[int], float]:
    """Give each calculator, (speed, seconds of other work), as many cells as it can process within the bound.

    Returns the end of each calculator's run, and the smallest larger bound that would extend one of them.
    """
    ends, longer, end, last = [], math.inf, 0, len(below) - 1
    for rate, other in machines:
        start = below[end]
        most = math.floor((bound - other) * rate)
        while (most + 1) / rate + other <= bound:
            most += 1
        while most / rate + other > bound:
            most -= 1
        end = bisect_right(below, start + most, end) - 1
        ends.append(end)
        if end == last:
            return ends + [last] * (len(machines) - len(ends)), longer
        longer = min(longer, (below[end + 1] - start) / rate)
    return ends, longer
