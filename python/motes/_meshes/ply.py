"""Reads Stanford .ply files, text or binary of either byte order: faces and triangle strips.

Vertices may have normals, texture coordinates and colours: 8 bits are sRGB, other numbers linear.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .polygons import Indices, Unreadable, strip, triangulate
from .surfaces import Surface, linear_of

__all__ = ["read"]

_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"double": "f8", "float32": "f4", "float64": "f8"},
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")
_PLACES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


@dataclass
class _Property:
    name: str
    kind: str
    count: str = ""
    """The type of a list's length; empty: the property is one number."""


@dataclass
class _Element:
    name: str
    rows: int
    properties: list[_Property] = field(default_factory=list)


class _Body:
    """The data after the header, read from start to end."""

    def __init__(self, content: bytes, order: str) -> None:
        self._order = order
        self._words = content.split() if not order else []
        self._content = content
        self._at = 0

    def take(self, kind: str, count: int) -> NDArray[Any]:
        """Return the next numbers of one type."""
        if self._order:
            dtype = np.dtype(self._order + kind)
            return np.frombuffer(self._bytes(count * dtype.itemsize), dtype)
        words = self._words[self._at : self._at + count]
        if len(words) < count:
            raise Unreadable("it is cut off")
        self._at += count
        return np.array(list(map(float, words)), np.float64)

    def rows(self, element: _Element, lengths: list[int]) -> NDArray[Any] | None:
        """Return all rows at once as records, if their lists have the lengths of the first row's."""
        fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
        for one, length in zip(element.properties, lengths, strict=True):
            if one.count:
                fields += [
                    (f"{one.name} length", self._kind(one.count)),
                    (one.name, self._kind(one.kind), (length,)),
                ]
            else:
                fields.append((one.name, self._kind(one.kind)))
        dtype = np.dtype(fields)
        if self._order:
            if dtype.itemsize * element.rows > len(self._content) - self._at:
                return None
            rows_ = np.frombuffer(self._content, dtype, element.rows, self._at)
            used = dtype.itemsize * element.rows
        else:
            used = dtype.itemsize // 8 * element.rows
            if used > len(self._words) - self._at:
                return None
            words = self._words[self._at : self._at + used]
            rows_ = np.array([float(word) for word in words]).view(dtype)
        for one, length in zip(element.properties, lengths, strict=True):
            if one.count and (rows_[f"{one.name} length"] != length).any():
                return None
        self._at += used
        return rows_

    def peek_lengths(self, element: _Element) -> list[int]:
        """Return the lengths of the lists of the next row, and 1 for numbers."""
        start = self._at
        lengths = []
        for one in element.properties:
            length = self._length(one) if one.count else 1
            self.take(one.kind, length)
            lengths.append(length)
        self._at = start
        return lengths

    def lists(self, element: _Element, name: str) -> tuple[Indices, Indices]:
        """Return the lengths and the numbers of a list, row by row; skip the other properties."""
        counts: list[int] = []
        lists: list[NDArray[Any]] = []
        for _ in range(element.rows):
            for one in element.properties:
                numbers = self.take(one.kind, self._length(one) if one.count else 1)
                if one.name == name:
                    counts.append(len(numbers))
                    lists.append(numbers)
        return np.array(counts, np.int64), np.concatenate([*lists, np.empty(0)]).astype(np.int64)

    def _length(self, one: _Property) -> int:
        length = int(self.take(one.count, 1)[0])
        if length < 0:
            raise Unreadable(f"a list of {one.name} has {length} items")
        return length

    def _kind(self, kind: str) -> str:
        return self._order + kind if self._order else "f8"

    def _bytes(self, size: int) -> bytes:
        content = self._content[self._at : self._at + size]
        if len(content) < size:
            raise Unreadable("it is cut off")
        self._at += size
        return content


def read(_: Path, content: bytes) -> Surface:
    """Return the surface of a file. Raises Unreadable."""
    elements, order, start = _header(content)
    body = _Body(content[start:], order)
    surface = Surface(np.empty((0, 3)), np.empty((0, 3), np.int64))
    faces = [(np.empty(0, np.int64), np.empty(0, np.int64))]
    strips: list[Indices] = []
    for element in elements:
        if element.name == "vertex":
            surface = _vertices(body, element)
        elif element.name in ("face", "tristrips"):
            counts, corners = _lists(body, element)
            if element.name == "face":
                faces.append((counts, corners))
            else:
                rows = np.split(corners, np.cumsum(counts))
                strips += [part for row in rows for part in _restarted(row)]
        else:
            _skip(body, element)
    for one in strips:
        triangles = strip(one).reshape(-1)
        faces.append((np.full(len(triangles) // 3, 3), triangles))
    counts, corners = (np.concatenate(part) for part in zip(*faces, strict=True))
    return surface._replace(triangles=triangulate(surface.vertices, counts, corners))


def _header(content: bytes) -> tuple[list[_Element], str, int]:
    """Return the elements, the byte order (empty for text), and the offset of the data."""
    end = content.find(b"end_header")
    start = content.find(b"\n", end) + 1
    if not content.startswith(b"ply") or end < 0 or not start:
        raise Unreadable("it has no header from 'ply' to 'end_header'")
    elements: list[_Element] = []
    order = None
    for line in content[:end].decode("latin-1").splitlines():
        words = line.split()
        if words[:1] == ["format"] and len(words) > 1:
            order = _ORDERS.get(words[1])
        elif words[:1] == ["element"]:
            elements.append(_Element(words[1], int(words[2])))
        elif words[:1] == ["property"]:
            is_list = words[1] == "list"
            kinds = words[2:4] if is_list else words[1:2]
            unknown = [kind for kind in kinds if kind not in _TYPES]
            if unknown or not elements:
                raise Unreadable(f"its header has {line.strip()!r}")
            *counted, kind = (_TYPES[one] for one in kinds)
            elements[-1].properties.append(_Property(words[-1], kind, *counted))
    if order is None:
        raise Unreadable(f"its format is not one of {', '.join(_ORDERS)}")
    return elements, order, start


def _vertices(body: _Body, element: _Element) -> Surface:
    if not {"x", "y", "z"} <= {one.name for one in element.properties}:
        raise Unreadable("its vertices have no x, y and z")
    records = _records(body, element)
    if records is None:
        raise Unreadable("lists of different lengths in its vertices are not supported")
    found = records

    def columns(*names: str) -> NDArray[np.float64] | None:
        if not set(names) <= set(found.dtype.names or ()) or any(found[name].ndim > 1 for name in names):
            return None
        return np.stack([found[name].astype(np.float64) for name in names], axis=-1)

    at = next((rows for names in _PLACES if (rows := columns(*names)) is not None), None)
    points = columns("x", "y", "z")
    assert points is not None
    tints = columns("red", "green", "blue")
    if tints is not None and any(one.kind == "u1" for one in element.properties if one.name == "red"):
        tints = linear_of(tints / 255)
    return Surface(points, np.empty((0, 3), np.int64), columns("nx", "ny", "nz"), at, tints)


def _lists(body: _Body, element: _Element) -> tuple[Indices, Indices]:
    name = next((one.name for one in element.properties if one.name in _CORNERS and one.count), None)
    if name is None:
        raise Unreadable(f"its element {element.name!r} has no list {_CORNERS[0]}")
    records = _records(body, element)
    if records is None:
        return body.lists(element, name)
    rows = records[name].astype(np.int64)
    return np.full(len(rows), rows.shape[1] if rows.ndim == 2 else 0, np.int64), rows.reshape(-1)


def _skip(body: _Body, element: _Element) -> None:
    if element.properties and _records(body, element) is None:
        body.lists(element, "")


def _records(body: _Body, element: _Element) -> NDArray[Any] | None:
    """Return the rows as records, or None if their lists differ in length."""
    if not element.rows:
        return np.empty(
            0, [(one.name, "f8", (0,)) if one.count else (one.name, "f8") for one in element.properties]
        )
    if element.rows < 0:
        raise Unreadable(f"its number of elements {element.name!r} is {element.rows}")
    rows = body.rows(element, body.peek_lengths(element))
    if rows is None and not any(one.count for one in element.properties):
        raise Unreadable("it is cut off")
    return rows


def _restarted(corners: Indices) -> list[Indices]:
    """Split a row of strips at its restart marks, -1."""
    marks = np.flatnonzero(corners == -1)
    parts = np.split(corners, marks)
    return [part[part != -1] for part in parts if (part != -1).sum() >= 3]
