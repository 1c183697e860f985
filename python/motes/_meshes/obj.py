"""Reads Wavefront .obj: `v`, `vt`, `vn` and `f`; lines, points, materials and names are ignored."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .polygons import Floats, Indices, Unreadable, triangulate
from .surfaces import Surface, linear_of

__all__ = ["read"]

_FREE_FORM = {b"surf", b"bsp", b"bzp", b"cdc", b"cdp", b"res"}
_COMMANDS = {b"call", b"csh"}
_OTHERS = (b"vt", b"vn")


def read(_: Path, content: bytes) -> Surface:
    """Return the surface of a file. Raises Unreadable."""
    numbers: dict[bytes, list[list[bytes]]] = {b"v": [], b"vt": [], b"vn": []}
    counts: list[int] = []
    corners: list[tuple[int, int, int]] = []
    lines: list[int] = []
    for line, text in enumerate(_joined(content), 1):
        words = text.partition(b"#")[0].split()
        if not words:
            continue
        if words[0] in numbers:
            numbers[words[0]].append(words[1:])
        elif words[0] in (b"f", b"fo"):
            counts.append(len(words) - 1)
            corners += [_corner(word, numbers, line) for word in words[1:]]
            lines.append(line)
        elif words[0] in _FREE_FORM:
            raise Unreadable(f"line {line}: free-form surfaces ({words[0].decode()}) are not supported")
        elif words[0] in _COMMANDS:
            raise Unreadable(f"line {line}: {words[0].decode()} is not supported")
    points = _positions([words[:3] for words in numbers[b"v"]])
    used, own = _split(np.array(corners, np.int64).reshape(-1, 3), len(points))
    surface = Surface(
        points[used[:, 0]],
        triangulate(
            points[used[:, 0]], np.array(counts, np.int64), own, lambda k: f"line {lines[k]}: the face"
        ),
        normals=_chosen(_others(numbers[b"vn"], 3), used[:, 2]),
        uv=_chosen(_others(numbers[b"vt"], 2), used[:, 1]),
        colors=_colors(numbers[b"v"]),
    )
    return surface._replace(colors=None if surface.colors is None else surface.colors[used[:, 0]])


def _split(corners: Indices, count: int) -> tuple[Indices, Indices]:
    """Give each vertex one texture vertex and one normal: repeat those that have several.

    Args:
        corners: indices of the vertex, texture vertex and normal of each corner; -1: none.
        count: number of vertices; they keep their numbers, and the repeated ones follow.

    Returns:
        The three indices of each vertex, and the vertex of each corner.
    """
    if (corners[:, 0] >= count).any():  # an error, which triangulate() names
        return np.stack([np.arange(count)] * 3, axis=1), corners[:, 0]
    rows, first, own = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    used = np.stack([np.arange(count), np.full(count, -1), np.full(count, -1)], axis=1)
    number = np.empty(len(rows), np.int64)
    taken: set[int] = set()
    more: list[int] = []
    for row in order.tolist():
        vertex = int(rows[row, 0])
        if vertex in taken:
            number[row] = count + len(more)
            more.append(row)
        else:
            number[row] = vertex
            taken.add(vertex)
            used[vertex] = rows[row]
    return np.concatenate([used, rows[more]]), number[own.reshape(-1)]


def _chosen(rows: Floats, which: Indices) -> Floats | None:
    """Return a row for each vertex, 0 where it has none; None if no vertex has one."""
    known = (which >= 0) & (which < len(rows))
    if not known.any():
        return None
    chosen: Floats = np.where(known[:, None], rows[np.where(known, which, 0)], 0.0)
    return chosen


def _colors(numbers: list[list[bytes]]) -> Floats | None:
    """Return the linear colours that some programs write behind positions, as sRGB in 0..1."""
    if not numbers or min(map(len, numbers)) < 6:
        return None
    rows = _others([words[-3:] for words in numbers], 3)
    return linear_of(rows) if len(rows) and np.isfinite(rows).all() else None


def _joined(content: bytes) -> list[bytes]:
    """Return the lines, joining those that end in a backslash with the next."""
    lines = content.splitlines()
    for number in range(len(lines) - 1, 0, -1):
        if lines[number - 1].rstrip(b" \t").endswith(b"\\"):
            lines[number - 1] = lines[number - 1].rstrip(b" \t")[:-1] + b" " + lines[number]
            lines[number] = b""  # so that the others keep their numbers
    return lines


def _corner(word: bytes, numbers: dict[bytes, list[list[bytes]]], line: int) -> tuple[int, int, int]:
    """Return the indices of a corner's vertex, texture vertex and normal, from 0; -1: none."""
    own, *others = word.split(b"/")
    at, along = (
        _optional(text, len(numbers[name])) for text, name in zip([*others, b"", b""], _OTHERS, strict=False)
    )
    return _index(own, len(numbers[b"v"]), line), at, along


def _optional(text: bytes, count: int) -> int:
    """Return an index from 0, -1 if there is none: what is wrong besides vertices is left out."""
    try:
        index = int(text)
    except ValueError:
        return -1
    return index - 1 if index >= 0 else max(count + index, -1)


def _index(word: bytes, vertices: int, line: int) -> int:
    """Return the index of a vertex, from 0; -1 refers to the last one defined before the face."""
    try:
        index = int(word)
    except ValueError:
        raise Unreadable(f"line {line}: {word.decode(errors='replace')!r} is not a vertex") from None
    if index == 0 or index < -vertices:
        known = f"1 to {vertices}, or -{vertices} to -1" if vertices else "none above this line"
        raise Unreadable(f"line {line}: vertex {index} does not exist; vertices are {known}")
    return index - 1 if index > 0 else vertices + index


def _others(numbers: list[list[bytes]], width: int) -> Floats:
    """Return rows of numbers; none if one of them is wrong."""
    try:
        return np.array([[float(x) for x in words[:width]] for words in numbers], np.float64).reshape(
            -1, width
        )
    except ValueError:
        return np.empty((0, width))


def _positions(numbers: list[list[bytes]]) -> Floats:
    try:
        return np.array([[float(x), float(y), float(z)] for x, y, z in numbers], np.float64).reshape(-1, 3)
    except ValueError:
        pass
    for number, words in enumerate(numbers, 1):
        try:
            _, _, _ = map(float, words)
        except ValueError:
            text = b" ".join(words).decode(errors="replace")
            raise Unreadable(f"vertex {number}, {text!r}, is not 3 numbers") from None
    raise AssertionError("unreachable: one of them is wrong")
