"""Clump: a template of rigid groups of spheres, and its volume and moments of inertia."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..errors import ArgumentError
from . import arguments
from .values import Value, value

__all__ = ["MOST_SPHERES", "Clump", "as_clump", "law_of"]

MOST_SPHERES = 64
MOST_LENGTH = 1e6  # m
LEAST_RADIUS = 1e-12  # m
LEAST_PART = 1e-3  # smallest radius of a sphere, as a fraction of the clump's extent
COLUMNS = 192  # columns along each side of the grid on which overlapping spheres are integrated

Tensor = tuple[float, float, float, float, float, float]
"""Components xx, yy, zz, xy, xz, yz of a symmetric tensor."""


@value()
class Clump(Value):
    """A rigid group of spheres of one density: the template of `System.clumps`. Immutable.

    A clump's position is its centre of mass. Volume and inertia are exact for spheres that do not overlap.
    The union of overlapping spheres is integrated over some 37,000 columns of exact length, with a relative
    error of about 1e-4.

    Attributes:
        spheres: x, y, z and radius of 1 to 64 spheres, m, shape (n, 4).
    """

    spheres: ArrayLike

    def __post_init__(self) -> None:
        """Check the spheres and store them in the engine."""
        given = _checked(self.spheres)
        volume, center, products = _moments(given)
        centered = given - (*center, 0.0)
        inertia = _inertia(products)
        distances = np.sqrt(_sum(centered[:, :3] ** 2))
        arms = centered[:, :3].tolist()
        self.__dict__.update(
            spheres=tuple(tuple(one) for one in given.tolist()),
            _volume=volume,
            _center=tuple(center.tolist()),
            _inertia=inertia,
            _radius=float((distances + centered[:, 3]).max()),
            _table=_core.keep_table(centered.astype(np.float32), (len(centered), 1, 1)),
            _numbers={
                "lightness": max(_lightness(arm, _inverse(inertia)) for arm in arms),
                "moments": inertia[:3],
                "products": inertia[3:],
            },
        )

    @property
    def volume(self) -> float:
        """The volume of the union of the spheres, m^3."""
        volume: float = self.__dict__["_volume"]
        return volume

    @property
    def center(self) -> tuple[float, float, float]:
        """The centre of mass, m, in the coordinates of the given spheres."""
        center: tuple[float, float, float] = self.__dict__["_center"]
        return center

    @property
    def radius(self) -> float:
        """The radius of the bounding sphere about the centre of mass, m."""
        radius: float = self.__dict__["_radius"]
        return radius

    @property
    def inertia(self) -> NDArray[np.float64]:
        """The inertia tensor about the centre of mass per kg of mass, m^2, shape (3, 3)."""
        xx, yy, zz, xy, xz, yz = self.__dict__["_inertia"]
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    @property
    def _law(self) -> tuple[dict[str, Any], int]:
        """The parameters of the contact law, and the engine's key of the spheres; for the package itself."""
        return self.__dict__["_numbers"], self.__dict__["_table"]


def law_of(clump: Clump) -> tuple[dict[str, Any], int]:
    """Return a clump's parameters for the contact law, and the engine's key of the spheres."""
    return clump._law


def as_clump(template: Any) -> Clump:
    """Return `template`, a clump or its spheres, as a clump."""
    return template if isinstance(template, Clump) else Clump(template)


def _checked(given: Any) -> NDArray[np.float64]:
    allowed = f"x, y, z and radius of 1..{MOST_SPHERES} spheres, m, shape (n, 4)"
    spheres = arguments.floats("template", given, np.float64, allowed)
    if spheres.ndim != 2 or spheres.shape[1] != 4 or not 1 <= len(spheres) <= MOST_SPHERES:
        raise ArgumentError("template", given, allowed)
    if not (np.abs(spheres) <= MOST_LENGTH).all():
        raise ArgumentError("template", given, f"finite numbers of at most {MOST_LENGTH:g} m")
    extent = float(np.ptp(spheres[:, :3], axis=0).max()) + float(spheres[:, 3].max())
    least = max(LEAST_PART * extent, LEAST_RADIUS)
    if not (spheres[:, 3] >= least).all():
        raise ArgumentError("template", given, f"spheres with a radius of at least {least:.3g} m")
    return spheres


def _sum(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each row's sum, added in a fixed order: the same bits on every processor."""
    return rows[:, 0] + rows[:, 1] + rows[:, 2]


def _moments(spheres: NDArray[np.float64]) -> tuple[float, NDArray[np.float64], Tensor]:
    """Return volume, centre of mass, and the means of xx, yy, zz, xy, xz, yz about that centre."""
    middle = np.array([0.5 * (float(x.min()) + float(x.max())) for x in spheres[:, :3].T])
    local = spheres - (*middle, 0.0)
    if _apart(local):
        sums = _of_balls(local)
    else:
        spans = [float((x + local[:, 3]).max() - (x - local[:, 3]).min()) for x in local[:, :3].T]
        long = int(np.argmax(spans))
        order = [(long + 1) % 3, (long + 2) % 3, long]  # columns are parallel to the longest side
        sums = _turned_back(_of_columns(local[:, [*order, 3]]), order)
    volume = sums[0]
    x, y, z = (one / volume for one in sums[1:4])
    xx, yy, zz, xy, xz, yz = (one / volume for one in sums[4:])
    about = (xx - x * x, yy - y * y, zz - z * z, xy - x * y, xz - x * z, yz - y * z)
    return volume, middle + (x, y, z), about


def _apart(spheres: NDArray[np.float64]) -> bool:
    for i, one in enumerate(spheres):
        others = spheres[i + 1 :]
        distance = np.sqrt(_sum((others[:, :3] - one[:3]) ** 2))
        if (distance < (others[:, 3] + one[3]) * (1 - 1e-9)).any():
            return False
    return True


def _of_balls(spheres: NDArray[np.float64]) -> list[float]:
    """Return the volume of separate spheres, and its integrals of x, y, z, xx, yy, zz, xy, xz, yz."""
    sums = []
    for x, y, z, radius in spheres.tolist():
        volume = 4 / 3 * math.pi * radius**3
        own = 0.2 * radius * radius
        about = (x * x + own, y * y + own, z * z + own, x * y, x * z, y * z)
        sums.append([volume * one for one in (1.0, x, y, z, *about)])
    return [math.fsum(column) for column in zip(*sums, strict=True)]


def _of_columns(spheres: NDArray[np.float64]) -> list[float]:
    """Return the results of `_of_balls` for a union of spheres: sums over a grid in x, y, exact along z."""
    low = (spheres[:, :2] - spheres[:, 3:]).min(axis=0)
    step = ((spheres[:, :2] + spheres[:, 3:]).max(axis=0) - low) / COLUMNS
    x = low[0] + (np.arange(COLUMNS) + 0.5) * step[0]
    totals = np.zeros((10, COLUMNS))
    for row in range(COLUMNS):
        y = float(low[1] + (row + 0.5) * step[1])
        half = spheres[:, 3:] ** 2 - (x - spheres[:, :1]) ** 2 - (y - spheres[:, 1:2]) ** 2
        high = np.sqrt(np.maximum(half, 0))
        begin = np.where(half > 0, spheres[:, 2:3] - high, np.inf)
        order = np.argsort(begin, axis=0, kind="stable")
        begin = np.take_along_axis(begin, order, axis=0)
        end = np.take_along_axis(np.where(half > 0, spheres[:, 2:3] + high, -np.inf), order, axis=0)
        reached = np.full(COLUMNS, -np.inf)
        for first, last in zip(begin, end, strict=True):
            inside = last > np.maximum(first, reached)
            a = np.where(inside, np.maximum(first, reached), 0)
            b = np.where(inside, last, 0)
            reached = np.maximum(reached, last)
            length, mean, square = b - a, 0.5 * (b * b - a * a), (b**3 - a**3) / 3
            of_z = (length, x * length, y * length, mean, x * x * length, y * y * length, square)
            totals += np.stack([*of_z, x * y * length, x * mean, y * mean])
    area = float(step[0] * step[1])
    return [area * math.fsum(total) for total in totals.tolist()]


def _turned_back(sums: list[float], order: list[int]) -> list[float]:
    """Permute the integrals from the axes in `order` back to x, y, z."""
    places = [order.index(axis) for axis in range(3)]
    pairs = {(0, 1): 7, (0, 2): 8, (1, 2): 9}
    mixed = [sums[pairs[min(a, b), max(a, b)]] for a, b in ((places[i], places[j]) for i, j in pairs)]
    return [sums[0], *(sums[1 + p] for p in places), *(sums[4 + p] for p in places), *mixed]


def _inertia(products: Tensor) -> Tensor:
    xx, yy, zz, xy, xz, yz = products
    return (yy + zz, xx + zz, xx + yy, -xy, -xz, -yz)


def _inverse(t: Tensor) -> Tensor:
    xx, xy, xz = t[1] * t[2] - t[5] * t[5], t[4] * t[5] - t[3] * t[2], t[3] * t[5] - t[4] * t[1]
    part = 1 / (t[0] * xx + t[3] * xy + t[4] * xz)
    rest = (t[0] * t[2] - t[4] * t[4], t[0] * t[1] - t[3] * t[3], xy, xz, t[3] * t[4] - t[0] * t[5])
    first, second, *mixed = (part * one for one in rest)
    return (part * xx, first, second, mixed[0], mixed[1], mixed[2])


def _lightness(arm: list[float], inverse: Tensor) -> float:
    """Return an upper bound of a point's mobility relative to the mobility of the centre of mass."""
    x, y, z = arm
    xx, yy, zz, xy, xz, yz = inverse
    turns = (y * y + z * z, x * x + z * z, x * x + y * y)
    # The trace of [arm] inverse [arm]^T.
    mixed = -2 * (x * y * xy + x * z * xz + y * z * yz)
    return 1 + max(0.0, turns[0] * xx + turns[1] * yy + turns[2] * zz + mixed)
