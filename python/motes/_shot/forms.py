"""Shapes as meshes: triangles of unit forms, and the transform that places them.

Round shapes have many sides: other programs would draw their own spheres and cones with few.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..shapes import Box, Cone, Cylinder, Disc, Plane, Rectangle, Shape, Sphere, Triangle

__all__ = ["Form", "form_of", "frame_along"]

Floats = NDArray[np.float64]

SIDES = 128
"""Sides of a circle: a circle of 400 px is nowhere more than 0.07 px off."""
_RINGS = (0.0, *(10.0**k for k in range(6)))
"""Distances from a plane's point at which it is cut, m: vast triangles would be imprecise where one looks."""


class Form(NamedTuple):
    """A shape as a mesh at a place."""

    key: tuple[Any, ...]
    """What decides the mesh."""
    make: Callable[[], tuple[Floats, NDArray[np.int64], Floats | None]]
    """Returns its points, triangles and normals; without normals it is flat."""
    place: Floats
    """The transform, (4, 4), m, whose columns are axes and position."""


def form_of(shape: Shape) -> Form:
    """Return the form of a shape with a surface, except meshes and unions."""
    if isinstance(shape, Box):
        low, high = np.array(shape.low), np.array(shape.high)
        return Form(("Box",), _box, _placed(np.diag(high - low), low))
    if isinstance(shape, Sphere):
        part = _part(shape.inner_radius, shape.radius)
        place = _placed(np.eye(3) * shape.radius, shape.center)
        return Form(("Sphere", part), lambda: _turned([_half_circle()], inside=part), place)
    if isinstance(shape, (Cylinder, Cone)):
        return _round(shape)
    if isinstance(shape, Disc):
        part = _part(shape.inner_radius, shape.radius)
        place = _placed(frame_along(shape.normal) * (shape.radius, 1, shape.radius), shape.center)
        return Form(("Disc", part), lambda: _turned([np.array([[1.0, 0], [part, 0]])]), place)
    return _flat(shape)


def _flat(shape: Shape) -> Form:
    """Return the form of a triangle, a rectangle or a plane."""
    if isinstance(shape, Plane):
        return Form(("Plane",), _vast, _placed(frame_along(shape.normal), shape.point))
    assert isinstance(shape, (Triangle, Rectangle))
    if isinstance(shape, Triangle):
        origin, p1, p2 = (np.array(one, float) for one in (shape.p0, shape.p1, shape.p2))
        axes, lean = _sides(p1 - origin, p2 - origin)
        corners = [(0.0, 0, 0), (1, 0, 0), (lean, 1, 0)]
    else:
        origin = np.array(shape.origin, float)
        axes, lean = _sides(np.array(shape.u, float), np.array(shape.v, float))
        corners = [(0.0, 0, 0), (1, 0, 0), (1 + lean, 1, 0), (lean, 1, 0)]
    triangles = np.array([[0, 1, 2], [0, 2, 3]])[: len(corners) - 2]
    return Form(
        (type(shape).__name__, lean), lambda: (np.array(corners), triangles, None), _placed(axes, origin)
    )


def _vast() -> tuple[Floats, NDArray[np.int64], None]:
    at = np.array([-far for far in _RINGS[:0:-1]] + list(_RINGS))
    x, z = np.meshgrid(at, at, indexing="ij")
    return np.stack([x, 0 * x, z], axis=-1).reshape(-1, 3), _grid(len(at), len(at)), None


def frame_along(axis: Any) -> Floats:
    """Return a rotation, (3, 3), that turns y to an axis."""
    y = np.array(axis, float)
    y /= np.linalg.norm(y)
    other = np.eye(3)[np.abs(y).argmin()]
    x = np.cross(other, y)
    x /= np.linalg.norm(x)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _round(shape: Cylinder | Cone) -> Form:
    """Return the form of a cylinder or a cone: of height 1 around y, with radius 1 at its base."""
    part = _part(shape.inner_radius, shape.radius)
    top = 0.0 if isinstance(shape, Cone) else 1.0
    start, end = (shape.base, shape.apex) if isinstance(shape, Cone) else (shape.p0, shape.p1)
    along = np.array(end, float) - start
    profiles = [np.array([[1.0, 0], [top, 1]])]
    if part < 1:
        profiles += [np.array([[part, 0], [1, 0]])]
        profiles += [np.array([[1.0, 1], [part, 1]])] if top else []
        profiles += [np.array([[part * top, 1], [part, 0]])] if part > 0 else []
    turn = frame_along(along) * (shape.radius, np.linalg.norm(along), shape.radius)
    return Form((type(shape).__name__, part), lambda: _turned(profiles), _placed(turn, start))


def _part(inner: float, outer: float) -> float:
    return inner / outer if outer > 0 else 0.0


def _placed(axes: Any, position: Any) -> Floats:
    place = np.eye(4)
    place[:3, :3] = axes
    place[:3, 3] = position
    return place


def _sides(u: Floats, v: Floats) -> tuple[Floats, float]:
    """Return axes along u, across it in the plane of u and v, and across both; and how far v leans along u.

    Axes at right angles: Blender knows no others, and would turn and scale a sheared form (5.0.1).
    """
    long = max(float(np.linalg.norm(u)), 1e-30)
    normal = np.cross(u, v)
    area = max(float(np.linalg.norm(normal)), 1e-30)
    across = np.cross(normal / area, u / long)
    return np.stack([u, across * (area / long), normal / area], axis=1), round(float(u @ v) / long**2, 6)


def _box() -> tuple[Floats, NDArray[np.int64], None]:
    points: list[Any] = []
    corners: list[Any] = []
    for axis in range(3):
        for side in (0, 1):
            square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])[:: 1 if side else -1]
            face = np.empty((4, 3))
            face[:, axis], face[:, (axis + 1) % 3], face[:, (axis + 2) % 3] = side, square[:, 0], square[:, 1]
            corners += [[len(points) + k for k in triangle] for triangle in ((0, 1, 2), (0, 2, 3))]
            points += face.tolist()
    return np.array(points, float), np.array(corners), None


def _half_circle() -> Floats:
    turn = np.linspace(0, math.pi, SIDES // 2 + 1)
    return np.stack([np.sin(turn), -np.cos(turn)], axis=1)


def _turned(profiles: list[Floats], inside: float = 0) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Return profiles of (radius, height), turned around y, outside to the right of their direction.

    `inside`: also each one this much smaller and inside out.
    """
    turn = np.linspace(0, 2 * math.pi, SIDES + 1)
    around = np.stack([np.cos(turn), 0 * turn, -np.sin(turn)], axis=1)
    points: list[Floats] = []
    normals: list[Floats] = []
    corners, first = [], 0
    for profile in [*profiles, *(profile[::-1] * inside for profile in profiles if inside > 0)]:
        way = np.gradient(profile, axis=0)
        out = np.stack([way[:, 1], -way[:, 0]], axis=1)
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        for rows, to in ((profile, points), (out, normals)):
            turned = rows[:, None, :1] * around + rows[:, None, 1:] * np.array([0, 1, 0])
            to.append(turned.reshape(-1, 3))
        corners.append(first + _grid(len(profile), len(turn)))
        first += len(points[-1])
    return np.concatenate(points), np.concatenate(corners), np.concatenate(normals)


def _grid(rows: int, columns: int) -> NDArray[np.int64]:
    """Return the triangles of a grid of points, counted row by row."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1)
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
