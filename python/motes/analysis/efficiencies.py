"""POP's factors of parallel efficiency as a table, computed from the log's times (see factors.py)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from .. import _extras
from .factors import COLUMNS, combined, factors

if TYPE_CHECKING:
    from pandas import DataFrame, Series

__all__ = ["chain_by_frame", "efficiencies", "wall_by_rank", "work_by_rank"]


def work_by_rank(times: DataFrame) -> DataFrame:
    """Return seconds of work, one row per frame, one column per rank; NaN for ranks that were not there."""
    spent = times.assign(work=_kept(times) - times["wait_s"] - times["messages_s"])
    work: DataFrame = spent.pivot(index="frame", columns="rank", values="work").clip(lower=0.0)
    return work


def wall_by_rank(times: DataFrame) -> DataFrame:
    """Return the wall-clock seconds of frames, one row per frame, one column per rank, without recovery."""
    return times.assign(kept=_kept(times)).pivot(index="frame", columns="rank", values="kept")


def _kept(times: DataFrame) -> Series:
    kept: Series = times["wall_s"] - (times["recovery_s"].fillna(0.0) if "recovery_s" in times else 0.0)
    return kept


def chain_by_frame(times: DataFrame, before_s: float = 0.0) -> Series:
    """Return by how much the longest chain of work grew in each frame.

    `before_s`: its length before the first frame. A process that continues a run counts from 0 again. In logs
    of earlier versions the first frame after a loss also has the chains of the frames that were lost, so the
    first frame counts as no longer than it took.
    """
    chain = times.pivot(index="frame", columns="rank", values="chain_s").max(axis=1)
    grown: Series = chain.diff()
    grown.iloc[0] = chain.iloc[0] - (before_s if chain.iloc[0] >= before_s else 0.0)
    grown = grown.where(grown > 0, chain)  # the first frame after a restart on the same ranks
    first = wall_by_rank(times).iloc[0].max()
    grown.iloc[0] = min(grown.iloc[0], first)
    return grown


def efficiencies(parts: Iterable[DataFrame]) -> DataFrame:
    """Return the factors of each frame and, in the row "all", of the whole run.

    `parts`: the times of the run's parts (`Run.parts`); each is analysed by its own ranks.
    """
    pd = _extras.pandas()
    rows, sums, before_s = [], [], 0.0
    frames: list[int] = []
    for times in parts:
        if times.empty:
            continue
        work, wall, grown = work_by_rank(times), wall_by_rank(times), chain_by_frame(times, before_s)
        for frame in work.index:
            rows.append(factors(work.loc[frame].tolist(), float(wall.loc[frame].max()), float(grown[frame])))
        frames += map(int, work.index)
        sums.append((work.sum().tolist(), float(wall.sum().max()), float(grown.sum())))
        before_s = float(times["chain_s"].max())
    if not rows:
        index = pd.Index([], name="frame", dtype=object)
        none: DataFrame = pd.DataFrame({name: np.zeros(0) for name in COLUMNS}, index=index)
        return none
    index = pd.Index([*frames, "all"], name="frame", dtype=object)
    table: DataFrame = pd.DataFrame([*rows, combined(sums)], columns=list(COLUMNS), index=index)
    return table
