"""Actions that move, bounce, sort and kill particles. Part of `motes.actions`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from .._values import arguments
from .._values.curves import Number, Vector
from .._values.values import value
from ..errors import ArgumentError
from ..shapes import Shape, as_shape, as_shapes
from .base import Action, at_least_0

__all__ = [
    "Align",
    "Bounce",
    "KillExpired",
    "KillOld",
    "Move",
    "Rest",
    "Sink",
    "SinkVelocity",
    "Sort",
]


@value()
class Bounce(Action):
    """Makes particles that hit the surface of a shape in this step rebound; record it before `move`.

    With `exact_hit`, the exact point and time of the hit within the step are used, and the particle stays on
    its side. Without it, as in McAllister's library, only the velocity changes if x + v dt is beyond the
    surface; planes have two sides, and spheres use the normal at the old position.

    n is the surface normal at the hit: perpendicular to the axis for a Cylinder's wall, to the slope for a
    Cone's, to the plane for a Triangle; along the axis for flat ends. Of several shapes, the one that is hit
    first counts, and the rest of the step continues from there: in a list they are one surface, whereas of
    two calls the second knows only the path that the first one left.

    Formula: with v split into v_t along and v_n across the surface, v = (1 - friction) v_t - restitution v_n;
    no friction where |v_t| <= min_tangential_speed. exact_hit: x += (v before - v after) (time until the
    hit), which makes `move` end where the rebound does

    Attributes:
        shape: Plane (from above), Rectangle, Triangle and Disc (both sides), Box, Cylinder, Cone and Sphere
            (from outside and from inside; a Sphere's inner radius has no surface), a Mesh, a Union or a list
            of them, m. A mesh that moves must be alone.
        restitution: fraction of the speed across the surface that remains.
        friction: fraction of the speed along the surface that is lost, 0..1.
        min_tangential_speed: no friction up to this speed along the surface, m/s.
        exact_hit: whether the exact point and time of the hit are used.
        hits: whether hits are noted in columns: `hit`, how often the particle has hit something in this frame
            (in all sub-steps and all such calls), and `hit_normal`, the normal of the last hit, (0, 0, 0)
            without one. Both are 0 when a frame's list begins to run. Needs exact_hit.

    Source: McAllister's Bounce; the exact hit and its columns are new here.
    """

    shape: Shape | Sequence[Shape]
    restitution: Number = 1
    friction: Number = 0
    min_tangential_speed: Number = 0
    exact_hit: bool = True
    hits: bool = False

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        hits = arguments.flag("hits", self.hits)
        if hits and not self.exact_hit:
            raise ArgumentError("hits", hits, "False if exact_hit is False, which knows no hits")
        self._set(
            "bounce_counted" if hits else "bounce",
            shape=as_shapes("shape", self.shape),
            restitution=arguments.number("restitution", self.restitution, low=0, high=1e15),
            friction=arguments.number("friction", self.friction, low=0, high=1),
            min_tangential_speed=at_least_0("min_tangential_speed", self.min_tangential_speed),
            exact_hit=arguments.flag("exact_hit", self.exact_hit),
        )
        self.__dict__["hits"] = hits


@value()
class Rest(Action):
    """Lays down what has come to rest on a surface, and holds it there: leaves, snow, confetti.

    Record it after `bounce(..., hits=True)` and before `move`. It acts on a particle that hits a surface in
    the (sub)step and is left with no more than `speed` by the bounce and the actions after it. Such a
    particle stays where it hit, or where it was if it lay there already, to the last bit; its velocity, spin
    and rotational velocity become 0; and it lies down: it turns the shortest way until its own z axis, or the
    opposite one, is within `angle_deg` of the surface's normal.

    Nothing is remembered: what rests must hit again in each step, as it does while gravity or wind press it
    against the surface, on roofs as on the ground. It is free in the step in which

    - something pushes it along the surface so that more than `speed` remains after friction,
    - something lifts it off, so that it does not hit, or
    - the surface below it moves or is gone. A surface that moves carries particles by its friction, and never
      holds them.

    Formula: after a hit, where |v| <= speed: x = the place of the hit, v = 0

    Attributes:
        speed: the highest speed that counts as rest, m/s. One step of gravity adds 0.4 m/s at 24 frames per
            second; on a slope, the part along it remains.
        angle_deg: the largest angle between the z axis and the normal that remains, 0..90 degrees; 0: flat.

    Source: new here.
    """

    speed: Number
    angle_deg: Number = 0

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "rest",
            speed=at_least_0("speed", self.speed),
            angle_deg=arguments.number("angle_deg", self.angle_deg, low=0, high=90),
        )


@value()
class Sink(Action):
    """Kills particles inside a shape, or outside it with inside=False.

    Formula: dead where x is in the shape

    Attributes:
        shape: region of positions, m; of a list of shapes, the region that any of them contains.
        inside: whether particles inside the shape die, or those outside.

    Source: McAllister's Sink.
    """

    shape: Shape | Sequence[Shape]
    inside: bool = True

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("sink", shape=as_shapes("shape", self.shape), inside=arguments.flag("inside", self.inside))


@value()
class SinkVelocity(Action):
    """Kills particles whose velocity is inside a shape, or outside it: slow or fast ones.

    Formula: dead where v is in the shape

    Attributes:
        shape: region of velocities, m/s.
        inside: whether particles inside the shape die, or those outside.

    Source: McAllister's SinkVelocity.
    """

    shape: Shape
    inside: bool = True

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "sink_velocity", shape=as_shape("shape", self.shape), inside=arguments.flag("inside", self.inside)
        )


@value()
class KillOld(Action):
    """Kills particles that have reached an age; with younger=True, kills those that have not.

    Ages do not drift: with `kill_old(24 * dt)` before `move`, a particle appears in 24 pictures.

    Formula: dead where age >= age_limit (younger: age < age_limit)

    Attributes:
        age_limit: the age, s.
        younger: whether younger particles die instead.

    Source: McAllister's KillOld.
    """

    age_limit: Number
    younger: bool = False

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "kill_old",
            age_limit=arguments.number("age_limit", self.age_limit, finite=False),
            younger=arguments.flag("younger", self.younger),
        )


@value()
class KillExpired(Action):
    """Kills particles whose age has reached their lifetime.

    Formula: dead where age >= lifetime

    Source: new here.
    """

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("kill_expired")


@value()
class Align(Action):
    """Turns each particle by the shortest rotation until its own z axis points along a direction.

    The z axis is the front of a card or a mesh, the y axis its top. A particle at rest keeps its orientation
    with `to="velocity"`.

    Formula: orientation turns by at most rate dt

    Attributes:
        to: direction, "velocity" or a vector.
        rate: maximum angular speed, rad/s.
    """

    to: Literal["velocity"] | Vector = "velocity"
    rate: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        to = self.to
        along = isinstance(to, str) and to == "velocity"
        if isinstance(to, str) and not along:
            raise ArgumentError("to", to, "'velocity' or a vector", known=("velocity",))
        vector = (0.0, 0.0, 0.0) if along else arguments.triple("to", to)
        if not along and not any(vector):
            raise ArgumentError("to", to, "'velocity' or a vector other than 0")
        rate = arguments.number("rate", self.rate, low=0, finite=False)
        self._set("align", velocity=float(along), to=vector, rate=rate)
        if along:
            self.__dict__.update(to=to)


@value()
class Move(Action):
    """Moves particles by their velocity, turns them by their rotational velocity and spin, and ages them.

    A particle dies if its position would leave float32's range (3e38 m), or if its velocity is not finite.
    Ages do not drift: n frames after birth at age 0, a particle's age is n dt rounded to float32 once, with
    any number of sub-steps, for 48 hours of film. Other ages stay within four units in the last place.

    Formula: x += v dt; age += dt; with `rotational`, up += rotational_velocity dt, and orientation turns
    about spin by |spin| dt

    Attributes:
        rotational: whether particles turn.

    Source: McAllister's Move.
    """

    rotational: bool = True

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("move", rotational=arguments.flag("rotational", self.rotational))


@value()
class Sort(Action):
    """Sorts particles for drawing: far ones first, so nearer ones cover them.

    Each calculator sorts its own particles, before the picture and before `System.local` shows them. Births,
    deaths and migration disturb the order, so record it in each frame. Pictures do not need it, and particles
    do not change. `gather` sorts by id. With `where`, the other particles keep their places.

    Formula: by (x - eye) . look, from the largest to the smallest; ties by id

    Attributes:
        eye: the viewer's position, m.
        look: the viewing direction; any length.

    Source: McAllister's Sort.
    """

    eye: Vector
    look: Vector

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set("sort", eye=arguments.triple("eye", self.eye), look=arguments.triple("look", self.look))
