"""Measures the cost of checkpoints: how long a frame waits, and how long a thread writes meanwhile."""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

from motes import Checkpoint, World
from motes.errors import ArgumentError

from .._engine import session_of
from . import falling

__all__ = ["checkpoint"]


def checkpoint(*, particles: int, systems: int, every: int, repeats: int) -> dict[str, Any]:
    """Time frames of falling particles with pictures, and checkpoints every `every` frames.

    Returns medians of wall time. Ordinary frames are those during which nothing is written; `every=1` has
    none and raises ArgumentError.
    """
    if every < 2:
        raise ArgumentError(
            "--every", every, "a whole number >= 2, since frames with and without a checkpoint are compared"
        )
    with tempfile.TemporaryDirectory(prefix="motes-bench-") as place:
        directory = Path(place) / "checkpoints"
        waited, plain, beside, written = _run(directory, particles, systems, every, repeats)
        size = sum(file.stat().st_size for file in max(directory.glob("frame-??????")).iterdir())
        copied = _plain_write(Path(place) / "plain", size)
    frame_s, wait_s = statistics.median(plain), statistics.median(waited)
    longer_s = sum(beside) - frame_s * len(beside)
    each_s = wait_s + max(0.0, longer_s) / repeats
    return {
        "particles": particles * systems,
        "every": every,
        "frame_ms": 1e3 * frame_s,
        "wait_ms": 1e3 * wait_s,
        "write_ms": 1e3 * statistics.median(written),
        "plain_write_ms": 1e3 * copied,
        "megabytes": size / 1e6,
        "percent_of_frames": 100 * wait_s / (every * frame_s),
        "percent_with_writing": 100 * each_s / (every * frame_s),
    }


def _run(
    directory: Path, particles: int, systems: int, every: int, repeats: int
) -> tuple[list[float], list[float], list[float], list[float]]:
    """Return the seconds of waits at borders, ordinary frames, frames during a write, and whole writes."""
    where = Checkpoint(directory, every=every)
    world = World(seed=1, space=falling.SPACE, renderer=falling.renderer(), progress="off", checkpoint=where)
    layers = [world.system(f"layer {i}") for i in range(systems)]
    waited: list[float] = []
    plain: list[float] = []
    beside: list[float] = []
    written: list[float] = []
    with world:
        border = time.perf_counter()
        begun = 0.0
        for frame in world.frames((repeats + 1) * every):
            start = time.perf_counter()
            due = frame > 0 and frame % every == 0
            if due:
                waited.append(start - border)
                if begun:  # this border waited for the end of the last write
                    written.append(start - begun)
                begun = start
            for layer in layers:
                falling.fall(layer, frame, particles)
            world.render()
            border = time.perf_counter()
            busy = session_of(world).engine_for("bench").part_outcome()[0]
            if begun and not busy:
                written.append(border - begun)
                begun = 0.0
            if frame > 0:
                (beside if due or busy else plain).append(border - start)
    return waited, plain, beside, written


def _plain_write(path: Path, size: int) -> float:
    """Return the seconds that it takes to write `size` bytes to the disk in one piece."""
    content = bytes(size)
    start = time.perf_counter()
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    return time.perf_counter() - start
