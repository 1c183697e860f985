"""Which rank plays which roles (paper 3.1.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .. import _core
from ..errors import ArgumentError
from . import arguments, environment

__all__ = ["Roles"]

MOST_RANKS = 2**31 - 1
Core = tuple[int, int, Sequence[int]]
MIN_SPEED = environment.LEAST_SPEED


@dataclass(frozen=True, kw_only=True)
class Roles:
    """Ranks by role: a rank may play several roles, or none.

    Attributes:
        manager: the rank that creates births, balances and writes the log.
        image_generator: the rank that gets the picture.
        calculators: the ranks that compute particles, in the order of their domains.
        speeds: {rank: relative speed, above 0, at most 1}. The rank takes as long as a machine of that speed
            would, to simulate a heterogeneous cluster on one computer. `MOTES_SPEEDS="2:1.0,3:0.5"` does the
            same without changing the script, and takes precedence.
    """

    manager: int
    image_generator: int
    calculators: Sequence[int]
    speeds: Mapping[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check what can be checked before the number of ranks is known."""
        arguments.integer("manager", self.manager, high=MOST_RANKS)
        arguments.integer("image_generator", self.image_generator, high=MOST_RANKS)
        for rank in arguments.listed("calculators", self.calculators, "a list of ranks"):
            arguments.integer("calculators", rank, high=MOST_RANKS)
        if not isinstance(self.speeds, Mapping):
            raise ArgumentError("speeds", self.speeds, "a dict of ranks and numbers above 0, at most 1")
        for rank, speed in self.speeds.items():
            arguments.integer("speeds", rank, high=MOST_RANKS)
            arguments.number("speeds", speed, low=MIN_SPEED, high=1)


def cast(roles: Any, ranks: Sequence[int], size: int) -> Core:
    """Return manager, image generator and calculators from `World`'s `roles`, which are for `size` ranks.

    `ranks`: the ranks that exist, ascending; the result refers to them by their index in this list.
    """
    if isinstance(roles, Roles):
        chosen = (roles.manager, roles.image_generator, list(roles.calculators))
        _core.check_roles(chosen, size)
        return chosen if len(ranks) == size else _core.cast_left(chosen, list(ranks))
    if not isinstance(roles, str) or roles not in ("auto", "shared"):
        raise ArgumentError("roles", roles, "'auto', 'shared' or Roles(...)", known=("auto", "shared"))
    return _core.cast(roles, len(ranks))


def speeds(roles: Any, ranks: Sequence[int], size: int) -> dict[int, float]:
    """Return the speeds of ranks that simulate slower machines, from MOTES_SPEEDS, or else from `roles`.

    Both are for `size` ranks, of which `ranks` exist; the result refers to them by their index in this list.
    """
    given = environment.read("MOTES_SPEEDS")
    if given is None and isinstance(roles, Roles):
        chosen = {int(rank): float(speed) for rank, speed in roles.speeds.items()}
    else:
        chosen = given or {}
    for rank in chosen:
        if rank >= size:
            name = "speeds" if given is None else "MOTES_SPEEDS"
            raise ArgumentError(name, chosen, f"for ranks 0..{size - 1}")
    return {now: chosen[then] for now, then in enumerate(ranks) if then in chosen}
