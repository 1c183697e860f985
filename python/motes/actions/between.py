"""Actions between particles: each sees the others within its reach, wherever they are (paper 3.1.5).

They read what all particles were before and sum in an order that positions and ids give, so the result is the
same on any number of ranks. They stand before `bounce` and `move`. `where` says who is changed; all are seen.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from .. import arguments
from ..errors import ArgumentError
from ..values import value
from .base import Action, at_least_0

if TYPE_CHECKING:
    from ..system import System

__all__ = ["Collide", "Gravitate", "MatchRotationalVelocity", "MatchVelocity"]


@value(kw_only=True)
class Gravitate(Action):
    """Draws particles to each other, more strongly the nearer they are; not those at the same place.

    Formula: v_i += sum over r < max_radius of toward_ij magnitude dt / (r^2 + epsilon), with r the distance
    to particle j, toward_ij the direction to it

    Attributes:
        magnitude: strength, m^3/s^2; negative: particles repel each other.
        epsilon: softens the pull of those that are near, m^2.
        max_radius: no pull beyond this distance, m.

    Source: McAllister's Gravitate.
    """

    magnitude: float = 1
    epsilon: float = 1e-3
    max_radius: float = math.inf

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        self._set(
            "gravitate",
            magnitude=arguments.number("magnitude", self.magnitude),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
            max_radius=at_least_0("max_radius", self.max_radius),
            far=0,
        )


@value(kw_only=True)
class MatchVelocity(Action):
    """Draws each particle's velocity to those of the others within reach, as in a flock.

    Formula: v_i += sum over r < max_radius of (v_j - v_i) w_ij / max(1, sum of w_ij), with r the distance to
    particle j, w_ij = magnitude dt / (r^2 + epsilon)

    Attributes:
        magnitude: strength, m^2/s.
        epsilon: softens the effect of those that are near, m^2.
        max_radius: no effect beyond this distance, m.

    Source: McAllister's MatchVelocity, whose sums are unstable where weights are large: here they count for
    at most 1.
    """

    magnitude: float = 1
    epsilon: float = 1e-3
    max_radius: float = math.inf

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        _set_match(self, "match_velocity")


@value(kw_only=True)
class MatchRotationalVelocity(Action):
    """Draws each particle's rotational velocity to those of the others within reach.

    Formula: as `MatchVelocity`, with rotational velocities.

    Attributes:
        magnitude: strength, m^2/s.
        epsilon: softens the effect of those that are near, m^2.
        max_radius: no effect beyond this distance, m.

    Source: McAllister's MatchRotationalVelocity; see `MatchVelocity`.
    """

    magnitude: float = 1
    epsilon: float = 1e-3
    max_radius: float = math.inf

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        _set_match(self, "match_rotational_velocity")


@value(kw_only=True)
class Collide(Action):
    """Keeps spheres apart: they push each other so that they will not overlap after this step, with friction.

    Piles come to rest where a frame has enough sub-steps: about dt sqrt(50 g layers / diameter) of them
    keep the mean overlap at 5 % under so many layers. Momentum is kept, but for particles that fall asleep. In each
    sub-step, `contacts` becomes the number of others that a particle touches. A particle that gets farther
    than the sum of two radii in a sub-step may pass through another.

    Formula: v_i += sum over contacts of f (n out - t min(|t|, friction out) / |t|) w_i / (w_i + w_j),
    with out = overlap after the step / dt, n the direction from j to i, t the velocity of i relative to j along the
    contact, w = 1 / mass, f = min(1, 2 / contacts of the busier in the last sub-step); then v_i = 0 where
    |v_i| < sleep and two or more touch

    Attributes:
        radius: of the particles, m; None: half of `size[0]`.
        restitution: speed after a head-on collision to that before, 0..1.
        friction: Coulomb's coefficient.
        sleep: particles that touch several others and are slower stop, m/s; None: 2.5 g times the sub-step.
        other: another system: its particles collide with these, and none among themselves.
        other_radius: of its particles, m; None: half of `size[0]`.

    Source: Mueller et al. (2007), "Position based dynamics", one iteration, as an action on velocities.
    """

    radius: float | None = None
    restitution: float = 0
    friction: float = 0.5
    sleep: float | None = None
    other: System | None = None
    other_radius: float | None = None

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        radius = None if self.radius is None else _radius("radius", self.radius)
        other_radius = None if self.other_radius is None else _radius("other_radius", self.other_radius)
        restitution = arguments.number("restitution", self.restitution, low=0, high=1)
        friction = arguments.number("friction", self.friction, low=0)
        sleep = None if self.sleep is None else arguments.number("sleep", self.sleep, low=0)
        if other_radius is not None and self.other is None:
            raise ArgumentError("other_radius", other_radius, "None where no other system is given")
        self._set(
            "collide",
            radius=radius or 0.0,
            restitution=restitution,
            friction=friction,
            sleep=-1.0 if sleep is None else sleep,
            other_radius=other_radius or 0.0,
            clear=0.0,
            second=0,
        )
        self.__dict__.update(radius=radius, sleep=sleep, other_radius=other_radius)


def _radius(argument: str, given: Any) -> float:
    radius = arguments.number(argument, given, low=0)
    if radius == 0:
        raise ArgumentError(argument, given, "above 0, or None for half of size[0]")
    return radius


def _set_match(action: MatchVelocity | MatchRotationalVelocity, name: str) -> None:
    action._set(
        name,
        magnitude=arguments.number("magnitude", action.magnitude, low=0),
        epsilon=arguments.number("epsilon", action.epsilon, low=0),
        max_radius=at_least_0("max_radius", action.max_radius),
    )
