"""Measures the cost of exports: the copy that a frame waits for, and each format's files."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from motes import Uniform, World
from motes._interchange.formats import FORMATS
from motes.errors import MissingExtraError
from motes.shapes import Box, Sphere

from .._engine import session_of

__all__ = ["export"]

FRAMES = 12
COLUMNS = ("position", "velocity", "color", "alpha", "size", "age")


def export(*, particles: int, repeats: int) -> dict[str, Any]:
    """Time each format, alternating with a plain write of the same bytes; medians of processor time."""
    columns, copy_s = _particles(particles, repeats)
    formats, missing = [], []
    for format in FORMATS.values():
        try:
            format.require()
        except MissingExtraError as error:
            missing.append(error.name)
        else:
            formats.append(format)
    taken: dict[str, list[float]] = {format.kind: [] for format in formats}
    ratios: dict[str, list[float]] = {format.kind: [] for format in formats}
    size: dict[str, int] = {}
    with tempfile.TemporaryDirectory(prefix="motes-bench-") as folder:
        for format in formats:  # not timed: the first write imports packages
            format.write(Path(folder) / "first", columns, frame=0, time=0.0)
        for _ in range(repeats):
            for format in formats:
                path = Path(folder) / f"part.{format.kind}"
                taken[format.kind].append(_seconds(partial(format.write, path, columns, frame=0, time=0.0)))
                size[format.kind] = path.stat().st_size
                plain = _seconds(partial((Path(folder) / "plain").write_bytes, path.read_bytes()))
                ratios[format.kind].append(taken[format.kind][-1] / plain)
    million = len(columns["id"]) / 1e6
    rows = [
        {
            "format": kind,
            "ms": 1e3 * statistics.median(seconds) / million,
            "megabytes": size[kind] / 1e6 / million,
            "by_plain": statistics.median(ratios[kind]),
        }
        for kind, seconds in taken.items()
    ]
    facts = {"particles": len(columns["id"]), "repeats": repeats, "columns": [*COLUMNS, "id"]}
    return {**facts, "copy_ms": 1e3 * copy_s / million, "rows": rows, "not_installed": missing}


def _particles(count: int, repeats: int) -> tuple[dict[str, NDArray[Any]], float]:
    """Return columns of particles in unsorted order, after some time, and the seconds of their copy."""
    world = World(seed=1, dt=1 / FRAMES, progress="off", threads=1)
    snow = world.system("snow")
    snow.configure(
        velocity=Sphere((0, 0, 0), 1),
        color=Uniform((0, 0, 0), (1, 1, 1)),
        alpha=Uniform(0, 1),
        size=Uniform((0, 0, 0), (1, 1, 1)),
        lifetime=Uniform(0.2, 1),
    )
    with world:
        for frame in world.frames(2 * FRAMES):
            if frame == 0:
                snow.burst(Box((0, 0, 0), (1, 1, 1)), count=count // 2)
            snow.source(Box((0, 0, 0), (1, 1, 1)), rate=1.6 * count)
            snow.move()
            snow.kill_expired()
            world.step()
        engine = session_of(world).engine_for("bench")
        (system,) = session_of(world).systems
        indices = [list(system.attributes).index(name) for name in COLUMNS]
        seconds = []
        for _ in range(repeats):
            start = time.thread_time()
            arrays = engine.copy_columns(system.index, indices)
            seconds.append(time.thread_time() - start)
    return dict(zip((*COLUMNS, "id"), arrays, strict=True)), statistics.median(seconds)


def _seconds(call: Callable[[], Any]) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start
