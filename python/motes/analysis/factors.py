"""POP's factors of parallel efficiency, computed from each rank's work and wall-clock time.

The POP Centre of Excellence (https://pop-coe.eu/node/69) divides parallel efficiency into factors:

    parallel      = load_balance x communication
    communication = serialisation x transfer

With work = the time in which a rank neither waits nor sends nor receives, and T the time of the slowest rank:
parallel = mean work / T, load_balance = mean work / largest work, serialisation = largest work / T_ideal and
transfer = T_ideal / T. T_ideal is the run's time on a network where messages take no time. POP computes it by
replaying a trace (Dimemas). Here each message carries the length of the longest chain of work that led to it,
so T_ideal is known during the run, on any machine and on virtual clusters.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

__all__ = ["COLUMNS", "combined", "factors"]

COLUMNS = ("parallel", "load_balance", "communication", "serialisation", "transfer")


def factors(work: Sequence[float], seconds: float, ideal_s: float) -> tuple[float, ...]:
    """Return the factors in COLUMNS for ranks that worked `work` seconds each (NaN: unknown) in `seconds`."""
    return combined([(work, seconds, ideal_s)])


def combined(parts: Sequence[tuple[Sequence[float], float, float]]) -> tuple[float, ...]:
    """Return the factors of a run in parts: the work of each part's ranks, its seconds, its ideal seconds.

    Each part counts with its seconds times its number of ranks.
    """
    worked = most = ideal = whole = 0.0
    for work, seconds, ideal_s in parts:
        known = [one for one in work if not math.isnan(one)]
        largest = max(known, default=0.0)
        if not (seconds > 0 and largest > 0):
            continue
        seconds = max(seconds, largest)
        worked += sum(known)
        most += len(known) * largest
        ideal += len(known) * min(max(ideal_s, largest), seconds)
        whole += len(known) * seconds
    if not whole > 0:
        return (math.nan,) * len(COLUMNS)
    balance, serialisation, transfer = worked / most, most / ideal, ideal / whole
    communication = serialisation * transfer
    return balance * communication, balance, communication, serialisation, transfer
