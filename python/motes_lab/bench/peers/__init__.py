"""Compares the engine with other tools on the actions of snow: `python -m motes bench peers`.

Each peer starts from the engine's particles and takes the same steps: a random acceleration, a bounce off the
ground, a test of the age, motion. Afterwards its particles are compared with the engine's. Colliding spheres
and grains at rest and flowing are compared with LAMMPS (spheres.py, bed.py).
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import statistics
import sys
import time
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np

from ..._engine import simd
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


def peers(
    *,
    particles: int,
    steps: int,
    threads: int,
    collide: int = 400_000,
    grains: int = 37_000,
    lammps: str | None = None,
) -> dict[str, Any]:
    """Time steps of all installed peers in turn, on one thread and, if more are given, on `threads`.

    `collide` is the number of spheres compared with LAMMPS on one thread; `grains` the number in the bed and
    on the chute, on one rank and on two. `lammps`: time only LAMMPS, with this Python; None: time all, with
    the current one.
    """
    python = lammps or sys.executable
    if lammps is not None:
        return {"simd": simd(), "rows": [], **_beside_lammps(python, steps, collide, grains)}
    missing = {
        name: f"not installed: pip install '{peer.package}', or the extra motes[peers]"
        for name, peer in PEERS.items()
        if importlib.util.find_spec(peer.module) is None
    }
    rows = []
    with contextlib.redirect_stdout(sys.stderr):  # some print their version
        for count in sorted({1, threads}):
            rows += _in_turn([name for name in PEERS if name not in missing], particles, steps, count)
    beside = _beside_lammps(python, steps, collide, grains)
    beside["not_installed"] = missing | beside["not_installed"]
    return {"particles": particles, "simd": simd(), "rows": rows, **beside}


def _beside_lammps(python: str, steps: int, collide: int, grains: int) -> dict[str, Any]:
    """Time the comparisons with LAMMPS, in `steps` rounds."""
    found: dict[str, Any] = {"steps": steps, "collide": None, "bed": None, "chute": None, "not_installed": {}}
    try:
        found["collide"] = spheres(particles=collide, rounds=steps, python=python)
        found["bed"] = bed(grains=grains, steps=200, rounds=steps, python=python)
        found["chute"] = chute(grains=grains, steps=200, rounds=steps, python=python)
    except NotInstalled as why:
        found["not_installed"] = {"lammps": str(why)}
    return found


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
