"""Actions that guide particles along the vectors of a grid or along a path. Part of `motes.actions`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._values import arguments
from .._values.curves import Number, Vector
from .._values.values import items_of, value
from ..errors import ArgumentError
from ..expressions._conditions import Columns, condition_of
from .base import Action, as_where, at_least_0

__all__ = ["Field", "FollowPath"]

MOST_NODES = 2**25
MOST_POINTS = 4096
PIECES = 16  # straight pieces between two points of a smooth path
GRID = "finite numbers of shape (nx, ny, nz, 3)"
POINTS = f"finite numbers of shape (n, 3), 2 <= n <= {MOST_POINTS}"


@value()
class Field(Action):
    """Accelerates particles by the vectors of a grid, or drags them along as moving air.

    The array holds one vector per node of a regular grid from `low` to `high`; between nodes, vectors are
    interpolated trilinearly. Particles outside are not affected. Along an axis with one node the field is
    constant. The engine keeps each array until the process ends, so create the action once and record it in
    each frame with `apply`.

    Formula: within low..high, with F the field at x: v += strength F dt; with `drag`, v += (strength F - v)
    (1 - exp(-drag dt)), as `wind`

    Attributes:
        grid: float32 (nx, ny, nz, 3), m/s^2, or m/s with `drag`; it is copied.
        low: the corner of node [0, 0, 0], m.
        high: the corner of node [-1, -1, -1], above `low` in each component, m.
        strength: factor that multiplies the vectors.
        drag: rate at which particles take on the field's velocity, 1/s; None: the vectors are accelerations.

    Source: D. McAllister's list of features missing from his API; common in effects editors.
    """

    grid: ArrayLike
    low: Vector
    high: Vector
    strength: Number = 1
    drag: Number | None = None

    def __post_init__(self) -> None:
        """Check the fields and store the array in the engine."""
        low = arguments.triple("low", self.low)
        high = arguments.triple("high", self.high)
        with np.errstate(over="ignore"):  # the core rejects values beyond float32's range
            grows = bool((np.array(low, np.float32) < np.array(high, np.float32)).all())
        if not grows:
            raise ArgumentError("high", high, f"above low = {low} in each component")
        grid = _grid(self.grid)
        drag = None if self.drag is None else arguments.number("drag", self.drag, low=0)
        strength = arguments.number("strength", self.strength)
        numbers = {"low": low, "high": high, "strength": strength, "drag": -1.0 if drag is None else drag}
        _make(self, "field", numbers, grid, (grid.shape[0], grid.shape[1], grid.shape[2]))
        self.__dict__.update(grid=grid, low=low, high=high, strength=strength, drag=drag)

    def _key(self) -> tuple[Any, ...]:
        return _key_of(self, "grid")

    def _compiled(self, columns: Columns, others: Columns | None = None) -> _core.Action:
        """Return the engine's action for a system with these columns."""
        return _with_table(self, columns)


@value()
class FollowPath(Action):
    """Steers particles along a path, toward a point ahead of the nearest point of the path.

    Particles slow down toward the end of the path, and where a bend brings the point ahead nearer than
    `look_ahead`. If two points of the path are equally near, the first one counts.

    Formula: v += (w - v) min(strength dt, 1) where the nearest point is within `radius`, with w = speed d /
    max(|d|, a), d the vector from x to the point a = look_ahead (at most the path's length) ahead of the
    nearest point along the path; this point stops at the end of the path, or with `loop` continues from the
    start

    Attributes:
        points: waypoints, (n, 3), m; consecutive duplicates count once.
        speed: speed along the path, m/s.
        strength: rate at which velocities change, 1/s.
        look_ahead: distance of the point ahead, m; larger values cut corners, smaller ones follow more
            closely.
        radius: particles farther from the path are not affected, m.
        loop: whether the path continues from the last point to the first.
        smooth: whether the path is a Catmull-Rom spline through the points instead of straight lines; the
            spline is approximated by 16 straight pieces between two points.

    Source: Reynolds (1999), "Steering behaviors for autonomous characters": path following and arrival.
    """

    points: ArrayLike
    speed: Number
    strength: Number = 2
    look_ahead: Number = 0.5
    radius: Number = math.inf
    loop: bool = False
    smooth: bool = False

    def __post_init__(self) -> None:
        """Check the fields and store the path in the engine."""
        loop, smooth = arguments.flag("loop", self.loop), arguments.flag("smooth", self.smooth)
        points = _points(self.points)
        speed = arguments.number("speed", self.speed, low=0)
        strength = arguments.number("strength", self.strength, low=0)
        look_ahead = arguments.number("look_ahead", self.look_ahead, low=1e-6)
        radius = at_least_0("radius", self.radius)
        segments = _segments(_spline(points, loop) if smooth else points, loop)
        numbers = dict(speed=speed, strength=strength, look_ahead=look_ahead, radius=radius, loop=loop)
        _make(self, "follow_path", numbers, segments, (len(segments), 1, 1))
        self.__dict__.update(points=tuple(map(tuple, points.tolist())), speed=speed, strength=strength)
        self.__dict__.update(look_ahead=look_ahead, radius=radius, loop=loop, smooth=smooth)

    def _compiled(self, columns: Columns, others: Columns | None = None) -> _core.Action:
        """Return the engine's action for a system with these columns."""
        return _with_table(self, columns)


def _make(
    action: Action, name: str, numbers: dict[str, Any], table: NDArray[np.float32], size: tuple[int, int, int]
) -> None:
    """Store the table in the engine and let it check the action."""
    key = _core.keep_table(table, size)
    _core.Action(name, numbers, [], table=key)
    action.__dict__.update(_call=(name, numbers), _table=key, where=as_where(action.where))


def _with_table(action: Action, columns: Columns) -> _core.Action:
    name, numbers = action.__dict__["_call"]
    shapes: list[_core.Shape] = []
    where = condition_of(action.where, columns, shapes)
    return _core.Action(name, numbers, shapes, where, table=action.__dict__["_table"])


def _key_of(action: Action, array: str) -> tuple[Any, ...]:
    """Return the key for comparing and hashing, with the engine's key for the table instead of the array."""
    return tuple(action.__dict__["_table"] if name == array else v for name, v in items_of(action).items())


def _grid(given: Any) -> NDArray[np.float32]:
    array = arguments.floats("grid", given, np.float32, GRID)
    if array.ndim != 4 or array.shape[3] != 3 or 0 in array.shape:
        raise ArgumentError("grid", f"{array.dtype} {array.shape}", GRID)
    if array.size // 3 > MOST_NODES:
        raise ArgumentError("grid", array.shape, f"of at most {MOST_NODES} nodes")
    wrong = np.argwhere(~np.isfinite(array))
    if len(wrong):
        raise ArgumentError(f"grid{wrong[0].tolist()}", float(array[tuple(wrong[0])]), "finite")
    copy = np.array(array, order="C")
    copy.flags.writeable = False
    return copy


def _points(given: Any) -> NDArray[np.float64]:
    array = arguments.floats("points", given, np.float64, POINTS)
    if array.ndim == 2 and array.shape[1] == 2:
        array = arguments.with_z(array)
    if array.ndim != 2 or array.shape[1] != 3 or not 2 <= len(array) <= MOST_POINTS:
        raise ArgumentError("points", given, POINTS)
    if not (np.abs(array) < 1e15).all():
        raise ArgumentError("points", given, "finite numbers within 1e15")
    return array


def _spline(points: NDArray[np.float64], loop: bool) -> NDArray[np.float64]:
    """Return points of the Catmull-Rom spline through the given points; both ends continue straight."""
    if loop:
        around = np.concatenate([points[-1:], points, points[:2]])
    else:
        around = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
    t = (np.arange(PIECES) / PIECES)[:, None]
    spans = []
    for a, b, c, d in zip(around[:-3], around[1:-2], around[2:-1], around[3:], strict=True):
        spans.append(
            b + t * ((c - a) / 2 + t * ((2 * a - 5 * b + 4 * c - d) / 2 + t * (3 * (b - c) + d - a) / 2))
        )
    return np.concatenate(spans if loop else [*spans, points[-1:]])


def _segments(points: NDArray[np.float64], loop: bool) -> NDArray[np.float32]:
    """Return the path's segments as rows of start, direction, distance along the path and length."""
    ends = np.concatenate([points, points[:1]]) if loop else points
    ways = np.diff(ends, axis=0)
    lengths = np.sqrt(ways[:, 0] ** 2 + ways[:, 1] ** 2 + ways[:, 2] ** 2).astype(np.float32)
    kept = lengths > 0
    if not kept.any():
        raise ArgumentError("points", points[0].tolist(), "at least two different points")
    directions = ways[kept] / lengths[kept, None]
    starts = np.zeros(int(kept.sum()), np.float32)
    for i, length in enumerate(lengths[kept][:-1]):  # float32 sums in a fixed order
        starts[i + 1] = starts[i] + length
    columns = (ends[:-1][kept], directions, starts[:, None], lengths[kept, None])
    return np.ascontiguousarray(np.concatenate(columns, axis=1), np.float32)
