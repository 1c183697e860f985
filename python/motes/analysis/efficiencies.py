"""POP's measures of parallel efficiency, from where each rank's time went.

The POP Centre of Excellence (https://pop-coe.eu/node/69) divides parallel efficiency into factors:

    parallel      = load_balance x communication
    communication = serialisation x transfer

With work = time that a rank neither waits nor sends nor receives, and T the time of the slowest rank:
parallel = mean work / T, load_balance = mean work / largest work, serialisation = largest work / T_ideal and
transfer = T_ideal / T. T_ideal is what the run would take on a network where messages take no time. POP
gets it by replaying a trace (Dimemas). Here each message carries the length of the longest chain of work that
led to it, so T_ideal is known while the run goes on, on any machine and on virtual clusters.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _extras

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["COLUMNS", "efficiencies", "factors", "frame_seconds", "wall_by_rank", "work_by_rank"]

COLUMNS = ("parallel", "load_balance", "communication", "serialisation", "transfer")


def work_by_rank(times: DataFrame) -> DataFrame:
    """Return seconds of work, one row per frame, one column per rank."""
    spent = times.assign(work=times["wall_s"] - times["wait_s"] - times["messages_s"])
    work: DataFrame = spent.pivot(index="frame", columns="rank", values="work").clip(lower=0.0)
    return work


def wall_by_rank(times: DataFrame) -> DataFrame:
    """Return seconds of each frame on each rank, one row per frame, one column per rank."""
    return times.pivot(index="frame", columns="rank", values="wall_s")


def frame_seconds(times: DataFrame) -> Any:
    """Return the seconds of each frame: those of the rank that took longest."""
    return wall_by_rank(times).max(axis=1)


def efficiencies(times: DataFrame) -> DataFrame:
    """Return the factors of each frame, and of all in the row "all"."""
    pd = _extras.pandas()
    if times.empty:
        index = pd.Index([], name="frame", dtype=object)
        none: DataFrame = pd.DataFrame({name: np.zeros(0) for name in COLUMNS}, index=index)
        return none
    work, wall = work_by_rank(times), wall_by_rank(times)
    chain = times.pivot(index="frame", columns="rank", values="chain_s").max(axis=1)
    longer = chain.diff()
    longer = longer.where(longer > 0, chain)  # the first frame, or the first behind a restart
    rows = [
        factors(work.loc[frame].to_numpy(), float(wall.loc[frame].max()), float(longer[frame]))
        for frame in work.index
    ]
    ideal = float(longer.iloc[1:].sum() + min(longer.iloc[0], wall.iloc[0].max()))
    rows.append(factors(work.sum().to_numpy(), float(wall.sum().max()), ideal))
    index = pd.Index([*map(int, work.index), "all"], name="frame", dtype=object)
    found: DataFrame = pd.DataFrame(rows, columns=list(COLUMNS), index=index)
    return found


def factors(work: Any, seconds: float, ideal_s: float) -> tuple[float, ...]:
    """Divide the efficiency of ranks that worked so long, (ranks,), in so many seconds, as in COLUMNS."""
    known = work[~np.isnan(work)]
    most = float(known.max()) if len(known) else 0.0
    if not (seconds > 0 and most > 0):
        return (np.nan,) * len(COLUMNS)
    seconds = max(seconds, most)
    ideal_s = min(max(ideal_s, most), seconds)
    balance, serialisation, transfer = float(known.mean()) / most, most / ideal_s, ideal_s / seconds
    communication = serialisation * transfer
    return balance * communication, balance, communication, serialisation, transfer
