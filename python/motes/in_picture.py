"""Whether a camera sees any particle: a remark where all of them are behind it, or outside of its picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .conditions import Condition
from .expressions import absolute, column, dot
from .rendering import Renderer
from .values import at

if TYPE_CHECKING:
    from .system import System

__all__ = ["in_view", "remark"]

LATER = 24
"""The picture with particles from which on something should be in it; before, it may be on its way there."""
MARGIN = 1.3  # times the picture: what is large reaches into it from outside


def in_view(renderer: Renderer, time: float) -> tuple[Condition, Condition]:
    """Return the conditions that a particle is in front of the camera, and that it is in the picture."""
    camera = renderer.camera
    eye, target, above = (
        np.array(at(one, time), float) for one in (camera.position, camera.look_at, camera.up)
    )
    look = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(look, above)
    right /= np.linalg.norm(right)
    up = np.cross(right, look)
    way = column("position") - tuple(eye)
    depth = dot(way, tuple(look))
    half = MARGIN * math.tan(math.radians(at(camera.fov_deg, time)) / 2)
    ahead = depth > at(camera.near, time)
    beside = absolute(dot(way, tuple(right))) < depth * (half * renderer.width / renderer.height)
    return ahead, ahead & beside & (absolute(dot(way, tuple(up))) < depth * half)


def remark(systems: Sequence[System], renderer: Renderer, time: float, picture: int, last: int) -> str | None:
    """Return what is wrong with the picture of this number, counted from 1 among those of particles.

    Collective in the first of them and in number `LATER`, or the `last` of the run, 0 where that is unknown;
    others are not looked at.
    """
    looked_at = min(LATER, last) if last > 0 else LATER
    if picture not in (1, looked_at):
        return None
    ahead, inside = in_view(renderer, time)
    camera = renderer.camera
    where = f"at {at(camera.position, time)}, looking to {at(camera.look_at, time)}"
    if not any(system.total(1, where=ahead) for system in systems if system.count):
        return f"all particles are behind the camera, {where}"
    if picture == looked_at and not any(system.total(1, where=inside) for system in systems if system.count):
        return f"all particles are outside of what the camera sees, {where}"
    return None
