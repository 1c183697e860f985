"""Replays of another code's tasks: a row that policies cut between tasks, weighed by their seconds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..balance import Balancer
from ..balance._options import checked_powers
from ..errors import ArgumentError
from .density import Density
from .frames import simulate
from .history import Floats, Moment
from .predict import Row, add_rows

if TYPE_CHECKING:
    from .._interchange.task_loads import TaskLoads

__all__ = ["Phases", "predict_tasks"]


class Phases:
    """The history of tasks: a task is as many particles at one place as it takes `particle_s` on a machine.

    What a balancer learns from a phase, it uses for the next one.

    Attributes:
        ranks: all ranks of the other code.
        systems: name of the only system.
        axes: axis of the row.
        frames: numbers of the phases.
    """

    def __init__(self, loads: TaskLoads, speeds: npt.ArrayLike | None = None) -> None:
        """Set the tasks and the machines.

        Args:
            loads: the tasks.
            speeds: particles per second of each calculator; None: those of the other code's ranks.
        """
        self._loads = loads
        self._speeds = np.full(loads.ranks, 1 / loads.particle_s) if speeds is None else np.asarray(speeds)
        count = len(self._speeds)
        self.ranks, self.systems, self.axes, self.frames = (
            list(range(count)),
            [loads.system],
            ["x"],
            loads.phases,
        )
        self._cuts = loads.cuts
        if count != loads.ranks:
            even = np.arange(1, count) / count
            self._cuts = np.rint(even * len(loads.first)).astype(np.float32)

    def moment(self, k: int, system: int) -> Moment:
        """Return the k-th phase.

        Args:
            k: index of the phase.
            system: index of the system.
        """
        return Moment(
            density=Density.in_cells(counts(self._loads, k)),
            births=Density.none(),
            killed=0,
            cuts=self._cuts,
            speeds=self._speeds,
            overhead_s=np.zeros(len(self._speeds)),
            fixed_s=fixed_s(self._loads, k, self._speeds),
            renewed=True,
        )


def counts(loads: TaskLoads, k: int) -> npt.NDArray[np.int64]:
    """Return each task's particles in the k-th phase, (tasks,)."""
    found: npt.NDArray[np.int64] = np.rint(loads.task_s[k] / loads.particle_s).astype(np.int64)
    return found


def fixed_s(loads: TaskLoads, k: int, speeds: Floats) -> Floats:
    """Return the seconds of the tasks that cannot migrate, (calculators,), on machines of these speeds.

    Raises ArgumentError if there are such tasks, and the machines are not as many as the ranks.
    """
    if len(speeds) == loads.ranks:
        seconds: Floats = loads.fixed_s[k] / (speeds * loads.particle_s)
        return seconds
    if loads.fixed_s.any():
        raise ArgumentError(
            "speeds", f"{len(speeds)} machines", f"{loads.ranks}, for the tasks that belong to their rank"
        )
    return np.zeros(len(speeds))


def predict_tasks(
    loads: TaskLoads, balancer: Balancer, *, powers: Sequence[float] | None = None
) -> dict[str, list[Row]]:
    """Predict the phases of another code under a balancer. A phase takes as long as its slowest rank.

    Args:
        loads: the tasks.
        balancer: the balancer.
        powers: the machines' powers, one per rank on any scale, if they differ: a task that took a second on
            one machine takes half of one on a machine with twice its power. None: all are equal.

    Returns:
        Rows of "frames", "load", "density" and "balance".

    Raises:
        ArgumentError: for a wrong argument.
    """
    if not isinstance(balancer, Balancer):
        raise ArgumentError("balancer", balancer, "a Balancer")
    speeds = None
    if powers is not None:
        known = np.array(checked_powers(powers, above=True))
        if len(known) != loads.ranks:
            raise ArgumentError("powers", powers, f"{loads.ranks} numbers, one per rank")
        loads, speeds = loads.on_machines(known / known.mean()), known / known.mean() / loads.particle_s
    history = Phases(loads, speeds)
    rows: dict[str, list[Row]] = {"frames": [], "load": [], "density": [], "balance": []}
    for step in simulate(history, balancer):
        seconds = {
            name: float(step.seconds.max()) for name in ("t_frame_s", "t_frame_low_s", "t_frame_high_s")
        }
        add_rows(rows, history, step, repr(balancer), recorded=seconds)
    return rows
