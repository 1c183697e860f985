"""Compares two installs of the engine: `python -m motes bench compare OLD_PYTHON`.

Both run the same benchmarks in turn, round after round, so that a slow moment of the machine affects both. A
row is slower if three quarters of the rounds say so: if the lower quartile of its ratios exceeds LIMIT.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import motes
from motes.errors import MotesError

from .quiet import LIMIT as MOST_OTHERS
from .quiet import OthersAtWork, require_quiet, too_busy

__all__ = ["BENCHES", "LIMIT", "compare"]

LIMIT = 1.03
"""A row whose time grows by more than this factor is slower."""

BENCHES: dict[str, tuple[str, ...]] = {
    "snow": ("--particles", "3200000", "--steps", "20"),
    "fountain": ("--particles", "3200000", "--steps", "20"),
    "render": ("--frames", "5"),
    "meetings": ("--particles", "200000", "--repeats", "3"),
    "births": ("--repeats", "200"),
}
"""Arguments of the benchmarks: whole rounds take about a minute."""


def compare(*, old_python: str, rounds: int, only: list[str] | None, busy: bool) -> dict[str, Any]:
    """Time both installs; return the time of each row before and now, and quartiles of the ratios.

    `only`: benchmarks among BENCHES; None: all. `busy`: on a busy machine, too; nothing is judged then.

    Raises MotesError if the machine is busy, or if an install fails or lacks a benchmark.
    """
    require_quiet(busy=busy)
    new_env = {**os.environ, "PYTHONPATH": str(Path(motes.__file__).resolve().parents[1])}
    old_env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    # The benchmarks run in another folder. An environment's Python is a link, which must not be followed.
    old_python = os.path.abspath(old_python) if os.sep in old_python else old_python
    sides = [(old_python, old_env), (sys.executable, new_env)]
    others = OthersAtWork()
    found: dict[str, tuple[list[float], list[float]]] = {}
    for number in range(rounds):
        for bench in only or BENCHES:
            times: list[dict[str, float]] = [{}, {}]
            for side in (0, 1) if number % 2 == 0 else (1, 0):
                times[side] = dict(_rows(bench, _figures(*sides[side], bench)))
            for name in (name for name in times[1] if name in times[0]):
                before, now = found.setdefault(name, ([], []))
                before.append(times[0][name])
                now.append(times[1][name])
    used = others.processors()
    if used > MOST_OTHERS and not busy:
        raise MotesError(f"not judged: while this ran, {too_busy(used)}")
    rows = [_row(name, before, now) for name, (before, now) in found.items()]
    judged = used <= MOST_OTHERS
    slower = [row["row"] for row in rows if judged and row["low"] > LIMIT]
    facts = {"rows": rows, "rounds": rounds, "others": used, "judged": judged, "slower": slower}
    return facts | {"cores": os.cpu_count(), "load": os.getloadavg()[0]}


def _row(name: str, before: list[float], now: list[float]) -> dict[str, Any]:
    ratios = [new / old for old, new in zip(before, now, strict=True)]
    low, middle, high = statistics.quantiles(ratios, n=4, method="inclusive") if ratios[1:] else ratios * 3
    times = {"before": statistics.median(before), "now": statistics.median(now)}
    return {"row": name, **times, "ratio": middle, "low": low, "high": high}


def _figures(python: str, env: Mapping[str, str], bench: str) -> dict[str, Any]:
    """Run a benchmark with an install, away from folders that hold another one."""
    command = [python, "-m", "motes", "bench", bench, *BENCHES[bench], "--json"]
    with tempfile.TemporaryDirectory(prefix="motes-compare-") as folder:
        try:
            job = subprocess.run(command, env=env, cwd=folder, check=False, capture_output=True, text=True)
        except OSError as error:
            raise MotesError(
                f"OLD_PYTHON {python}: {error.strerror}; give the Python of an install"
            ) from error
    lines = [line for line in job.stdout.splitlines() if line.startswith("{")]
    if job.returncode != 0 or not lines:
        why = job.stderr.strip().splitlines()[-1:] or [f"exit code {job.returncode}"]
        raise MotesError(
            f"`{' '.join(command[:5])}` failed: {why[0]}; give the Python of an install of motes"
        )
    figures: dict[str, Any] = json.loads(lines[-1])
    return figures


def _rows(bench: str, figures: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    """Yield the times of a benchmark's rows; only ratios of equal rows have a meaning."""
    if bench == "render":
        for row in figures["rows"]:
            yield f"{bench}: {row['name']}, {row['kind']}, {row['blend']}, ms", row["ms_per_frame"]
    elif bench == "meetings":
        for row in figures["rows"]:
            yield f"{bench}: {row['action']}, ns", row["ns"]
    elif bench == "births":
        for name, value in figures.items():
            if name.endswith("_ns"):
                yield f"{bench}: {name.removesuffix('_ns')}, ns", value
    else:
        yield f"{bench}: list, ns", 1e9 / figures["updates_per_s"]
