"""The viewers' camera, and how the mouse moves it.

Only the image generator's process computes a pose. It rounds the pose and sends it to the other ranks and the
log as decimal numbers, so sines that differ in the last bit between machines change nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import numpy as np

from .._picture.rendering import Camera
from .._values import arguments
from .._values.arguments import Triple
from .._values.values import at
from ..errors import ArgumentError

__all__ = ["Pose"]

STEEPEST_DEG = 89.0  # largest angle between the view direction and the plane normal to `up`
NEAREST = 4.0  # zooming in ends at this multiple of the camera's `near`
FARTHEST_M = 1e9
MOST_ZOOM = 50.0  # in one move
DIGITS = 4  # decimals, more for scenes smaller than a metre


class Pose(NamedTuple):
    """The properties of a camera that viewers change."""

    position: Triple
    look_at: Triple
    up: Triple
    fov_deg: float

    @classmethod
    def of(cls, camera: Camera, time: float) -> Self:
        """Return a script's camera at a time (s)."""
        return cls(*(at(vars(camera)[name], time) for name in cls._fields))

    @classmethod
    def read(cls, content: Any) -> Self:
        """Parse the result of `to_dict()`. Raises ValueError for anything else."""
        if not isinstance(content, Mapping) or set(content) != set(cls._fields):
            raise ValueError(f"a camera must have {', '.join(cls._fields)}")
        try:
            position, look_at, up = (
                arguments.triple(name, content[name], pair=False) for name in cls._fields[:3]
            )
            pose = cls(
                position, look_at, up, arguments.number("fov_deg", content["fov_deg"], low=0.01, high=179)
            )
        except ArgumentError as error:
            raise ValueError(str(error)) from None
        if not pose.possible():
            raise ValueError("a camera must look somewhere, not along its up")
        return pose

    def to_dict(self) -> dict[str, Any]:
        """Return the pose as a JSON object."""
        return {
            name: list(part) if isinstance(part, tuple) else part for name, part in self._asdict().items()
        }

    def possible(self) -> bool:
        """Return whether camera and target differ, and `up` is not along the view direction."""
        look = np.subtract(self.look_at, self.position)
        far, high = np.linalg.norm(look), np.linalg.norm(self.up)
        if not (1e-12 < far < 1e12 and 1e-12 < high < 1e12):
            return False
        return bool(np.linalg.norm(np.cross(look / far, np.asarray(self.up) / high)) > 1e-6)

    def orbit(self, right: float, up: float) -> Pose:
        """Orbit around the target, to the right and upwards, by angles in radians."""
        high = _unit(self.up)
        arm = np.subtract(self.position, self.look_at)
        far = float(np.linalg.norm(arm))
        steep = math.asin(min(max(float(arm @ high) / far, -1.0), 1.0))
        flat = arm - (arm @ high) * high
        flat = _unit(flat) if np.linalg.norm(flat) > 1e-9 * far else _any_across(high)
        flat = math.cos(right) * flat + math.sin(right) * np.cross(high, flat)
        most = max(math.radians(STEEPEST_DEG), abs(steep))
        steep = min(max(steep + up, -most), most)
        arm = far * (math.cos(steep) * flat + math.sin(steep) * high)
        return self._replace(position=_triple(self.look_at + arm))

    def pan(self, right: float, up: float) -> Pose:
        """Move camera and target across the picture, by fractions of the picture's height."""
        look = np.subtract(self.look_at, self.position)
        seen = 2 * np.linalg.norm(look) * math.tan(math.radians(self.fov_deg) / 2)
        across = _unit(np.cross(look, self.up))
        shift = seen * (right * across + up * np.cross(across, _unit(look)))
        return self._replace(position=_triple(self.position + shift), look_at=_triple(self.look_at + shift))

    def zoom(self, closer: float, near: float) -> Pose:
        """Move towards the target: the distance is multiplied by exp(-closer), within limits."""
        arm = np.subtract(self.position, self.look_at)
        far = float(np.linalg.norm(arm))
        least = min(far, NEAREST * near)
        wanted = min(
            max(far * math.exp(min(max(-closer, -MOST_ZOOM), MOST_ZOOM)), least), max(far, FARTHEST_M)
        )
        return self._replace(position=_triple(self.look_at + arm * (wanted / far)))

    def rounded(self) -> Pose:
        """Round to `DIGITS` decimals of metres and degrees; metres to more decimals in small scenes."""
        far = float(np.linalg.norm(np.subtract(self.position, self.look_at)))
        digits = DIGITS + max(0, -math.floor(math.log10(max(far, 1e-12))))

        def triple(given: Triple, places: int) -> Triple:
            return _triple([round(one, places) + 0.0 for one in given])

        return Pose(
            triple(self.position, digits),
            triple(self.look_at, digits),
            self.up,
            round(self.fov_deg, DIGITS),
        )


def _unit(given: Any) -> Any:
    return np.asarray(given, float) / np.linalg.norm(given)


def _any_across(high: Any) -> Any:
    axis = np.zeros(3)
    axis[int(np.argmin(np.abs(high)))] = 1.0
    return _unit(np.cross(high, axis))


def _triple(given: Any) -> Triple:
    return float(given[0]), float(given[1]), float(given[2])
