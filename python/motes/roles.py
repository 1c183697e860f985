"""Who plays what (paper 3.1.1)."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from . import _core, arguments
from .errors import ArgumentError

__all__ = ["Roles"]

MOST_RANKS = 2**31 - 1
Core = tuple[int, int, list[int]]
MIN_SPEED = 1e-3


@dataclass(frozen=True, kw_only=True)
class Roles:
    """Ranks by role: a rank may play several roles, or none.

    `speeds`: {rank: part of its speed, above 0, at most 1}: such a rank takes the time that a machine of that
    speed would take, so that a heterogeneous cluster can be studied on one computer. The environment variable
    MOTES_SPEEDS="2:1.0,3:0.5" does the same without a change of the script, and takes precedence.
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


def cast(roles: Any, size: int) -> Core:
    """Turn World's `roles` into manager, image generator and calculators among `size` ranks."""
    if isinstance(roles, Roles):
        chosen = (roles.manager, roles.image_generator, list(roles.calculators))
        _core.check_roles(chosen, size)
        return chosen
    if not isinstance(roles, str) or roles not in ("auto", "shared"):
        raise ArgumentError("roles", roles, "'auto', 'shared' or Roles(...)")
    return _core.cast(roles, size)


def speeds(roles: Any, size: int) -> dict[int, float]:
    """Return which ranks behave like slower machines: by MOTES_SPEEDS, or else by `roles`."""
    text = os.environ.get("MOTES_SPEEDS", "")
    if text:
        chosen = _parse(text)
        name: str = "MOTES_SPEEDS"
    else:
        chosen = {int(r): float(v) for r, v in roles.speeds.items()} if isinstance(roles, Roles) else {}
        name = "speeds"
    for rank in chosen:
        if rank >= size:
            raise ArgumentError(name, text or chosen, f"ranks 0..{size - 1}")
    return chosen


def _parse(text: str) -> dict[int, float]:
    allowed = f"rank:speed pairs such as 2:1.0,3:0.5 with speeds {MIN_SPEED}..1"
    chosen = {}
    for pair in text.split(","):
        rank, _, speed = pair.partition(":")
        try:
            chosen[int(rank)] = float(speed)
        except ValueError:
            raise ArgumentError("MOTES_SPEEDS", text, allowed) from None
    if any(rank < 0 or not MIN_SPEED <= speed <= 1 for rank, speed in chosen.items()):
        raise ArgumentError("MOTES_SPEEDS", text, allowed)
    return chosen
