"""motes: a scriptable engine for particle-system animations on clusters.

A script issues the same calls on every rank; the engine gives each rank its role. See `World`.

`import motes` is quick and starts nothing: each name is loaded when it is first used, and MPI starts with the
first name that needs the compiled core. Only in a rank that a launcher started does MPI start at once,
so that a script that fails on its first line ends the job instead of leaving the other ranks waiting.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

from ._run import mpi_settings as _mpi_settings  # noqa: F401  (before MPI or NumPy starts)
from ._run import rank_process as _rank_process

if TYPE_CHECKING:
    from . import actions, analysis, balance, cluster, errors, expressions, replay, script, shapes
    from .analysis import Run, Runs, open_run, open_runs
    from .checkpoint import Checkpoint
    from .controls import Control
    from .curves import Curve
    from .distributions import Normal, Uniform
    from .errors import (
        ArgumentError,
        CheckpointError,
        LogError,
        MissingExtraError,
        MotesError,
        MotesWarning,
        NotAssignableError,
        NotHereError,
        RankError,
        ScriptMismatchError,
        Stopped,
    )
    from .export import Export
    from .expressions import column, maximum, minimum, time
    from .frame import Frame
    from .interchange.reading import open_particles
    from .live import Live
    from .meshes import Mesh
    from .movie import Movie
    from .notebook import Player, launch, show
    from .particles import Particles
    from .rendering import Camera, Renderer
    from .roles import Roles
    from .solids import Light, Solid
    from .sprites import Sprite
    from .system import System
    from .ties import Ties
    from .world import World

    __version__: str

_MODULES = {
    "analysis": ("Run", "Runs", "open_run", "open_runs"),
    "checkpoint": ("Checkpoint",),
    "controls": ("Control",),
    "curves": ("Curve",),
    "distributions": ("Normal", "Uniform"),
    "errors": (
        *(
            "ArgumentError",
            "CheckpointError",
            "LogError",
            "MissingExtraError",
            "MotesError",
            "MotesWarning",
            "NotAssignableError",
        ),
        *("NotHereError", "RankError", "ScriptMismatchError", "Stopped"),
    ),
    "export": ("Export",),
    "expressions": ("column", "maximum", "minimum", "time"),
    "frame": ("Frame",),
    "interchange.reading": ("open_particles",),
    "live": ("Live",),
    "meshes": ("Mesh",),
    "movie": ("Movie",),
    "notebook": ("Player", "launch", "show"),
    "particles": ("Particles",),
    "rendering": ("Camera", "Renderer"),
    "roles": ("Roles",),
    "solids": ("Light", "Solid"),
    "sprites": ("Sprite",),
    "system": ("System",),
    "ties": ("Ties",),
    "world": ("World",),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}
_PUBLIC_MODULES = (
    *("actions", "analysis", "balance", "cluster", "errors", "expressions", "replay", "script"),
    "shapes",
)

__all__ = [
    "ArgumentError",
    "Camera",
    "Checkpoint",
    "CheckpointError",
    "Control",
    "Curve",
    "Export",
    "Frame",
    "Light",
    "Live",
    "LogError",
    "Mesh",
    "MissingExtraError",
    "MotesError",
    "MotesWarning",
    "Movie",
    "Normal",
    "NotAssignableError",
    "NotHereError",
    "Particles",
    "Player",
    "RankError",
    "Renderer",
    "Roles",
    "Run",
    "Runs",
    "ScriptMismatchError",
    "Solid",
    "Sprite",
    "Stopped",
    "System",
    "Ties",
    "Uniform",
    "World",
    "actions",
    "analysis",
    "balance",
    "cluster",
    "column",
    "errors",
    "expressions",
    "launch",
    "maximum",
    "minimum",
    "open_particles",
    "open_run",
    "open_runs",
    "replay",
    "script",
    "shapes",
    "show",
    "time",
]


if not TYPE_CHECKING:  # a checker reads the imports above, and knows each name's type

    def __getattr__(name: str) -> Any:
        """Load a public name when it is first used."""
        if name == "_core":
            # Modules say `from . import _core`, which asks here first: the core binds to the MPI library that
            # mpi4py has loaded.
            _start_mpi()
            return importlib.import_module("._core", __name__)  # loaded by now
        if name == "__version__":
            from importlib.metadata import version

            value: Any = version("motes")
        elif name in _MODULE_OF:
            value = getattr(importlib.import_module(f".{_MODULE_OF[name]}", __name__), name)
        elif name in _PUBLIC_MODULES:
            value = importlib.import_module(f".{name}", __name__)
        else:
            raise AttributeError(f"module 'motes' has no attribute {name!r}{_near(name)}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def _near(name: str) -> str:
    # `from . import arguments` asks `__getattr__` first: it must not look for similar names.
    if name.startswith("_") or os.path.exists(os.path.join(__path__[0], f"{name}.py")):
        return ""
    from .errors import near

    return near(name, __all__)


def _start_mpi() -> None:
    """Start MPI, unless mpi4py was told not to; from then on, a failure of this rank ends the whole job."""
    from ._run import loading, presence

    presence.waits_for_mpi()
    loading.load_mpi()
    loading.load_core()
    from ._run import ending

    ending.install()
    presence.has_mpi()


if _rank_process.settle():
    _start_mpi()
