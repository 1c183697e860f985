"""Triangulates faces with any number of corners; the triangles cover the face exactly.

A face with n corners gives n - 2 triangles and keeps all of its corners, even those in the middle of a
straight edge: without them, surfaces that are closed in the file would have gaps.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Triangles", "Unreadable", "fan", "strip", "triangulate"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Triangles = tuple[Floats, Indices]
"""Vertices, float64 (n, 3), and triangles, int64 (m, 3)."""

STRAIGHT = 1e-6
"""Corners whose angle has a smaller sine count as straight."""
MARGINS = (STRAIGHT, 1e-9, 1e-13)
"""Margins that other corners must keep from an ear, as fractions of the face's size; tried in turn."""


class Unreadable(Exception):
    """Says why a file cannot be read."""


def triangulate(
    vertices: Floats, counts: Indices, corners: Indices, name: Callable[[int], str] = "face {}".format
) -> Indices:
    """Cut faces into triangles; face i has the next `counts[i]` indices in `corners`.

    `name` returns a face's name for errors. Faces without an area may be left out. Raises Unreadable.
    """
    wrong = np.flatnonzero((corners < 0) | (corners >= len(vertices)))
    if len(wrong):
        face = int(np.searchsorted(np.cumsum(counts), wrong[0], side="right"))
        raise Unreadable(f"{name(face)} uses vertex {corners[wrong[0]]}, counted from 0, of {len(vertices)}")
    starts = np.cumsum(counts) - counts
    parts: list[Indices] = []
    faces: list[Indices] = []
    for size in np.unique(counts[counts >= 3]).tolist():
        which = np.flatnonzero(counts == size)
        indices = corners[starts[which, None] + np.arange(size)]
        triangles, of = _of_size(vertices, indices, lambda k, which=which: name(int(which[k])))  # type: ignore[misc]
        parts.append(triangles)
        faces.append(which[of])
    if not parts:
        return np.empty((0, 3), np.int64)
    order = np.argsort(np.concatenate(faces), kind="stable")
    return np.concatenate(parts)[order]


def fan(corners: NDArray[Any]) -> NDArray[Any]:
    """Return the triangles of fans around the first corner: (..., n) to (..., n - 2, 3)."""
    first = np.broadcast_to(corners[..., :1], corners[..., 2:].shape)
    return np.stack([first, corners[..., 1:-1], corners[..., 2:]], axis=-1)


def strip(corners: NDArray[Any]) -> NDArray[Any]:
    """Return the triangles of a strip, (n,) to (n - 2, 3): the winding of every second one is reversed."""
    triangles = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=-1)
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles


def _of_size(vertices: Floats, faces: Indices, name: Callable[[int], str]) -> tuple[Indices, Indices]:
    """Cut faces of one size, (m, n); return the triangles and the face of each."""
    rows, size = faces.shape
    if size == 3:
        return faces, np.arange(rows)
    flat, straight, cancelled = _flattened(vertices[faces])
    if cancelled.any():
        raise Unreadable(f"{name(int(cancelled.argmax()))} crosses itself")
    convex, turned = _plain(flat)
    rolled = np.take_along_axis(faces, (turned[:, None] + np.arange(size)) % size, axis=1)
    parts = [fan(rolled[convex]).reshape(-1, 3)]
    of = [np.repeat(np.flatnonzero(convex), size - 2)]
    for row in np.flatnonzero(~convex & ~straight).tolist():
        kept = _without_repeats(flat[row])
        if len(kept) >= 3:
            try:
                local = np.array(_ears(flat[row][kept]), np.int64)
            except Unreadable as error:
                raise Unreadable(f"{name(row)} {error}") from None
            parts.append(faces[row][kept][local])
            of.append(np.full(len(local), row))
    return np.concatenate(parts), np.concatenate(of)


def _flattened(points: Floats) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Project faces, (m, n, 3), onto their planes by Newell's normal: (m, n, 2), counter-clockwise.

    They are scaled to a size of 1. Also return which faces lie on a line, and which have areas that cancel.
    """
    points = points - points.mean(axis=1, keepdims=True)
    size = np.abs(points).max(axis=(1, 2))
    points = points / np.where(size > 0, size, 1)[:, None, None]
    normal = np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)
    length = np.linalg.norm(normal, axis=1)
    even = length <= 1e-12
    spread = np.linalg.svd(points[even], compute_uv=False)[:, 1] if even.any() else np.empty(0)
    straight = even.copy()
    straight[even] = spread <= STRAIGHT
    normal[even] = (0, 0, 1)
    normal /= np.where(even, 1, length)[:, None]
    least = np.abs(normal).argmin(axis=1)
    across = np.cross(normal, np.eye(3)[least])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(normal, across)
    flat = np.stack([np.einsum("mnk,mk->mn", points, axis) for axis in (across, along)], axis=-1)
    return flat, straight, even & ~straight


def _plain(flat: Floats) -> tuple[NDArray[np.bool_], Indices]:
    """Tell which faces are fans around some corner, and which corner that is.

    Convex faces are, and so are most faces of four corners of which one is straight or points inwards.
    """
    before, after = flat - np.roll(flat, 1, axis=1), np.roll(flat, -1, axis=1) - flat
    cross, dot = _cross(before, after), (before * after).sum(axis=-1)
    turn = np.arctan2(cross, dot)
    outward = turn > STRAIGHT
    once = np.abs(turn.sum(axis=1) - 2 * np.pi) < 1
    convex = outward.all(axis=1) & once
    if flat.shape[1] != 4:
        return convex, np.zeros(len(flat), np.int64)
    inward = outward.argmin(axis=1)
    rolled = np.take_along_axis(flat, ((inward[:, None] + np.arange(4)) % 4)[:, :, None], axis=1)
    halves = fan(np.swapaxes(rolled, 1, 2))  # (m, 2, 2, 3): coordinate, triangle, corner
    a, b, c = (np.moveaxis(halves[..., k], 1, 2) for k in range(3))
    whole = (_cross(b - a, c - a) > STRAIGHT).all(axis=1)
    return convex | (once & whole & (outward.sum(axis=1) == 3)), np.where(convex, 0, inward)


def _cross(a: Floats, b: Floats) -> Floats:
    product: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _without_repeats(flat: Floats) -> Indices:
    """Return the corners without repeated positions."""
    return np.flatnonzero(np.abs(flat - np.roll(flat, 1, axis=0)).max(axis=1) > 1e-12)


def _ears(flat: Floats) -> list[tuple[int, int, int]]:
    """Triangulate one face, (n, 2), by ear clipping: best-shaped ears first, so that none has zero area."""
    if _crosses(flat):
        raise Unreadable("crosses itself")
    left = np.arange(len(flat))
    ears: list[tuple[int, int, int]] = []
    while len(left) > 3:
        ear = next((found for margin in MARGINS if (found := _ear(flat[left], margin)) is not None), None)
        if ear is None:
            raise Unreadable("overlaps itself")
        ears.append((int(left[ear - 1]), int(left[ear]), int(left[(ear + 1) % len(left)])))
        left = np.delete(left, ear)
    return [*ears, (int(left[0]), int(left[1]), int(left[2]))]


def _ear(flat: Floats, margin: float) -> int | None:
    """Return an ear to clip: a corner whose triangle has no other corner within the margin."""
    before, after = np.roll(flat, 1, axis=0), np.roll(flat, -1, axis=0)
    area = _cross(flat - before, after - flat)
    longest = np.max(
        [((p - q) ** 2).sum(axis=1) for p, q in ((flat, before), (after, flat), (before, after))], axis=0
    )
    shape = area / np.where(longest > 0, longest, 1)
    for corner in np.argsort(-shape, kind="stable").tolist():
        if shape[corner] <= margin:
            return None
        a, b, c = before[corner], flat[corner], after[corner]
        inside = np.full(len(flat), True)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= _cross(np.broadcast_to(q - p, flat.shape), flat - p) >= -margin * np.linalg.norm(q - p)
        own = np.min([np.abs(flat - p).max(axis=1) for p in (a, b, c)], axis=0) <= 1e-12
        if not (inside & ~own).any():
            return int(corner)
    return None


def _crosses(flat: Floats) -> bool:
    """Return whether two edges of a face cross: the ends of each are on both sides of the other."""
    ends = np.roll(flat, -1, axis=0)
    for start, end in zip(flat, ends, strict=True):
        way = end - start
        sides = [_cross(np.broadcast_to(way, flat.shape), p - start) for p in (flat, ends)]
        others = [_cross(ends - flat, p - flat) for p in (start, end)]
        apart = [np.minimum(p, q) < -1e-9 for p, q in (sides, others)]
        across = [np.maximum(p, q) > 1e-9 for p, q in (sides, others)]
        if (apart[0] & across[0] & apart[1] & across[1]).any():
            return True
    return False
