"""Actions between particles: each sees the others within its reach, wherever they are (paper 3.1.5).

They read what all particles were before and sum in an order that positions and ids give, so the result is the
same on any number of ranks. They stand before `bounce` and `move`. `where` says who is changed; all are seen.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from .. import _core
from .._values import arguments
from .._values.curves import Number
from .._values.ties import Ties
from .._values.values import value
from ..errors import ArgumentError
from ..expressions._conditions import Columns, condition_of
from ..shapes import Shape
from .base import Action, at_least_0

if TYPE_CHECKING:
    from .._system.system import System
    from .._values.clump import Clump

__all__ = [
    "Collide",
    "Contact",
    "Fluid",
    "Follow",
    "Gravitate",
    "MatchRotationalVelocity",
    "MatchVelocity",
    "Tie",
]


LEAST_STIFFNESS = 1e-9  # N/m
LEAST_DENSITY = 1e-9  # kg/m^3


@value(kw_only=True)
class Gravitate(Action):
    """Draws particles to each other, more strongly the nearer they are.

    Formula: v_i += sum over 0 < r < max_radius of toward_ij magnitude dt / (r^2 + epsilon), with r the
    distance to particle j, toward_ij the direction to it

    Attributes:
        magnitude: strength, m^3/s^2; negative: particles repel each other.
        epsilon: softens the pull of those that are near, m^2.
        max_radius: no pull beyond this distance, m.
        far: "exact", every pair; or "cells": distant particles are grouped into cells, with a root mean
            square error of 0.2 to 0.3 %; needs an infinite `max_radius`.

    Source: McAllister's Gravitate; cells: Barnes and Hut (1986), on the levels of a cube.
    """

    magnitude: Number = 1
    epsilon: Number = 1e-3
    max_radius: Number = math.inf
    far: Literal["exact", "cells"] = "exact"

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        far = arguments.choice("far", self.far, ("exact", "cells"))
        if far == "cells" and self.max_radius != math.inf:
            raise ArgumentError("far", far, "'exact' where max_radius is finite")
        self._set(
            "gravitate",
            magnitude=arguments.number("magnitude", self.magnitude),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
            max_radius=at_least_0("max_radius", self.max_radius),
            cells=int(far == "cells"),
        )
        self.__dict__["far"] = far


@value(kw_only=True)
class Follow(Action):
    """Draws each particle to the next living one that was born after it; the last one goes free.

    Formula: v += toward magnitude dt / (r^2 + epsilon) where r < max_radius, with r the distance to that
    particle, toward the direction to it

    Attributes:
        magnitude: strength, m^3/s^2.
        epsilon: softens the pull of one that is near, m^2.
        max_radius: no pull beyond this distance, m.

    Source: McAllister's Follow.
    """

    magnitude: Number = 1
    epsilon: Number = 1e-3
    max_radius: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        self._set(
            "follow",
            magnitude=arguments.number("magnitude", self.magnitude),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
            max_radius=at_least_0("max_radius", self.max_radius),
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

    magnitude: Number = 1
    epsilon: Number = 1e-3
    max_radius: Number = math.inf

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

    magnitude: Number = 1
    epsilon: Number = 1e-3
    max_radius: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        _set_match(self, "match_rotational_velocity")


@value(kw_only=True)
class Collide(Action):
    """Keeps spheres apart, with friction: they push each other so that none overlap after this step.

    Piles come to rest if a frame has enough sub-steps: about dt sqrt(50 g layers / diameter). Momentum is
    conserved, except for particles that fall asleep. `contacts` becomes the number of others that a particle
    touches in this sub-step.

    Formula: v_i += sum over contacts of f (n out - t min(|t|, friction out) / |t|) w_i / (w_i + w_j),
    with out = overlap after the step / dt, or (1 + restitution) times the speed of approach where that is
    above 2 g dt and gives more (never with a restitution of 0), n the direction from j to i, t the velocity
    of i relative to j along the contact, w = 1 / mass, f = min(1, 2 / contacts of the busier in the last
    sub-step); then v_i = 0 where |v_i| < sleep and two or more touch

    Attributes:
        radius: of the particles, m; None: half of `size[0]`.
        restitution: speed after a head-on collision to that before, 0..1.
        friction: Coulomb's coefficient.
        sleep: particles that touch several others and are slower stop, m/s; None: 2.5 g times the sub-step.
        other: another system: its particles collide with these, and none among themselves.
        other_radius: of its particles, m; None: half of `size[0]`.
        clear: newborn particles that overlap others by more than this part of their radius after the step are
            removed (of two newborn ones that of the higher id), before they push anybody. 0: none are.

    Source: Mueller et al. (2007), "Position based dynamics", one iteration, as an action on velocities.
    """

    radius: Number | None = None
    restitution: Number = 0
    friction: Number = 0.5
    sleep: Number | None = None
    other: System | None = None
    other_radius: Number | None = None
    clear: Number = 0

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
            clear=arguments.number("clear", self.clear, low=0, high=1),
        )
        self.__dict__.update(radius=radius, sleep=sleep, other_radius=other_radius)


@value(kw_only=True)
class Contact(Action):
    """Lets spheres press, rub and roll on each other like grains (discrete elements).

    Forces and spins (`rotational_velocity`) are physical, unlike those of `collide`. Two grains touch for pi
    sqrt(mass / (2 stiffness)); a sub-step should be a twentieth of that, which gives the restitution to 0.03,
    with 100 sub-steps per touch to 0.01, with 300 to a thousandth. Above a fifth, springs are softened. Each
    contact of a list remembers its own touches (40 bytes each). Particles without a positive mass touch
    nobody. Walls are like flat grains that nothing moves: each
    holds a particle on the side where its centre is, whichever way a plane's normal points. Bodies are
    touched at one point from outside, at each face from inside. Of a system of clumps
    (`System.clumps`), each sphere is a grain with its clump's mass: pushes add up to the clump's velocity and
    `spin`, and `contacts` counts touches of spheres.

    Formula: force_i = -n (stiffness overlap - damper n.v_ij) + drag, torque_i = arm n x drag - r n x brake,
    with n the direction to particle j, v_ij its velocity seen from here, damper = 2 zeta sqrt(stiffness m),
    zeta that of the restitution, m and r half the harmonic means of masses and radii; drag and brake of
    springs of 2/7 of the stiffness, drawn out by sliding and by rolling and damped half as much, at most
    friction and rolling_friction times the force along n; a solid sphere's moment of inertia

    Attributes:
        stiffness: of the spring between two particles, N/m.
        restitution: speed after a head-on collision of two to that before, 0..1.
        friction: Coulomb's coefficient.
        rolling_friction: the same for rolling, as rough or angular grains have it.
        radius: of the particles, m; None: half of `size[0]`.
        walls: shapes with a surface. A mesh (its grid of distances) may be `moving_from` another place; other
            shapes stand still within a frame.

    Source: Cundall and Strack (1979), "A discrete numerical model for granular assemblies"; sliding and
    rolling as in Luding (2008), "Cohesive, frictional powders"; its scaling on clusters: Henty (2000).
    """

    stiffness: Number
    restitution: Number = 0.5
    friction: Number = 0.5
    rolling_friction: Number = 0
    radius: Number | None = None
    walls: Sequence[Shape] = ()

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        radius = None if self.radius is None else _radius("radius", self.radius)
        self._set(
            "contact",
            radius=radius or 0.0,
            restitution=arguments.number("restitution", self.restitution, low=0, high=1),
            friction=arguments.number("friction", self.friction, low=0),
            stiffness=arguments.number("stiffness", self.stiffness, low=LEAST_STIFFNESS),
            rolling_friction=arguments.number("rolling_friction", self.rolling_friction, low=0),
            walls=_walls(self.walls),
        )
        self.__dict__["radius"] = radius


@value(kw_only=True)
class Fluid(Action):
    """Keeps a liquid's density: particles push each other apart until they are no denser than at rest.

    A particle's mass is what it stands for: rest_density spacing^3, where they are born `spacing` apart;
    `radius` is twice the spacing, so that each sees some 30 others. Stiffness comes from sub-steps: with 20
    per 24th of a second the lowest of 16 layers of 5 cm is a sixth too dense, with 40 a 20th. `bounce` keeps
    a liquid in a vessel. Momentum is conserved.

    Formula: at x + v dt, density_i = sum of mass_j W(r); pressure_i such that it would come to rest_density
    if it is above that; what was above already comes down by a 20th; v_i += sum of (pressure_i mass_j /
    mass_i + pressure_j) grad W / (rest_density dt) + 10 viscosity dt sum of mass_j / rest_density
    (v_ij . n / r) grad W + cohesion dt sum of mass_j / rest_density C(r) n, with n the direction to particle
    j, v_ij its velocity seen from here; W of Mueller et al. (2003), C of Akinci et al. (2013)

    Attributes:
        radius: how far particles see each other, 1e-4 to 1e6 m.
        rest_density: of the liquid, kg/m^3.
        viscosity: kinematic, m^2/s: 1e-2 is honey; what is above radius^2 / (24 dt) has no effect, and
            radius^2 / (4000 dt) are always there, so that a liquid comes to rest.
        cohesion: draws particles to each other, m/s^2: drops and strings.

    Source: Macklin and Mueller (2013), "Position based fluids", one iteration, as an action on velocities;
    viscosity: Monaghan (2005), "Smoothed particle hydrodynamics".
    """

    radius: Number
    rest_density: Number
    viscosity: Number = 0
    cohesion: Number = 0

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        self._set(
            "fluid",
            rest_density=arguments.number("rest_density", self.rest_density, low=LEAST_DENSITY),
            viscosity=arguments.number("viscosity", self.viscosity, low=0),
            radius=arguments.number("radius", self.radius, low=1e-4, high=1e6),
            cohesion=arguments.number("cohesion", self.cohesion),
        )


@value(kw_only=True)
class Tie(Action):
    """Holds particles at the distances that ties give them, as in cloth and ropes.

    Stiffness comes from sub-steps: 40 keep a cloth that falls over a ball within a few percent of its size.
    Ties to dead particles do not pull. Pinned particles stand still unless the script moves them. Each bit of
    `torn` stands for one of a particle's ties, in the order of its partners' ids. Ties that can tear must not
    share particles with other ties of the list, and a script that replaces ties sets `torn` to 0. In periodic
    space ties go to the nearest image; tethers longer than half a period do nothing.

    Formula: at x + v dt, correction_ij = -w_i (r - length) / (w_i + w_j + compliance / dt^2) along the tie,
    with w = 1 / mass; x_i moves by 1.8 times the mean of its corrections, less where
    they all point the same way; v_i is what takes it there

    Attributes:
        ties: of `System.cloth`, `System.rope`, or `motes.Ties`.
        stretch: compliance of ties between neighbours, m/N; 0: as stiff as the sub-steps allow.
        shear: of those across the meshes, m/N.
        bend: of those between the next but one, m/N.
        damping: how fast a particle takes on its partners' velocity, 1/s.
        break_at: a tie that is longer than so many times its length tears.
        tethers: keep particles from getting farther away from pinned ones than along the ties.

    Source: Macklin et al. (2016), "XPBD", one iteration, each particle by itself, as an action on velocities.
    """

    ties: Ties
    stretch: Number = 0
    shear: Number = 0
    bend: Number = 1e-3
    damping: Number = 0
    break_at: Number = math.inf
    tethers: bool = True

    def __post_init__(self) -> None:
        """Check the fields and make the engine's value."""
        if not isinstance(self.ties, Ties):
            raise ArgumentError("ties", self.ties, "what cloth() or rope() returned, or motes.Ties")
        self._set(
            "tie",
            stretch=arguments.number("stretch", self.stretch, low=0),
            shear=arguments.number("shear", self.shear, low=0),
            bend=arguments.number("bend", self.bend, low=0),
            damping=arguments.number("damping", self.damping, low=0),
            break_at=arguments.number("break_at", self.break_at, low=1, finite=False),
            tethers=arguments.flag("tethers", self.tethers),
        )

    def _compiled(self, columns: Columns, others: Columns | None = None) -> _core.Action:
        """Return the engine's value for a system with these columns."""
        name, numbers, own = self.__dict__["_call"]
        shapes = list(own)
        where = condition_of(self.where, columns, shapes)
        return _core.Action(name, numbers, shapes, where, ties=self.ties.__dict__["_name"])


def compiled_for_clumps(action: Contact, clump: Clump, columns: Columns) -> _core.Action:
    """Return the engine's value of a contact for a system of clumps with these columns."""
    if action.radius is not None:
        raise ArgumentError("radius", action.radius, "None for clumps, whose spheres have their own")
    _, numbers, own = action.__dict__["_call"]
    shapes = list(own)
    where = condition_of(action.where, columns, shapes)
    from .._values.clump import law_of

    of_clump, table = law_of(clump)
    return _core.Action("contact_clumps", numbers | of_clump, shapes, where, table=table)


def _radius(argument: str, given: Any) -> float:
    radius = arguments.number(argument, given, low=0)
    if radius == 0:
        raise ArgumentError(argument, given, "above 0, or None for half of size[0]")
    return radius


def _walls(given: Any) -> tuple[Shape, ...]:
    if isinstance(given, Shape):
        return (given,)
    if not isinstance(given, (list, tuple)) or not all(isinstance(wall, Shape) for wall in given):
        raise ArgumentError("walls", given, "a shape with a surface, or a list of them")
    return tuple(given)


def _set_match(action: MatchVelocity | MatchRotationalVelocity, name: str) -> None:
    action._set(
        name,
        magnitude=arguments.number("magnitude", action.magnitude, low=0),
        epsilon=arguments.number("epsilon", action.epsilon, low=0),
        max_radius=at_least_0("max_radius", action.max_radius),
    )
