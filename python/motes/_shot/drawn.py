"""Particles as USD draws them: what the sprite makes of their columns, as a picture shows them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._picture.rendering import Renderer, looking
from .._picture.sprites import Sprite
from .._values.values import at
from .facts import ATTRIBUTES, CURVES, INSTANCES, POINTS, Drawn
from .looks import form_of_sprite
from .picks import columns_of_pick, tile_numbers
from .ribbons import columns_of_trace, lines_of

__all__ = ["Drawing", "Eye", "eye_of", "needed"]

Array = NDArray[Any]

_USED = ("position", "velocity", "up", "color", "alpha", "size", "age", "lifetime", "orientation", "spin")


def needed(sprite: Sprite) -> tuple[str, ...]:
    """Return the columns from which a sprite is drawn."""
    traced = columns_of_trace() if sprite.kind == "ribbon" else ()
    return (*_USED, *traced, *columns_of_pick(sprite))


class Eye(NamedTuple):
    """The camera of a picture: unit vectors, and the focal length, px."""

    position: Array
    right: Array
    up: Array
    forward: Array
    focal_px: float
    height: int
    near: float

    def depths(self, points: Array) -> Array:
        """Return the distances of points along the view, m, those behind the near plane at it."""
        return np.maximum((points.astype(np.float64) - self.position) @ self.forward, self.near)


def eye_of(renderer: Renderer, time: float) -> Eye:
    """Return the camera at a time of its curves, s."""
    camera = renderer.camera
    position, right, up, back = looking(camera, time)
    focal = renderer.height / 2 / math.tan(math.radians(at(camera.fov_deg, time)) / 2)
    return Eye(position, right, up, -back, focal, renderer.height, at(camera.near, time))


class Drawing(NamedTuple):
    """How the particles of a system are drawn in a frame."""

    sprite: Sprite
    eye: Eye
    initial: Mapping[str, tuple[float, ...]]
    """The values of columns that no particle has changed."""
    columns: Mapping[str, Array]
    """Columns besides those that are written, in the same order."""
    seed: int
    system: int
    frame: int
    dt: float

    def draw(self, columns: Mapping[str, Array]) -> Drawn:
        """Return what the particles are in USD; `columns`: all, in the order in which they are written."""
        rows = len(columns["id"])

        def column(name: str) -> Array:
            if name in columns:
                return columns[name]
            value = np.array(self.initial[name], np.float32)
            return np.tile(value, (rows, 1)) if len(value) > 1 else np.repeat(value, rows)

        form = form_of_sprite(self.sprite)
        values = {POINTS: self._points, INSTANCES: self._instances, CURVES: self._curves}[form](column)
        kinds = ATTRIBUTES[form]
        return Drawn(form, {name: (kinds[name], array) for name, array in values.items()})

    # --- forms

    def _points(self, column: Callable[[str], Array]) -> dict[str, Array]:
        points, widths = column("position"), self._widths(column)
        shared = self._shared(column, points, widths / 2)
        return {"points": points, "widths": widths.astype(np.float32), **shared}

    def _instances(self, column: Callable[[str], Array]) -> dict[str, Array]:
        sprite, points = self.sprite, column("position")
        wide = self._widths(column)
        reach = 0.7072 if sprite.mesh is None else float(np.linalg.norm(sprite.mesh.vertices, axis=1).max())
        spin = column("spin") if sprite.facing != "velocity" else np.zeros_like(points)
        if sprite.kind == "image" and sprite.facing == "camera":
            spin = np.zeros_like(points)
        return {
            "positions": points,
            "protoIndices": tile_numbers(sprite, column, self.seed, self.system, (self.frame + 1) * self.dt),
            "orientations": self._rotations(column).astype(np.float16),
            "scales": np.repeat(wide.astype(np.float32)[:, None], 3, axis=1),
            "angularVelocities": np.degrees(spin).astype(np.float32),
            **self._shared(column, points, wide * reach),
        }

    def _curves(self, column: Callable[[str], Array]) -> dict[str, Array]:
        sprite = self.sprite
        assert sprite.length is not None and sprite.width is not None
        points, along, counts = lines_of(column, sprite.length, self.frame, self.dt)
        widths = (sprite.width * (1 - along)).astype(np.float32)
        opacity = (np.repeat(column("alpha"), counts) * (1 - along)).astype(np.float32)
        return {
            "points": points,
            "curveVertexCounts": counts.astype(np.int32),
            "widths": widths,
            "extent": extent(points, widths / 2),
            "primvars:displayColor": column("color"),
            "primvars:displayOpacity": opacity,
            **_small_ids(column("id")),
        }

    def _shared(self, column: Callable[[str], Array], points: Array, reach: Array) -> dict[str, Array]:
        return {
            "velocities": column("velocity"),
            "ids": column("id").astype(np.int64),
            "primvars:displayColor": column("color"),
            "primvars:displayOpacity": column("alpha"),
            "extent": extent(points, reach),
            **_small_ids(column("id")),
        }

    # --- sizes and turns

    def _widths(self, column: Callable[[str], Array]) -> Array:
        """Return the diameters of sprites, m: of those sized in pixels, at their depths; scales of meshes."""
        sprite, eye = self.sprite, self.eye
        if sprite.kind == "surface":
            return np.full(len(column("id")), 2 * (sprite.radius or 0))
        posed = sprite.kind == "mesh" or (sprite.kind == "image" and sprite.facing != "camera")
        pixels: float | None = 1 if sprite.kind == "point" else sprite.pixels
        if sprite.height is not None:
            pixels = sprite.height * eye.height
        elif posed and pixels == 5:  # the default, which counts as left out
            pixels = None
        if pixels is None:
            return column("size")[:, 0].astype(np.float64)
        return eye.depths(column("position")) * (pixels / eye.focal_px)

    def _rotations(self, column: Callable[[str], Array]) -> Array:
        """Return quaternions x, y, z, w, as `cpp/image/project/project_wide_lanes.cpp` computes them."""
        sprite, eye = self.sprite, self.eye
        if sprite.kind == "image" and sprite.facing == "camera":
            return self._toward_camera(column)
        if sprite.facing != "velocity":
            turn = column("orientation").astype(np.float64)
            length = np.linalg.norm(turn, axis=1, keepdims=True)
            return np.where(length > 0, turn / np.where(length > 0, length, 1), (0, 0, 0, 1))
        velocity = column("velocity").astype(np.float64)
        speed = np.linalg.norm(velocity, axis=1, keepdims=True)
        known = (speed > 1e-15) & (speed < 1e15)
        front = np.where(known, velocity / np.where(known, speed, 1), -eye.forward)
        up = np.where(known, column("up"), eye.up).astype(np.float64)
        side = np.cross(up, front)
        square = (side**2).sum(axis=1, keepdims=True)
        steady = square > 1e-12 * (up**2).sum(axis=1, keepdims=True)
        # Without a side, by the shortest way from z, about an axis in the plane of x and y.
        turn = _shortest_from_z(front)
        side = np.where(steady, side, _turned_x(turn))
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        return _quaternions(np.stack([side, np.cross(front, side), front], axis=2))

    def _toward_camera(self, column: Callable[[str], Array]) -> Array:
        eye = self.eye
        up, offset = column("up").astype(np.float64), column("position") - eye.position
        depth = offset @ eye.forward
        ahead = (up @ eye.forward) / np.where(depth > 0, depth, 1)
        x = up @ eye.right - (offset @ eye.right) * ahead
        y = up @ eye.up - (offset @ eye.up) * ahead
        length = np.hypot(x, y)
        known = length > 0
        x, y = (np.where(known, one / np.where(known, length, 1), lone) for one, lone in ((x, 0), (y, 1)))
        top = x[:, None] * eye.right + y[:, None] * eye.up
        back = np.broadcast_to(-eye.forward, top.shape)
        return _quaternions(np.stack([np.cross(top, back), top, back], axis=2))


def extent(points: Array, reach: Array) -> Array:
    """Return the lowest and highest corner of the box around points, (2, 3), m, each with its reach."""
    if not len(points):
        return np.array([[3.4028235e38] * 3, [-3.4028235e38] * 3], np.float32)
    with np.errstate(invalid="ignore", over="ignore"):
        low, high = points - np.abs(reach)[:, None], points + np.abs(reach)[:, None]
        return np.array([np.fmin.reduce(low), np.fmax.reduce(high)], np.float32)


def _small_ids(ids: Array) -> dict[str, Array]:
    """Return ids as the integers of 32 bits that programs read as a primvar, if they fit."""
    small = ids.astype(np.int32)
    return {"primvars:id": small} if (small == ids.astype(np.int64)).all() else {}


def _shortest_from_z(front: Array) -> Array:
    """Return the shortest rotations from z to unit vectors, as quaternions."""
    turn = np.column_stack([-front[:, 1], front[:, 0], np.zeros(len(front)), 1 + front[:, 2]])
    turn[turn[:, 3] < 1e-9] = (0, 1, 0, 0)
    return np.asarray(turn / np.linalg.norm(turn, axis=1, keepdims=True))


def _turned_x(turn: Array) -> Array:
    x, y, z, w = turn.T
    return np.column_stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])


def _quaternions(axes: Array) -> Array:
    """Return rotations, (n, 3, 3) with axes as columns, as quaternions x, y, z, w."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = axes.transpose(1, 2, 0)
    rows = np.array(
        [
            [1 + xx - yy - zz, yx + xy, zx + xz, zy - yz],
            [yx + xy, 1 - xx + yy - zz, zy + yz, xz - zx],
            [zx + xz, zy + yz, 1 - xx - yy + zz, yx - xy],
            [zy - yz, xz - zx, yx - xy, 1 + xx + yy + zz],
        ]
    )
    greatest = rows[range(4), range(4)].argmax(axis=0)
    best = rows[greatest, :, np.arange(len(axes))]
    return np.asarray(best / np.linalg.norm(best, axis=1, keepdims=True))
