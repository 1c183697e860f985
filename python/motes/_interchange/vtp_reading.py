"""Reads columns from .vtp, VTK's file of points, as written by motes or by VTK.

Data is text or base64 inside the XML, or base64 or raw bytes appended to it; uncompressed, or compressed in
blocks by zlib or LZMA. Binary data starts with its length in bytes; compressed data with the number of
blocks, the bytes of a full block, the bytes of the last one, and the compressed bytes of each block.
"""

from __future__ import annotations

import base64
import lzma
import re
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from .._particles.foreign import WIDTHS, leave_out

__all__ = ["read"]

_TYPES = {
    "Int8": "i1",
    "Int16": "i2",
    "Int32": "i4",
    "Int64": "i8",
    "UInt8": "u1",
    "UInt16": "u2",
    "UInt32": "u4",
    "UInt64": "u8",
    "Float32": "f4",
    "Float64": "f8",
}
"""NumPy's name of each of the format's types."""
_OPEN = b"<AppendedData"
_MOST_HEAD = 1 << 20
_COMPRESSORS = ("vtkZLibDataCompressor", "vtkLZMADataCompressor")


def read(path: Path, names: Iterable[str] | None, *, frame: int) -> dict[str, NDArray[Any]]:
    """Read the named columns, or all if `names` is None. Raises OSError, ValueError or KeyError.

    If `names` is None, columns that particles cannot have, such as text, are left out with a warning.
    """
    del frame
    with open(path, "rb") as file:
        text = file.read(_MOST_HEAD)
        if _OPEN not in text:
            text += file.read()
        data = _Data(file, text)
        pieces = data.tree.findall("./PolyData/Piece")
        if not pieces:
            raise ValueError("it has no PolyData with a piece")
        arrays = [_arrays(piece) for piece in pieces]
        whole = names is None
        if names is None:
            odd = {name: reason for name, array in arrays[0].items() if (reason := _oddity(name, array))}
            for name, reason in odd.items():
                leave_out(path, name, reason)
            names = [name for name in arrays[0] if name not in odd]
        columns = {}
        for name in names:
            parts = [data.array(own[name], _rows(piece)) for piece, own in zip(pieces, arrays, strict=True)]
            columns[name] = parts[0] if len(parts) == 1 else np.concatenate(parts)
        if whole and _is_radius(columns.get("radius"), columns.get("size")):
            del columns["radius"]
        return columns


def _arrays(piece: ElementTree.Element) -> dict[str, ElementTree.Element]:
    """Return the XML element that describes each column, by name."""
    arrays = {array.get("Name", ""): array for array in piece.findall("./PointData/*")}
    points = piece.findall("./Points/DataArray")
    return {"position": points[0], **arrays} if points else arrays


def _oddity(name: str, array: ElementTree.Element) -> str:
    """Return what keeps a column from being read; empty if nothing does, or if it is the position."""
    kind, width = array.get("type", ""), _whole(array, "NumberOfComponents", "1")
    if name == "position":
        return ""
    if array.tag != "DataArray" or kind not in _TYPES:
        return f"values of type {kind or array.tag}"
    return "" if width in WIDTHS else f"{width} numbers per particle"


def _is_radius(radius: NDArray[Any] | None, size: NDArray[Any] | None) -> bool:
    """Return whether a column only repeats half of the sizes, as motes writes it for other programs."""
    if radius is None or size is None or size.ndim != 2:
        return False
    return np.array_equal(radius, size[:, 0] / 2, equal_nan=True)


def _rows(piece: ElementTree.Element) -> int:
    return _whole(piece, "NumberOfPoints", "0")


def _whole(element: ElementTree.Element, name: str, default: str) -> int:
    text = element.get(name, default)
    if not re.fullmatch(r"\d{1,18}", text):
        raise ValueError(f"{name} is {text!r}, not a whole number")
    return int(text)


class _Data:
    """Decodes the arrays that a file's XML describes."""

    def __init__(self, file: Any, text: bytes) -> None:
        """Parse the XML without the appended data."""
        self._file = file
        at = text.find(_OPEN)
        self._raw = False
        if at >= 0:
            tag = re.match(rb'<AppendedData\s+encoding="(raw|base64)"\s*>\s*_', text[at:])
            if tag is None:
                raise ValueError("its appended data is neither raw nor base64")
            self._start, self._raw = at + tag.end(), tag[1] == b"raw"
            text = text[:at] + b"</VTKFile>"
        try:
            self.tree = ElementTree.fromstring(text)
        except ElementTree.ParseError as error:
            raise ValueError(str(error)) from error
        self._appended = at >= 0
        order = self.tree.get("byte_order", "LittleEndian")
        if order not in ("LittleEndian", "BigEndian"):
            raise ValueError(f"its byte order is {order!r}")
        self._order = "<" if order == "LittleEndian" else ">"
        header = self.tree.get("header_type", "UInt32")
        if header not in ("UInt32", "UInt64"):
            raise ValueError(f"lengths of type {header!r} are not supported")
        self._length = np.dtype(self._order + _TYPES[header])
        self._compressor = self.tree.get("compressor")

    def array(self, element: ElementTree.Element, rows: int) -> NDArray[Any]:
        """Return a column: (rows,), or (rows, width) if it has several components."""
        name, kind, form = element.get("Name", ""), element.get("type", ""), element.get("format", "ascii")
        if element.tag != "DataArray" or kind not in _TYPES:
            raise ValueError(f"column {name!r} is of type {kind or element.tag!r}, which is not supported")
        width = _whole(element, "NumberOfComponents", "1")
        if width < 1:
            raise ValueError(f"column {name!r} has {width} components")
        dtype = np.dtype(self._order + _TYPES[kind])
        if form == "ascii":
            words = (element.text or "").split()
            numbers = np.array(words, dtype if dtype.kind == "f" else object).astype(dtype)
        elif form in ("binary", "appended"):
            numbers = self._binary(element, form == "appended", dtype, rows * width)
        else:
            raise ValueError(f"column {name!r} is in the format {form!r}, which is not supported")
        if len(numbers) != rows * width:
            raise ValueError(f"{name} is cut short: {len(numbers)} of {rows * width} numbers")
        native = numbers.astype(dtype.newbyteorder("="), copy=False)
        return native.reshape(rows, width) if width > 1 else native

    def _binary(
        self, element: ElementTree.Element, appended: bool, dtype: np.dtype[Any], count: int
    ) -> NDArray[Any]:
        if self._compressor is not None and self._compressor not in _COMPRESSORS:
            known = " and ".join(_COMPRESSORS)
            raise ValueError(f"data packed by {self._compressor} is not supported; {known} are")
        source: _Raw | _Base64
        if not appended:
            text = "".join((element.text or "").split()).encode()
            source = _Base64(lambda at, size: text[at : at + size])
        elif not self._appended:
            raise ValueError("it has no appended data")
        else:
            source = _Raw(self._file, self._start + _whole(element, "offset", ""))
            if self._raw and self._compressor is None:
                self._check_length(source, count * dtype.itemsize)
                return source.numbers(self._length.itemsize, dtype, count)
            source = source if self._raw else _Base64(source.take)
        size = count * dtype.itemsize
        return np.frombuffer(
            self._plain(source, size) if self._compressor is None else self._packed(source, size), dtype
        )

    def _numbers(self, source: _Raw | _Base64, count: int) -> list[int]:
        content = source.take(0, count * self._length.itemsize)
        if len(content) < count * self._length.itemsize:
            raise ValueError("it is cut short")
        numbers: list[int] = np.frombuffer(content, self._length).tolist()
        return numbers

    def _check_length(self, source: _Raw | _Base64, size: int) -> None:
        (length,) = self._numbers(source, 1)
        if length != size:
            raise ValueError(f"an array has {length} bytes, not {size}")

    def _plain(self, source: _Raw | _Base64, size: int) -> bytes:
        self._check_length(source, size)
        if source.ends_at(self._length.itemsize):
            return source.skip(self._length.itemsize).take(0, size)
        return source.take(self._length.itemsize, size)

    def _packed(self, source: _Raw | _Base64, size: int) -> bytes:
        (blocks,) = self._numbers(source, 1)
        if blocks > size:
            raise ValueError(f"it has {blocks} blocks for {size} bytes")
        if not blocks:
            return b""
        _, whole, last, *lengths = self._numbers(source, 3 + blocks)
        if whole * (blocks - bool(last)) + last != size:
            raise ValueError(f"its blocks do not have {size} bytes")
        content = source.skip((3 + blocks) * self._length.itemsize).take(0, sum(lengths))
        parts = []
        for number, length in enumerate(lengths):
            parts.append(self._unpack(content[:length], last if last and number == blocks - 1 else whole))
            content = content[length:]
        return b"".join(parts)

    def _unpack(self, packed: bytes, size: int) -> bytes:
        """Decompress a block to exactly `size` bytes."""
        opened: Any = zlib.decompressobj() if self._compressor == _COMPRESSORS[0] else lzma.LZMADecompressor()
        try:
            content: bytes = opened.decompress(packed, size)
        except (zlib.error, lzma.LZMAError) as error:
            raise ValueError(f"a block cannot be unpacked: {error}") from None
        if len(content) != size:
            raise ValueError("a block is cut short")
        return content


class _Raw:
    """The bytes of a file from an offset on."""

    def __init__(self, file: Any, start: int) -> None:
        self._file = file
        self._start = start

    def take(self, at: int, size: int) -> bytes:
        self._file.seek(self._start + at)
        content: bytes = self._file.read(size)
        return content

    def numbers(self, at: int, dtype: np.dtype[Any], count: int) -> NDArray[Any]:
        """Read numbers straight into an array."""
        self._file.seek(self._start + at)
        return np.fromfile(self._file, dtype, count)

    def skip(self, size: int) -> _Raw:
        return _Raw(self._file, self._start + size)

    def ends_at(self, size: int) -> bool:
        del size
        return False


class _Base64:
    """The bytes that base64 characters encode, from an offset on."""

    def __init__(self, characters: Callable[[int, int], bytes], start: int = 0) -> None:
        self._characters = characters
        self._start = start

    def take(self, at: int, size: int) -> bytes:
        first, end = at // 3 * 4, -(-(at + size) // 3) * 4
        text = self._characters(self._start + first, end - first)
        return base64.b64decode(text, validate=True)[at % 3 :][:size]

    def skip(self, size: int) -> _Base64:
        """Return the separate base64 text that follows one of `size` bytes."""
        return _Base64(self._characters, self._start + -(-size // 3) * 4)

    def ends_at(self, size: int) -> bool:
        """Return whether the base64 text that starts here ends, with padding, after `size` bytes."""
        return self._characters(self._start + -(-size // 3) * 4 - 1, 1) == b"="
