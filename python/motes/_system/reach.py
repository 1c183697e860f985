"""Checks of the reach of interactions in a periodic world."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .. import actions
from .._values.space import Period, half_period
from ..actions.base import Action
from ..errors import ArgumentError

__all__ = ["check_action", "check_reach"]


def check_action(action: Action, periods: tuple[Period, ...]) -> None:
    """Raise ArgumentError for an action between particles that reaches farther than half a period.

    Beyond that, a particle would interact with both another particle and its image, and a tie could not tell
    them apart. The engine checks radii stored per particle, which only it knows.
    """
    match action:
        case actions.Tie():
            check_reach("ties", float(np.max(action.ties.lengths, initial=0)), periods)
        case actions.Gravitate(far="cells"):
            raise ArgumentError("far", action.far, "'exact' in a periodic world")
        case actions.Gravitate() | actions.MatchVelocity() | actions.MatchRotationalVelocity():
            check_reach("max_radius", action.max_radius, periods)
        case (
            actions.Collide(radius=own, other_radius=theirs)
            | actions.Contact(radius=own, other_radius=theirs)
        ) if own is not None:
            meets: Any = theirs if action.other is not None else own
            check_reach("radius", own, periods, parts=2 if meets is None else 1 + meets / own)
        case actions.Fluid() | actions.Interact():
            check_reach("radius", action.radius, periods)


def check_reach(argument: str, radius: Any, periods: tuple[Period, ...], *, parts: float = 1) -> None:
    """Raise ArgumentError if `parts` times the radius (m) exceeds half of the shortest period."""
    if radius * parts <= half_period(periods):
        return
    most = half_period(periods) / parts
    whose = (
        "half of the shortest period"
        if parts == 1
        else "so that two together span half of the shortest period"
    )
    hint = "; give one" if math.isinf(radius) else ""
    raise ArgumentError(argument, radius, f"at most {most:g} m in this periodic world, {whose}{hint}")
