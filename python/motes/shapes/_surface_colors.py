"""Colours and densities of a mesh's vertices, given directly or read from a picture at their `uv`."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._values import arguments, colors
from .._values.images import interpolated
from ..errors import ArgumentError

__all__ = ["densities", "directions_of", "of_vertices", "places"]

BRIGHTEST = 1e6
DENSEST = 1e6
MOST_SIDE = 8192


def places(given: Any, vertices: int) -> NDArray[np.float32]:
    """Return the checked texture coordinates, one row per vertex."""
    return _rows("uv", given, (vertices, 2))


def directions_of(given: Any, vertices: int) -> NDArray[np.float32]:
    """Return a mesh's normals as a read-only array."""
    rows = _rows("normals", given, (vertices, 3))
    if not (np.abs(rows) <= 1e6).all():
        raise ArgumentError("normals", given, "finite and within 1e6")
    return rows


def of_vertices(given: Any, uv: NDArray[np.float32] | None, vertices: int) -> NDArray[np.float32]:
    """Return the linear RGB of each vertex."""
    if isinstance(given, str) and not arguments.is_path(given):
        given = [given] * vertices
    picture = _picture("colors", given)
    if picture is not None:
        table = np.array(colors.LINEAR)
        return _frozen(interpolated(picture, _given(uv, "colors"), lambda pixels: table[pixels]))
    rows = _rows("colors", arguments.colors_of_rows("colors", given), (vertices, 3))
    if not ((rows >= 0) & (rows <= BRIGHTEST)).all():
        raise ArgumentError("colors", given, "linear RGB, in 0..1e6")
    return rows


def densities(
    given: Any, uv: NDArray[np.float32] | None, triangles: NDArray[np.uint32], vertices: int
) -> NDArray[np.float32]:
    """Return the density of each vertex."""
    picture = _picture("density", given)
    if picture is not None:
        places_on = _given(uv, "density")
        rows = _frozen(
            interpolated(picture, places_on, lambda pixels: pixels.mean(axis=1, keepdims=True) / 255)[:, 0]
        )
    else:
        rows = _rows("density", given, (vertices,))
    if not ((rows >= 0) & (rows <= DENSEST)).all():
        wrong = np.flatnonzero(~((rows >= 0) & (rows <= DENSEST)))[0]
        raise ArgumentError(f"density[{wrong}]", float(rows[wrong]), f"a number in 0..{DENSEST:g}")
    if not (rows[triangles] > 0).any():
        raise ArgumentError("density", "0 at all corners of triangles", "above 0 at one or more of them")
    return rows


def _picture(argument: str, given: Any) -> NDArray[np.uint8] | None:
    """Return the pixels if a picture is given, uint8 (height, width, 3 or 4), else None."""
    if isinstance(given, (str, os.PathLike)):
        from .._values.images import read_picture

        return read_picture(argument, given, most=MOST_SIDE)
    if getattr(given, "ndim", 0) != 3:
        return None
    if given.dtype != np.uint8 or given.shape[2] not in (3, 4) or 0 in given.shape:
        allowed = "a picture, uint8 (height, width, 3) or (height, width, 4)"
        raise ArgumentError(argument, f"{given.dtype} {given.shape}", allowed)
    pixels: NDArray[np.uint8] = np.asarray(given)
    return pixels


def _given(uv: NDArray[np.float32] | None, argument: str) -> NDArray[np.float32]:
    if uv is None:
        raise ArgumentError(
            "uv", None, f"given if {argument} is a picture: the position of each vertex on it"
        )
    return uv


def _rows(argument: str, given: Any, shape: tuple[int, ...]) -> NDArray[np.float32]:
    allowed = f"finite numbers of shape {shape}, one row per vertex"
    array = arguments.floats(argument, given, np.float32, allowed)
    if array.shape != shape or not np.isfinite(array).all():
        raise ArgumentError(argument, f"{array.dtype} {array.shape}", allowed)
    return _frozen(np.array(array, order="C"))


def _frozen(array: NDArray[np.float32]) -> NDArray[np.float32]:
    array.flags.writeable = False
    return array
