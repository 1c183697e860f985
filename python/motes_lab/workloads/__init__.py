"""Loads with known solutions, for comparing balancers: all particle positions and the best cuts.

To play one in a script::

    pic = motes.workloads.Pic("geometric", cells=64, particles=10_000)
    world = motes.World(**pic.world)
    system = world.system("particles")
    with world:
        for frame in world.frames(20):
            pic.step(system, frame)
            world.step()
        assert pic.verify(system.gather(to="all"), 20)

Each provides `counts(frame)`, `optimum(frame, speeds)` and the methods used in this script; `python -m motes
arena` plays balancers on them. `Tasks` has what another code measured; no script plays it.
"""

from __future__ import annotations

from typing import Any

from motes.errors import missing

from .._engine import arguments
from .base import Workload
from .history import Planned
from .loads import HotSpots, Noise, SlowRank, Step, Wave
from .optimum import Best, best_cuts
from .pic import DISTRIBUTIONS, Pic
from .tasks import Tasks

__all__ = [
    "WORKLOADS",
    "Best",
    "HotSpots",
    "Noise",
    "Pic",
    "Planned",
    "SlowRank",
    "Step",
    "Tasks",
    "Wave",
    "Workload",
    "best_cuts",
    "workload",
]

_KINDS = {kind.name: kind for kind in (Step, Wave, HotSpots, SlowRank, Noise)}
WORKLOADS = (*_KINDS, *(f"pic_{name}" for name in DISTRIBUTIONS))
"""The names of all workloads."""


def workload(name: str, *, frames: int = 60, cells: int = 1000, particles: int = 200_000) -> Workload:
    """Make a workload by name.

    Args:
        name: one of `WORKLOADS`.
        frames: number of frames.
        cells: number of cells in the row; for "pic_...", along each side.
        particles: total number of particles.

    Returns:
        The workload.
    """
    arguments.choice("workload", name, WORKLOADS)
    if name in _KINDS:
        return _KINDS[name](frames=frames, cells=cells, particles=particles)
    distribution: Any = name.removeprefix("pic_")
    return Pic(distribution, frames=frames, cells=cells, particles=particles)


def __getattr__(name: str) -> Any:
    raise missing("motes.workloads", name, __all__)


def __dir__() -> list[str]:
    return [*__all__]
