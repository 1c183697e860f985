"""Reads the numbers in a glTF file: buffers, buffer views, and accessors, which give their types."""

from __future__ import annotations

import base64
import re
import urllib.parse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .polygons import Unreadable

__all__ = ["Accessors"]

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
_MOST_ZEROS = 10**8
"""Most items of an accessor without a buffer, which are zeros."""


class Accessors:
    """Reads a document's accessors."""

    def __init__(self, path: Path, document: dict[str, Any], binary: bytes) -> None:
        """Take the JSON document and the bytes of its first buffer; others may be files beside `path`."""
        self._folder = path.parent
        self._document = document
        self._buffers: dict[int, bytes] = {}
        self._binary = binary

    def read(self, index: int) -> NDArray[Any]:
        """Return the numbers of an accessor, (count, width); normalised integers as floats."""
        accessor = self._document["accessors"][index]
        count, width = _natural(accessor["count"]), _WIDTHS[accessor["type"]]
        dtype = np.dtype(_COMPONENTS[accessor["componentType"]])
        if "bufferView" in accessor:
            start = _natural(accessor.get("byteOffset", 0))
            items = self._items(accessor["bufferView"], start, count, width, dtype)
        elif count > _MOST_ZEROS:
            raise Unreadable(f"accessor {index} has {count} items without a buffer")
        else:
            items = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            items = self._replaced(items, accessor["sparse"])
        if accessor.get("normalized") and dtype.kind in "iu":
            return np.maximum(items / np.iinfo(dtype).max, -1.0)
        return items

    def view(self, index: int) -> bytes:
        """Return the bytes of a buffer view. Raises Unreadable for one that is compressed."""
        view = self._document["bufferViews"][index]
        buffer = self._buffer(view["buffer"])
        start, size = _natural(view.get("byteOffset", 0)), _natural(view["byteLength"])
        if start + size > len(buffer):
            raise Unreadable(f"buffer view {index} ends beyond its buffer")
        return buffer[start : start + size]

    def _items(self, view: int, start: int, count: int, width: int, dtype: np.dtype[Any]) -> NDArray[Any]:
        content = self.view(view)
        size = width * dtype.itemsize
        stride = _natural(self._document["bufferViews"][view].get("byteStride", size))
        if count and (count - 1) * stride + start + size > len(content):
            raise Unreadable(f"an accessor ends beyond buffer view {view}")
        strides = (stride, dtype.itemsize)
        return np.ndarray((count, width), dtype, content, start if count else 0, strides).copy()

    def _replaced(self, items: NDArray[Any], sparse: dict[str, Any]) -> NDArray[Any]:
        """Replace the items that a sparse accessor names, and return all."""
        count, where, values = _natural(sparse["count"]), sparse["indices"], sparse["values"]
        kind = np.dtype(_COMPONENTS[where["componentType"]])
        rows = self._items(where["bufferView"], _natural(where.get("byteOffset", 0)), count, 1, kind)
        start = _natural(values.get("byteOffset", 0))
        items[rows[:, 0]] = self._items(values["bufferView"], start, count, items.shape[1], items.dtype)
        return items

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            self._buffers[index] = self._content(index, self._document["buffers"][index])
        return self._buffers[index]

    def _content(self, index: int, buffer: dict[str, Any]) -> bytes:
        uri = buffer.get("uri")
        if uri is None:
            # A buffer without bytes is a placeholder for compressed data.
            compressed = [name for name in _MESHOPT if name in buffer.get("extensions", {})]
            if compressed:
                raise Unreadable(f"its meshes are compressed by {compressed[0]}, which is not supported")
            if index:
                raise Unreadable(f"buffer {index} has no content")
            return self._binary
        return self.file_of("buffer", index, uri)

    def file_of(self, what: str, index: int, uri: str) -> bytes:
        """Return the bytes that a URI names: its own, or those of a file beside this one."""
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            return base64.b64decode(body) if head.endswith(";base64") else urllib.parse.unquote_to_bytes(body)
        if re.match(r"[A-Za-z][A-Za-z0-9+.-]*:|/|\\", uri) or ".." in Path(uri).parts:
            raise Unreadable(f"{what} {index} is {uri!r}: only files in the same folder are supported")
        return (self._folder / urllib.parse.unquote(uri)).read_bytes()


def _natural(number: Any) -> int:
    if isinstance(number, bool) or not isinstance(number, int) or number < 0:
        raise Unreadable(f"it is damaged: {number!r} where a whole number should be")
    return number
