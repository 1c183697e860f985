"""Particles as .vtp, VTK's file of points, and .pvd, ParaView's list of such files over time.

The data stands behind the XML as raw bytes ("appended"), which every reader of VTK understands.
"""

from __future__ import annotations

import re
import struct
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from .manifest import Manifest

__all__ = ["MARK", "pvd", "read", "write"]

MARK = "<!-- particles of motes -->"
_TYPES = {"float32": "Float32", "uint64": "UInt64", "int32": "Int32", "int64": "Int64", "float64": "Float64"}
_DTYPES = {said: np.dtype(kind) for kind, said in _TYPES.items()}
_ORDER = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
_OPEN, _APPENDED = b"<AppendedData", b"_"
_MOST_HEAD = 1 << 20
_LENGTH = struct.Struct("=Q")


def write(path: Path, columns: Mapping[str, NDArray[Any]], *, frame: int, time: float) -> None:
    """Write columns (n, 3) or (n,), `position` among them, into an existing file."""
    del frame
    rows = len(columns["position"])
    # A vertex per particle: filters that choose cells can then choose particles.
    counting = np.arange(rows + 1, dtype=np.int32 if rows < 2**31 - 1 else np.int64)
    data: list[NDArray[Any]] = []

    def declare(name: str, array: NDArray[Any]) -> str:
        offset = sum(one.nbytes + _LENGTH.size for one in data)
        data.append(np.ascontiguousarray(array))
        parts = f' NumberOfComponents="{array.shape[1]}"' if array.ndim == 2 else ""
        said = f'<DataArray type="{_TYPES[array.dtype.name]}" Name={quoteattr(name)}{parts}'
        return f'{said} format="appended" offset="{offset}"/>'

    point_data = "".join(declare(name, column) for name, column in columns.items() if name != "position")
    points = declare("position", columns["position"])
    verts = declare("connectivity", counting[:-1]) + declare("offsets", counting[1:])
    head = (
        f'<?xml version="1.0"?>\n{MARK}\n'
        f'<VTKFile type="PolyData" version="1.0" byte_order="{_ORDER}" header_type="UInt64">\n<PolyData>\n'
        f'<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">'
        f"{time!r}</DataArray></FieldData>\n"
        f'<Piece NumberOfPoints="{rows}" NumberOfVerts="{rows}" NumberOfLines="0" NumberOfStrips="0" '
        f'NumberOfPolys="0">\n<PointData>{point_data}</PointData>\n<Points>{points}</Points>\n'
        f"<Verts>{verts}</Verts>\n</Piece>\n</PolyData>\n"
        '<AppendedData encoding="raw">\n_'
    )
    with open(path, "wb") as file:
        file.write(head.encode())
        for array in data:
            file.write(_LENGTH.pack(array.nbytes))
            if array.size:
                file.write(array.data.cast("B"))
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def read(path: Path, names: Iterable[str] | None, *, frame: int) -> dict[str, NDArray[Any]]:
    """Read these columns, or all, of raw appended data. Raises OSError, ValueError or KeyError."""
    del frame
    with open(path, "rb") as file:
        tree, start = _head(file.read(_MOST_HEAD))
        found = _arrays(tree)
        columns = {}
        for name in found if names is None else names:
            kind, width, offset = found[name]
            file.seek(start + offset)
            length = file.read(_LENGTH.size)
            size = _LENGTH.unpack(length)[0] if len(length) == _LENGTH.size else -1
            array = np.fromfile(file, kind, max(size, 0) // kind.itemsize)
            if array.nbytes != size:
                raise ValueError(f"{name} is cut short")
            columns[name] = array.reshape(-1, width) if width > 1 else array
    return columns


def pvd(manifest: Manifest, folder: str) -> bytes:
    """Return ParaView's list of all files: at each time one block per system and rank."""
    blocks: dict[tuple[int, int | None], int] = {}
    lines = ['<?xml version="1.0"?>', MARK, '<VTKFile type="Collection" version="1.0">', "<Collection>"]
    for frame in manifest.frames:
        for part in frame.parts:
            block = blocks.setdefault((part.system, part.rank), len(blocks))
            system = manifest.systems[part.system].name
            name = quoteattr(system if part.rank is None else f"{system}, rank {part.rank}")
            file = quoteattr(f"{folder}/{part.file}")
            lines.append(f'<DataSet timestep="{frame.time!r}" part="{block}" name={name} file={file}/>')
    return "\n".join([*lines, "</Collection>", "</VTKFile>", ""]).encode()


def _head(text: bytes) -> tuple[ElementTree.Element, int]:
    """Return the XML in front of the data, and where the data begins."""
    at = text.find(_OPEN)
    if at < 0:
        raise ValueError("it has no appended data")
    tag = re.match(rb'<AppendedData\s+encoding="raw"\s*>\s*_', text[at:])
    if tag is None:
        raise ValueError("its appended data is not raw")
    try:
        tree = ElementTree.fromstring(text[:at] + b"</VTKFile>")
    except ElementTree.ParseError as error:
        raise ValueError(str(error)) from error
    if tree.get("byte_order") != _ORDER or tree.get("header_type") != "UInt64" or tree.get("compressor"):
        raise ValueError(f"only {_ORDER} data with 64-bit lengths, not compressed, is read")
    return tree, at + tag.end()


def _arrays(tree: ElementTree.Element) -> dict[str, tuple[np.dtype[Any], int, int]]:
    """Return for each column its type, width and place."""
    pieces = tree.findall("./PolyData/Piece")
    if len(pieces) != 1:
        raise ValueError(f"it has {len(pieces)} pieces instead of one")
    found = {}
    for array in [*pieces[0].findall("./Points/DataArray"), *pieces[0].findall("./PointData/DataArray")]:
        kind, name = array.get("type", ""), array.get("Name", "")
        if kind not in _DTYPES or array.get("format") != "appended":
            raise ValueError(f"column {name!r} is {kind} and not appended, or of a type that is not read")
        name = "position" if name == "Points" else name
        found[name] = (_DTYPES[kind], int(array.get("NumberOfComponents", "1")), int(array.get("offset", "")))
    return found
