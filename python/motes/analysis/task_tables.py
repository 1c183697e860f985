"""A run of another code as tables: its phases are frames, the work of its tasks is a system of particles."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._interchange.task_loads import TaskLoads

__all__ = ["facts_of", "tables_of"]

Row = dict[str, Any]


def facts_of(loads: TaskLoads) -> Row:
    """Return the facts of the run, as in run.json; all ranks are calculators."""
    ranks = list(range(loads.ranks))
    return {
        "name": loads.name,
        "ranks": len(ranks),
        "calculators": ranks,
        "systems": [loads.system],
        "axes": ["x"],
        "space": [0.0, float(len(loads.first))],
        "particle_s": loads.particle_s,
    }


def tables_of(loads: TaskLoads) -> dict[str, list[Row]]:
    """Return the rows of `frames` and `load`. Domains are known while each rank's tasks are side by side."""
    rows: dict[str, list[Row]] = {"frames": [], "load": []}
    before = np.zeros(loads.ranks, np.int64)
    for k, frame in enumerate(loads.phases):
        there = loads.rank_of[k] >= 0
        weights = np.rint(loads.task_s[k] / loads.particle_s)
        held = np.bincount(loads.rank_of[k][there], weights[there], loads.ranks).astype(np.int64)
        seconds = loads.by_rank(k) + loads.fixed_s[k]
        sent, received = _moved(loads, k, weights)
        mean = float(seconds.mean())
        rows["frames"].append(
            {
                "frame": frame,
                "particles": int(held.sum()),
                "exchanged": int(sent.sum()),
                "imbalance": float(seconds.max()) / mean if mean > 0 else 1.0,
                "slowest_rank": int(np.argmax(seconds)),
                "t_frame_s": float(seconds.max()),
                "t_act_s": float(seconds.max()),
            }
        )
        ends = _ends(loads, k)
        for rank in range(loads.ranks):
            rows["load"].append(
                {
                    "frame": frame,
                    "system": loads.system,
                    "rank": rank,
                    "host": "",
                    "n_start": int(before[rank]),
                    "n_end": int(held[rank]),
                    "sent": int(sent[rank]),
                    "received": int(received[rank]),
                    "t_compute_s": float(seconds[rank]),
                    "t_wait_s": float(seconds.max() - seconds[rank]),
                    "domain_lo": ends[rank],
                    "domain_hi": ends[rank + 1],
                    "speed": float(held[rank]) / float(seconds[rank]) if seconds[rank] > 0 else 0.0,
                }
            )
        before = held
    return rows


def _moved(loads: TaskLoads, k: int, weights: Any) -> tuple[Any, Any]:
    """Return the particles that each rank gave away and got since the phase before."""
    earlier, now = loads.rank_of[max(k - 1, 0)], loads.rank_of[k]
    other = (earlier >= 0) & (now >= 0) & (earlier != now)
    sides = [np.bincount(one[other], weights[other], loads.ranks) for one in (earlier, now)]
    return sides[0].astype(np.int64), sides[1].astype(np.int64)


def _ends(loads: TaskLoads, k: int) -> list[float | None]:
    """Return the ends of all domains; None for the outermost, and where the ranks' tasks are mixed."""
    there = np.flatnonzero(loads.rank_of[k] >= 0)
    ranks = loads.rank_of[k][there]
    if (np.diff(ranks) < 0).any():
        return [None] * (loads.ranks + 1)
    if np.array_equal(ranks, loads.first[there]):
        return [None, *map(float, loads.cuts), None]
    at = np.searchsorted(ranks, np.arange(1, loads.ranks))
    ends = np.append(there, len(loads.first))[at]
    return [None, *map(float, ends), None]
