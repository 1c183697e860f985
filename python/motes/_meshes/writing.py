"""Writes meshes to files: .obj, .glb and .usd."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._io.files import write_whole
from .._values.rotations import matrix_of

__all__ = ["SUFFIXES", "Placed", "placed", "write"]

Array = NDArray[Any]


class Placed(NamedTuple):
    """A mesh at its place, as it is written: see `Mesh` for the arrays."""

    points: Array
    triangles: Array
    normals: Array | None
    uv: Array | None
    colors: Array | None


def write(path: Path, mesh: Placed) -> None:
    """Write a mesh; the file appears only when it is complete."""
    write_whole(path, _WRITERS[path.suffix.lower()](mesh))


def turned(rows: Array, pose: tuple[float, ...]) -> Array:
    """Rotate vectors by a pose's quaternion (w, x, y, z), which follows its position."""
    w, x, y, z = pose[3:7]
    around: Array = rows.astype(np.float64) @ matrix_of(x, y, z, w).T
    return around


def placed(
    pose: tuple[float, ...],
    vertices: Array,
    triangles: Array,
    normals: Array | None,
    uv: Array | None,
    colors: Array | None,
) -> Placed:
    """Return a mesh in a pose: its position, then its rotation."""
    points = (turned(vertices, pose) + pose[:3]).astype(np.float32)
    if normals is not None:
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        unit = np.where(lengths > 0, normals / np.where(lengths > 0, lengths, 1), (0, 1, 0))
        normals = turned(unit, pose).astype(np.float32)
    return Placed(points, triangles, normals, uv, colors)


def _rows(array: Array, form: str) -> str:
    text = io.StringIO()
    np.savetxt(text, array, fmt=form)
    return text.getvalue()


def _obj(mesh: Placed) -> bytes:
    points, normals = mesh.points, mesh.normals
    parts = [_rows(points, "v %.9g %.9g %.9g")]
    index = "%d"
    if mesh.uv is not None:
        parts.append(_rows(mesh.uv, "vt %.9g %.9g"))
        index = "%d/%d" if normals is None else "%d/%d/%d"
    if normals is not None:
        parts.append(_rows(normals, "vn %.9g %.9g %.9g"))
        index = "%d//%d" if mesh.uv is None else index
    corners = np.repeat(mesh.triangles.astype(np.int64) + 1, index.count("%"), axis=1)
    parts.append(_rows(corners, f"f {index} {index} {index}"))
    return "".join(parts).encode()


def _glb(mesh: Placed) -> bytes:
    points, normals = mesh.points, mesh.normals
    binary = bytearray()
    views: list[dict[str, int]] = []
    accessors: list[dict[str, Any]] = []

    def put(array: Array, component: int, kind: str, target: int, **more: Any) -> int:
        content = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes()
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(content), "target": target})
        binary.extend(content + bytes(-len(content) % 4))
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": component, "type": kind, "count": array.size}
            | more
        )
        if kind != "SCALAR":
            accessors[-1]["count"] = len(array)
        return len(accessors) - 1

    bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
    attributes = {"POSITION": put(points, _FLOAT, "VEC3", _VERTICES, **bounds)}
    if normals is not None:
        attributes["NORMAL"] = put(normals, _FLOAT, "VEC3", _VERTICES)
    if mesh.uv is not None:
        flipped = np.column_stack([mesh.uv[:, 0], 1 - mesh.uv[:, 1]]).astype(np.float32)
        attributes["TEXCOORD_0"] = put(flipped, _FLOAT, "VEC2", _VERTICES)
    if mesh.colors is not None:
        attributes["COLOR_0"] = put(mesh.colors, _FLOAT, "VEC3", _VERTICES)
    indices = put(mesh.triangles.reshape(-1), _UINT32, "SCALAR", _INDICES)
    document = {
        "asset": {"version": "2.0", "generator": "motes"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": indices}]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = _chunk(b"JSON", text) + _chunk(b"BIN\0", bytes(binary))
    return b"glTF" + _uint32(2) + _uint32(12 + len(chunks)) + chunks


def _chunk(kind: bytes, content: bytes) -> bytes:
    return _uint32(len(content)) + kind + content


def _uint32(number: int) -> bytes:
    return number.to_bytes(4, "little")


def _usd(mesh: Placed) -> bytes:
    points, normals = mesh.points, mesh.normals
    bounds = np.stack([points.min(axis=0), points.max(axis=0)])
    lines = [
        f"int[] faceVertexCounts = [{', '.join(['3'] * len(mesh.triangles))}]",
        f"int[] faceVertexIndices = [{', '.join(map(str, mesh.triangles.reshape(-1).tolist()))}]",
        f"point3f[] points = {_tuples(points)}",
        f"float3[] extent = {_tuples(bounds)}",
        'uniform token subdivisionScheme = "none"',
    ]
    varying = '(interpolation = "vertex")'
    if normals is not None:
        lines.append(f"normal3f[] normals = {_tuples(normals)} {varying}")
    if mesh.uv is not None:
        lines.append(f"texCoord2f[] primvars:st = {_tuples(mesh.uv)} {varying}")
    if mesh.colors is not None:
        lines.append(f"color3f[] primvars:displayColor = {_tuples(mesh.colors)} {varying}")
    head = '(\n    defaultPrim = "Mesh"\n    metersPerUnit = 1\n    upAxis = "Y"\n)'
    body = "\n".join(f"    {line}" for line in lines)
    return f'#usda 1.0\n{head}\n\ndef Mesh "Mesh"\n{{\n{body}\n}}\n'.encode()


def _tuples(rows: Array) -> str:
    width = rows.shape[1]
    form = f"({', '.join(['%.9g'] * width)}),"
    return "[" + _rows(rows, form).replace("\n", " ").rstrip(", ") + "]"


_FLOAT, _UINT32 = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_WRITERS: dict[str, Callable[[Placed], bytes]] = {".obj": _obj, ".glb": _glb, ".usd": _usd}
SUFFIXES = tuple(_WRITERS)
