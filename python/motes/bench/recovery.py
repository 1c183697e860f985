"""What it costs that the loss of a rank is survived, and how long one takes: a job on several ranks."""

from __future__ import annotations

import json
import os
import signal
import statistics
import sys
import time
from typing import Any

from .._run.recovering import EVERY
from ..rendering import Camera, Renderer
from ..shapes import Box, Plane
from ..world import World

__all__ = ["recovery"]

_BESIDE = 3  # frames that copies may lengthen: they are made, travel, and arrive


def recovery(*, particles: int, systems: int, ranks: int, repeats: int) -> dict[str, Any]:
    """Run frames of falling particles with pictures; medians of wall time on the image generator.

    Copies of all particles are made every `EVERY` frames; at the end the last rank is killed.
    """
    from .jobs import figures_of

    sizes = [str(particles), str(systems), str(repeats)]
    return figures_of("motes.bench.recovery", ranks, sizes, survive=True)


def _figures(border_s: list[float], lost_s: float, particles: int, ranks: int) -> dict[str, Any]:
    """Say how much longer frames are beside copies, as a part of all frames."""
    cycles = [border_s[start : start + EVERY] for start in range(EVERY, len(border_s) - EVERY + 1, EVERY)]
    plain_s = statistics.median(seconds for cycle in cycles for seconds in cycle[_BESIDE:-1])
    # The frame at whose end copies are made is the last one of a cycle.
    beside_s = [sum(cycle[:_BESIDE]) + cycle[-1] - (_BESIDE + 1) * plain_s for cycle in cycles]
    return {
        "particles": particles,
        "ranks": ranks,
        "every": EVERY,
        "frame_ms": 1e3 * plain_s,
        "copies_ms": 1e3 * statistics.median(beside_s),
        "percent_of_frames": 100 * statistics.median(beside_s) / (EVERY * plain_s),
        "recovery_ms": 1e3 * lost_s,
    }


def _run(particles: int, systems: int, repeats: int) -> None:
    renderer = Renderer(1920, 1080, camera=Camera((0, 4, 40), (0, 4, 0)))
    world = World(
        seed=1, space=(-20, 20), roles="shared", renderer=renderer, progress="off", on_loss="recover"
    )
    layers = [world.system(f"layer {i}") for i in range(systems)]
    border_s: list[float] = []
    with world:
        ranks, last = world.size, world.rank == world.size - 1
        frames = (repeats + 1) * EVERY + EVERY // 2
        for frame in world.frames(frames + 1):
            for layer in layers:
                if frame == 0:
                    layer.burst(Box((-20, 0, -5), (20, 12, 5)), count=particles)
                layer.gravity((0, -2, 0))
                layer.random_acceleration(Box((-1, -1, -1), (1, 1, 1)))
                layer.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=0.6)
                layer.move()
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
