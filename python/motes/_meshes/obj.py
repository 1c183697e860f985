"""Reads Wavefront .obj: `v` and `f`; lines, points, colours, normals, materials and names are ignored."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .polygons import Triangles, Unreadable, triangulate

__all__ = ["read"]

_FREE_FORM = {b"surf", b"bsp", b"bzp", b"cdc", b"cdp", b"res"}
_COMMANDS = {b"call", b"csh"}


def read(_: Path, content: bytes) -> Triangles:
    """Return the vertices and triangles of a file. Raises Unreadable."""
    numbers: list[list[bytes]] = []
    counts: list[int] = []
    corners: list[int] = []
    lines: list[int] = []
    for line, text in enumerate(_joined(content), 1):
        words = text.partition(b"#")[0].split()
        if not words:
            continue
        if words[0] == b"v":
            numbers.append(words[1:4])
        elif words[0] in (b"f", b"fo"):
            counts.append(len(words) - 1)
            corners += [_index(word, len(numbers), line) for word in words[1:]]
            lines.append(line)
        elif words[0] in _FREE_FORM:
            raise Unreadable(f"line {line}: free-form surfaces ({words[0].decode()}) are not supported")
        elif words[0] in _COMMANDS:
            raise Unreadable(f"line {line}: {words[0].decode()} is not supported")
    vertices = _positions(numbers)
    faces = np.array(counts, np.int64), np.array(corners, np.int64)
    return vertices, triangulate(vertices, *faces, lambda face: f"line {lines[face]}: the face")


def _joined(content: bytes) -> list[bytes]:
    """Return the lines, joining those that end in a backslash with the next."""
    lines = content.splitlines()
    for number in range(len(lines) - 1, 0, -1):
        if lines[number - 1].rstrip(b" \t").endswith(b"\\"):
            lines[number - 1] = lines[number - 1].rstrip(b" \t")[:-1] + b" " + lines[number]
            lines[number] = b""  # so that the others keep their numbers
    return lines


def _index(word: bytes, vertices: int, line: int) -> int:
    """Return the index of a vertex, from 0; -1 refers to the last one defined before the face."""
    try:
        index = int(word.partition(b"/")[0])
    except ValueError:
        raise Unreadable(f"line {line}: {word.decode(errors='replace')!r} is not a vertex") from None
    if index == 0 or index < -vertices:
        known = f"1 to {vertices}, or -{vertices} to -1" if vertices else "none above this line"
        raise Unreadable(f"line {line}: vertex {index} does not exist; vertices are {known}")
    return index - 1 if index > 0 else vertices + index


def _positions(numbers: list[list[bytes]]) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
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
