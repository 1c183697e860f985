"""The facts of a shot that are kept with its frames: plain data, which a manifest holds as JSON."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

__all__ = [
    *("ATTRIBUTES", "CAMERA", "CURVES", "FILES", "INSTANCES", "POINTS", "Drawn", "Prim", "Scene"),
    *("changes", "files_of", "is_users", "with_changes"),
]

Prim = dict[str, Any]
"""`type`; `values`: text by declaration, such as "float focalLength"; and, where it has some, `apis`, `mesh`,
a file, and `material`."""
Scene = dict[str, dict[str, Any]]
"""The prims of a frame by name, in groups: "world", "solids", and "looks", of systems by their index."""

CAMERA = "Camera"
FILES = re.compile(r"(mesh|picture)_[0-9a-f]{16}\.(usdc|png|hdr)")
"""The names of all files of scenes."""

POINTS, INSTANCES, CURVES = "Points", "PointInstancer", "BasisCurves"
_ALL = {"primvars:displayColor": "color3f[]", "primvars:displayOpacity": "float[]", "primvars:id": "int[]"}
_ALL |= {"extent": "float3[]"}
_MOVING = {"velocities": "vector3f[]", "ids": "int64[]"}
ATTRIBUTES: dict[str, dict[str, str]] = {
    POINTS: {"points": "point3f[]", "widths": "float[]"} | _MOVING | _ALL,
    INSTANCES: {
        "positions": "point3f[]",
        "protoIndices": "int[]",
        "orientations": "quath[]",
        "scales": "float3[]",
        "angularVelocities": "vector3f[]",
    }
    | _MOVING
    | _ALL,
    CURVES: {"points": "point3f[]", "curveVertexCounts": "int[]", "widths": "float[]"} | _ALL,
}
"""The attributes of particles in each form that vary over time, and their types."""


class Drawn(NamedTuple):
    """Attributes of a prim: type and values by name."""

    form: str
    values: dict[str, tuple[str, Any]]


@cache
def _builtin() -> set[str]:
    from .. import _core  # not at the top: reading files needs no engine

    return {name for name, _ in _core.builtin_attributes()} | {"id"}


def is_users(column: str) -> bool:
    """Return whether a column is one of the script's own."""
    return column not in _builtin() and not column.startswith("ribbon_")


def changes(scene: Mapping[str, Any], before: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return a frame as a JSON merge patch of the one before (RFC 7386): None where a name is gone."""
    before = before or {}
    found: dict[str, Any] = {name: None for name in before.keys() - scene.keys()}
    for name, value in scene.items():
        known = before.get(name)
        if isinstance(value, dict) and isinstance(known, dict):
            value = changes(value, known)
            if value:
                found[name] = value
        elif value != known:
            found[name] = value
    return found


def with_changes(before: Mapping[str, Any] | None, changed: Mapping[str, Any]) -> dict[str, Any]:
    """Return a frame from the one before it and their differences."""
    found = dict(before or {})
    for name, value in changed.items():
        known = found.get(name)
        if value is None:
            found.pop(name, None)
        elif isinstance(value, dict) and isinstance(known, dict):
            found[name] = with_changes(known, value)
        else:
            found[name] = value
    return found


def files_of(scene: Scene) -> set[str]:
    """Return the names of the files that a frame needs."""
    prims = [prim for group in scene.values() for prim in group.values()]
    found = {prim[key] for prim in prims for key in ("mesh", "picture") if key in prim}
    found |= {name for prim in prims for name in prim.get("prototypes", ())}
    materials = [prim.get("material", {}) for prim in prims]
    return found | {one[key] for one in materials for key in ("picture", "finish") if key in one}
