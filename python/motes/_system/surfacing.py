"""The surface of a system's particles as a mesh: the implementation of `System.surface`."""

from __future__ import annotations

from typing import Any

from .._values import arguments
from ..errors import ArgumentError
from ..shapes._mesh import Mesh
from .system_state import SystemState

__all__ = ["surfaced"]


def surfaced(state: SystemState, cell: Any, radius: Any) -> Mesh:
    """Return the surface of all particles. Collective."""
    size = arguments.number("cell", cell)
    reach = size if radius is None else arguments.number("radius", radius)
    session = state.session
    engine = session.begin("surface()", reads=True)
    try:
        vertices, triangles = engine.surface(state.index, size, reach)
    finally:
        session.end_conversation(engine)
    if not len(triangles):
        allowed = "one with particles: without any there is no surface"
        raise ArgumentError("system", state.name, allowed)
    return Mesh(vertices, triangles)
