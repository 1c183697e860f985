"""BetweenRecorder: a method for each action of `between` and `laws`. Written by `.ci/recorder`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from .. import actions
from .._values.curves import Number
from .._values.values import says_near_names
from ..actions.base import Where
from ..shapes import Shape
from .recording import Recording

if TYPE_CHECKING:
    from .._values.ties import Ties
    from .._values.wall import Wall
    from .system import System

__all__ = ["BetweenRecorder"]


class BetweenRecorder(Recording):
    """What particles do that see each other; laws."""

    @says_near_names
    def gravitate(
        self,
        magnitude: Number = 1,
        epsilon: Number = 0.001,
        max_radius: Number = math.inf,
        far: Literal["exact", "cells"] = "exact",
        *,
        where: Where = None,
    ) -> None:
        """Pulls particles toward each other, more strongly the nearer they are.

        Records `actions.Gravitate`.

        Args:
            magnitude: strength, m^3/s^2; negative: particles repel each other.
            epsilon: softens the pull of near particles, m^2.
            max_radius: no pull beyond this distance, m.
            far: "exact" sums every pair; "cells" groups distant particles into cells, with a root mean square
                error of 0.2 to 0.3 %, and needs an infinite `max_radius`.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.Gravitate(
                magnitude=magnitude, epsilon=epsilon, max_radius=max_radius, far=far, where=where
            )
        )

    @says_near_names
    def follow(
        self,
        magnitude: Number = 1,
        epsilon: Number = 0.001,
        max_radius: Number = math.inf,
        *,
        where: Where = None,
    ) -> None:
        """Pulls each particle toward the next living particle born after it; the last particle is free.

        Records `actions.Follow`.

        Args:
            magnitude: strength, m^3/s^2.
            epsilon: softens the pull of a near particle, m^2.
            max_radius: no pull beyond this distance, m.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Follow(magnitude=magnitude, epsilon=epsilon, max_radius=max_radius, where=where))

    @says_near_names
    def match_velocity(
        self,
        magnitude: Number = 1,
        epsilon: Number = 0.001,
        max_radius: Number = math.inf,
        *,
        where: Where = None,
    ) -> None:
        """Pulls each particle's velocity toward the velocities of others within reach, as in a flock.

        Records `actions.MatchVelocity`.

        Args:
            magnitude: strength, m^2/s.
            epsilon: softens the effect of near particles, m^2.
            max_radius: no effect beyond this distance, m.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.MatchVelocity(magnitude=magnitude, epsilon=epsilon, max_radius=max_radius, where=where)
        )

    @says_near_names
    def match_rotational_velocity(
        self,
        magnitude: Number = 1,
        epsilon: Number = 0.001,
        max_radius: Number = math.inf,
        *,
        where: Where = None,
    ) -> None:
        """Pulls each particle's rotational velocity toward those of others within reach.

        Records `actions.MatchRotationalVelocity`.

        Args:
            magnitude: strength, m^2/s.
            epsilon: softens the effect of near particles, m^2.
            max_radius: no effect beyond this distance, m.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.MatchRotationalVelocity(
                magnitude=magnitude, epsilon=epsilon, max_radius=max_radius, where=where
            )
        )

    @says_near_names
    def collide(
        self,
        radius: Number | None = None,
        restitution: Number = 0,
        friction: Number = 0.5,
        sleep: Number | None = None,
        other: System | None = None,
        other_radius: Number | None = None,
        clear: Number = 0,
        *,
        where: Where = None,
    ) -> None:
        """Keeps spheres apart, with friction: they push each other until none would overlap after this step.

        Records `actions.Collide`.

        Args:
            radius: particle radius, m; None: half of `size[0]`.
            restitution: ratio of the speeds after and before a head-on collision, 0..1.
            friction: Coulomb's coefficient.
            sleep: particles slower than this that touch several others stop, and pairs slower than 0.8 of it
                do not rebound, m/s; None: 2.5 g times the sub-step, so 0 without gravity.
            other: another system: the particles of the two systems collide with each other, and not among
                themselves.
            other_radius: radius of the other system's particles, m; None: half of `size[0]`.
            clear: newborn particles that would overlap others by more than this fraction of their radius
                after the step are removed before they push any (of two newborn ones, the one with the higher
                id); 0: none are removed.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.Collide(
                radius=radius,
                restitution=restitution,
                friction=friction,
                sleep=sleep,
                other=other,
                other_radius=other_radius,
                clear=clear,
                where=where,
            )
        )

    @says_near_names
    def contact(
        self,
        stiffness: Number,
        restitution: Number = 0.5,
        friction: Number = 0.5,
        rolling_friction: Number = 0,
        radius: Number | None = None,
        walls: Sequence[Shape | tuple[Shape, Wall]] = (),
        other: System | None = None,
        other_radius: Number | None = None,
        *,
        where: Where = None,
    ) -> None:
        """Lets spheres press, rub and roll on each other like grains (discrete elements).

        Records `actions.Contact`.

        Args:
            stiffness: stiffness of the spring between two particles, N/m.
            restitution: ratio of the speeds after and before a head-on collision, 0..1.
            friction: Coulomb's coefficient.
            rolling_friction: coefficient of rolling friction, for rough or angular grains.
            radius: particle radius, m; None: half of `size[0]`.
            walls: shapes with a surface, which this system's particles touch; `(shape, motes.Wall(...))` has
                its own coefficients. A mesh (its distance field) can move within a frame (`moving_from`);
                other shapes are fixed during a frame.
            other: another system: the particles of the two systems touch each other, and not among
                themselves. Both may be spheres or clumps.
            other_radius: radius of the other system's particles, m; None: half of `size[0]`.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.Contact(
                stiffness=stiffness,
                restitution=restitution,
                friction=friction,
                rolling_friction=rolling_friction,
                radius=radius,
                walls=walls,
                other=other,
                other_radius=other_radius,
                where=where,
            )
        )

    @says_near_names
    def fluid(
        self,
        radius: Number,
        rest_density: Number,
        viscosity: Number = 0,
        cohesion: Number = 0,
        *,
        where: Where = None,
    ) -> None:
        """Keeps a liquid's density: particles push each other apart until they are no denser than at rest.

        Records `actions.Fluid`.

        Args:
            radius: reach of the interaction, 1e-12 to 1e9 m.
            rest_density: the liquid's density at rest, kg/m^3.
            viscosity: kinematic viscosity, m^2/s; honey has 1e-2. radius^2 / (4000 dt) is always added, so a
                liquid comes to rest; the sum is limited to radius^2 / (24 dt).
            cohesion: attraction between particles, m/s^2; forms drops and strings.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.Fluid(
                radius=radius, rest_density=rest_density, viscosity=viscosity, cohesion=cohesion, where=where
            )
        )

    @says_near_names
    def tie(
        self,
        ties: Ties,
        stretch: Number = 0,
        shear: Number = 0,
        bend: Number = 0.001,
        damping: Number = 0,
        break_at: Number = math.inf,
        tethers: bool = True,
        *,
        where: Where = None,
    ) -> None:
        """Holds particles at the distances given by their ties, as in cloth and ropes.

        Records `actions.Tie`.

        Args:
            ties: the result of `System.cloth` or `System.rope`, or a `motes.Ties`.
            stretch: compliance of ties between neighbours, m/N; 0: as stiff as the sub-steps allow.
            shear: compliance of diagonal ties, m/N.
            bend: compliance of ties between second neighbours, m/N.
            damping: rate at which a particle takes on its partners' velocity, 1/s.
            break_at: a tie tears when stretched beyond this many times its length.
            tethers: whether particles are kept from moving farther from pinned particles than the ties
                between them allow.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.Tie(
                ties=ties,
                stretch=stretch,
                shear=shear,
                bend=bend,
                damping=damping,
                break_at=break_at,
                tethers=tethers,
                where=where,
            )
        )

    @says_near_names
    def law(
        self,
        *,
        acceleration: Any = None,
        velocity: Any = None,
        set: Mapping[str, Any] | None = None,
        where: Where = None,
    ) -> None:
        """Applies a custom law, written as expressions of columns, to each particle.

        Records `actions.Law`.

        Args:
            acceleration: m/s^2: a vector or an expression.
            velocity: change of velocity in each (sub)step, m/s.
            set: new values of attributes, by name.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Law(acceleration=acceleration, velocity=velocity, set=set, where=where))

    @says_near_names
    def interact(
        self,
        radius: Number,
        *,
        acceleration: Any = None,
        velocity: Any = None,
        spin: Any = None,
        set: Mapping[str, Any] | None = None,
        state: Mapping[str, int] | None = None,
        other: System | None = None,
        where: Where = None,
    ) -> None:
        """Applies a custom law, written as expressions, to pairs of particles.

        Records `actions.Interact`.

        Args:
            radius: reach of the interaction, m.
            acceleration: acceleration of a due to b, m/s^2: a vector or an expression.
            velocity: change of a's velocity due to b in each (sub)step, m/s.
            spin: change of a's spin due to b in each (sub)step, rad/s.
            set: new values by name: of state variables, and of attributes of a, which become the sum over all
                b.
            state: names of a pair's state variables, and the size of each: 1 or 3 numbers, at most 96 in all.
            other: another system, to which b belongs; its particles do not change.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.Interact(
                radius=radius,
                acceleration=acceleration,
                velocity=velocity,
                spin=spin,
                set=set,
                state=state,
                other=other,
                where=where,
            )
        )
