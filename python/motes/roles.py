"""Who plays what (paper 3.1.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from . import _core, arguments
from .errors import ArgumentError

__all__ = ["Roles"]

MOST_RANKS = 2**31 - 1
Core = tuple[int, int, list[int]]


@dataclass(frozen=True, kw_only=True)
class Roles:
    """Ranks by role: one may play several; a rank in none looks on."""

    manager: int
    image_generator: int
    calculators: Sequence[int]

    def __post_init__(self) -> None:
        """Check what can be checked before the number of ranks is known."""
        arguments.integer("manager", self.manager, high=MOST_RANKS)
        arguments.integer("image_generator", self.image_generator, high=MOST_RANKS)
        for rank in arguments.listed("calculators", self.calculators, "a list of ranks"):
            arguments.integer("calculators", rank, high=MOST_RANKS)


def cast(roles: Any, size: int) -> Core:
    """Turn World's `roles` into manager, image generator and calculators among `size` ranks."""
    if isinstance(roles, Roles):
        chosen = (roles.manager, roles.image_generator, list(roles.calculators))
        _core.check_roles(chosen, size)
        return chosen
    if not isinstance(roles, str) or roles not in ("auto", "shared"):
        raise ArgumentError("roles", roles, "'auto', 'shared' or Roles(...)")
    return _core.cast(roles, size)
