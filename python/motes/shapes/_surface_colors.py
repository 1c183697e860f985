"""Colours of a mesh's vertices: given, or read from a picture at their places on it."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._values import arguments, colors
from ..errors import ArgumentError

__all__ = ["of_vertices", "places"]

BRIGHTEST = 1e6
MOST_SIDE = 8192


def places(given: Any, vertices: int) -> NDArray[np.float32]:
    """Return places on a picture, one per vertex."""
    return _rows("uv", given, (vertices, 2))


def of_vertices(given: Any, uv: NDArray[np.float32] | None, vertices: int) -> NDArray[np.float32]:
    """Return the linear RGB of each vertex."""
    if isinstance(given, (str, os.PathLike)):
        from .._values.images import read_picture

        given = read_picture("colors", given, most=MOST_SIDE)
    if getattr(given, "ndim", 2) != 3:
        rows = _rows("colors", arguments.colors_of_rows("colors", given), (vertices, 3))
        if not ((rows >= 0) & (rows <= BRIGHTEST)).all():
            raise ArgumentError("colors", given, "linear RGB, in 0..1e6")
        return rows
    if given.dtype != np.uint8 or given.shape[2] not in (3, 4) or 0 in given.shape:
        allowed = "a picture, uint8 (height, width, 3) or (height, width, 4)"
        raise ArgumentError("colors", f"{given.dtype} {given.shape}", allowed)
    if uv is None:
        raise ArgumentError("uv", None, "given with a picture as colors: where each vertex is on it")
    return _frozen(_read(given, uv))


def _read(picture: NDArray[np.uint8], uv: NDArray[np.float32]) -> NDArray[np.float32]:
    """Mix the four nearest pixels at each place, as light."""
    height, width, _ = picture.shape
    x = (uv[:, 0].astype(np.float64) % 1) * width - 0.5
    y = (1 - uv[:, 1].astype(np.float64) % 1) * height - 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    right, down = (x - column)[:, None], (y - row)[:, None]
    table = np.array(colors.LINEAR)

    def light(i: NDArray[Any], j: NDArray[Any]) -> NDArray[np.float64]:
        found: NDArray[np.float64] = table[picture[j % height, i % width, :3]]
        return found

    above = light(column, row) * (1 - right) + light(column + 1, row) * right
    below = light(column, row + 1) * (1 - right) + light(column + 1, row + 1) * right
    mixed: NDArray[np.float32] = (above * (1 - down) + below * down).astype(np.float32)
    return mixed


def _rows(argument: str, given: Any, shape: tuple[int, int]) -> NDArray[np.float32]:
    allowed = f"finite numbers of shape {shape}, one row per vertex"
    array = arguments.floats(argument, given, np.float32, allowed)
    if array.shape != shape or not np.isfinite(array).all():
        raise ArgumentError(argument, f"{array.dtype} {array.shape}", allowed)
    return _frozen(np.array(array, order="C"))


def _frozen(array: NDArray[np.float32]) -> NDArray[np.float32]:
    array.flags.writeable = False
    return array
