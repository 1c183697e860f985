"""Actions over particles as values (paper 3.1.5). `System` has a method for each that records it.

An action acts on each particle alone: v is its velocity in m/s, x its position in m, dt the (sub)step in
seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from . import _core, arguments
from .errors import ArgumentError
from .expressions import (
    Columns,
    Condition,
    as_condition,
    as_expression,
    compile_condition,
    compile_values,
)
from .shapes import Shape, as_shape

__all__ = [
    "Action",
    "Bounce",
    "Damping",
    "Gravity",
    "KillExpired",
    "KillOld",
    "Move",
    "RandomAcceleration",
    "RandomVelocity",
    "Set",
    "Sink",
]

Where = Shape | Condition | None


@dataclass(frozen=True, kw_only=True)
class Action:
    """Base of all actions. `where` limits one to particles in a shape, or for which a comparison holds."""

    where: Where = None

    _call: ClassVar[tuple[str, list[float], list[_core.Shape]]]
    _core: ClassVar[_core.Action]

    def _set(self, name: str, numbers: list[float], *shapes: Shape) -> None:
        if self.where is not None:
            as_condition("where", self.where)
        cores = [shape.core for shape in shapes]
        object.__setattr__(self, "_call", (name, numbers, cores))
        object.__setattr__(self, "_core", _core.Action(name, numbers, cores))  # checks the arguments

    def compiled(self, columns: Columns) -> _core.Action:
        """Return the engine's value for a system with these columns."""
        if self.where is None:
            return self._core
        name, numbers, own = self._call
        shapes = list(own)
        where = compile_condition(self.where, columns, shapes)
        return _core.Action(name, numbers, shapes, where)


@dataclass(frozen=True, kw_only=True, eq=False)  # expressions compare to conditions
class Set(Action):
    """attribute = value, a number, three numbers or an expression of columns, for each particle.

    The value is computed from the particle as it was before the action.
    """

    attribute: str
    value: Any

    def __post_init__(self) -> None:
        """Check what can be checked before the system is known."""
        if not isinstance(self.attribute, str):
            raise ArgumentError("attribute", self.attribute, "an attribute's name")
        as_expression(self.attribute, self.value)
        if self.where is not None:
            as_condition("where", self.where)

    def compiled(self, columns: Columns) -> _core.Action:
        """Return the engine's value for a system with these columns."""
        if self.attribute not in columns:
            raise ArgumentError("attribute", self.attribute, f"one of {', '.join(columns)}")
        shapes: list[_core.Shape] = []
        where = compile_condition(self.where, columns, shapes)
        values = compile_values(self.attribute, self.value, columns[self.attribute][1], columns, shapes)
        return _core.Action("set", [], shapes, where, list(columns).index(self.attribute), values)


@dataclass(frozen=True, kw_only=True)
class Gravity(Action):
    """v += acceleration dt."""

    acceleration: ArrayLike

    def __post_init__(self) -> None:
        """Check and hand to the engine."""
        self._set("gravity", list(arguments.triple("acceleration", self.acceleration)))


@dataclass(frozen=True, kw_only=True)
class Damping(Action):
    """v *= 1 - (1 - damping) dt, axis by axis, where min_speed <= |v| <= max_speed (m/s).

    `damping`: what is left of the velocity after a second, along each axis. After McAllister's Damping.
    """

    damping: ArrayLike
    min_speed: float = 0
    max_speed: float = math.inf

    def __post_init__(self) -> None:
        """Check and hand to the engine."""
        factors = arguments.triple("damping", self.damping, low=0)
        low = arguments.number("min_speed", self.min_speed, low=0)
        high = arguments.number("max_speed", self.max_speed, low=0, finite=False)
        self._set("damping", [*factors, low, high])


@dataclass(frozen=True, kw_only=True)
class RandomAcceleration(Action):
    """v += a dt, with a drawn uniformly from `shape` (m/s^2), anew for each particle and step."""

    shape: Shape | ArrayLike

    def __post_init__(self) -> None:
        """Check and hand to the engine."""
        self._set("random_acceleration", [], as_shape("shape", self.shape))


@dataclass(frozen=True, kw_only=True)
class RandomVelocity(Action):
    """v = u, with u drawn uniformly from `shape` (m/s), anew for each particle and step."""

    shape: Shape | ArrayLike

    def __post_init__(self) -> None:
        """Check and hand to the engine."""
        self._set("random_velocity", [], as_shape("shape", self.shape))


@dataclass(frozen=True, kw_only=True)
class Bounce(Action):
    """Particles that meet the surface of `shape` in this step leave it again.

    With v split along (t) and across (n) the surface at the place of the hit, v becomes
    (1 - friction) v_t - restitution v_n; there is no friction where |v_t| <= min_tangential_speed (m/s). The
    hit's true place and time inside the step count: record it before `move`. Shapes: Plane (from above),
    Rectangle and Disc (both sides), Box and Sphere (from outside and from inside).
    """

    shape: Shape
    restitution: float = 1
    friction: float = 0
    min_tangential_speed: float = 0

    def __post_init__(self) -> None:
        """Check and hand to the engine."""
        numbers = [
            arguments.number("restitution", self.restitution, low=0, high=1e15),
            arguments.number("friction", self.friction, low=0, high=1),
            arguments.number("min_tangential_speed", self.min_tangential_speed, low=0, finite=False),
        ]
        self._set("bounce", numbers, as_shape("shape", self.shape))


@dataclass(frozen=True, kw_only=True)
class Sink(Action):
    """Kills particles inside `shape`, or with inside=False those outside it."""

    shape: Shape
    inside: bool = True

    def __post_init__(self) -> None:
        """Check and hand to the engine."""
        self._set("sink", [float(arguments.flag("inside", self.inside))], as_shape("shape", self.shape))


@dataclass(frozen=True, kw_only=True)
class KillOld(Action):
    """Kills particles whose age is `age_limit` (s) or more; with younger=True those below it."""

    age_limit: float
    younger: bool = False

    def __post_init__(self) -> None:
        """Check and hand to the engine."""
        limit = arguments.number("age_limit", self.age_limit, finite=False)
        self._set("kill_old", [limit, float(arguments.flag("younger", self.younger))])


@dataclass(frozen=True, kw_only=True)
class KillExpired(Action):
    """Kills particles whose age has reached their lifetime."""

    def __post_init__(self) -> None:
        """Hand to the engine."""
        self._set("kill_expired", [])


@dataclass(frozen=True, kw_only=True)
class Move(Action):
    """x += v dt, age += dt; with `rotational`, up += rotational_velocity dt. After McAllister's Move."""

    rotational: bool = True

    def __post_init__(self) -> None:
        """Check and hand to the engine."""
        self._set("move", [float(arguments.flag("rotational", self.rotational))])


def as_action(value: Any) -> Action:
    """Return `value`, which must be an action."""
    if not isinstance(value, Action):
        raise ArgumentError("action", value, "an action of motes.actions, or a list of them")
    return value
