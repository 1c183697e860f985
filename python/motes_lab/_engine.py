"""What several rooms of the laboratory use of the engine beyond its public names.

tests/source/test_laboratory.py lists all such names, with reasons.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from motes import _extras as extras
from motes._io import files
from motes._values import arguments, environment

if TYPE_CHECKING:
    from motes import World

__all__ = ["arguments", "environment", "extras", "files", "session_of", "simd"]


def session_of(world: World) -> Any:
    """Return the session of an open world: its compiled engine, and the engine's view of its systems."""
    from motes._world.world import session_of

    return session_of(world)


def simd() -> str:
    """Return the vector instructions of the engine's kernels, such as "avx2". Starts MPI."""
    from motes import _core

    return _core.simd()
