"""Actions that set attributes to given values, at once or over time. Part of `motes.actions`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._values import arguments
from .._values.curves import Curve, Number, Vector
from .._values.values import value
from ..errors import ArgumentError
from ..expressions import Expression
from ..expressions._compiling import compile_values
from ..expressions._conditions import Columns, condition_of
from ..expressions._expression import as_expression, constant_of, node_of
from ..shapes import Shape, as_shape
from .base import Action, PerParticle, as_where, at_least_0

__all__ = [
    "AlphaOverLife",
    "ColorOverLife",
    "CopyVertexB",
    "Damping",
    "RandomDisplacement",
    "RandomRotationalVelocity",
    "RandomVelocity",
    "Restore",
    "RotationalDamping",
    "Set",
    "SizeOverLife",
    "SpeedClamp",
    "TargetColor",
    "TargetRotationalVelocity",
    "TargetSize",
    "TargetVelocity",
]

T = TypeVar("T")


@value()
class Damping(PerParticle):
    """Slows particles down, axis by axis, while their speed is in a range.

    Formula: v *= 1 - (1 - damping) dt, each component, where min_speed <= |v| <= max_speed

    Attributes:
        damping: fraction of the velocity that remains after one second, per axis. It and the speeds may be
            expressions; a damping below 0 counts as 0, and where a value is NaN, nothing changes.
        min_speed: lower end of the range, m/s.
        max_speed: upper end of the range, m/s.

    Source: McAllister's Damping.
    """

    damping: Vector | Expression
    min_speed: Number | Expression = 0
    max_speed: Number | Expression = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set_each(
            "damping",
            damping=(3, self.damping, partial(arguments.triple, low=0)),
            min_speed=(1, self.min_speed, partial(arguments.number, low=0)),
            max_speed=(1, self.max_speed, at_least_0),
        )


@value()
class RotationalDamping(PerParticle):
    """Slows rotations down, axis by axis, while their rotational speed is in a range.

    Formula: rotational_velocity *= 1 - (1 - damping) dt, each component, where min_speed <=
    |rotational_velocity| <= max_speed

    Attributes:
        damping: fraction of the rotational velocity that remains after one second, per axis. It and the
            speeds may be expressions, as in `damping`.
        min_speed: lower end of the range, 1/s.
        max_speed: upper end of the range, 1/s.

    Source: McAllister's RotDamping.
    """

    damping: Vector | Expression
    min_speed: Number | Expression = 0
    max_speed: Number | Expression = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set_each(
            "rotational_damping",
            damping=(3, self.damping, partial(arguments.triple, low=0)),
            min_speed=(1, self.min_speed, partial(arguments.number, low=0)),
            max_speed=(1, self.max_speed, at_least_0),
        )


@value()
class SpeedClamp(Action):
    """Limits speeds to a range; directions do not change, and particles at rest stay at rest.

    Formula: v *= clamp(|v|, min_speed, max_speed) / |v|

    Attributes:
        min_speed: lower end of the range, m/s.
        max_speed: upper end of the range, m/s.

    Source: McAllister's SpeedClamp.
    """

    min_speed: Number = 0
    max_speed: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "speed_clamp",
            min_speed=arguments.number("min_speed", self.min_speed, low=0),
            max_speed=at_least_0("max_speed", self.max_speed),
        )


@value()
class RandomVelocity(Action):
    """Gives each particle a new random velocity in each step.

    Formula: v = sample, uniform in the shape

    Attributes:
        shape: distribution of the sample, m/s.

    Source: McAllister's RandomVelocity.
    """

    shape: Shape | ArrayLike

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("random_velocity", shape=as_shape("shape", self.shape))


@value()
class RandomDisplacement(Action):
    """Shifts each particle by its own random displacement, redrawn in each step; velocities stay.

    Formula: x += sample dt, uniform in the shape

    Attributes:
        shape: distribution of the sample, m/s.

    Source: McAllister's RandomDisplace.
    """

    shape: Shape | ArrayLike

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("random_displacement", shape=as_shape("shape", self.shape))


@value()
class RandomRotationalVelocity(Action):
    """Gives each particle a new random rotational velocity in each step.

    Formula: rotational_velocity = sample, uniform in the shape

    Attributes:
        shape: distribution of the sample, 1/s.

    Source: McAllister's RandomRotVelocity.
    """

    shape: Shape | ArrayLike

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("random_rotational_velocity", shape=as_shape("shape", self.shape))


@value()
class TargetColor(Action):
    """Moves color and alpha toward given values, by the same fraction of the difference in each step.

    Formula: color += (target - color) scale dt; the same for alpha

    Attributes:
        color: target color, linear RGB.
        alpha: target alpha, 0..1.
        scale: fraction of the difference per second, 1/s.

    Source: McAllister's TargetColor.
    """

    color: Vector
    alpha: Number
    scale: Number

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "target_color",
            color=arguments.color("color", self.color),
            alpha=arguments.number("alpha", self.alpha),
            scale=arguments.number("scale", self.scale, low=0),
        )


@value()
class TargetSize(Action):
    """Moves the size toward a given one, each component by its own fraction of the difference per step.

    Formula: size += (target - size) scale dt, each component

    Attributes:
        size: target size, one number or three, m.
        scale: fraction of the difference per second, one number or three, 1/s.

    Source: McAllister's TargetSize.
    """

    size: Vector
    scale: Vector

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "target_size",
            size=arguments.triple("size", _thrice(self.size)),
            scale=arguments.triple("scale", _thrice(self.scale), low=0),
        )


@value()
class TargetVelocity(Action):
    """Moves the velocity toward a given velocity, by the same fraction of the difference in each step.

    Formula: v += (target - v) scale dt

    Attributes:
        velocity: target velocity, m/s.
        scale: fraction of the difference per second, 1/s.

    Source: McAllister's TargetVelocity.
    """

    velocity: Vector
    scale: Number

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "target_velocity",
            velocity=arguments.triple("velocity", self.velocity),
            scale=arguments.number("scale", self.scale, low=0),
        )


@value()
class TargetRotationalVelocity(Action):
    """Moves the rotational velocity toward a given one, by the same fraction of the difference per step.

    Formula: rotational_velocity += (target - rotational_velocity) scale dt

    Attributes:
        rotational_velocity: target rotational velocity, 1/s.
        scale: fraction of the difference per second, 1/s.

    Source: McAllister's TargetRotVelocity.
    """

    rotational_velocity: Vector
    scale: Number

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "target_rotational_velocity",
            rotational_velocity=arguments.triple("rotational_velocity", self.rotational_velocity),
            scale=arguments.number("scale", self.scale, low=0),
        )


@value()
class Restore(Action):
    """Returns particles to position_b and up_b, where they come to rest after `time_left`.

    The script must decrease `time_left` by dt in each frame. position_b is where a particle was born, unless
    `copy_vertex_b`, `configure` or `emit(position_b=...)` changed it.

    Formula: v = v ((1 - q) (1 - 3 q) - 0.0002 q) + (position_b - x) 6 q (1 - q) / time_left, with q = dt /
    time_left, at most 1: the cubic path that ends at rest (McAllister's 0.0002 makes it stop short by this
    fraction). Once time_left <= 0: x = position_b, v = 0. The same for up and rotational_velocity

    Attributes:
        time_left: time until particles come to rest, s.
        position: whether positions go back.
        up: whether orientations go back.

    Source: McAllister's Restore.
    """

    time_left: Number
    position: bool = True
    up: bool = True

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "restore",
            time_left=arguments.number("time_left", self.time_left),
            position=arguments.flag("position", self.position),
            up=arguments.flag("up", self.up),
        )


@value()
class CopyVertexB(Action):
    """Stores the current position, orientation or velocity as the target to which `restore` returns.

    Formula: with `position`, position_b = position and up_b = up; with `velocity`, velocity_b = velocity

    Attributes:
        position: whether positions and orientations are copied.
        velocity: whether velocities are copied.

    Source: McAllister's CopyVertexB.
    """

    position: bool = True
    velocity: bool = False

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "copy_vertex_b",
            position=arguments.flag("position", self.position),
            velocity=arguments.flag("velocity", self.velocity),
        )


@value()
class ColorOverLife(Action):
    """Sets each particle's color from the fraction of its lifetime that has passed.

    Formula: color = ramp(age / lifetime), linear between knots, constant before the first and after the last;
    two knots with the same ratio make a jump; an infinite lifetime counts as ratio 0

    Attributes:
        ramp: knots (ratio 0..1, linear RGB) in ascending order.

    Source: common in effects editors.
    """

    ramp: Sequence[tuple[float, ArrayLike]]

    _may_move = False  # a curve as ramp is one of age / lifetime, not of the time

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("color_over_life", ramp=_knots(self.ramp, arguments.color))


@value()
class AlphaOverLife(Action):
    """Sets each particle's alpha from the fraction of its lifetime that has passed.

    Formula: alpha = ramp(age / lifetime), as color_over_life

    Attributes:
        ramp: knots (ratio 0..1, alpha) in ascending order.

    Source: common in effects editors.
    """

    ramp: Sequence[tuple[float, float]]

    _may_move = False

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("alpha_over_life", ramp=_knots(self.ramp, arguments.number))


@value()
class SizeOverLife(Action):
    """Sets each particle's size from the fraction of its lifetime that has passed.

    Formula: size = ramp(age / lifetime), as color_over_life

    Attributes:
        ramp: knots (ratio 0..1, size) in ascending order; a size is one number or three, m.

    Source: common in effects editors.
    """

    ramp: Sequence[tuple[float, ArrayLike]]

    _may_move = False

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("size_over_life", ramp=_knots(self.ramp, _size))


@value()
class Set(Action):
    """Sets an attribute to a value, or to an expression of columns evaluated for each particle.

    Where the result is not finite, as after a division by 0, the attribute does not change.

    Formula: attribute = value, computed from the particle's state before the action

    Attributes:
        attribute: the attribute's name; the method `set` takes `attribute=value` instead.
        value: a number, a vector or an expression such as column("age") * 2, with the functions of
            motes.expressions.

    Source: new here.
    """

    attribute: str
    value: Any

    def __post_init__(self) -> None:
        """Check everything that does not depend on the system."""
        if not isinstance(self.attribute, str):
            raise ArgumentError("attribute", self.attribute, "an attribute's name")
        given = as_expression(self.attribute, self.value)
        constant = constant_of(given)
        self.__dict__.update(value=given if constant is None else constant, where=as_where(self.where))

    def _key(self) -> tuple[Any, ...]:
        """Return the key for comparing and hashing; `==` on expressions would build a condition."""
        return self.attribute, node_of(as_expression(self.attribute, self.value)), self.where

    def _compiled(self, columns: Columns, others: Columns | None = None) -> _core.Action:
        """Return the engine's action for a system with these columns."""
        if self.attribute not in columns:
            known = ", ".join(columns)
            raise ArgumentError("attribute", self.attribute, f"one of {known}", known=columns)
        shapes: list[_core.Shape] = []
        where = condition_of(self.where, columns, shapes)
        values = compile_values(self.attribute, self.value, columns[self.attribute][1], columns, shapes)
        return _core.Action("set", {}, shapes, where, list(columns).index(self.attribute), values)


def _thrice(value: Any) -> Any:
    """Repeat a single number three times, as `configure` does for sizes."""
    return (value, value, value) if isinstance(value, (int, float, np.integer, np.floating)) else value


def _size(argument: str, value: Any) -> arguments.Triple:
    return arguments.triple(argument, _thrice(value))


def _knots(ramp: Any, checked: Callable[[str, Any], T]) -> tuple[tuple[float, T], ...]:
    if isinstance(ramp, Curve):
        if type(ramp) is not Curve or ramp.interpolation != "linear":
            raise ArgumentError("ramp", ramp, "a list of (age / lifetime, value), or a linear Curve of them")
        ramp = ramp.keys
    try:
        pairs = [(ratio, given) for ratio, given in ramp]
    except Exception:  # any exception: this runs methods of users' classes
        pairs = []
    if not pairs:
        raise ArgumentError("ramp", ramp, "a list of (age / lifetime, value), at least one")
    knots: list[tuple[float, T]] = []
    for ratio, given in pairs:
        at = arguments.number("ramp", ratio, low=0, high=1)
        if knots and at < knots[-1][0]:
            raise ArgumentError("ramp", ramp, "ratios in ascending order")
        knots.append((at, checked("ramp", given)))
    return tuple(knots)
