"""What a mesh file holds: triangles, and what their vertices have besides positions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._values.colors import LINEAR
from .._values.materials import Material
from .polygons import Floats, Indices

__all__ = ["Surface", "joined", "linear_of", "moved", "sane"]

MOST = 1e6


class Surface(NamedTuple):
    """Vertices, (n, 3), and triangles, (m, 3); the other arrays have a row per vertex, or are None."""

    vertices: Floats
    triangles: Indices
    normals: Floats | None = None
    """Of any length; 0, 0, 0 where the file has none: there the triangles are flat."""
    uv: Floats | None = None
    colors: Floats | None = None
    """Linear RGB."""
    material: Material | None = None


_ABSENT = {"normals": (0.0, 0.0, 0.0), "uv": (0.0, 0.0), "colors": (1.0, 1.0, 1.0)}
"""What vertices have that lack what others have."""


def sane(name: str, rows: NDArray[Any] | None) -> Floats | None:
    """Return rows without numbers that a mesh refuses; None if nothing is left."""
    if rows is None:
        return None
    good = (np.abs(rows) <= MOST).all(axis=1)  # false for NaN
    checked = np.where(good[:, None], rows, np.array(_ABSENT[name]))
    if name == "colors":
        return checked.clip(0)
    return checked if checked.any() else None


def linear_of(encoded: NDArray[Any]) -> Floats:
    """Return sRGB in 0..1 as linear RGB, to 8 bits."""
    linear: Floats = np.array(LINEAR)[np.rint(encoded.clip(0, 1) * 255).astype(np.int64)]
    return linear


def moved(part: Surface, place: Floats) -> Surface:
    """Return a part at a place, a matrix of shape (4, 4)."""
    turn = place[:3, :3]
    mirrors = np.linalg.det(turn) < 0
    normals = part.normals
    if normals is not None:
        # The matrix of cofactors keeps normals perpendicular, also where the place squeezes the part.
        cofactors = np.stack(
            [np.cross(turn[1], turn[2]), np.cross(turn[2], turn[0]), np.cross(turn[0], turn[1])]
        )
        normals = normals @ cofactors.T * (-1 if mirrors else 1)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = normals / np.where(lengths > 0, lengths, 1)
    return part._replace(
        vertices=part.vertices @ turn.T + place[:3, 3],
        triangles=part.triangles[:, ::-1] if mirrors else part.triangles,  # mirroring reverses the winding
        normals=normals,
    )


def joined(parts: Sequence[Surface]) -> Surface:
    """Return several surfaces as one, without materials."""
    vertices: list[Floats] = [np.empty((0, 3)), *(part.vertices for part in parts)]
    firsts = np.cumsum([len(points) for points in vertices])
    triangles = [part.triangles + first for part, first in zip(parts, firsts, strict=False)]
    others: dict[str, Any] = {name: _joined(name, parts) for name in _ABSENT}
    return Surface(
        np.concatenate(vertices), np.concatenate([np.empty((0, 3), np.int64), *triangles]), **others
    )


def _joined(name: str, parts: Sequence[Surface]) -> Floats | None:
    given = [getattr(part, name) for part in parts]
    if all(rows is None for rows in given):
        return None
    return np.concatenate(
        [
            np.tile(_ABSENT[name], (len(part.vertices), 1)) if rows is None else rows
            for part, rows in zip(parts, given, strict=True)
        ]
    )
