"""Measures the cost of surviving the loss of a rank, and the time of a recovery: a job on several ranks."""

from __future__ import annotations

import json
import os
import signal
import statistics
import sys
import time
from typing import Any

from motes import World
from motes._world.recovering import EVERY

from . import falling

__all__ = ["recovery"]

_BESIDE = 3  # frames that replicas may lengthen: creation, transfer, arrival


def recovery(*, particles: int, systems: int, ranks: int, repeats: int) -> dict[str, Any]:
    """Time frames of falling particles with pictures: medians of wall time on the image generator.

    All particles are replicated every `EVERY` frames; at the end the last rank is killed.
    """
    from .jobs import figures_of

    sizes = [str(particles), str(systems), str(repeats)]
    return figures_of("motes_lab.bench.recovery", ranks, sizes, survive=True)


def _figures(border_s: list[float], lost_s: float, particles: int, ranks: int) -> dict[str, Any]:
    """Return how much replicas lengthen frames, in ms and as a percentage of all frames."""
    cycles = [border_s[start : start + EVERY] for start in range(EVERY, len(border_s) - EVERY + 1, EVERY)]
    plain_s = statistics.median(seconds for cycle in cycles for seconds in cycle[_BESIDE:-1])
    # Replicas are made at the end of the last frame of a cycle.
    beside_s = [sum(cycle[:_BESIDE]) + cycle[-1] - (_BESIDE + 1) * plain_s for cycle in cycles]
    return {
        "particles": particles,
        "ranks": ranks,
        "every": EVERY,
        "frame_ms": 1e3 * plain_s,
        "replicas_ms": 1e3 * statistics.median(beside_s),
        "percent_of_frames": 100 * statistics.median(beside_s) / (EVERY * plain_s),
        "recovery_ms": 1e3 * lost_s,
    }


def _run(particles: int, systems: int, repeats: int) -> None:
    world = World(
        seed=1, space=falling.SPACE, roles="shared", renderer=falling.renderer(), progress="off",
        on_loss="recover",
    )  # fmt: skip
    layers = [world.system(f"layer {i}") for i in range(systems)]
    border_s: list[float] = []
    with world:
        ranks, last = world.size, world.rank == world.size - 1
        frames = (repeats + 1) * EVERY + EVERY // 2
        for frame in world.frames(frames + 1):
            for layer in layers:
                falling.fall(layer, frame, particles)
            if frame == frames and last and ranks > 1:
                os.kill(os.getpid(), signal.SIGKILL)
            start = time.perf_counter()
            world.render()
            border_s.append(time.perf_counter() - start)
        figures = _figures(border_s[:frames], border_s[frames], particles * systems, ranks)
        if "image_generator" in world.role:
            print(json.dumps(figures), flush=True)


if __name__ == "__main__":
    _run(*map(int, sys.argv[1:]))
