"""Measures the cost of interactions between particles: `python -m motes bench meetings`.

The scene is a jittered lattice with seven neighbours within reach of each particle. In each sub-step an
interaction sorts all particles into cells and sums over neighbours; other actions take a few nanoseconds.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from motes.expressions import a, dot, normal, r, relative_velocity

from .._engine import simd

if TYPE_CHECKING:
    from motes import System

__all__ = ["lattice", "meetings"]

REACH = 1.25
"""Reach in lattice spacings: about seven other particles are within it."""

SPRING = 1e3 * (r - REACH) + 10 * dot(relative_velocity, normal)
"""A linear spring and dashpot, N for 1 kg."""

ACTIONS: dict[str, Callable[[System], None]] = {
    "gravitate": lambda s: s.gravitate(magnitude=1e-3, epsilon=0.01, max_radius=REACH),
    "match_velocity": lambda s: s.match_velocity(magnitude=1e-3, epsilon=0.01, max_radius=REACH),
    "collide": lambda s: s.collide(radius=REACH / 2),
    "collide, restitution": lambda s: s.collide(radius=REACH / 2, restitution=0.5),
    "collide, own radii": lambda s: s.collide(),
    "contact": lambda s: s.contact(1e3, rolling_friction=0.1, radius=REACH / 2),
    "interact": lambda s: s.interact(REACH, acceleration=SPRING * normal / a.mass),
    "interact, state": lambda s: s.interact(
        REACH,
        acceleration=SPRING * normal / a.mass + 300 * a.state.slip,
        state={"slip": 3},
        set={"slip": a.state.slip + 1e-3 * (relative_velocity - normal * dot(relative_velocity, normal))},
    ),
    "fluid": lambda s: s.fluid(radius=2.0, rest_density=1.0),
}


def lattice(particles: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return positions and velocities: a cubic lattice of unit spacing, jittered by up to 0.35."""
    rng = np.random.default_rng(7)
    side = int(np.ceil(particles ** (1 / 3)))
    places = np.arange(particles)
    cells = np.stack([places // (side * side) - side // 2, places // side % side, places % side], -1)
    position = (cells + rng.uniform(-0.35, 0.35, cells.shape)).astype(np.float32)
    return position, rng.uniform(-0.35, 0.35, cells.shape).astype(np.float32)


def meetings(*, particles: int, repeats: int) -> dict[str, Any]:
    """Measure each action on one rank and one thread: the median processor time."""
    from motes import World

    position, velocity = lattice(particles)
    rows = []
    pairs = 0.0
    with World(seed=1, dt=1e-3, progress="off", threads=1) as world:
        system = world.system("lattice")
        system.emit(position=position, velocity=velocity, size=np.full((particles, 3), REACH, np.float32))
        world.step()
        for name, record in ACTIONS.items():
            times = []
            for _ in range(repeats):
                start = time.process_time()
                record(system)
                world.step()
                times.append(time.process_time() - start)
            rows.append({"action": name, "ns": statistics.median(times) / particles * 1e9})
            if name == "collide":
                pairs = float(np.mean(system.gather().contacts))
    return {
        "particles": particles,
        "neighbours": pairs,
        "repeats": repeats,
        "simd": simd(),
        "rows": rows,
    }
