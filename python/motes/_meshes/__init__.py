"""Reads mesh files, .obj, .ply, .stl and .glb, into vertices and triangles.

Each module reads one format; `polygons` cuts faces into triangles. A module returns all triangles of a file,
or raises `Unreadable`, which names what it cannot read.
"""

from __future__ import annotations

import importlib
from pathlib import Path

from .polygons import Triangles, Unreadable

__all__ = ["SUFFIXES", "Unreadable", "read"]

SUFFIXES = (".obj", ".ply", ".stl", ".glb")
"""Suffixes of mesh files; each names its module, which is loaded for the first file of the format."""


def read(path: Path) -> Triangles:
    """Return vertices, float64 (n, 3), and triangles, int64 (m, 3), in the order of the file.

    Raises Unreadable with the reason; OSError if the file cannot be opened; MissingExtraError.
    """
    content = path.read_bytes()
    try:
        format_ = importlib.import_module(path.suffix.lower(), __name__)  # ".obj": the module beside this one
        vertices, triangles = format_.read(path, content)
    except (Unreadable, ImportError, OSError):
        raise
    except Exception as error:  # any: a damaged file can fail anywhere
        raise Unreadable(f"it is damaged: {type(error).__name__} {error}".rstrip()) from None
    if not len(triangles):
        raise Unreadable(f"it has {len(vertices)} vertices but no triangles")
    return vertices, triangles
