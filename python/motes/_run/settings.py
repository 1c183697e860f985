"""The settings of a run: one immutable value that ranks compare, and that core and log get."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Self

from .._values import environment
from .._values.checkpoint import Checkpoint
from .._values.live import Live
from .._values.space import Period, ends_of
from ..balance import policy_of
from .excerpt import Excerpt

__all__ = ["RunSettings"]

_NOT_COMPARED = ("speeds", "stall_s", "threads")  # these may differ between machines


class RunSettings(NamedTuple):
    """The checked arguments of a World, after environment variables have taken precedence."""

    seed: int | None
    """The seed; None before the ranks have agreed on the seed that rank 0 draws."""
    dt: float
    substeps: int
    axis: str
    space: tuple[float, float] | str | None
    periodic: tuple[Period, ...]
    roles: tuple[int, int, Sequence[int]]
    """The ranks of the manager, the image generator and the calculators."""
    balancer: Any
    """A balancer of motes.balance."""
    combine: str
    births: str
    fan_out: int
    skin: float | None
    """The skin of neighbour lists as a fraction of a law's reach; None: the cheapest."""
    threads: int | None
    """The number of this rank's threads; None: its share of the processors, set after the handshake."""
    clock: str
    digest: bool
    log: str | None
    spans: bool
    speeds: Mapping[int, float]
    """The relative speeds of ranks that simulate slower machines."""
    stall_s: float | None
    """Seconds without an answer after which a rank gives up, even on a live process; None: not set."""

    checkpoint: Checkpoint | None = None
    on_loss: str = "stop"
    live: Live | None = None
    crowded: bool = False
    """Whether a host has fewer processors than ranks; set after the handshake."""
    steering: str | None = None
    """The path of the steer.jsonl of the run that this one repeats."""
    excerpt: Excerpt | None = None
    """The frames that are drawn; None: all."""
    whole_log: str | None = None
    """The log of the whole run, whose digests an excerpt's pictures are compared with."""
    continued_from: int = 0
    """The first frame of a run that continues an earlier one and its log; 0: a new run."""

    seed_given: bool = True
    """Whether the script chose the seed, instead of rank 0."""

    def agreed(self, *, seed: int, threads: int, continued_from: int, crowded: bool) -> Self:
        """Return the settings with the values that are known after the handshake."""
        given = self.seed is not None
        return self._replace(
            seed=seed, seed_given=given, threads=threads, continued_from=continued_from, crowded=crowded
        )

    def of_roles(self, roles: tuple[int, int, Sequence[int]], speeds: Mapping[int, float]) -> Self:
        """Return the settings with other roles, before the run."""
        return self._replace(roles=roles, speeds=speeds)

    def of_those_left(self, roles: tuple[int, int, Sequence[int]], survivors: Sequence[int]) -> Self:
        """Return the settings for the ranks that survive; `survivors`: their ranks before the loss."""
        speeds = {now: self.speeds[then] for now, then in enumerate(survivors) if then in self.speeds}
        return self._replace(roles=roles, speeds=speeds)

    def compared(self) -> dict[str, str]:
        """Return the settings that must be equal on all ranks as {name: text}."""
        values: dict[str, object] = {
            name: one for name, one in self._asdict().items() if name not in _NOT_COMPARED
        }
        values["roles"] = _roles(self.roles)
        values["periodic"] = ends_of(self.periodic)
        kind = type(self.balancer)
        # The repr of a user's class may contain an address, so compare only its name: `decide` runs only on
        # the manager.
        ours = kind.__module__.partition(".")[0] == __package__.partition(".")[0]
        values["balancer"] = repr(self.balancer) if ours else kind.__qualname__
        return {name: str(value) for name, value in values.items()}

    def for_core(self, *, rank: int, hosts: Sequence[str]) -> dict[str, Any]:
        """Return the argument `facts` of `_core.Engine` for a rank; `hosts`: the host of each rank."""
        return {
            "seed": self.seed,
            "dt": self.dt,
            "substeps": self.substeps,
            "digest": self.digest,
            "log": self.log or "",
            "hosts": list(hosts),
            "policy": policy_of(self.balancer),
            "combine": self.combine,
            # Ranks that share processors wait long for each other, so only one creates births.
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
        """Return the settings for run.json and recorded scenes."""
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
