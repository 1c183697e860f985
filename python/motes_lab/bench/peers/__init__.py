"""Compares the engine with other tools: `python -m motes bench peers`.

Grains at rest and flowing come first, compared with LAMMPS (bed.py). In snow, each peer starts from the
engine's particles and takes the same steps: a random acceleration, a bounce off the ground, a test of the
age, motion. Afterwards its particles are compared with the engine's. Colliding spheres come last: see
spheres.py.
"""

from __future__ import annotations

import contextlib
import datetime
import importlib
import importlib.util
import os
import statistics
import sys
import time
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np

from motes.errors import MotesError

from ..._engine import simd
from ..quiet import LIMIT, OthersAtWork, processor, require_quiet, too_busy
from .bed import bed, chute
from .engine import Engine
from .scene import Peer, disagreement
from .spheres import NotInstalled, spheres

__all__ = ["PEERS", "peers"]


class _Known(NamedTuple):
    """A peer, compared by the class `Run` in `NAME_run.py`."""

    package: str
    """Its name on PyPI and in the extra."""
    module: str
    """The module to import."""
    threads: bool
    """Whether one call can use all cores."""
    leaves_out: str
    """The engine's work that the peer does not do."""


_OUT = "equal bits in every run, exact hits, removal of dead particles, migration"

PEERS = {
    "numpy": _Known("numpy", "numpy", False, _OUT),
    "numba": _Known("numba", "numba", True, f"{_OUT}; ids (a particle is identified by its index)"),
    "taichi": _Known("taichi", "taichi", True, f"{_OUT}; the same random numbers in every run"),
    "warp": _Known("warp-lang", "warp", False, f"{_OUT}; ids (a particle is identified by its index)"),
}


MOST_ROUNDS = 3
"""Of what is compared with LAMMPS: with these, the whole command takes less than four minutes."""


def peers(
    *,
    particles: int,
    steps: int,
    threads: int,
    collide: int = 400_000,
    grains: int = 37_000,
    lammps: str | None = None,
    busy: bool = False,
) -> dict[str, Any]:
    """Time steps of all installed peers in turn, on one thread and, if more are given, on `threads`.

    `grains` is the number in the bed and on the chute, compared with LAMMPS on one rank and on two; `collide`
    the number of spheres, compared on one thread. `lammps`: time only LAMMPS, with this Python; None: time
    all, with the current one. `busy`: on a busy machine, too.

    Raises MotesError if the machine is busy before or while figures are taken.
    """
    require_quiet(busy=busy)
    others = OthersAtWork()
    python, rounds = lammps or sys.executable, min(steps, MOST_ROUNDS)
    found: dict[str, Any] = {"simd": simd(), "steps": steps, "rows": [], "not_installed": {}}
    found |= {"bed": None, "chute": None, "collide": None}
    with _without(found["not_installed"]):
        found["bed"] = bed(grains=grains, steps=200, rounds=rounds, python=python)
        found["chute"] = chute(grains=grains, steps=200, rounds=rounds, python=python)
    if lammps is None:
        found |= {"particles": particles, "rows": _snow(found["not_installed"], particles, steps, threads)}
    with _without(found["not_installed"]):
        found["collide"] = spheres(particles=collide, rounds=rounds, python=python)
    if (used := others.processors()) > LIMIT and not busy:
        raise MotesError(f"not judged: while this ran, {too_busy(used)}")
    return found | {"others": used, **_machine()}


def _machine() -> dict[str, Any]:
    """Return what a table of figures says of the machine and the day."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "date": datetime.date.today().isoformat(),
    }


@contextlib.contextmanager
def _without(missing: dict[str, str]) -> Iterator[None]:
    """Note that there is no LAMMPS, instead of raising NotInstalled."""
    try:
        yield
    except NotInstalled as why:
        missing["lammps"] = str(why)


def _snow(missing: dict[str, str], particles: int, steps: int, threads: int) -> list[dict[str, Any]]:
    """Time snow's steps of each peer, and note those that are not installed."""
    for name, peer in PEERS.items():
        if importlib.util.find_spec(peer.module) is None:
            missing[name] = f"not installed: pip install '{peer.package}', or the extra motes[peers]"
    rows = []
    with contextlib.redirect_stdout(sys.stderr):  # some print their version
        for count in sorted({1, threads}):
            rows += _in_turn([name for name in PEERS if name not in missing], particles, steps, count)
    return rows


def _in_turn(names: list[str], particles: int, steps: int, threads: int) -> list[dict[str, Any]]:
    """Run one step of each peer in turn: a slow moment of the machine affects all."""
    chosen = [name for name in names if threads == 1 or PEERS[name].threads]
    with Engine(particles, steps + 1, threads) as engine:
        start = engine.columns()
        runs: dict[str, Peer] = {"motes": engine}
        runs |= {name: _load(name).Run(start.copy(), threads) for name in chosen}
        seconds: dict[str, list[float]] = {name: [] for name in runs}
        for step in range(steps + 1):
            for name, run in runs.items():
                seconds[name].append(_timed(run, step, threads))
        end = engine.columns()
        wrong = {name: disagreement(start, end, run.columns()) for name, run in runs.items()}
    for name, what in wrong.items():
        if what:
            raise RuntimeError(f"{name} and the engine disagree: {what}")
    own = seconds["motes"][1:]
    return [
        {
            "peer": name,
            "version": version("motes" if name == "motes" else PEERS[name].package),
            "threads": threads,
            "million_per_s": particles / min(seconds[name][1:]) / 1e6,
            "engine_by_peer": statistics.median(
                theirs / ours for ours, theirs in zip(own, seconds[name][1:], strict=True)
            ),
            "leaves_out": "" if name == "motes" else PEERS[name].leaves_out,
        }
        for name in runs
    ]


def _timed(run: Peer, step: int, threads: int) -> float:
    """Return the seconds of a step: processor time of this process on one thread, else wall time."""
    clock = time.process_time if threads == 1 else time.perf_counter
    begin = clock()
    run.step(np.uint32(step))
    return clock() - begin


def _load(name: str) -> Any:
    return importlib.import_module(f"{__name__}.{name}_run")
