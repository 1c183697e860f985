"""Particles as .vtp, VTK's file of points, and .pvd, ParaView's list of such files over time.

Columns are base64 text inside the XML, uncompressed, with no comment before the root and no field data before
the points: OVITO opens nothing else. `vtp_reading` also reads the files of other programs.
"""

from __future__ import annotations

import binascii
import struct
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from .format import Format
from .manifest import Manifest
from .vtp_reading import read

__all__ = ["FORMAT", "read"]

MARK = "<!-- particles of motes -->"
_TYPES = {"float32": "Float32", "uint64": "UInt64", "int32": "Int32", "int64": "Int64", "float64": "Float64"}
_ORDER = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
_LENGTH = struct.Struct("=Q")
_CHUNK = 3 << 18  # bytes encoded at a time, a multiple of 3: Python's lock is held meanwhile


def write(path: Path, columns: Mapping[str, NDArray[Any]], *, frame: int, time: float) -> None:
    """Write columns (n,), (n, 3) or (n, 4), including `position`, into an existing file."""
    del frame
    rows = len(columns["position"])
    # One vertex cell per particle: filters that select cells can then select particles.
    counting = np.arange(rows + 1, dtype=np.int32 if rows < 2**31 - 1 else np.int64)
    data = {name: column for name, column in columns.items() if name != "position"}
    if "size" in data:
        data.setdefault("radius", data["size"][:, 0] / 2)  # OVITO's name
    with open(path, "wb") as file:
        file.write(
            f'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="{_ORDER}" '
            f'header_type="UInt64">\n{MARK}\n<PolyData>\n<Piece NumberOfPoints="{rows}" '
            f'NumberOfVerts="{rows}" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="0">\n'
            "<PointData>\n".encode()
        )
        for name, column in data.items():
            _put(file, name, column)
        file.write(b"</PointData>\n<Points>\n")
        _put(file, "Points", columns["position"])
        file.write(b"</Points>\n<Verts>\n")
        _put(file, "connectivity", counting[:-1])
        _put(file, "offsets", counting[1:])
        file.write(
            '</Verts>\n</Piece>\n<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" '
            f'format="ascii">{time!r}</DataArray></FieldData>\n</PolyData>\n</VTKFile>\n'.encode()
        )


def _put(file: IO[bytes], name: str, column: NDArray[Any]) -> None:
    """Write an array as base64 of its length in bytes and its values."""
    content = np.ascontiguousarray(column).reshape(-1).view(np.uint8).data
    start = _LENGTH.pack(len(content)) + bytes(content[:4])  # 12 bytes: the rest begins a new group of three
    parts = f' NumberOfComponents="{column.shape[1]}"' if column.ndim == 2 else ""
    head = f'<DataArray type="{_TYPES[column.dtype.name]}" Name={quoteattr(name)}{parts} format="binary">'
    file.write(head.encode() + binascii.b2a_base64(start, newline=False))
    for at in range(4, len(content), _CHUNK):
        file.write(binascii.b2a_base64(content[at : at + _CHUNK], newline=False))
    file.write(b"</DataArray>\n")


def pvd(manifest: Manifest, folder: str) -> bytes:
    """Return ParaView's list of all files: one block per system and rank at each time."""
    blocks: dict[tuple[int, int | None], int] = {}
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="1.0">', MARK, "<Collection>"]
    for frame in manifest.frames:
        for part in frame.parts:
            block = blocks.setdefault((part.system, part.rank), len(blocks))
            system = manifest.systems[part.system].name
            name = quoteattr(system if part.rank is None else f"{system}, rank {part.rank}")
            file = quoteattr(f"{folder}/{part.file}")
            lines.append(f'<DataSet timestep="{frame.time!r}" part="{block}" name={name} file={file}/>')
    return "\n".join([*lines, "</Collection>", "</VTKFile>", ""]).encode()


FORMAT = Format("vtp", ".pvd", write, read, pvd, MARK, alone=True, mistaken=(".vtp",))
