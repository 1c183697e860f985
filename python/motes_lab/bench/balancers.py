"""Compares balancers: on synthetic or recorded loads, and by their cost in a job."""

from __future__ import annotations

from typing import Any

from .jobs import figures_of

__all__ = ["balance", "overhead"]

PLANNING_CALCULATORS = 4096


def balance(*, calculators: int, particles: int, frames: int, run: str | None) -> dict[str, Any]:
    """Compare balancers on synthetic loads, or on those in `run`, a run's log; that needs pandas."""
    from motes import replay

    histories: dict[str, replay.History] = {}
    if run is not None:
        from motes.analysis import open_run

        histories[run] = replay.Recorded(open_run(run))
    else:
        size = {"calculators": calculators, "particles": particles, "frames": frames}
        histories = {load: replay.synthetic(load, **size) for load in replay.LOADS}
    rows = []
    for load, history in histories.items():
        speeds = history.moment(0, 0).speeds
        rows += [{"load": load, **row} for row in replay.compare(history, replay.candidates(speeds))]
    planned = replay.candidates([1.0] * PLANNING_CALCULATORS)
    planning = {type(b).__name__: replay.planning_ms(b, PLANNING_CALCULATORS) for b in planned}
    return {"rows": rows, "planning_calculators": PLANNING_CALCULATORS, "planning_ms": planning}


def overhead(*, ranks: int, systems: int, particles: int, rounds: int, frames: int) -> dict[str, Any]:
    """Start a job in which worlds with each balancer take turns, and return the figures of its first rank."""
    sizes = {"systems": systems, "particles": particles, "rounds": rounds, "frames": frames}
    options = [f"--{name}={value}" for name, value in sizes.items()]
    return figures_of("motes_lab.bench.overhead", ranks, options)
