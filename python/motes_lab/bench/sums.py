"""Measures the cost of sums over particles on one core, relative to reading a column."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from motes import System, World
from motes.expressions import column
from motes.shapes import Box, Sphere

__all__ = ["sums"]

BINS, CELLS = 100, (100, 100, 100)
SIZE = 1.0  # edge of the box that the particles fill, m


def sums(*, particles: int, repeats: int) -> dict[str, Any]:
    """Time each kind of sum, alternating with reading a column: medians of CPU time and of ratios."""
    world = World(seed=1, progress="off", threads=1)
    gas = world.system("gas")
    box = (0, 0, 0), (SIZE, SIZE, SIZE)
    gas.configure(velocity=Sphere((0, 0, 0), 1))
    with world:
        gas.burst(Box(*box), count=particles)
        gas.move()
        world.step()
        kinds = _kinds(gas, box)
        taken: dict[str, list[float]] = {name: [] for name in ("read", *kinds)}
        with gas.local() as here:
            plane = here.velocity[:, 0]
            for _ in range(repeats):
                taken["read"].append(_seconds(lambda: plane.max()))
                for name, call in kinds.items():
                    taken[name].append(_seconds(call))
    figures: dict[str, Any] = {"particles": particles, "repeats": repeats}
    for name, seconds in taken.items():
        figures[f"{name}_ns"] = 1e9 * statistics.median(seconds) / particles
    ratios = [total / read for total, read in zip(taken["total"], taken["read"], strict=True)]
    return {**figures, "total_by_read": statistics.median(ratios)}


def _kinds(gas: System, box: tuple[Any, Any]) -> dict[str, Callable[[], Any]]:
    v = column("velocity")
    return {
        "total": lambda: gas.total(v.x),
        "energy": lambda: gas.total(0.5 * (v.x * v.x + v.y * v.y + v.z * v.z)),
        "total_where": lambda: gas.total(v.x, where=v.y > 0),
        "histogram": lambda: gas.histogram(v.x, np.linspace(-1, 1, BINS + 1)),
        "weighted_histogram": lambda: gas.histogram(v.x, np.linspace(-1, 1, BINS + 1), weights=v.y),
        "tally": lambda: gas.tally(*box, CELLS),
        "weighted_tally": lambda: gas.tally(*box, CELLS, weights=v.x),
    }


def _seconds(call: Callable[[], Any]) -> float:
    start = time.thread_time()
    call()
    return time.thread_time() - start
