"""Rotations in space as quaternions, for the attribute `orientation`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ArgumentError
from . import arguments

__all__ = ["euler", "matrix_of"]

ALLOWED = "finite angles in degrees: a number, or an array that broadcasts with the others"


def euler(x: ArrayLike, y: ArrayLike = 0, z: ArrayLike = 0) -> Any:
    """Return a rotation given by angles as a quaternion, for `orientation`.

    The rotation turns about the x axis first, then about the y axis, then about the z axis: axes of space,
    which stay in place. Seen against an axis, positive angles are anticlockwise. The result has the same bits
    on any machine.

    Args:
        x: angle about the x axis, degrees: a number or an array.
        y: angle about the y axis, degrees.
        z: angle about the z axis, degrees.

    Returns:
        The unit quaternion (x, y, z, w): a tuple for numbers, a float32 array of shape (..., 4) for arrays,
        as `emit(orientation=...)` takes it.
    """
    angles = [_angles(name, given) for name, given in (("x", x), ("y", y), ("z", z))]
    try:
        turns = np.broadcast_arrays(*angles)
    except ValueError:
        shapes = ", ".join(str(one.shape) for one in angles)
        raise ArgumentError("x, y and z", shapes, "of shapes that broadcast") from None
    (sx, cx), (sy, cy), (sz, cz) = map(_half, turns)
    quaternion = np.stack(
        [
            cz * cy * sx - sz * sy * cx,
            cz * sy * cx + sz * cy * sx,
            sz * cy * cx - cz * sy * sx,
            cz * cy * cx + sz * sy * sx,
        ],
        axis=-1,
    )
    if quaternion.ndim == 1:
        return tuple(quaternion.tolist())
    rounded: NDArray[np.float32] = quaternion.astype(np.float32)
    return rounded


def _angles(name: str, given: Any) -> NDArray[np.float64]:
    array = arguments.floats(name, given, np.float64, ALLOWED)
    if not np.isfinite(array).all() or np.asarray(given).dtype == np.bool_:
        raise ArgumentError(name, given, ALLOWED)
    return array


def _half(degrees: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return sine and cosine of half the angles, by their series: libraries differ in the last bits."""
    quarters = np.round(degrees / 180)
    x = (degrees / 2 - quarters * 90) * (math.pi / 180)  # within +-pi / 4
    square = x * x
    sine, cosine = np.ones_like(x), np.ones_like(x)
    for n in range(16, 0, -2):
        sine = 1 - square / (n * (n + 1)) * sine
        cosine = 1 - square / (n * (n - 1)) * cosine
    sine = x * sine
    turn = quarters % 4
    return (
        np.choose(turn.astype(int), (sine, cosine, -sine, -cosine)),
        np.choose(turn.astype(int), (cosine, -sine, -cosine, sine)),
    )


def matrix_of(x: float, y: float, z: float, w: float) -> NDArray[np.float64]:
    """Return the rotation matrix of a unit quaternion, (3, 3), for columns of coordinates."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
