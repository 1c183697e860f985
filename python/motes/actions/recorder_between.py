"""BetweenRecorder: a method for each action between particles, which records it.

Written by `.ci/recorder` from the fields of the actions.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from .. import actions
from ..curves import Number
from ..values import says_near_names
from .base import Where
from .recording import Recording

if TYPE_CHECKING:
    from ..system import System
    from ..ties import Ties

__all__ = ["BetweenRecorder"]


class BetweenRecorder(Recording):
    """What a script can tell particles that see each other; `motes.actions` says what each means."""

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
        """Record `actions.Gravitate`."""
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
        """Record `actions.Follow`."""
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
        """Record `actions.MatchVelocity`."""
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
        """Record `actions.MatchRotationalVelocity`."""
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
        """Record `actions.Collide`."""
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
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.Contact`."""
        self._record(
            actions.Contact(
                stiffness=stiffness,
                restitution=restitution,
                friction=friction,
                rolling_friction=rolling_friction,
                radius=radius,
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
        """Record `actions.Fluid`."""
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
        """Record `actions.Tie`."""
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
