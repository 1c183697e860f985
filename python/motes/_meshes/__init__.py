"""Files of meshes: .obj, .ply, .stl and .glb, read into vertices and triangles.

Each module reads one format; `polygons` cuts faces into triangles. What a module does not read, it refuses by
name: it returns all triangles of a file, or raises `Unreadable`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from . import glb, obj, ply, stl
from .polygons import Triangles, Unreadable

__all__ = ["READERS", "Unreadable", "read"]

READERS: dict[str, Callable[[Path, bytes], Triangles]] = {
    ".obj": lambda _, content: obj.read(content),
    ".ply": lambda _, content: ply.read(content),
    ".stl": lambda _, content: stl.read(content),
    ".glb": glb.read,
}
"""By suffix."""


def read(path: Path) -> Triangles:
    """Return vertices, float64 (n, 3), and triangles, int64 (m, 3), in the order of the file.

    Raises Unreadable, with the reason; OSError, if the file cannot be opened; MissingExtraError.
    """
    content = path.read_bytes()
    try:
        vertices, triangles = READERS[path.suffix.lower()](path, content)
    except (Unreadable, ImportError, OSError):
        raise
    except Exception as error:  # any: a damaged file can fail anywhere
        raise Unreadable(f"it is damaged: {type(error).__name__} {error}".rstrip()) from None
    if not len(triangles):
        raise Unreadable(f"it has {len(vertices)} vertices and no triangle")
    return vertices, triangles
