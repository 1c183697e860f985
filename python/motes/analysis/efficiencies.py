"""POP's factors of parallel efficiency as a table, computed from the log's times (see factors.py)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _extras
from .factors import COLUMNS, factors

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["efficiencies", "frame_seconds", "wall_by_rank", "work_by_rank"]


def work_by_rank(times: DataFrame) -> DataFrame:
    """Return seconds of work, one row per frame, one column per rank."""
    spent = times.assign(work=times["wall_s"] - times["wait_s"] - times["messages_s"])
    work: DataFrame = spent.pivot(index="frame", columns="rank", values="work").clip(lower=0.0)
    return work


def wall_by_rank(times: DataFrame) -> DataFrame:
    """Return the wall-clock seconds of frames, one row per frame, one column per rank."""
    return times.pivot(index="frame", columns="rank", values="wall_s")


def frame_seconds(times: DataFrame) -> Any:
    """Return the seconds of each frame on its slowest rank."""
    return wall_by_rank(times).max(axis=1)


def efficiencies(times: DataFrame) -> DataFrame:
    """Return the factors of each frame, and of the whole run in the row "all"."""
    pd = _extras.pandas()
    if times.empty:
        index = pd.Index([], name="frame", dtype=object)
        none: DataFrame = pd.DataFrame({name: np.zeros(0) for name in COLUMNS}, index=index)
        return none
    work, wall = work_by_rank(times), wall_by_rank(times)
    chain = times.pivot(index="frame", columns="rank", values="chain_s").max(axis=1)
    longer = chain.diff()
    longer = longer.where(longer > 0, chain)  # the first frame, or the first after a restart
    rows = [
        factors(work.loc[frame].tolist(), float(wall.loc[frame].max()), float(longer[frame]))
        for frame in work.index
    ]
    ideal = float(longer.iloc[1:].sum() + min(longer.iloc[0], wall.iloc[0].max()))
    rows.append(factors(work.sum().tolist(), float(wall.sum().max()), ideal))
    index = pd.Index([*map(int, work.index), "all"], name="frame", dtype=object)
    found: DataFrame = pd.DataFrame(rows, columns=list(COLUMNS), index=index)
    return found
