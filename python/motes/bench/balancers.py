"""Comparisons of balancers: on synthetic or recorded loads, and by what they cost in a job."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

from .. import launch
from ..errors import MotesError

__all__ = ["balance", "overhead"]

PLANNING_CALCULATORS = 4096


def balance(*, calculators: int, particles: int, frames: int, run: str | None) -> dict[str, Any]:
    """Compare balancers on synthetic loads, or on those of `run`, the log of a run, which needs pandas."""
    from .. import replay

    histories: dict[str, replay.History] = {}
    if run is not None:
        from ..analysis import open_run

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
    argv = launch.command(ranks, [sys.executable, "-m", "motes.bench.overhead", *options])
    job = subprocess.run(argv, check=False, capture_output=True, text=True)
    lines = [line for line in job.stdout.splitlines() if line.startswith("{")]
    if job.returncode != 0 or not lines:
        raise MotesError(f"the job on {ranks} ranks failed:\n{job.stderr}")
    figures: dict[str, Any] = json.loads(lines[-1])
    return figures
