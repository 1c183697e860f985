"""Normals of meshes that look round: means over the triangles around each position."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["places_of", "smooth_normals"]


def smooth_normals(
    points: NDArray[np.float32], corners: NDArray[np.uint32], groups: NDArray[Any]
) -> NDArray[np.float32]:
    """Return the mean normal at each vertex; vertices with equal rows of `groups` share it."""
    _, at = np.unique(groups, axis=0, return_inverse=True)
    first, second, third = (points[corners[:, k]].astype(np.float64) for k in range(3))
    twice_areas = np.cross(second - first, third - first)
    sums = np.zeros((at.max() + 1, 3))
    for k in range(3):
        np.add.at(sums, at.reshape(-1)[corners[:, k]], twice_areas)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.asarray(sums / np.where(lengths > 0, lengths, 1), np.float32)[at.reshape(-1)]


def places_of(points: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return positions in cells of 1e-5 of the size: formulas and files repeat those of seams and poles."""
    cell = max(float(np.abs(points).max()), 1e-30) * 1e-5
    places: NDArray[np.float64] = np.rint(points / np.float64(cell)) + 0.0  # no -0
    return places
