"""Reads mesh files, .obj, .ply, .stl, .glb and .usd: triangles, normals, places in pictures, colours, looks.

Each module reads one format; `polygons` cuts faces into triangles. A module returns the whole surface
of a file, or raises `Unreadable`, which names what it cannot read.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

from .polygons import Unreadable
from .surfaces import Surface, sane

__all__ = ["SUFFIXES", "Unreadable", "read"]

MOVING = (".glb", ".usd", ".usda", ".usdc", ".usdz")
"""Suffixes of files that hold movements."""
SUFFIXES = (".obj", ".ply", ".stl", *MOVING)
"""Suffixes of mesh files; each names its module, which is loaded for the first file of the format."""


def read(path: Path, time: float | None = None) -> Surface:
    """Return the surface, with vertices and triangles in the order of the file.

    `time`: of a file that holds movements, s; None: as it is without them.

    Raises Unreadable with the reason; OSError if the file cannot be opened; MissingExtraError.
    """
    content, suffix = path.read_bytes(), path.suffix.lower()
    try:
        # ".obj": the module beside this one
        format_ = importlib.import_module(suffix[:4], __name__)
        surface: Surface = format_.read(path, content, *(() if time is None else (time,)))
    except (Unreadable, ImportError, OSError):
        raise
    except Exception as error:  # any: a damaged file can fail anywhere
        raise Unreadable(f"it is damaged: {type(error).__name__} {error}".rstrip()) from None
    if not len(surface.triangles):
        raise Unreadable(f"it has {len(surface.vertices)} vertices but no triangles")
    kept: dict[str, Any] = {name: sane(name, getattr(surface, name)) for name in ("normals", "uv", "colors")}
    return surface._replace(**kept)
