"""The settings of a run: one frozen value, which all ranks compare, the core gets and the log keeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Self

from .._values import environment
from .._values.checkpoint import Checkpoint
from .._values.live import Live
from .._values.space import Period, ends_of
from ..balance import policy_of

__all__ = ["RunSettings"]

_NOT_COMPARED = ("speeds", "stall_s", "threads")  # of this machine


class RunSettings(NamedTuple):
    """The arguments of a World, checked; the environment has taken precedence."""

    seed: int | None
    """None before the ranks have agreed on the one that rank 0 draws."""
    dt: float
    substeps: int
    axis: str
    space: tuple[float, float] | str | None
    periodic: tuple[Period, ...]
    roles: tuple[int, int, Sequence[int]]
    """Manager, image generator, calculators: ranks."""
    balancer: Any
    """One of motes.balance, whose policy the core takes."""
    combine: str
    births: str
    fan_out: int
    skin: float | None
    """Of kept neighbour lists, as a part of how far a law sees; None: what is cheapest."""
    threads: int | None
    """Of this rank; None: its share of the processors, once the ranks have met."""
    clock: str
    digest: bool
    log: str | None
    spans: bool
    speeds: Mapping[int, float]
    """Ranks that behave like slower machines."""
    stall_s: float | None
    """Seconds without an answer after which a rank gives up, whatever lives; None: no limit was set."""

    checkpoint: Checkpoint | None = None
    on_loss: str = "stop"
    live: Live | None = None
    crowded: bool = False
    """Whether a host has fewer processors than ranks, once the ranks have met."""
    steering: str | None = None
    """A steer.jsonl of the run that this one repeats."""
    continued_from: int = 0
    """The first frame still to do of a run that goes on after another one, in its log; 0: a new run."""

    def agreed(self, *, seed: int, threads: int, continued_from: int, crowded: bool) -> Self:
        """Return the same with what is known once the ranks have met."""
        return self._replace(seed=seed, threads=threads, continued_from=continued_from, crowded=crowded)

    def of_roles(self, roles: tuple[int, int, Sequence[int]], speeds: Mapping[int, float]) -> Self:
        """Return the same with other roles, before the run."""
        return self._replace(roles=roles, speeds=speeds)

    def of_those_left(self, roles: tuple[int, int, Sequence[int]], survivors: Sequence[int]) -> Self:
        """Return the same for those that are left: their roles; `survivors` are their ranks of before."""
        speeds = {now: self.speeds[then] for now, then in enumerate(survivors) if then in self.speeds}
        return self._replace(roles=roles, speeds=speeds)

    def compared(self) -> dict[str, str]:
        """Return what must be equal on all ranks, by name, as text."""
        values: dict[str, object] = {
            name: one for name, one in self._asdict().items() if name not in _NOT_COMPARED
        }
        values["roles"] = _roles(self.roles)
        values["periodic"] = ends_of(self.periodic)
        kind = type(self.balancer)
        # The repr of a user's class may hold an address; its `decide` runs on the manager only.
        ours = kind.__module__.partition(".")[0] == __package__.partition(".")[0]
        values["balancer"] = repr(self.balancer) if ours else kind.__qualname__
        return {name: str(value) for name, value in values.items()}

    def for_core(self, *, rank: int, hosts: Sequence[str]) -> dict[str, Any]:
        """Return what `_core.Engine` takes as `facts` on a rank; `hosts`: the host of each rank."""
        return {
            "seed": self.seed,
            "dt": self.dt,
            "substeps": self.substeps,
            "digest": self.digest,
            "log": self.log or "",
            "hosts": list(hosts),
            "policy": policy_of(self.balancer),
            "combine": self.combine,
            # Ranks that take turns wait long for each other, so one of them creates all births.
            "births": "manager" if self.births == "auto" and self.crowded else self.births,
            "fan_out": self.fan_out,
            "threads": self.threads,
            "grain": environment.grain(),
            "skin": self.skin,
            "shares_pictures": environment.shares_pictures(),
            "clock": self.clock,
            "speed": self.speeds.get(rank, 1.0),
            "spans": self.spans,
            "continued_from": self.continued_from,
        }

    def for_log(self) -> dict[str, Any]:
        """Return what run.json and a recorded scene say about the run."""
        manager, image_generator, calculators = self.roles
        return {
            "seed": self.seed,
            "dt_s": self.dt,
            "substeps": self.substeps,
            "axis": self.axis,
            "space": self.space,
            "periodic": ends_of(self.periodic),
            "balancer": repr(self.balancer),
            "combine": self.combine,
            "births": self.births,
            "fan_out": self.fan_out,
            "clock": self.clock,
            "speeds": {str(rank): speed for rank, speed in sorted(self.speeds.items())},
            "manager": manager,
            "image_generator": image_generator,
            "calculators": list(calculators),
        }


def _roles(roles: tuple[int, int, Sequence[int]]) -> str:
    manager, image_generator, calculators = roles
    ranks = ", ".join(map(str, calculators))
    return f"manager {manager}, image generator {image_generator}, calculators [{ranks}]"
