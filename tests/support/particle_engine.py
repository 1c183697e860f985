"""Frames with single particles, without MPI or clock: the reference for replays, which have no particles."""

from __future__ import annotations

from typing import Any

import numpy as np

from motes import Run, _core
from motes.analysis._tables.schema import TABLES
from motes.analysis._tables.tables import frame_of
from motes.balance import Balancer

__all__ = ["play"]


def play(balancer: Balancer, *, frames: int = 60, particles: int = 40_000, seed: int = 1) -> Run:
    """Run a spreading, drifting cloud with births at a point, over four machines of different speeds.

    As in the engine, in each frame births follow the new cuts, old particles act where they were,
    all move, migrants go to their owners, loads are reported, and the balancer plans.
    """
    random = np.random.default_rng(seed)
    machine = np.array([8e6, 4e6, 8e6, 2e6])
    n = len(machine)
    policy = balancer._policy
    speeds = policy.speeds(n)
    x = random.normal(-2, 1, particles).astype(np.float32)
    v = random.normal(0.06, 0.05, particles).astype(np.float32)
    cuts = np.array([-4, 0, 4], np.float32)
    owner = np.zeros(0, np.int64)
    tables: dict[str, list[dict[str, Any]]] = {"frames": [], "load": [], "density": [], "balance": []}
    for frame in range(frames):
        born = 0 if frame == 0 else particles // 200
        old = np.bincount(owner, minlength=n)
        first = random.normal(3, 0.2, born).astype(np.float32) if frame else x
        created = np.bincount(np.searchsorted(cuts, first, side="right"), minlength=n)
        start = np.concatenate([owner, np.searchsorted(cuts, first, side="right")])
        if frame:
            x = np.concatenate([x, first])
            v = np.concatenate([v, random.normal(0, 0.1, born).astype(np.float32)])
        x = x + v
        owner = np.searchsorted(cuts, x, side="right")
        held = np.bincount(owner, minlength=n)
        noise = random.normal(1, 0.02, n)
        seconds = (old + created) / machine * noise
        for c in range(n):
            speeds.add(c, int(old[c] + created[c]), float(seconds[c]), int(created[c]))
        moved = start != owner
        rescaled = seconds * held / np.maximum(old + created, 1)
        smooth = [speeds.of(c) for c in range(n)]
        error = [speeds.error(c) for c in range(n)]
        load = _core.BalanceTable(frame, frame, "cloud", held, rescaled, smooth, cuts, error)
        plan = _core.legal_plan(policy.plan(load), load, policy.name)
        ends = [-np.inf, *cuts, np.inf]
        for c in range(n):
            mine = x[owner == c]
            key = {"frame": frame, "system": "cloud", "rank": c}
            row = {**key, "host": "h", "n_start": int(old[c]), "n_end": int(held[c]), "killed": 0}
            row |= {"created": int(created[c]), "sent": int(moved[start == c].sum())}
            row |= {"received": int(moved[owner == c].sum()), "t_compute_s": float(seconds[c])}
            row |= {"t_rescaled_s": float(rescaled[c]), "speed": float(machine[c] / noise[c])}
            row |= {"domain_lo": _finite(ends[c]), "domain_hi": _finite(ends[c + 1])}
            tables["load"].append(row)
            q = _core.quantiles(mine, 16)
            named = {f"x_q{i:02d}": float(q[i]) if len(q) else None for i in range(17)}
            tables["density"].append({**key, "n": len(mine), **named})
        row = {"frame": frame, "time": (frame + 1) / 24, "particles": len(x), "exchanged": int(moved.sum())}
        row |= {"exchanged_bytes": 40 * int(moved.sum()), "imbalance": float(seconds.max() / seconds.mean())}
        tables["frames"].append(row | {"t_frame_s": float(seconds.max()) + 1e-3, "dropped": 0})
        cuts = _after(plan, x, owner, cuts)
    facts = {"calculators": list(range(n)), "systems": ["cloud"], "balancer": repr(balancer), "ranks": n}
    return Run(facts, {name: frame_of(rows, TABLES[name].columns) for name, rows in tables.items()})


def _after(plan: _core.BalancePlan, x: np.ndarray, owner: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    held = [x[owner == c] for c in range(len(cuts) + 1)]
    if len(plan.shares):
        histograms = [_core.histogram(mine, 64) for mine in held]
        return _core.prefix_cuts(histograms, plan.costs, plan.shares, cuts)
    after = cuts.copy()
    ends = [-np.inf, *cuts, np.inf]
    for source, to, count in plan.orders:
        give = _core.give_right if to > source else _core.give_left
        cut, given = give(held[source], count, ends[source], ends[source + 1])
        if given:
            after[min(source, to)] = cut
    return after


def _finite(end: float) -> float | None:
    return float(end) if np.isfinite(end) else None
