"""Actions between particles: each particle interacts with others within reach, on any rank (paper 3.1.5).

They read the state of all particles before the action and sum in an order determined by positions and ids, so
the result is the same on any number of ranks. Record them before `bounce` and `move`. `where` selects which
particles change; all particles count as neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from .. import _core
from .._values import arguments
from .._values.curves import Number
from .._values.ties import Ties
from .._values.values import items_of, value
from .._values.wall import LEAST_STIFFNESS, MOST_STIFFNESS, Wall
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


LEAST_DENSITY = 1e-9  # kg/m^3
STANDARD = Wall()


@value()
class Gravitate(Action):
    """Pulls particles toward each other, more strongly the nearer they are.

    Formula: v_i += sum over 0 < r < max_radius of toward_ij magnitude dt / (r^2 + epsilon), with r the
    distance to particle j, toward_ij the direction to j

    Attributes:
        magnitude: strength, m^3/s^2; negative: particles repel each other.
        epsilon: softens the pull of near particles, m^2.
        max_radius: no pull beyond this distance, m.
        far: "exact" sums every pair; "cells" groups distant particles into cells, with a root mean square
            error of 0.2 to 0.3 %, and needs an infinite `max_radius`.

    Source: McAllister's Gravitate; cells: Barnes and Hut (1986), on the levels of an octree.
    """

    magnitude: Number = 1
    epsilon: Number = 1e-3
    max_radius: Number = math.inf
    far: Literal["exact", "cells"] = "exact"

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        far = arguments.choice("far", self.far, ("exact", "cells"))
        if far == "cells" and self.max_radius != math.inf:
            raise ArgumentError("far", far, "'exact' if max_radius is finite")
        self._set(
            "gravitate",
            magnitude=arguments.number("magnitude", self.magnitude),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
            max_radius=at_least_0("max_radius", self.max_radius),
            cells=int(far == "cells"),
        )
        self.__dict__["far"] = far


@value()
class Follow(Action):
    """Pulls each particle toward the next living particle born after it; the last particle is free.

    Formula: v += toward magnitude dt / (r^2 + epsilon) where r < max_radius, with r the distance to that
    particle, toward the direction to it

    Attributes:
        magnitude: strength, m^3/s^2.
        epsilon: softens the pull of a near particle, m^2.
        max_radius: no pull beyond this distance, m.

    Source: McAllister's Follow.
    """

    magnitude: Number = 1
    epsilon: Number = 1e-3
    max_radius: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "follow",
            magnitude=arguments.number("magnitude", self.magnitude),
            epsilon=arguments.number("epsilon", self.epsilon, low=0),
            max_radius=at_least_0("max_radius", self.max_radius),
        )


@value()
class MatchVelocity(Action):
    """Pulls each particle's velocity toward the velocities of others within reach, as in a flock.

    Formula: v_i += sum over r < max_radius of (v_j - v_i) w_ij / max(1, sum of w_ij), with r the distance to
    particle j, w_ij = magnitude dt / (r^2 + epsilon)

    Attributes:
        magnitude: strength, m^2/s.
        epsilon: softens the effect of near particles, m^2.
        max_radius: no effect beyond this distance, m.

    Source: McAllister's MatchVelocity, which is unstable where the sum of weights is large: here the sum is
    limited to 1.
    """

    magnitude: Number = 1
    epsilon: Number = 1e-3
    max_radius: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        _set_match(self, "match_velocity")


@value()
class MatchRotationalVelocity(Action):
    """Pulls each particle's rotational velocity toward those of others within reach.

    Formula: as `MatchVelocity`, with rotational velocities.

    Attributes:
        magnitude: strength, m^2/s.
        epsilon: softens the effect of near particles, m^2.
        max_radius: no effect beyond this distance, m.

    Source: McAllister's MatchRotationalVelocity; see `MatchVelocity`.
    """

    magnitude: Number = 1
    epsilon: Number = 1e-3
    max_radius: Number = math.inf

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        _set_match(self, "match_rotational_velocity")


@value()
class Collide(Action):
    """Keeps spheres apart, with friction: they push each other until none would overlap after this step.

    Piles come to rest if a frame has enough sub-steps: about dt sqrt(50 g layers / diameter), with g the
    gravity: the length of the sum of the `gravity` actions before this one in the list. Momentum is
    conserved, except for particles that fall asleep; a pair that did not overlap gains no energy. A pair that
    would not touch at the end of a step passes. Sets the attribute `contacts` to the number of particles
    touched in this sub-step.

    Formula: v_i += sum over contacts of f (n out - t min(|t|, friction out) / |t|) w_i / (w_i + w_j), with
    out = overlap after the step / dt, or (1 + restitution) times the approach speed if that is larger,
    restitution > 0 and the approach speed exceeds 0.8 sleep; n the direction from j to i after the step, or
    at the first touch if the pair would gain energy, t the tangential velocity of i relative to j, w = 1 /
    mass, f = min(1, 2 / contacts in the last sub-step of the particle that had more); then v_i = 0 where
    |v_i| < sleep and i touches two or more

    Attributes:
        radius: particle radius, m; None: half of `size[0]`.
        restitution: ratio of the speeds after and before a head-on collision, 0..1.
        friction: Coulomb's coefficient.
        sleep: particles slower than this that touch several others stop, and pairs slower than 0.8 of it do
            not rebound, m/s; None: 2.5 g times the sub-step, so 0 without gravity.
        other: another system: the particles of the two systems collide with each other, and not among
            themselves.
        other_radius: radius of the other system's particles, m; None: half of `size[0]`.
        clear: newborn particles that would overlap others by more than this fraction of their radius after
            the step are removed before they push any (of two newborn ones, the one with the higher id); 0:
            none are removed.

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
        """Check the fields and build the engine's action."""
        radius = None if self.radius is None else _radius("radius", self.radius)
        other_radius = None if self.other_radius is None else _radius("other_radius", self.other_radius)
        restitution = arguments.number("restitution", self.restitution, low=0, high=1)
        friction = arguments.number("friction", self.friction, low=0)
        sleep = None if self.sleep is None else arguments.number("sleep", self.sleep, low=0)
        if other_radius is not None and self.other is None:
            raise ArgumentError("other_radius", other_radius, "None unless other= is given")
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


@value()
class Contact(Action):
    """Lets spheres press, rub and roll on each other like grains (discrete elements).

    Forces and spins (`rotational_velocity`) are physical, unlike those of `collide`. A collision of two
    grains takes pi sqrt(mass / (2 stiffness)) seconds. With 20 sub-steps per collision, the recommended
    minimum, the restitution is accurate to 0.03, with 100 to 0.01, with 300 to 0.001. With fewer than 5,
    springs are softened. Grains that approach by more than a fifth of a radius per sub-step rebound at once.
    Each `contact` action in the list remembers its own contacts (40 bytes per contact). Particles whose mass
    is not positive touch nothing. Walls behave like flat, immovable grains: each keeps a particle on the side
    where its centre is, whichever way a plane's normal points. A body is touched at one point from outside
    and at each face from inside. `World.force` returns the force on a wall. In a system of clumps
    (`System.clumps`), each sphere is a grain with its clump's mass: forces add up to the clump's velocity and
    `spin`, and `contacts` counts the contacts of spheres.

    Formula: force_i = -n (stiffness overlap - damper n.v_ij) + drag, torque_i = arm n x drag - r n x brake,
    with n the direction to particle j, v_ij the velocity of j relative to i, damper = 2 zeta sqrt(stiffness
    m), zeta the damping ratio for the restitution, m and r half the harmonic means of masses and radii; drag
    and brake are forces of springs with 2/7 of the stiffness, stretched by sliding and by rolling, with half
    the damping, limited to friction and rolling_friction times the force along n; the moment of inertia is a
    solid sphere's

    Attributes:
        stiffness: stiffness of the spring between two particles, N/m.
        restitution: ratio of the speeds after and before a head-on collision, 0..1.
        friction: Coulomb's coefficient.
        rolling_friction: coefficient of rolling friction, for rough or angular grains.
        radius: particle radius, m; None: half of `size[0]`.
        walls: shapes with a surface, which this system's particles touch; `(shape, motes.Wall(...))` has its
            own coefficients. A mesh (its distance field) can move within a frame (`moving_from`); other
            shapes are fixed during a frame.
        other: another system: the particles of the two systems touch each other, and not among themselves.
            Both may be spheres or clumps.
        other_radius: radius of the other system's particles, m; None: half of `size[0]`.

    Source: Cundall and Strack (1979), "A discrete numerical model for granular assemblies"; sliding and
    rolling as in Luding (2008), "Cohesive, frictional powders"; scaling on clusters: Henty (2000).
    """

    stiffness: Number
    restitution: Number = 0.5
    friction: Number = 0.5
    rolling_friction: Number = 0
    radius: Number | None = None
    walls: Sequence[Shape | tuple[Shape, Wall]] = ()
    other: System | None = None
    other_radius: Number | None = None

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        radius = None if self.radius is None else _radius("radius", self.radius)
        other_radius = None if self.other_radius is None else _radius("other_radius", self.other_radius)
        if other_radius is not None and self.other is None:
            raise ArgumentError("other_radius", other_radius, "None unless other= is given")
        stiffness = arguments.number("stiffness", self.stiffness, low=LEAST_STIFFNESS, high=MOST_STIFFNESS)
        own = Wall(
            stiffness=stiffness,
            restitution=arguments.number("restitution", self.restitution, low=0, high=1),
            friction=arguments.number("friction", self.friction, low=0),
            rolling_friction=arguments.number("rolling_friction", self.rolling_friction, low=0),
        )
        walls = _walls(self.walls)
        numbers = [(shape, _numbers(wall, own)) for shape, wall in walls]
        self._set("contact", radius=radius or 0.0, **items_of(own), walls=numbers)
        given = tuple(shape if wall == STANDARD else (shape, wall) for shape, wall in walls)
        self.__dict__.update(radius=radius, other_radius=other_radius, walls=given)

    def _counterpart(self) -> Contact:
        """Return the action of the other system, in its own list."""
        own = items_of(self) | {"radius": self.other_radius, "other_radius": None}
        return Contact(**own | {"walls": (), "where": None, "other": None})


@value()
class Fluid(Action):
    """Keeps a liquid's density: particles push each other apart until they are no denser than at rest.

    Give particles that are born `spacing` apart the mass rest_density spacing^3, and set `radius` to twice
    the spacing: each then sees about 30 others. More sub-steps make the liquid stiffer: with 20 per 1/24 s,
    the lowest of 16 layers of 5 cm is 1/6 too dense, with 40 it is 1/20. Use `bounce` to keep a liquid in a
    vessel. Momentum is conserved.

    Formula: at x + v dt, density_i = sum of mass_j W(r); pressure_i brings a density above rest_density down
    to it, but removes only 1/20 of any excess that already exists; v_i += sum of (pressure_i mass_j / mass_i
    + pressure_j) grad W / (rest_density dt) + 10 viscosity dt sum of mass_j / rest_density (v_ij . n / r)
    grad W + cohesion dt sum of mass_j / rest_density C(r) n, with n the direction to particle j, v_ij the
    velocity of j relative to i; W of Mueller et al. (2003), C of Akinci et al. (2013)

    Attributes:
        radius: reach of the interaction, 1e-12 to 1e9 m.
        rest_density: the liquid's density at rest, kg/m^3.
        viscosity: kinematic viscosity, m^2/s; honey has 1e-2. radius^2 / (4000 dt) is always added, so a
            liquid comes to rest; the sum is limited to radius^2 / (24 dt).
        cohesion: attraction between particles, m/s^2; forms drops and strings.

    Source: Macklin and Mueller (2013), "Position based fluids", one iteration, as an action on velocities;
    viscosity: Monaghan (2005), "Smoothed particle hydrodynamics".
    """

    radius: Number
    rest_density: Number
    viscosity: Number = 0
    cohesion: Number = 0

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
        self._set(
            "fluid",
            rest_density=arguments.number("rest_density", self.rest_density, low=LEAST_DENSITY),
            viscosity=arguments.number("viscosity", self.viscosity, low=0),
            radius=arguments.number("radius", self.radius, low=1e-12, high=1e9),
            cohesion=arguments.number("cohesion", self.cohesion),
        )


@value()
class Tie(Action):
    """Holds particles at the distances given by their ties, as in cloth and ropes.

    More sub-steps make ties stiffer: 40 keep a cloth that falls over a ball within a few percent of its size.
    Ties to dead particles do not pull. Pinned particles do not move unless the script moves them. Each bit of
    `torn` represents one of a particle's ties, in the order of its partners' ids. Ties that can tear must not
    share particles with the other `tie` actions in the list, and a script that replaces ties must set `torn`
    to 0. In periodic space ties pull toward the nearest image; tethers longer than half a period have no
    effect.

    Formula: at x + v dt, correction_ij = -w_i (r - length) / (w_i + w_j + compliance / dt^2) along the tie,
    with w = 1 / mass; x_i moves by 1.8 times the mean of its corrections, less where they all point the same
    way; v_i is the velocity that takes it there

    Attributes:
        ties: the result of `System.cloth` or `System.rope`, or a `motes.Ties`.
        stretch: compliance of ties between neighbours, m/N; 0: as stiff as the sub-steps allow.
        shear: compliance of diagonal ties, m/N.
        bend: compliance of ties between second neighbours, m/N.
        damping: rate at which a particle takes on its partners' velocity, 1/s.
        break_at: a tie tears when stretched beyond this many times its length.
        tethers: whether particles are kept from moving farther from pinned particles than the ties between
            them allow.

    Source: Macklin et al. (2016), "XPBD", one iteration, computed per particle, as an action on velocities.
    """

    ties: Ties
    stretch: Number = 0
    shear: Number = 0
    bend: Number = 1e-3
    damping: Number = 0
    break_at: Number = math.inf
    tethers: bool = True

    def __post_init__(self) -> None:
        """Check the fields and build the engine's action."""
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
        """Return the engine's action for a system with these columns."""
        name, numbers, own, _ = self.__dict__["_call"]
        shapes = list(own)
        where = condition_of(self.where, columns, shapes)
        return _core.Action(name, numbers, shapes, where, ties=self.ties.__dict__["_name"])


def compiled_for_clumps(action: Contact, clump: Clump, columns: Columns) -> _core.Action:
    """Return the engine's contact action for a system of clumps with these columns."""
    _, numbers, own, more = action.__dict__["_call"]
    shapes = list(own)
    where = condition_of(action.where, columns, shapes)
    from .._values.clump import law_of

    of_clump, table = law_of(clump)
    return _core.Action("contact_clumps", numbers | of_clump, shapes, where, table=table, **more)


def counterpart_of(action: Contact) -> Contact:
    """Return what the list of `action.other` gets."""
    return action._counterpart()


def _radius(argument: str, given: Any) -> float:
    radius = arguments.number(argument, given, low=0)
    if radius == 0:
        raise ArgumentError(argument, given, "above 0, or None for half of size[0]")
    return radius


def _walls(given: Any) -> list[tuple[Shape, Wall]]:
    """Return shapes with their coefficients, given as a shape, a pair, or a list of both."""
    alone = isinstance(given, Shape) or _is_pair(given)
    walls = (given,) if alone else given
    if not isinstance(walls, (list, tuple)) or not all(isinstance(w, Shape) or _is_pair(w) for w in walls):
        allowed = "a shape with a surface, a pair (shape, motes.Wall(...)), or a list of them"
        raise ArgumentError("walls", given, allowed)
    return [(wall, STANDARD) if isinstance(wall, Shape) else tuple(wall) for wall in walls]


def _is_pair(given: Any) -> bool:
    return (
        isinstance(given, (list, tuple))
        and len(given) == 2
        and isinstance(given[0], Shape)
        and isinstance(given[1], Wall)
    )


def _numbers(wall: Wall, call: Wall) -> tuple[float, ...]:
    """Return a wall's coefficients, or those of the call where it has none."""
    of_call = items_of(call)
    return tuple(of_call[name] if one is None else one for name, one in items_of(wall).items())


def _set_match(action: MatchVelocity | MatchRotationalVelocity, name: str) -> None:
    action._set(
        name,
        magnitude=arguments.number("magnitude", action.magnitude, low=0),
        epsilon=arguments.number("epsilon", action.epsilon, low=0),
        max_radius=at_least_0("max_radius", action.max_radius),
    )
