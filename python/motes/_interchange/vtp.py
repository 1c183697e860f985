"""Particles as .vtp, VTK's file of points, and .pvd, ParaView's list of such files over time.

The data follows the XML as raw bytes ("appended"), which every VTK reader understands. `vtp_reading` also
reads the files of other programs.
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any
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


def write(path: Path, columns: Mapping[str, NDArray[Any]], *, frame: int, time: float) -> None:
    """Write columns (n,), (n, 3) or (n, 4), including `position`, into an existing file."""
    del frame
    rows = len(columns["position"])
    # One vertex cell per particle: filters that select cells can then select particles.
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


def pvd(manifest: Manifest, folder: str) -> bytes:
    """Return ParaView's list of all files: one block per system and rank at each time."""
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


FORMAT = Format("vtp", ".pvd", write, read, pvd, MARK, alone=True, mistaken=(".vtp",))
