"""Reads stereolithography's .stl, text or binary: triangles that share no vertices."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .polygons import Triangles, Unreadable
from .surfaces import Surface

__all__ = ["read"]

_HEADER, _COUNT, _FACET = 80, 4, 50  # bytes


def read(_: Path, content: bytes) -> Surface:
    """Return the surface of a file. Raises Unreadable."""
    if len(content) >= _HEADER + _COUNT:
        count = int.from_bytes(content[_HEADER : _HEADER + _COUNT], "little")
        # Binary files may begin with "solid", too: their length decides.
        if len(content) == _HEADER + _COUNT + _FACET * count or b"\0" in content[: _HEADER + _COUNT]:
            return Surface(*_binary(content, count))
    return Surface(*_text(content))


def _binary(content: bytes, count: int) -> Triangles:
    facets = (len(content) - _HEADER - _COUNT) // _FACET
    if facets < count:
        raise Unreadable(f"it is cut off: it holds {facets} of {count} triangles")
    numbers = np.frombuffer(content, np.uint8, count * _FACET, _HEADER + _COUNT).reshape(count, _FACET)
    corners = np.ascontiguousarray(numbers[:, 12:48]).view("<f4").astype(np.float64)
    return _numbered(corners.reshape(-1, 3))


def _text(content: bytes) -> Triangles:
    words = content.lower().split()
    if not words or words[0] != b"solid":
        raise Unreadable("it is neither a text that begins with 'solid' nor binary")
    corners: list[list[float]] = []
    of_loop = 0
    for number, word in enumerate(words):
        if word == b"vertex":
            try:
                x, y, z = map(float, words[number + 1 : number + 4])
            except ValueError:
                continue  # part of a solid's name
            corners.append([x, y, z])
            of_loop += 1
        elif word == b"endloop":
            if of_loop != 3:
                raise Unreadable(f"facet {len(corners) // 3} has {of_loop} vertices, not 3")
            of_loop = 0
    if of_loop:
        raise Unreadable("it is cut off within a facet")
    return _numbered(np.array(corners, np.float64).reshape(-1, 3))


def _numbered(corners: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Triangles:
    return corners, np.arange(len(corners)).reshape(-1, 3)
