"""Measures Python's cost per frame: a script's recording calls, and a frame without particles."""

from __future__ import annotations

import statistics
import time
from typing import Any

from motes import System, World
from motes.shapes import Box, Plane

__all__ = ["recording"]

ACTIONS = 12


def recording(*, systems: int, frames: int) -> dict[str, Any]:
    """Time the calls of a frame, and the frame without particles, in CPU time of this thread."""
    world = World(seed=1, dt=1 / 24, progress="off")
    made = [world.system(f"system {i}") for i in range(systems)]
    calls, steps = [], []
    with world:
        for _ in world.frames(frames):
            start = time.thread_time()
            for system in made:
                _record(system)
            called = time.thread_time()
            world.step()
            calls.append(called - start)
            steps.append(time.thread_time() - called)
    return {
        "systems": systems,
        "actions": ACTIONS * systems,
        "frames": frames,
        "calls_ms": 1e3 * statistics.median(calls),
        "empty_step_ms": 1e3 * statistics.median(steps),
    }


_GUST = Box((-2, -1, -2), (2, 1, 2))
_GROUND = Plane((0, 0, 0), (0, 1, 0))
_FAR = Box((90, 90, 90), (91, 91, 91))


def _record(s: System) -> None:
    """Record twelve actions."""
    s.gravity((0, -9.81, 0))
    s.random_acceleration(_GUST)
    s.damping((0.9, 0.9, 0.9))
    s.wind((1, 0, 0), drag=0.5)
    s.orbit_point((0, 5, 0), magnitude=1, epsilon=0.1)
    s.target_color((1, 0.5, 0.2), alpha=1, scale=0.5)
    s.speed_clamp(max_speed=10)
    s.bounce(_GROUND, restitution=0.5)
    s.sink(_FAR)
    s.sink_velocity(_FAR)
    s.kill_old(10)
    s.move()
