"""Tells on which side of a surface points are: in float64, from a shape's numbers, without the engine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motes import shapes

__all__ = ["Sheet", "Wall", "rounding", "walls_of"]

Floats = NDArray[np.float64]
Distance = Callable[[Floats], Floats]


def rounding(position: Floats) -> Floats:
    """Return four units in the last place of each point's largest coordinate, m."""
    return 4 * np.spacing(np.abs(position).max(axis=1).astype(np.float32)).astype(np.float64)


@dataclass(frozen=True)
class Wall:
    """A closed or infinite surface. `height` is positive outside; near the surface it is the distance, m."""

    height: Distance
    one_sided: bool = False  # only particles outside must stay on their side

    def crossed(self, start: Floats, end: Floats) -> NDArray[np.bool_]:
        """Tell which points were clearly on one side and are now clearly on the other."""
        before, after = self.height(start), self.height(end)
        out = (before > rounding(start)) & (after < -rounding(end))
        if self.one_sided:
            return out
        return out | ((before < -rounding(start)) & (after > rounding(end)))


@dataclass(frozen=True)
class Sheet:
    """A surface with edges; `inward` is a point's distance from the nearest edge, m."""

    height: Distance
    inward: Distance
    flat: bool

    def crossed(self, start: Floats, end: Floats, way: Floats) -> NDArray[np.bool_]:
        """Tell which points passed through it, having moved at most `way` metres."""
        before, after = self.height(start), self.height(end)
        sides = (before * after < 0) & (np.abs(before) > rounding(start)) & (np.abs(after) > rounding(end))
        margin = np.minimum(self.inward(start), self.inward(end))
        return sides & (margin > way + rounding(start) + rounding(end))

    def pierced(self, start: Floats, end: Floats) -> NDArray[np.bool_]:
        """Tell which straight paths between two points pass through a flat sheet."""
        before, after = self.height(start), self.height(end)
        sides = (before * after < 0) & (np.abs(before) > rounding(start)) & (np.abs(after) > rounding(end))
        part = np.where(sides, before / np.where(sides, before - after, 1), 0)[:, None]
        return sides & (self.inward(start + (end - start) * part) > 4 * (rounding(start) + rounding(end)))


def singles(value: object) -> Floats:
    """Round to float32, as the engine stores it."""
    return np.asarray(value, np.float32).astype(np.float64)


def plane_height(point: Floats, normal: Floats) -> Distance:
    unit = normal / np.linalg.norm(normal)
    return lambda p: (p - point) @ unit


def round_parts(shape: shapes.Cylinder | shapes.Cone) -> tuple[Distance, Distance, Distance | None]:
    """Return the heights above the ends, above the outer wall, and above the bore."""
    cone = isinstance(shape, shapes.Cone)
    start, end = singles(shape.apex if cone else shape.p0), singles(shape.base if cone else shape.p1)
    length = np.linalg.norm(end - start)
    axis = (end - start) / length

    def along(p: Floats) -> Floats:
        return (p - start) @ axis

    def wall(radius: float) -> Distance:
        slope = float(singles(radius)) / length if cone else 0.0

        def height(p: Floats) -> Floats:
            h = along(p)
            across = np.linalg.norm((p - start) - h[:, None] * axis, axis=1)
            least = slope * h if cone else float(singles(radius))
            return (across - least) / np.hypot(1, slope)

        return height

    def ends(p: Floats) -> Floats:
        return np.maximum(-along(p), along(p) - length)

    return ends, wall(shape.radius), wall(shape.inner_radius) if shape.inner_radius > 0 else None


def round_walls(shape: shapes.Cylinder | shapes.Cone) -> list[Wall | Sheet]:
    ends, outer, bore = round_parts(shape)
    if shape.inner_radius == shape.radius:
        return [Sheet(outer, lambda p: -ends(p), flat=False)]
    if bore is None:
        return [Wall(lambda p: np.maximum(ends(p), outer(p)))]
    return [Wall(lambda p: np.maximum.reduce([ends(p), outer(p), -bore(p)]))]


def edges_inward(origin: Floats, u: Floats, v: Floats, triangle: bool) -> Distance:
    across = np.cross(u, v)
    to_a, to_b = np.cross(v, across) / (across @ across), np.cross(across, u) / (across @ across)

    def inward(p: Floats) -> Floats:
        a, b = (p - origin) @ to_a, (p - origin) @ to_b
        sides = [a / np.linalg.norm(to_a), b / np.linalg.norm(to_b)]
        if triangle:
            sides.append((1 - a - b) / np.linalg.norm(to_a + to_b))
        else:
            sides += [(1 - a) / np.linalg.norm(to_a), (1 - b) / np.linalg.norm(to_b)]
        return np.minimum.reduce(sides)

    return inward


def disc_inward(shape: shapes.Disc) -> Distance:
    center, unit = singles(shape.center), singles(shape.normal)
    unit = unit / np.linalg.norm(unit)
    outer, inner = float(singles(shape.radius)), float(singles(shape.inner_radius))

    def inward(p: Floats) -> Floats:
        d = p - center
        across = np.linalg.norm(d - (d @ unit)[:, None] * unit, axis=1)
        return np.minimum(outer - across, across - inner if inner > 0 else outer)

    return inward


def walls_of(shape: shapes.Shape) -> list[Wall | Sheet]:
    """Return the surfaces that particles must not pass."""
    if isinstance(shape, shapes.Union):
        walls = [wall for part in shape.shapes for wall in walls_of(part)]
        # After a bounce off one part, a particle may pass around the edge of another.
        return [replace(wall, flat=False) if isinstance(wall, Sheet) else wall for wall in walls]
    if isinstance(shape, shapes.Plane):
        return [Wall(plane_height(singles(shape.point), singles(shape.normal)), one_sided=True)]
    if isinstance(shape, shapes.Box):
        low, high = singles(shape.low), singles(shape.high)
        return [Wall(lambda p: np.maximum(low - p, p - high).max(axis=1))]
    if isinstance(shape, shapes.Sphere):
        center, radius = singles(shape.center), float(singles(shape.radius))
        return [Wall(lambda p: np.linalg.norm(p - center, axis=1) - radius)]
    if isinstance(shape, shapes.Cylinder | shapes.Cone):
        return round_walls(shape)
    if isinstance(shape, shapes.Disc):
        return [
            Sheet(plane_height(singles(shape.center), singles(shape.normal)), disc_inward(shape), flat=True)
        ]
    triangle = isinstance(shape, shapes.Triangle)
    origin = singles(shape.p0 if triangle else shape.origin)
    u = singles(shape.p1) - origin if triangle else singles(shape.u)
    v = singles(shape.p2) - origin if triangle else singles(shape.v)
    return [Sheet(plane_height(origin, np.cross(u, v)), edges_inward(origin, u, v, triangle), flat=True)]
