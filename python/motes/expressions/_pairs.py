"""Names for the laws of `interact`: a particle, another one within reach, and the pair's state."""

from __future__ import annotations

from typing import Any

from ..errors import ArgumentError
from ._expression import Expression

__all__ = ["Particle", "a", "b", "normal", "r", "relative_velocity"]


class Particle:
    """One of the two particles of a pair: `a.position`, `b.mass`, ... are expressions."""

    __slots__ = ("_name",)
    _name: str

    def __init__(self, name: str) -> None:
        """Set its name, a or b; scripts use `expressions.a` and `expressions.b`."""
        object.__setattr__(self, "_name", name)

    @property
    def state(self) -> PairState:
        """The pair's state as `a` sees it: `a.state.slip`."""
        if self._name != "a":
            raise ArgumentError(
                "expressions.b.state", "of b", "expressions.a.state: a pair remembers what a sees"
            )
        return PairState()

    def __getattr__(self, name: str) -> Expression:
        """Return the expression for an attribute of this particle."""
        if name.startswith("_"):
            raise AttributeError(f"expressions.{self._name} has no attribute {name!r}")
        return Expression(("column", f"{self._name}.{name}"))

    def __setattr__(self, name: str, _: object) -> None:
        """Raise: only the arguments of `interact` change particles."""
        raise AttributeError(
            f"expressions.{self._name}.{name} cannot be assigned: "
            "interact(acceleration=..., set={...}) changes a"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the name."""
        return Particle, (self._name,)

    def __repr__(self) -> str:
        """Show it as a script writes it."""
        return self._name


class PairState:
    """Values that a pair keeps from one sub-step to the next, with the names declared by `state=`."""

    __slots__ = ()

    def __getattr__(self, name: str) -> Expression:
        """Return the expression for a state variable."""
        if name.startswith("_"):
            raise AttributeError(f"expressions.a.state has no {name!r}")
        return Expression(("column", f"a.state.{name}"))

    def __repr__(self) -> str:
        """Show it as a script writes it."""
        return "a.state"


a = Particle("a")
"""The particle that a pair law changes; in `law` and `where=`, each particle."""
b = Particle("b")
"""The other particle of a pair, within reach of `a`."""
r = Expression(("column", "pair.r"))
"""Distance between `a` and `b`, m."""
normal = Expression(("column", "pair.normal"))
"""Unit vector from `a` to `b`; (0, 0, 0) if their positions are equal."""
relative_velocity = b.velocity - a.velocity
"""Velocity of `b` relative to `a`, m/s."""
