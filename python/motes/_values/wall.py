"""Wall and WallForce: how `contact` treats one of its walls, and the forces of particles on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import arguments
from .values import Value, value

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["LEAST_STIFFNESS", "MOST_STIFFNESS", "Wall", "WallForce", "wall_force"]

LEAST_STIFFNESS, MOST_STIFFNESS = 1e-30, 1e30  # N/m


@value(kw_only=True)
class Wall(Value):
    """How `System.contact` treats one of its walls; None: as the call treats its particles.

    Attributes:
        stiffness: stiffness of the spring between a particle and the wall, N/m.
        restitution: ratio of the speeds after and before a head-on collision, 0..1.
        friction: Coulomb's coefficient.
        rolling_friction: coefficient of rolling friction.
    """

    stiffness: float | None = None
    restitution: float | None = None
    friction: float | None = None
    rolling_friction: float | None = None

    def __post_init__(self) -> None:
        """Check the fields."""
        limits = {
            "stiffness": (LEAST_STIFFNESS, MOST_STIFFNESS),
            "restitution": (0, 1),
            "friction": (0, arguments.FARTHEST),
            "rolling_friction": (0, arguments.FARTHEST),
        }
        for name, (low, high) in limits.items():
            given = self.__dict__[name]
            if given is not None:
                self.__dict__[name] = arguments.number(name, given, low=low, high=high)


class WallForce(NamedTuple):
    """What `World.force` returns: means over the sub-steps of the last frame.

    Attributes:
        force: the force of all particles on the wall, N, shape (3,).
        torque: its torque about the wall's origin, N m, shape (3,).
    """

    force: NDArray[np.float64]
    torque: NDArray[np.float64]


def wall_force(numbers: Sequence[float]) -> WallForce:
    """Return the six numbers of the engine as a `WallForce`."""
    both = np.array(numbers, np.float64)
    both.flags.writeable = False
    return WallForce(both[:3], both[3:])
