"""Actions that accelerate: they pull, push and turn particles. Part of `motes.actions`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from numpy.typing import ArrayLike

from .._values import arguments
from .._values.curves import Number, Vector
from .._values.values import value
from ..expressions import Expression
from ..shapes import Shape, as_shape, as_shapes
from .base import Action, PerParticle, at_least_0

__all__ = [
    "Avoid",
    "CurlNoise",
    "Explosion",
    "Gravity",
    "Jet",
    "OrbitLine",
    "OrbitPoint",
    "RandomAcceleration",
    "Vortex",
    "Wind",
]


@value()
class Gravity(PerParticle):
    """Accelerates all particles by the same amount, or each by the value of an expression.

    Formula: v += acceleration dt

    Attributes:
        acceleration: acceleration of the particles, m/s^2: a vector, or an expression such as (0, -9.8 *
            column("weight"), 0). Where it is not finite, nothing changes.

    Source: McAllister's Gravity; expressions are new here.
    """

    acceleration: Vector | Expression

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set_each("gravity", acceleration=(3, self.acceleration, arguments.triple))


@value()
class RandomAcceleration(Action):
    """Gives each particle its own random acceleration, redrawn in each step.

    Formula: v += a dt, a uniform in the shape

    Attributes:
        shape: distribution of a, m/s^2.

    Source: McAllister's RandomAccel.
    """

    shape: Shape | ArrayLike

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("random_acceleration", shape=as_shape("shape", self.shape))


@value()
class Jet(Action):
    """Accelerates the particles inside a shape, as a fan does.

    Formula: v += a dt where x is in the shape; a uniform in `acceleration`

    Attributes:
        shape: where the jet blows, m.
        acceleration: a value, or a shape from which a is redrawn in each step, m/s^2.

    Source: McAllister's Jet.
    """

    shape: Shape
    acceleration: Shape | ArrayLike

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "jet",
            shape=as_shape("shape", self.shape),
            acceleration=as_shape("acceleration", self.acceleration),
        )


@value()
class Explosion(Action):
    """Pushes particles away from a centre, most strongly at the shock wave: let `radius` grow with time.

    Formula: v += out magnitude dt g(d - radius) / (d^2 + epsilon), with d the distance from the centre, out
    the direction away from it, g(y) = exp(-y^2 / (2 sigma^2)) / (sigma sqrt(2 pi))

    Attributes:
        center: centre of the explosion, m.
        radius: distance of the shock wave's crest from the centre, m.
        magnitude: strength, m^4/s^2.
        sigma: thickness of the wave, m.
        epsilon: softens the push near the centre, m^2.

    Source: McAllister's Explosion.
    """

    center: Vector
    radius: Number
    magnitude: Number
    sigma: Number
    epsilon: Number

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "explosion",
            center=arguments.triple("center", self.center),
            radius=arguments.number("radius", self.radius, low=0),
            magnitude=arguments.number("magnitude", self.magnitude),
            sigma=arguments.number("sigma", self.sigma, low=1e-6),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
        )


@value()
class OrbitPoint(Action):
    """Pulls particles toward a point, more strongly the nearer they are, which lets them orbit it.

    Formula: v += toward magnitude dt / (r^2 + epsilon) where r < max_radius, with r the distance from the
    centre, toward the direction to it

    Attributes:
        center: the point, m.
        magnitude: strength, m^3/s^2.
        epsilon: softens the pull near the centre, m^2.
        max_radius: no pull beyond this distance, m.

    Source: McAllister's OrbitPoint.
    """

    center: Vector
    magnitude: Number
    epsilon: Number
    max_radius: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "orbit_point",
            center=arguments.triple("center", self.center),
            magnitude=arguments.number("magnitude", self.magnitude),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
            max_radius=at_least_0("max_radius", self.max_radius),
        )


@value()
class OrbitLine(Action):
    """Pulls particles toward an infinite line, more strongly the nearer they are.

    Formula: v += toward magnitude dt / (r^2 + epsilon) where r < max_radius, with r the distance from the
    line, toward the direction to it

    Attributes:
        point: any point of the line, m.
        axis: the line's direction; any length.
        magnitude: strength, m^3/s^2.
        epsilon: softens the pull near the line, m^2.
        max_radius: no pull beyond this distance, m.

    Source: McAllister's OrbitLine.
    """

    point: Vector
    axis: Vector
    magnitude: Number
    epsilon: Number
    max_radius: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "orbit_line",
            point=arguments.triple("point", self.point),
            axis=arguments.triple("axis", self.axis),
            magnitude=arguments.number("magnitude", self.magnitude),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
            max_radius=at_least_0("max_radius", self.max_radius),
        )


@value()
class Vortex(Action):
    """Whirls particles around an axis like a tornado: pulls them in, then carries them around and up.

    Formula: with h = 0..1 along the axis, R = max_radius h^tightness, r the distance from the axis, m the
    mass: r < R: v = (along up_speed + around around_speed) dt / m; R <= r < max_radius: v += inward in_speed
    dt / m; elsewhere nothing changes. along is the direction of the axis, inward the direction to the axis,
    around = along x inward

    Attributes:
        tip: where the axis starts, m.
        axis: from the tip to the upper end, m.
        tightness: 1 makes a cone; larger values bend its side inward.
        max_radius: radius at the upper end, m; farther particles are not affected.
        in_speed: force toward the axis outside the whirl, kg m/s^2.
        up_speed: v m / dt along the axis inside the whirl, kg m/s^2.
        around_speed: v m / dt around the axis inside the whirl, kg m/s^2.

    Source: McAllister's Vortex.
    """

    tip: Vector
    axis: Vector
    tightness: Number
    max_radius: Number
    in_speed: Number
    up_speed: Number
    around_speed: Number

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "vortex",
            tip=arguments.triple("tip", self.tip),
            axis=arguments.triple("axis", self.axis),
            tightness=arguments.number("tightness", self.tightness, low=0),
            max_radius=at_least_0("max_radius", self.max_radius),
            in_speed=arguments.number("in_speed", self.in_speed),
            up_speed=arguments.number("up_speed", self.up_speed),
            around_speed=arguments.number("around_speed", self.around_speed),
        )


@value()
class Wind(PerParticle):
    """Drags particles along with moving air; the result does not depend on the step's length.

    Formula: v += (velocity - v) (1 - exp(-drag dt))

    Attributes:
        velocity: the air's velocity, m/s: a vector, or an expression of one.
        drag: rate, 1/s: a particle at rest reaches 63 % of the air's velocity in 1 / drag seconds. A number,
            or an expression such as 0.02 / column("size").x; below 0, it counts as 0. Where an expression is
            not finite, nothing changes.

    Source: linear drag (Stokes).
    """

    velocity: Vector | Expression
    drag: Number | Expression

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set_each(
            "wind",
            velocity=(3, self.velocity, arguments.triple),
            drag=(1, self.drag, partial(arguments.number, low=0)),
        )


@value()
class CurlNoise(Action):
    """Stirs particles like turbulent air: accelerates them along a random, divergence-free field.

    The field neither disperses nor crowds particles, and is smooth in space and time. Each system has its own
    fields.

    Formula: v += strength n(x / scale, speed t) dt, with n the curl of gradient noise, scaled to a root mean
    square of 1; each further octave has half the size and half the strength of the previous one. t is the
    animation's time at the start of the (sub)step

    Attributes:
        strength: root mean square of the acceleration, m/s^2. Together with `wind`, particles reach speeds of
            about strength / drag.
        scale: edge length of a cell of the noise, about the distance between eddies, m. Along a periodic axis
            the cells are stretched or shrunk so that a whole number of them, at least one, fills the period:
            the field is the same at both ends.
        octaves: 1 to 8; each adds smaller eddies, at the cost of one more evaluation of the noise.
        speed: how many times per second the field changes smoothly into another one, 1/s; 0: never.
        field: number of the system's field, 0 to 65535. The same number gives the same field in every frame,
            wherever the action is in the list; give two actions different numbers for different fields.

    Source: Bridson, Houriham, Nordenstam: Curl-noise for procedural fluid flow (2007); Perlin's noise.
    """

    strength: Number
    scale: Number
    octaves: int = 1
    speed: Number = 0
    field: int = 0

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "curl_noise",
            strength=arguments.number("strength", self.strength),
            scale=arguments.number("scale", self.scale, low=1e-6),
            octaves=arguments.integer("octaves", self.octaves, low=1, high=8),
            speed=arguments.number("speed", self.speed),
            field=arguments.integer("field", self.field, high=65535),
        )


@value()
class Avoid(Action):
    """Turns particles that would hit a shape within `look_ahead`, without changing their speed.

    Formula: v = |v| unit(unit(v) + aside magnitude dt / (q^2 + epsilon)). With t the time until the hit, q =
    t and aside is the direction of v along the surface (Plane), from the hit point to the nearest edge
    (Rectangle, Triangle), or from the centre to the hit point (Disc). Sphere, from outside: q = |v| t, aside
    is perpendicular to v and points away from the centre. Box, from outside: as for the Rectangle that would
    be hit. Cylinder and Cone, from outside: walls as for a Plane, flat ends as for a Disc. Union, and several
    shapes: as for the part that would be hit first

    Attributes:
        shape: the obstacle, or a list of them, m.
        magnitude: how sharply particles turn, s (Sphere: m^2/s).
        epsilon: softens the turn near the shape, s^2 (Sphere: m^2).
        look_ahead: how far ahead in time hits are predicted, s.

    Source: McAllister's Avoid; Box, Cylinder, Cone and Union follow the same idea.
    """

    shape: Shape | Sequence[Shape]
    magnitude: Number
    epsilon: Number
    look_ahead: Number

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "avoid",
            shape=as_shapes("shape", self.shape),
            magnitude=arguments.number("magnitude", self.magnitude),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
            look_ahead=arguments.number("look_ahead", self.look_ahead, low=0),
        )
