"""Measures of balance: pure functions of the tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ... import _extras
from ...errors import ArgumentError
from .schema import QUANTILES

if TYPE_CHECKING:
    from pandas import DataFrame, Series

__all__ = [
    "RANK_SECONDS",
    "balanced_s",
    "by_rank",
    "efficiency",
    "imbalance",
    "moved_by_cuts",
    "of_system",
    "shares",
    "speeds",
    "systems_of",
]

RANK_SECONDS = ("t_exchange_s", "t_wait_s", "t_image_s", "t_project_s")
"""Columns of load.jsonl with one value per rank and frame, which each system's row repeats."""


def systems_of(load: DataFrame) -> list[str]:
    """Return the systems' names in the order of the log."""
    return [str(name) for name in load["system"].unique()]


def of_system(table: DataFrame, system: str | None) -> DataFrame:
    """Return the rows of one system, or all rows; ArgumentError for a name that is not in the table."""
    if system is None:
        return table
    names = systems_of(table)
    if system not in names:
        raise ArgumentError("system", system, f"None or one of {names}")
    return table[table["system"] == system]


def by_rank(load: DataFrame, column: str = "t_compute_s", system: str | None = None) -> DataFrame:
    """Return one column of load.jsonl as a table frame x rank, summed over systems.

    Columns with one value per rank (`t_wait_s`, ...) and ends of domains are not summed; the largest is
    taken.
    """
    if column not in load.columns or column in ("frame", "rank", "system", "host"):
        allowed = [name for name in load.columns if name not in ("frame", "rank", "system", "host")]
        raise ArgumentError("column", column, f"one of {allowed}")
    if column == "speed":
        return speeds(load, system)
    once = column in RANK_SECONDS or column.startswith("domain_")
    return of_system(load, system).pivot_table(
        index="frame", columns="rank", values=column, aggfunc="max" if once else "sum", dropna=False
    )


def imbalance(load: DataFrame, column: str = "t_compute_s", system: str | None = None) -> Series:
    """Return largest / mean over the calculators, per frame; 1 where all are idle."""
    table = by_rank(load, column, system)
    mean = table.mean(axis=1)
    return (table.max(axis=1) / mean.where(mean > 0)).fillna(1.0).rename("imbalance")


def efficiency(load: DataFrame, column: str = "t_compute_s", system: str | None = None) -> Series:
    """Return mean / largest over the calculators, per frame: the fraction of their time spent computing."""
    return (1 / imbalance(load, column, system)).rename("efficiency")


def shares(load: DataFrame, column: str = "n_end", system: str | None = None) -> DataFrame:
    """Return each rank's fraction of a column's sum, frame x rank; NaN where the sum is 0."""
    table = by_rank(load, column, system)
    total = table.sum(axis=1)
    return table.div(total.where(total > 0), axis=0)


def speeds(load: DataFrame, system: str | None = None) -> DataFrame:
    """Return particles per second of compute time, frame x rank; NaN where nothing was computed."""
    pd = _extras.pandas()
    rows = of_system(load, system)
    known = rows["speed"] > 0
    seconds = rows["t_compute_s"].where(known, 0.0)
    work = (rows["speed"] * seconds).fillna(0.0)
    parts = {"frame": rows["frame"], "rank": rows["rank"], "work": work, "seconds": seconds}
    sums = pd.DataFrame(parts).groupby(["frame", "rank"])[["work", "seconds"]].sum()
    per_rank: Series = sums["work"] / sums["seconds"].where(sums["seconds"] > 0, np.nan)
    return per_rank.unstack("rank")


def balanced_s(load: DataFrame, seconds: DataFrame) -> Series:
    """Return the seconds of each frame if calculators shared its particles by their machines' speeds.

    That is particles / sum of speeds, less than the mean of the seconds on machines that differ.

    Args:
        load: rows of the log's table.
        seconds: seconds of actions, frame x rank, to use instead of the table's.
    """
    held = by_rank(load.assign(n=load["n_start"] + load["created"]), "n").fillna(0.0)
    held = held.reindex(index=seconds.index, columns=seconds.columns).fillna(0.0)
    spent = seconds.sum()
    all_speeds = float((held.sum() / spent.where(spent > 0)).sum())
    return held.sum(axis=1) / (all_speeds if all_speeds > 0 else 1.0)


def moved_by_cuts(balance: DataFrame, density: DataFrame) -> int:
    """Count the particles that new cuts gave to other calculators.

    Uses the donors' counts if there are any. Balancers that replace all cuts have none: then the particles
    between the old and the new position of each cut are estimated from the quantiles of both neighbours.
    """
    total = float(balance["given"].abs().sum())
    anew = balance[balance["given"].isna() & (balance["cut_before"] != balance["cut_after"])]
    if density.empty or anew.empty:
        return round(total)
    known = density.set_index(["frame", "system", "rank"])[["n", *QUANTILES]]
    parts = np.linspace(0, 1, len(QUANTILES))
    ends = anew[["cut_before", "cut_after"]].to_numpy(float)
    for side in ("left_rank", "right_rank"):
        keys = list(zip(anew["frame"], anew["system"], anew[side], strict=True))
        for row, cuts in zip(known.reindex(keys).to_numpy(float), ends, strict=True):
            if row[0] > 0 and not (np.isnan(row).any() or np.isnan(cuts).any()):
                below = row[0] * np.interp(cuts, row[1:], parts)
                total += abs(float(below[1] - below[0]))
    return round(total)
