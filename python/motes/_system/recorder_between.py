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
        """Draws particles to each other, more strongly the nearer they are.

        Records `actions.Gravitate`.

        Args:
            magnitude: strength, m^3/s^2; negative: particles repel each other.
            epsilon: softens the pull of those that are near, m^2.
            max_radius: no pull beyond this distance, m.
            far: "exact", every pair; or "cells": distant particles are grouped into cells, with a root mean
                square error of 0.2 to 0.3 %; needs an infinite `max_radius`.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
        """Draws each particle to the next living one that was born after it; the last one goes free.

        Records `actions.Follow`.

        Args:
            magnitude: strength, m^3/s^2.
            epsilon: softens the pull of one that is near, m^2.
            max_radius: no pull beyond this distance, m.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
        """Draws each particle's velocity to those of the others within reach, as in a flock.

        Records `actions.MatchVelocity`.

        Args:
            magnitude: strength, m^2/s.
            epsilon: softens the effect of those that are near, m^2.
            max_radius: no effect beyond this distance, m.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
        """Draws each particle's rotational velocity to those of the others within reach.

        Records `actions.MatchRotationalVelocity`.

        Args:
            magnitude: strength, m^2/s.
            epsilon: softens the effect of those that are near, m^2.
            max_radius: no effect beyond this distance, m.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
        """Keeps spheres apart, with friction: they push each other so that none overlap after this step.

        Records `actions.Collide`.

        Args:
            radius: of the particles, m; None: half of `size[0]`.
            restitution: speed after a head-on collision to that before, 0..1.
            friction: Coulomb's coefficient.
            sleep: particles that touch several others and are slower stop, m/s; None: 2.5 g times the
                sub-step.
            other: another system: its particles collide with these, and none among themselves.
            other_radius: of its particles, m; None: half of `size[0]`.
            clear: newborn particles that overlap others by more than this part of their radius after the step
                are removed (of two newborn ones that of the higher id), before they push anybody. 0: none
                are.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
        walls: Sequence[Shape] = (),
        *,
        where: Where = None,
    ) -> None:
        """Lets spheres press, rub and roll on each other like grains (discrete elements).

        Records `actions.Contact`.

        Args:
            stiffness: of the spring between two particles, N/m.
            restitution: speed after a head-on collision of two to that before, 0..1.
            friction: Coulomb's coefficient.
            rolling_friction: the same for rolling, as rough or angular grains have it.
            radius: of the particles, m; None: half of `size[0]`.
            walls: shapes with a surface. A mesh (its grid of distances) may be `moving_from` another place;
                other shapes stand still within a frame.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
        """
        self._record(
            actions.Contact(
                stiffness=stiffness,
                restitution=restitution,
                friction=friction,
                rolling_friction=rolling_friction,
                radius=radius,
                walls=walls,
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
            radius: how far particles see each other, 1e-4 to 1e6 m.
            rest_density: of the liquid, kg/m^3.
            viscosity: kinematic, m^2/s: 1e-2 is honey; what is above radius^2 / (24 dt) has no effect, and
                radius^2 / (4000 dt) are always there, so that a liquid comes to rest.
            cohesion: draws particles to each other, m/s^2: drops and strings.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
        """Holds particles at the distances that ties give them, as in cloth and ropes.

        Records `actions.Tie`.

        Args:
            ties: of `System.cloth`, `System.rope`, or `motes.Ties`.
            stretch: compliance of ties between neighbours, m/N; 0: as stiff as the sub-steps allow.
            shear: of those across the meshes, m/N.
            bend: of those between the next but one, m/N.
            damping: how fast a particle takes on its partners' velocity, 1/s.
            break_at: a tie that is longer than so many times its length tears.
            tethers: keep particles from getting farther away from pinned ones than along the ties.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
        """Lets each particle obey a law of the script's own, written as expressions of its columns.

        Records `actions.Law`.

        Args:
            acceleration: m/s^2: a vector or an expression.
            velocity: what is added to the velocity in each (sub)step, m/s.
            set: values of attributes, by name.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
        """Applies a pair law of the script's own, written as expressions.

        Records `actions.Interact`.

        Args:
            radius: how far particles see each other, m.
            acceleration: of a by b, m/s^2: a vector or an expression.
            velocity: what b adds to the velocity of a in each (sub)step, m/s.
            spin: what b adds to the spin of a in each (sub)step, rad/s.
            set: values by name: of states, and of attributes of a, which become the sum over all b.
            state: names of what a pair remembers, and how many numbers each has: 1 or 3, at most 96 in all.
            other: another system, whose particles b is; they do not change.
            where: which particles it acts on: those in a shape, or for which a comparison of columns holds;
                None: all.
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
