"""What the laws of `interact` are about: a particle, another one within reach, and what they remember."""

from __future__ import annotations

from typing import Any

from ..errors import ArgumentError
from ._expression import Expression

__all__ = ["Particle", "a", "b", "normal", "r", "relative_velocity"]


class Particle:
    """One of the two particles of a pair: `motes.a.position`, `motes.b.mass`, ... are expressions."""

    __slots__ = ("_name",)
    _name: str

    def __init__(self, name: str) -> None:
        """Take its name, a or b; scripts use `motes.a` and `motes.b`."""
        object.__setattr__(self, "_name", name)

    @property
    def state(self) -> PairState:
        """What a pair remembers, as `a` sees it: `motes.a.state.slip`."""
        if self._name != "a":
            raise ArgumentError("motes.b.state", "of b", "motes.a.state: a pair remembers what a sees")
        return PairState()

    def __getattr__(self, name: str) -> Expression:
        """Make the expression that is an attribute of this particle."""
        if name.startswith("_"):
            raise AttributeError(f"motes.{self._name} has no attribute {name!r}")
        return Expression(("column", f"{self._name}.{name}"))

    def __setattr__(self, name: str, _: object) -> None:
        """Refuse: `interact` says what changes."""
        raise AttributeError(
            f"motes.{self._name}.{name} cannot be assigned: interact(acceleration=..., set={{...}}) changes a"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the name."""
        return Particle, (self._name,)

    def __repr__(self) -> str:
        """Show it as a script writes it."""
        return f"motes.{self._name}"


class PairState:
    """What a pair remembers from one sub-step to the next; its names are those that `state=` declares."""

    __slots__ = ()

    def __getattr__(self, name: str) -> Expression:
        """Make the expression that is one of the states."""
        if name.startswith("_"):
            raise AttributeError(f"motes.a.state has no {name!r}")
        return Expression(("column", f"a.state.{name}"))

    def __repr__(self) -> str:
        """Show it as a script writes it."""
        return "motes.a.state"


a = Particle("a")
"""The particle that a law changes; alone, in `law` and `where=`, each particle."""
b = Particle("b")
"""The other one of a pair, within reach of `a`."""
r = Expression(("column", "pair.r"))
"""Their distance, m."""
normal = Expression(("column", "pair.normal"))
"""The unit vector from `a` to `b`; (0, 0, 0) where both are at the same place."""
relative_velocity = b.velocity - a.velocity
"""The velocity of `b` as `a` sees it, m/s."""
