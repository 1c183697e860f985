"""Text and Picture: letters and pictures as meshes, cut out along their outlines."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._values import arguments, colors
from .._values.images import read_picture
from ..errors import ArgumentError
from ._mesh import Mesh

__all__ = ["Picture", "Text"]

LETTERS = 96  # pixels per font size
MOST_PIXELS = 4096  # of a text each way
MOST_SIDE = 8192  # of a picture file
CELLS = 512  # along the longest side of a picture; larger ones are averaged
INSIDE = 256  # cells of the grid of a text's inside
NEAREST = 0.02  # of a cell: how close outlines come to corners of cells, so that no triangle is too thin
FONT = "a TrueType or OpenType font: a file, or the name of an installed one"


def Text(  # noqa: N802 (a shape, like the classes beside it)
    text: str, height: float, depth: float = 0, font: str | os.PathLike[str] | None = None
) -> Mesh:
    """Make letters into a mesh, centred at the origin and facing +z; `at` moves and turns it.

    Flat letters are sampled from their area, letters with a depth from their inside; these are closed, so
    particles bounce off them, too. Needs Pillow (the extra [image]), whose rasteriser draws the letters
    before their outlines are traced. Ranks compare the mesh like any argument of a call: if a font differs
    between hosts, the run ends with ScriptMismatchError.

    Args:
        text: the letters; a line break starts a new line, and lines are centred.
        height: distance from the lowest to the highest point of the letters, m.
        depth: thickness along z, m; 0: flat.
        font: a TrueType or OpenType font: a file, or the name of an installed one; None: Pillow's own
            sans-serif font.

    Returns:
        The mesh.
    """
    if not isinstance(text, str) or not text.strip():
        raise ArgumentError("text", text, "text with at least one visible letter")
    height, depth = _above_0("height", height), arguments.number("depth", depth, low=0, high=1e6)
    level = np.pad(_drawn(text, font) - 0.5, 1, constant_values=-0.5)
    outline = _Outline(level)
    if not len(outline.triangles):
        raise ArgumentError("text", text, "text with at least one letter that the font can draw")
    low, high = outline.points.min(axis=0), outline.points.max(axis=0)
    points = (outline.points - (low + high) / 2) * (height / (high[1] - low[1]))
    if depth == 0:
        return Mesh(_at(points, 0), outline.triangles)
    return Mesh(*_thick(points, outline, depth), solid=True, resolution=INSIDE)


def Picture(  # noqa: N802 (a shape, like the classes beside it)
    path: str | os.PathLike[str], width: float, threshold: float = 0.5
) -> Mesh:
    """Make the opaque or bright part of a picture into a flat mesh, with the picture's colours.

    The picture's middle is at the origin, and it faces +z; `at` moves and turns the mesh. Its `colors` are
    the picture's: `configure(color=motes.surface_color())` gives them to particles born in it. Needs Pillow
    (the extra [image]). Longest sides above 512 pixels are reduced.

    Args:
        path: a file: PNG, JPEG, WebP, TIFF, BMP, GIF, TGA or PPM.
        width: of the whole picture, m.
        threshold: which part counts, 0..1: where the picture's alpha is at least this, or its brightness
            (sRGB) if it is opaque everywhere.

    Returns:
        The mesh.
    """
    width = _above_0("width", width)
    threshold = arguments.number("threshold", threshold, low=0, high=1)
    pixels = read_picture("path", path, most=MOST_SIDE)
    across = pixels.shape[1]
    alpha = pixels[:, :, 3] / 255
    light = np.array(colors.LINEAR)[pixels[:, :, :3]]
    opaque = bool((alpha == 1).all())
    cover = (pixels[:, :, :3] / 255) @ (0.2126, 0.7152, 0.0722) if opaque else alpha
    step = -(-max(cover.shape) // CELLS)
    weight = _mean(alpha, step)
    light = _mean(light * alpha[:, :, None], step) / np.maximum(weight, 1e-9)[:, :, None]
    level = np.pad(_mean(cover, step) - threshold, 1, mode="edge")
    for edge in (level[0], level[-1], level[:, 0], level[:, -1]):
        edge[:] = -np.abs(edge) - 1e-9  # the outline is where the picture ends
    outline = _Outline(level)
    if not len(outline.triangles):
        raise ArgumentError("threshold", threshold, "lower: no part of the picture reaches it")
    middle = np.array((across, -pixels.shape[0])) / (2 * step) + (0.5, -0.5)
    points = (outline.points - middle) * (width / across * step)
    tints = np.pad(light, ((1, 1), (1, 1), (0, 0)), mode="edge").reshape(-1, 3)[outline.nearest]
    return Mesh(_at(points, 0), outline.triangles, colors=tints)


class _Outline:
    """The part of a grid of samples where they are at least 0, as triangles: marching squares.

    Corners of cells are at (column, -row). Samples at the grid's border must be below 0.
    """

    points: NDArray[np.float64]
    """(n, 2), in cells."""
    triangles: NDArray[np.int64]
    """(m, 3), anticlockwise."""
    edges: NDArray[np.int64]
    """(k, 2): the outline's edges, with the inside on their left."""
    nearest: NDArray[np.int64]
    """(n,): each point's corner of a cell, of those inside, counted row by row."""

    def __init__(self, level: NDArray[np.float64]) -> None:
        rows, columns = level.shape
        self._columns, self._size = columns, rows * columns
        inside = level >= 0
        row, column = np.mgrid[: rows - 1, : columns - 1].reshape(2, -1)
        # A cell's corners anticlockwise from the lower left, and the crossings on the sides that follow them.
        at = row * columns + column
        corner = (at + columns, at + columns + 1, at + 1, at)
        side = (
            at + columns + self._size,  # along the row below
            at + 1 + 2 * self._size,  # along the column to the right
            at + self._size,
            at + 2 * self._size,
        )
        flat = inside.ravel()
        kind = sum(flat[one].astype(int) << k for k, one in enumerate(corner))
        triangles, edges = [], []
        for which in range(1, 16):
            cells = np.flatnonzero(kind == which)
            ring, cuts = _ring(which)
            polygon = [(side if crossing else corner)[k][cells] for crossing, k in ring]
            for k in range(1, len(polygon) - 1):
                triangles.append(np.stack((polygon[0], polygon[k], polygon[k + 1]), axis=1))
            edges += [np.stack((side[a][cells], side[b][cells]), axis=1) for a, b in cuts]
        corners = np.concatenate(triangles)
        used, self.triangles = np.unique(corners, return_inverse=True)
        self.triangles = self.triangles.reshape(-1, 3)
        self.edges = np.searchsorted(used, np.concatenate(edges))
        self._place(used, level.ravel(), flat)

    def _place(self, used: NDArray[np.int64], level: NDArray[np.float64], inside: NDArray[np.bool_]) -> None:
        """Set where the used corners and crossings are."""
        which, first = np.divmod(used, self._size)
        second = first + np.choose(which, (0, 1, self._columns))
        rise = level[second] - level[first]
        crossed = which > 0
        part = np.where(crossed, -level[first] / np.where(crossed, rise, 1), 0)
        part = np.where(crossed, part.clip(NEAREST, 1 - NEAREST), 0)
        x, y = first % self._columns + part * (which == 1), first // self._columns + part * (which == 2)
        self.points = np.stack((x, -y), axis=1)
        self.nearest = np.where(inside[first], first, second)


def _ring(which: int) -> tuple[list[tuple[bool, int]], list[tuple[int, int]]]:
    """Return the polygon of a cell whose corners inside are the bits of `which`, and its cut edges.

    The polygon is a list of (whether it is a crossing, number of the corner or of the side).
    """
    ring, crossings = [], []
    for k in range(4):
        here, after = which >> k & 1, which >> (k + 1) % 4 & 1
        if here:
            ring.append((False, k))
        if here != after:
            ring.append((True, k))
            crossings.append((k, bool(here)))
    cuts = []
    for i, (k, leaves) in enumerate(crossings):
        if leaves:  # the outline runs from where the ring leaves the inside to where it returns
            cuts.append((k, crossings[(i + 1) % len(crossings)][0]))
    return ring, cuts


def _drawn(text: str, font: Any) -> NDArray[np.float64]:
    """Return the letters' coverage, 0..1, of shape (rows, columns)."""
    images, draws = _extras.pillow(need="letters as a shape"), _extras.pillow("PIL.ImageDraw")
    face = _font(font)
    pen = draws.Draw(images.new("L", (1, 1)))
    left, top, right, bottom = map(round, pen.multiline_textbbox((0, 0), text, font=face, align="center"))
    size = right - left + 2, bottom - top + 2
    if max(size) > MOST_PIXELS:
        raise ArgumentError("text", text, "shorter: at most about 80 letters in a line, and 40 lines")
    picture = images.new("L", size)
    draws.Draw(picture).multiline_text((1 - left, 1 - top), text, fill=255, font=face, align="center")
    return np.asarray(picture) / 255


def _font(font: Any) -> Any:
    """Return the font, with the layout that every Pillow has."""
    fonts = _extras.pillow("PIL.ImageFont")
    if font is not None and not isinstance(font, (str, os.PathLike)):
        raise ArgumentError("font", font, FONT)
    if font is not None and os.path.exists(font) and not os.path.isfile(font):
        raise ArgumentError("font", font, FONT)  # Pillow would wait for a pipe
    basic = fonts.Layout.BASIC
    try:
        if font is None:
            return fonts.load_default(LETTERS).font_variant(layout_engine=basic)
        return fonts.truetype(os.fspath(font), LETTERS, layout_engine=basic)
    except Exception as error:  # of any kind: each damaged file raises another
        raise ArgumentError("font", font, f"{FONT} ({error})") from None


def _mean(values: NDArray[np.float64], step: int) -> NDArray[np.float64]:
    """Average squares of `step` pixels; those at the border repeat the last row and column."""
    rows, columns = values.shape[:2]
    wide = [(0, -rows % step), (0, -columns % step), (0, 0)][: values.ndim]
    whole = np.pad(values, wide, mode="edge")
    cut = whole.reshape(whole.shape[0] // step, step, whole.shape[1] // step, step, *values.shape[2:])
    mean: NDArray[np.float64] = cut.mean(axis=(1, 3))
    return mean


def _thick(points: NDArray[np.float64], outline: _Outline, depth: float) -> tuple[Any, Any]:
    """Return vertices and triangles of a body: front, back and the walls between them."""
    count = len(points)
    start, end = outline.edges.T
    walls = [
        np.stack((start, start + count, end + count), axis=1),
        np.stack((start, end + count, end), axis=1),
    ]
    faces = [outline.triangles, outline.triangles[:, ::-1] + count]
    return np.concatenate((_at(points, depth / 2), _at(points, -depth / 2))), np.concatenate(faces + walls)


def _at(points: NDArray[np.float64], z: float) -> NDArray[np.float64]:
    return np.column_stack((points, np.full(len(points), z)))


def _above_0(argument: str, value: Any) -> float:
    number = arguments.number(argument, value, low=0, high=1e6)
    if number == 0:
        raise ArgumentError(argument, value, "above 0")
    return number
