"""Predict a recorded run under another balancer, as rows of the log's tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..balance import Balancer, policy_of
from ..balance._options import checked_powers
from ..errors import ArgumentError
from .bricks import Cloud, Tree
from .costs import Costs
from .density import Density
from .estimate import Estimate
from .frames import Step, SystemStep, simulate
from .history import History, Recorded
from .tables import Tables

__all__ = ["Row", "add_rows", "predict"]

Row = dict[str, Any]


def predict(
    tables: Tables,
    balancer: Balancer,
    *,
    powers: Sequence[float] | None = None,
    migrant_s: float | None = None,
) -> dict[str, list[Row]]:
    """Predict a recorded run under another balancer.

    Particle positions in each frame come from the log (density.jsonl); they do not depend on which calculator
    owned them. So does how far particles moved, which tells who migrates across other cuts. Without it, for
    bricks and in logs of earlier versions, `sent` and `received` are the minimum that brings all particles to
    their calculators, and those that swap sides of a cut: the same fraction of the particles near it as in
    the recorded run.

    A frame takes what the recorded one took, and the difference that the balancers make to the clocks of all
    ranks: actions, migrants, plans and the search for new cuts, pictures, and messages. `t_frame_low_s` and
    `t_frame_high_s` in `frames` are bounds.

    The log records the distribution of each calculator's particles along every cut axis, but not how the axes
    correlate, so they are assumed to be independent within a brick. If particles are distributed by id,
    ranges of ids are cut like slabs.

    Args:
        tables: the recorded run's tables, such as a `Run`.
        balancer: the balancer to predict.
        powers: the machines' powers, one per calculator on any scale, if known. Other differences in measured
            time are then attributed to places, and move with the particles there to another calculator. None:
            measured speeds are attributed to the machines, per calculator and frame.
        migrant_s: seconds per migrant for each of its two calculators, with its bytes on the network; None:
            as the log tells.

    Returns:
        Rows of "frames", "load", "density" and "balance".

    Raises:
        LogError: if the log has no densities, or not along all cut axes, as in logs of earlier versions.
        ArgumentError: if `balancer` is not a balancer or does not fit, such as orders for bricks.
    """
    if not isinstance(balancer, Balancer):
        raise ArgumentError("balancer", balancer, "a Balancer")
    tables = getattr(tables, "unchanged", tables)  # a replay ends where other ranks continue
    history = Recorded(tables)
    costs = Costs(tables, history, migrant_s)
    known = None
    if powers is not None:
        known = np.array(checked_powers(powers, above=True))
        if len(known) != len(history.ranks):
            raise ArgumentError("powers", powers, f"{len(history.ranks)} numbers, one per calculator")
    recorded = tables.frames.set_index("frame")
    estimate = Estimate(costs, decentralised=policy_of(balancer).decentralised)
    rows: dict[str, list[Row]] = {"frames": [], "load": [], "density": [], "balance": []}
    for step in simulate(history, balancer, known):
        estimate.add(step)
        add_rows(
            rows,
            history,
            step,
            repr(balancer),
            recorded={str(name): value for name, value in recorded.loc[step.frame].items()},
            hosts=tables.hosts,
            bytes_each=costs.migrant_bytes / costs.scale,
        )
    for row, frame_s, low_s, high_s in zip(rows["frames"], *estimate.seconds(), strict=True):
        row["t_frame_s"], row["t_frame_low_s"], row["t_frame_high_s"] = map(float, (frame_s, low_s, high_s))
    return rows


def add_rows(
    rows: dict[str, list[Row]],
    history: History,
    step: Step,
    policy: str,
    *,
    recorded: Row,
    hosts: Mapping[int, str] | None = None,
    bytes_each: float = 0.0,
) -> None:
    """Add a simulated frame to the rows of all tables.

    Args:
        rows: rows by name of the table.
        history: what was simulated.
        step: the frame.
        policy: the balancer, as text.
        recorded: columns of `frames` that the replay does not change.
        hosts: each rank's host.
        bytes_each: bytes of a migrant.
    """
    rows["frames"].append(_frame_row(history.ranks, step, bytes_each, recorded))
    for name, axes, system in zip(history.systems, history.axes, step.systems, strict=True):
        key = {"frame": step.frame, "system": name}
        rows["load"] += _load_rows(key, history.ranks, hosts or {}, axes, system, bytes_each)
        rows["density"] += _density_rows(key, history.ranks, axes, system)
        rows["balance"] += _balance_rows(key, history.ranks, system, policy)


def _frame_row(ranks: Sequence[int], step: Step, bytes_each: float, recorded: Row) -> Row:
    seconds = step.seconds
    exchanged = sum(float(system.sent.sum()) for system in step.systems)
    slowest = int(np.argmax(seconds))
    total = float(seconds.sum())
    return {
        **recorded,
        "frame": step.frame,
        "particles": int(step.particles.sum()),
        "exchanged": round(exchanged),
        "exchanged_bytes": round(exchanged * bytes_each),
        "imbalance": float(seconds[slowest]) * len(seconds) / total if total > 0 else 1.0,
        "slowest_rank": ranks[slowest],
        "t_act_s": float(seconds[slowest]),
    }


def _load_rows(
    key: Row,
    ranks: Sequence[int],
    hosts: Mapping[int, str],
    axes: str,
    system: SystemStep,
    bytes_each: float,
) -> Iterable[Row]:
    sent, received = np.rint(system.sent), np.rint(system.received)
    processed = system.n_start + system.created
    deaths = system.killed * processed / max(int(processed.sum()), 1)
    waits = float(system.seconds.max()) - system.seconds
    domains = _domains(axes, system.cuts)
    for c, rank in enumerate(ranks):
        seconds = float(system.seconds[c])
        yield {
            **key,
            "rank": rank,
            "host": hosts.get(rank, ""),
            "n_start": int(system.n_start[c]),
            "n_end": int(system.n_end[c]),
            "created": int(system.created[c]),
            "killed": round(float(deaths[c])),
            "sent": int(sent[c]),
            "received": int(received[c]),
            "bytes_sent": round(float(sent[c]) * bytes_each),
            "t_compute_s": seconds,
            "t_rescaled_s": float(system.rescaled[c]),
            "t_exchange_s": 0.0,
            "t_wait_s": float(waits[c]),
            "t_image_s": 0.0,
            **domains[c],
            "speed": float(processed[c]) / seconds if seconds > 0 else 0.0,
        }


def _domains(axes: str, cuts: Any) -> list[Row]:
    """Return the ends of each domain as columns of the log."""
    if not isinstance(cuts, Tree):
        low, high = [None, *map(float, cuts)], [*map(float, cuts), None]
        return [{"domain_lo": lo, "domain_hi": hi} for lo, hi in zip(low, high, strict=True)]
    rows: list[Row] = [{} for _ in range(len(cuts) + 1)]
    for row, lows, highs in zip(rows, *cuts.boxes(), strict=True):
        for axis in axes:
            number = "xyz".index(axis)
            start = "domain_" if axis == axes[0] else f"domain_{axis}_"
            for name, end in (("lo", lows[number]), ("hi", highs[number])):
                row[start + name] = float(end) if np.isfinite(end) else None
    return rows


def _density_rows(key: Row, ranks: Sequence[int], axes: str, system: SystemStep) -> Iterable[Row]:
    density = system.density
    if isinstance(density, Cloud) and isinstance(system.cuts, Tree):
        names = ["x", *axes[1:]]
        places = [density.quantiles(system.cuts, 16, "xyz".index(axis)) for axis in axes]
    elif isinstance(density, Density) and not isinstance(system.cuts, Tree):
        names, places = ["x"], [density.quantiles(system.cuts, 16)]
    for c, (rank, n) in enumerate(zip(ranks, system.n_end, strict=True)):
        known = {
            f"{name}_q{i:02d}": None if np.isnan(v) else float(v)
            for name, along in zip(names, places, strict=True)
            for i, v in enumerate(along[c])
        }
        yield {**key, "rank": rank, "n": int(n), **known}


def _balance_rows(key: Row, ranks: Sequence[int], system: SystemStep, policy: str) -> Iterable[Row]:
    if system.plan is None:
        return
    orders = {min(source, to): (to - source) * count for source, to, count in system.plan.orders}
    shares = len(system.plan.shares) > 0
    cuts, next_cuts = (one.at if isinstance(one, Tree) else one for one in (system.cuts, system.next_cuts))
    given = np.zeros(len(cuts))
    if isinstance(system.density, Density):
        given = np.rint(system.density.count_below(cuts)) - np.rint(system.density.count_below(next_cuts))
    for cut in map(int, system.plan.evaluated if not orders else sorted({*system.plan.evaluated, *orders})):
        yield {
            **key,
            "left_rank": ranks[cut],
            "right_rank": ranks[cut + 1],
            "n_left": int(system.n_end[cut]),
            "n_right": int(system.n_end[cut + 1]),
            "t_left_s": float(system.rescaled[cut]),
            "t_right_s": float(system.rescaled[cut + 1]),
            "speed_left": float(system.smoothed[cut]),
            "speed_right": float(system.smoothed[cut + 1]),
            "ordered": None if shares else orders.get(cut, 0),
            "given": None if shares else int(given[cut]),
            **({"axis": "xyz"[system.cuts.axes[cut]]} if isinstance(system.cuts, Tree) else {}),
            "cut_before": float(cuts[cut]),
            "cut_after": float(next_cuts[cut]),
            "policy": policy,
        }
