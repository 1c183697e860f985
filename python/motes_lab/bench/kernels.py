"""Benchmarks of the C++ core on one processor core: kernels, births, the picture. No MPI.

Figures are the median or the minimum of several repeats, in CPU time of this thread, to reduce the effect of
other programs. Ratios compare figures of one run.
"""

from __future__ import annotations

import platform
from pathlib import Path
from typing import Any

from .. import compiled
from .._engine import simd

__all__ = ["actions", "births", "leavers", "lists", "meshes", "render", "scale", "scene", "scenery"]


def scene(name: str, *, particles: int, steps: int) -> dict[str, Any]:
    """Time the list of "snow" or "fountain", and compare it with the limit of memory bandwidth."""
    figures = compiled.act_bench(name, particles, steps)
    return {"scene": name, "particles": particles, "steps": steps, **_one_core(), **figures}


def actions(*, particles: int, repeats: int) -> dict[str, Any]:
    """Time each action, by itself and added to a list."""
    return {
        "machine": _machine(),
        "particles": particles,
        "repeats": repeats,
        **_one_core(),
        "actions": compiled.action_bench(particles, repeats),
    }


def meshes(*, particles: int, repeats: int) -> dict[str, Any]:
    """Time bounces off a mesh of 10,000 triangles and off a sphere, and building the mesh's grid."""
    return {
        "particles": particles,
        "repeats": repeats,
        **_one_core(),
        **compiled.mesh_bench(particles, repeats),
    }


def births(*, calculators: int, births: int, repeats: int) -> dict[str, Any]:
    """Time the work per birth of the calculators that create and pass on births."""
    figures = compiled.birth_bench(calculators, births, repeats)
    return {"calculators": calculators, "births": births, "repeats": repeats, **_one_core(), **figures}


def lists(*, particles: int, steps: int) -> dict[str, Any]:
    """Compare lists of four to twelve actions, with and without random numbers, with memory bandwidth."""
    return {
        "particles": particles,
        "steps": steps,
        **_one_core(),
        **compiled.list_bench(particles, steps),
    }


def scale(*, particles: int, steps: int) -> dict[str, Any]:
    """Time snow with 1, 3, 10, 30, ... million particles, in turn: a slow moment affects all sizes.

    Also time only the loads and stores, the lower limit, which drops if a cache holds the particles.
    """
    sizes = sorted({min(n * 10**k, particles) for n in (1, 3) for k in range(6, 9)})
    cost: dict[int, list[float]] = {n: [] for n in sizes}
    limit: dict[int, list[float]] = {n: [] for n in sizes}
    for _ in range(3):
        for n in sizes:
            figures = compiled.act_bench("snow", n, max(steps, 10_000_000 // n))
            cost[n].append(1e9 / figures["updates_per_s"])
            limit[n].append(1e9 / figures["memory_limit_updates_per_s"])
    least = {n: min(ns) for n, ns in cost.items()}
    return {
        "scene": "snow",
        **_one_core(),
        **{f"ns_per_particle_{n}": ns for n, ns in least.items()},
        **{f"memory_limit_ns_{n}": min(ns) for n, ns in limit.items()},
        "largest_by_least": max(least.values()) / min(least.values()),
    }


def leavers(*, particles: int, bins: int, steps: int) -> dict[str, Any]:
    """Time several ways to find the particles that have left a domain."""
    seconds = compiled.leaver_bench(particles, bins, steps)
    return {
        "particles": particles,
        "bins": bins,
        "simd": simd(),
        **{f"{way.removesuffix('_s')}_ns_per_particle": 1e9 * s / particles for way, s in seconds.items()},
    }


def render(
    *, particles: int, size: tuple[int, int], pixels: int, frames: int, fountain: bool
) -> dict[str, Any]:
    """Time a whole frame: project, splat, tone map."""
    return compiled.render_bench(particles, *size, pixels, frames, fountain)


def scenery(*, size: tuple[int, int], frames: int) -> dict[str, Any]:
    """Time pictures of solids without particles: the camera moves around shapes and a mesh; a light moves."""
    return compiled.scenery_bench(*size, frames)


def _one_core() -> dict[str, Any]:
    return {"cores": 1, "simd": simd()}


def _machine() -> str:
    """Name the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
