"""Custom laws written as expressions, for each particle or for pairs. Part of `motes.actions`.

They run in the engine, over hundreds of particles or pairs at a time. They read the state of all particles
before the action. Values that are not finite, as after a division by 0, are ignored.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .. import _core
from .._values import arguments
from .._values.values import value
from ..errors import ArgumentError
from ..expressions._compiling import compile_values, components_of
from ..expressions._conditions import Columns, condition_of, zero_divisor_of
from ..expressions._expression import as_expression, node_of
from .base import Action, Reaching, as_where

if TYPE_CHECKING:
    from .._system.system import System

__all__ = ["Interact", "Law"]

MOST_STATES = 96  # numbers per pair
Part = tuple[str, int, int]


@value(kw_only=True)
class Law(Action):
    """Applies a custom law, written as expressions of columns, to each particle.

    Formula: v += acceleration dt + velocity

    Attributes:
        acceleration: m/s^2: a vector or an expression.
        velocity: change of velocity in each (sub)step, m/s.
        set: new values of attributes, by name.

    Source: new here.
    """

    acceleration: Any = None
    velocity: Any = None
    set: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        """Check everything that does not depend on the system."""
        self.__dict__.update(_values_of(self, ("acceleration", "velocity")), where=as_where(self.where))

    def _key(self) -> tuple[Any, ...]:
        """Return the key for comparing and hashing; `==` on expressions would build a condition."""
        return (*_key_of(self, ("acceleration", "velocity")), self.where)

    def _compiled(self, columns: Columns, others: Columns | None = None) -> _core.Action:
        """Return the engine's action for a system with these columns."""
        shapes: list[_core.Shape] = []
        where = condition_of(self.where, columns, shapes)
        results = _Results(columns, {}, columns, shapes)
        results.add_changes(self)
        return _core.Action("law", {}, shapes, where, values=results.values, results=results.places)


@value(kw_only=True)
class Interact(Reaching):
    """Applies a custom law, written as expressions, to pairs of particles.

    Of the names in `motes.expressions`, `a` is the particle that changes, `b` each other particle within the
    radius, `r` their distance, `normal` the direction from a to b (0 if their positions are equal),
    `relative_velocity` the velocity of b relative to a. Sums run in the order of ids and skip values that are
    not finite.

    Each particle of a pair has its own state: `a.state.slip` is 0 when b comes within the radius, then the
    value that `set` gave it in the last (sub)step, until b leaves the radius or `where` excludes a.

    Formula: v_a += sum over r < radius of (acceleration dt + velocity), spin_a += sum of spin

    Attributes:
        radius: reach of the interaction, m.
        acceleration: acceleration of a due to b, m/s^2: a vector or an expression.
        velocity: change of a's velocity due to b in each (sub)step, m/s.
        spin: change of a's spin due to b in each (sub)step, rad/s.
        set: new values by name: of state variables, and of attributes of a, which become the sum over all b.
        state: names of a pair's state variables, and the size of each: 1 or 3 numbers, at most 96 in all.
        other: another system, to which b belongs; its particles do not change.

    Source: new here; pairs are found as for `contact`.
    """

    acceleration: Any = None
    velocity: Any = None
    spin: Any = None
    set: Mapping[str, Any] | None = None
    state: Mapping[str, int] | None = None
    other: System | None = None

    def __post_init__(self) -> None:
        """Check everything that does not depend on the systems."""
        radius = arguments.number("radius", self.radius, low=0, high=1e15)
        if radius == 0:
            raise ArgumentError("radius", self.radius, "above 0")
        state = _state_of(self.state)
        changes = _values_of(self, ("acceleration", "velocity", "spin"))
        self.__dict__.update(changes, radius=radius, state=state, where=as_where(self.where))

    def _key(self) -> tuple[Any, ...]:
        """Return the key for comparing and hashing; `==` on expressions would build a condition."""
        state = None if self.state is None else tuple(self.state.items())
        changes = _key_of(self, ("acceleration", "velocity", "spin"))
        return (self.radius, *changes, state, self.other, self.where)

    def _compiled(self, columns: Columns, others: Columns | None = None) -> _core.Action:
        """Return the engine's action for a system with these columns, and for the other system's columns."""
        shapes: list[_core.Shape] = []
        where = condition_of(self.where, columns, shapes)
        states, numbers = {}, 0
        for name, width in (self.state or {}).items():
            states[name] = (numbers, width)
            numbers += width
        leaves = _Leaves(columns, columns if others is None else others, states)
        inside: list[_core.Shape] = []
        results = _Results(leaves, states, columns, inside)
        results.add_changes(self)
        if inside:
            raise ArgumentError("expression", "a shape", "a comparison: shapes test particles, not pairs")
        return _core.Action(
            "interact",
            {"radius": self.radius, "state": numbers},
            shapes,
            where,
            values=results.values,
            leaves=leaves.parts,
            results=results.places,
        )


class _Leaves(Columns):
    """The columns used by a pair law, in the order in which its expressions first name them."""

    def __init__(self, own: Columns, others: Columns, states: Columns) -> None:
        self.parts: list[Part] = []
        self._known = {
            **{f"a.{name}": ("own", i, width) for i, (name, (_, width)) in enumerate(own.items())},
            **{f"b.{name}": ("other", i, width) for i, (name, (_, width)) in enumerate(others.items())},
            **{f"a.state.{name}": ("state", first, width) for name, (first, width) in states.items()},
            "pair.r": ("distance", 0, 1),
            "pair.normal": ("normal", 0, 3),
        }
        self._known |= {name: self._known[f"a.{name}"] for name in own}
        self._placed: dict[str, tuple[int, int]] = {}

    def __getitem__(self, name: str) -> tuple[int, int]:
        of, number, width = self._known[name]
        key = f"a.{name}" if f"a.{name}" in self._known else name
        if key not in self._placed:
            self._placed[key] = (len(self.parts), width)
            for c in range(width):
                self.parts.append((of, 0, number + c) if of == "state" else (of, number, c))
        return self._placed[key]

    def __contains__(self, name: object) -> bool:
        return self._must_know(name) in self._known

    def __iter__(self) -> Any:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)

    def _must_know(self, name: object) -> object:
        """Return `name`; raise if it is an attribute or state that the pair does not have."""
        if name in self._known or not isinstance(name, str) or "." not in name:
            return name
        of = name.rpartition(".")[0]
        known = [one.rpartition(".")[2] for one in self._known if one.rpartition(".")[0] == of]
        allowed = f"one of {', '.join(known)}" if known else "declared by state={...}"
        raise ArgumentError(f"expressions.{of}", name.rpartition(".")[2], allowed, known=known)


class _Results:
    """The compiled values of a law, and where each is written."""

    def __init__(self, read: Columns, states: Columns, own: Columns, shapes: list[_core.Shape]) -> None:
        self.values: list[Any] = []
        self.places: list[Part] = []
        self._read, self._states, self._own, self._shapes = read, states, own, shapes

    def add_changes(self, law: Any) -> None:
        """Add all changes that a law makes."""
        named = list(self._own)
        for field, how, attribute in (
            ("acceleration", "rate", "velocity"),
            ("velocity", "change", "velocity"),
            ("spin", "change", "spin"),
        ):
            given = getattr(law, field, None)
            if given is not None:
                self._add(field, given, 3, [(how, named.index(attribute), c) for c in range(3)])
        for name, given in (law.set or {}).items():
            self._add_set(law, name, given, named)

    def _add_set(self, law: Any, name: str, given: Any, named: list[str]) -> None:
        if name in self._states:
            if name in self._own:
                raise ArgumentError("state", name, "a name that is not an attribute of the system")
            first, width = self._states[name]
            self._add(name, given, width, [("state", 0, first + c) for c in range(width)])
            return
        if name not in self._own:
            allowed = f"one of {', '.join([*self._states, *self._own])}: only a can change"
            raise ArgumentError("set", name, allowed, known=[*self._states, *self._own])
        if name == "position" and isinstance(law, Interact):
            raise ArgumentError(
                "set", name, "left out: interact() changes only velocities; use law() or set()"
            )
        changed = {"velocity": ("acceleration", "velocity"), "spin": ("spin",)}.get(name, ())
        if any(getattr(law, field, None) is not None for field in changed):
            raise ArgumentError("set", name, f"left out if {' or '.join(changed)} changes it")
        width = self._own[name][1]
        self._add(name, given, width, [("value", named.index(name), c) for c in range(width)])

    def _add(self, argument: str, given: Any, width: int, places: list[Part]) -> None:
        zero = zero_divisor_of(node_of(given))
        if zero is not None:
            raise ArgumentError(argument, zero, "no division by 0")
        values = compile_values(argument, given, width, self._read, self._shapes)
        if places[0][0] in ("rate", "change") and len(components_of(argument, given, self._read, [])) != 3:
            raise ArgumentError(argument, given, "a vector: 3 numbers, or an expression of them")
        self.values += values
        self.places += places


def _values_of(law: Any, fields: tuple[str, ...]) -> dict[str, Any]:
    given = {field: getattr(law, field) for field in fields if getattr(law, field) is not None}
    changes: dict[str, Any] = {field: as_expression(field, one) for field, one in given.items()}
    if law.set is not None:
        if not isinstance(law.set, Mapping) or not all(isinstance(name, str) for name in law.set):
            raise ArgumentError("set", law.set, "a dict of names and values: set={'heat': ...}")
        changes["set"] = {name: as_expression(name, one) for name, one in law.set.items()}
    if not given and not law.set:
        allowed = f"given, or another of {', '.join(fields)}, set={{...}}: a law must change something"
        raise ArgumentError(fields[0], None, allowed)
    return changes


def _state_of(given: Any) -> dict[str, int] | None:
    if given is None:
        return None
    if not isinstance(given, Mapping):
        raise ArgumentError("state", given, "a dict of names and widths: state={'slip': 3}")
    for name, width in given.items():
        if not isinstance(name, str) or not name.isidentifier() or name.startswith("_"):
            raise ArgumentError("state", name, "an identifier that does not begin with _, as in a.state.slip")
        if isinstance(width, bool) or width not in (1, 3):
            raise ArgumentError(f"state[{name!r}]", width, "1 or 3 numbers")
    if sum(given.values()) > MOST_STATES:
        raise ArgumentError(
            "state", f"{sum(given.values())} numbers", f"at most {MOST_STATES} numbers per pair"
        )
    return {name: int(width) for name, width in given.items()}


def _key_of(law: Any, fields: tuple[str, ...]) -> tuple[Any, ...]:
    given = [getattr(law, field) for field in fields]
    set_values = None if law.set is None else tuple((name, node_of(one)) for name, one in law.set.items())
    return (*(None if one is None else node_of(one) for one in given), set_values)
