"""Mesh files as other programs write them, as bytes: .obj, .ply, .stl, .glb."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["CUBE", "QUADS", "SOLID_L", "TRIANGLES", "Glb", "obj", "ply", "stl"]

CUBE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])

Faces = Sequence[Sequence[int]]


def _solid(outline: Sequence[tuple[float, float]]) -> tuple[NDArray[np.float64], Faces]:
    """Extrude an outline in the xz plane, seen from above, by 1 m: two large faces and a quad per edge."""
    n = len(outline)
    points = np.array([(x, y, -z) for y in (0, 1) for x, z in outline], np.float64)
    sides = [(k, (k + 1) % n, (k + 1) % n + n, k + n) for k in range(n)]
    return points, [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides]


SOLID_L = _solid([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
"""An L: two concave faces of 3 m2 each, 8 m2 around them, 3 m3."""


def obj(points: Any, faces: Faces, *, relative: bool = False) -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    shift = -len(points) if relative else 1
    return "\n".join([*lines, *("f " + " ".join(str(i + shift) for i in face) for face in faces)]).encode()


def ply(
    points: Any, faces: Faces, order: str = "ascii", *, kinds: str = "float", name: str = "indices"
) -> bytes:
    """Return a .ply file with an unused element at the start, and a property after each list."""
    head = ["ply", f"format {order} 1.0", "comment made", "element camera 1", "property uchar kind"]
    head += ["property list uchar short sizes", f"element vertex {len(points)}"]
    head += [f"property {kinds} {axis}" for axis in "xyz"]
    head += [
        f"element face {len(faces)}",
        f"property list uchar int vertex_{name}",
        "property uchar flag",
        "end_header",
    ]
    text = ("\n".join(head) + "\n").encode()
    if order == "ascii":
        rows = ["7 2 -1 -2", *(f"{x} {y} {z}" for x, y, z in points)]
        return text + "\n".join([*rows, *(" ".join(map(str, (len(f), *f, 5))) for f in faces)]).encode()
    mark = "<" if "little" in order else ">"
    text += struct.pack(mark + "BBhh", 7, 2, -1, -2)
    text += np.asarray(points).astype(mark + ("f8" if kinds == "double" else "f4")).tobytes()
    return text + b"".join(struct.pack(f"{mark}B{len(f)}iB", len(f), *f, 5) for f in faces)


def stl(points: Any, triangles: Any, *, binary: bool = True, begin: bytes = b"solid") -> bytes:
    corners = np.asarray(points)[np.asarray(triangles)]
    if binary:
        facets = b"".join(struct.pack("<12fH", 0, 0, 0, *facet.reshape(-1), 9) for facet in corners)
        return begin.ljust(80, b" ") + struct.pack("<I", len(corners)) + facets
    lines = ["solid part vertex"]
    for facet in corners:
        lines += ["facet normal 0 0 1", "outer loop"]
        lines += [f"vertex {x} {y} {z}" for x, y, z in facet] + ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part"]).encode()


class Glb:
    """Puts a .glb together: `array` keeps numbers and returns their accessor, `bytes` the file."""

    TYPES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}

    def __init__(self) -> None:
        self.binary = b""
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, content: bytes, **more: Any) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(content), **more})
        self.binary += content
        return len(self.views) - 1

    def array(self, given: Any, kind: str = "f4", *, stride: int = 0, **more: Any) -> int:
        rows = np.asarray(given).astype("<" + kind)
        rows = rows.reshape(len(rows), -1)
        content = rows.tobytes()
        if stride:
            wide = np.full((len(rows), stride), 0x55, np.uint8)
            wide[:, : rows.itemsize * rows.shape[1]] = rows.view(np.uint8)
            content = wide.tobytes()
        width = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[rows.shape[1]]
        view = self.view(content, **({"byteStride": stride} if stride else {}))
        made = {"bufferView": view, "componentType": self.TYPES[kind], "count": len(rows), "type": width}
        self.accessors.append(made | more)
        return len(self.accessors) - 1

    def bytes(self, primitives: Any, nodes: Any = None, **more: Any) -> bytes:
        nodes = nodes or [{"mesh": 0}]
        document = {
            **{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}]},
            **{"nodes": nodes, "meshes": [{"primitives": primitives}], "accessors": self.accessors},
            **{"buffers": [{"byteLength": len(self.binary)}], "bufferViews": self.views, **more},
        }
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        body = self.binary + b"\0" * (-len(self.binary) % 4)
        chunks = (
            struct.pack("<II", len(text), 0x4E4F534A)
            + text
            + struct.pack("<II", len(body), 0x004E4942)
            + body
        )
        return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks
