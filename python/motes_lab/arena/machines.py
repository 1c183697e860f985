"""Virtual machines for the arena: the speeds of ranks, and the costs of moving particles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from motes.errors import ArgumentError

from .._engine import arguments
from ..cluster import Cluster, Modern, Node
from ..cluster.machines import described
from ..cluster.paper import model
from ..cluster.paper.tables import IN_TEXT, Cell
from ..cluster.simulate import MEASURED_COSTS, costs_of

__all__ = ["MACHINES", "Machine", "machine"]

ACTIONS = ("gravity", "random_acceleration", "bounce", "kill_old", "move")
"""Actions on each particle of the paper's snow in a frame."""
BYTES = 60
"""Bytes per particle in a message: position, velocity, orientation, age, id and the birth's key."""


@dataclass(frozen=True)
class Machine:
    """A virtual machine: ranks in the order of their domains, all of which are calculators.

    Attributes:
        name: the machine's name.
        speeds: speed of each rank, relative to the processor on which the costs were measured.
        particle_s: seconds for the actions on one particle at speed 1.
        leave_s: seconds to remove and pack a particle at speed 1.
        arrive_s: seconds to unpack and add a particle at speed 1.
        byte_s: seconds per byte on a rank's link.
        message_s: seconds per message between two ranks.
    """

    name: str
    speeds: tuple[float, ...]
    particle_s: float
    leave_s: float
    arrive_s: float
    byte_s: float
    message_s: float

    def __post_init__(self) -> None:
        """Check the fields."""
        if not self.speeds:
            raise ArgumentError("speeds", self.speeds, "one number per rank")
        for speed in self.speeds:
            arguments.number("speeds", speed, low=1e-9)
        arguments.number("particle_s", self.particle_s, low=1e-15)
        for cost in ("leave_s", "arrive_s", "byte_s", "message_s"):
            arguments.number(cost, getattr(self, cost), low=0)

    @property
    def move_cost(self) -> float:
        """Cost of moving a particle, mean of both ends, in units of its actions' time per frame."""
        return ((self.leave_s + self.arrive_s) / 2 + BYTES * self.byte_s) / self.particle_s

    @staticmethod
    def of(
        name: str, cluster: Cluster, costs: str | None = None, actions: Sequence[str] = ACTIONS
    ) -> Machine:
        """Return the machine that represents a virtual cluster.

        Args:
            name: the machine's name.
            cluster: nodes and networks; only the first network is used.
            costs: costs of work at speed 1, as lines `name = nanoseconds`; None: measured on a Xeon.
            actions: actions on each particle in a frame.
        """
        found = costs_of(MEASURED_COSTS.read_text() if costs is None else costs)
        network = cluster.networks[0]
        each = [node.rank_speed for _, node in cluster.hosts() for _ in range(node.started)]
        return Machine(
            name,
            tuple(each),
            sum(found.get(f"action.{action}", found.get("action", 0.0)) for action in actions),
            found["leave"],
            found["arrive"],
            1 / network.bandwidth,
            network.latency_s + 2 * network.overhead_s,
        )


def _paper() -> Machine:
    cell = Cell(IN_TEXT, "snow", "myrinet", "gcc", "8*B(16)+8*A(16)", 32, "FS-DLB", math.nan)
    return Machine.of("paper", model.cluster(cell), model.costs("motes"))


def _two_kinds() -> Machine:
    nodes = [Node("new", 1.0, cores=4, count=2), Node("old", 0.4, cores=4, count=2)]
    return Machine.of("two_kinds", Cluster(nodes, Modern()))


def _thousand() -> Machine:
    nodes = [Node("new", 1.0, cores=32, count=24), Node("old", 0.6, cores=32, count=8)]
    return Machine.of("thousand", Cluster(nodes, Modern()), actions=(*ACTIONS, "collide"))


MACHINES: dict[str, Callable[[], Machine]] = {
    "paper": _paper,
    "two_kinds": _two_kinds,
    "thousand": _thousand,
}
"""Machines by name: the paper's 8 B and 8 A nodes with two ranks each; 16 ranks of two kinds, where moving a
particle costs as much as a dozen frames of its actions; 1024 ranks, where particles collide."""


def machine(name: str) -> Machine:
    """Return a virtual machine by name, or from a file that defines `cluster = motes.cluster.Cluster(...)`.

    Args:
        name: one of `MACHINES`, or a path that ends in .py.
    """
    if name in MACHINES:
        return MACHINES[name]()
    path = Path(name)
    if path.suffix != ".py":
        allowed = f"{', '.join(MACHINES)}, or a file.py that sets cluster = motes.cluster.Cluster(...)"
        raise ArgumentError("cluster", name, allowed, known=MACHINES)
    return Machine.of(path.stem, described(path))
