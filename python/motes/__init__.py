"""motes: a scriptable engine for particle-system animations on clusters.

A script issues the same calls on every rank; the engine gives each rank its role. See `World`.

`import motes` is quick and starts nothing: each name is loaded when it is first used, and MPI starts with the
first name that needs the compiled core. In a rank that a launcher started, MPI starts at once: a script that
fails on its first line then ends the job instead of leaving the other ranks waiting.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from . import _extras
from ._mpi import mpi_settings as _mpi_settings  # noqa: F401  (before MPI or NumPy starts)
from ._mpi import rank_process as _rank_process

if TYPE_CHECKING:
    from . import (
        actions,
        analysis,
        balance,
        cluster,
        course,
        errors,
        expressions,
        replay,
        script,
        shapes,
        workloads,
    )
    from ._film.movie import Movie
    from ._interchange.export import Export
    from ._interchange.reading import open_particles
    from ._live.controls import Control
    from ._particles.particles import Particles
    from ._picture.frame import Frame
    from ._picture.rendering import Camera, Renderer
    from ._picture.skies import Gradient
    from ._picture.solids import Light, Solid
    from ._picture.sprites import Sprite
    from ._player.notebook import launch, show
    from ._player.player import Player
    from ._system.distributions import Normal, Uniform, along_normal, surface_color
    from ._system.system import System
    from ._values.checkpoint import Checkpoint
    from ._values.curves import Curve
    from ._values.live import Live
    from ._values.roles import Roles
    from ._values.ties import Ties
    from ._values.wall import Wall, WallForce
    from ._world.world import World
    from .analysis import Run, Runs, open_run, open_runs
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
    from .expressions import (
        a,
        b,
        column,
        cross,
        dot,
        length,
        maximum,
        minimum,
        normal,
        normalize,
        r,
        relative_velocity,
        time,
        where,
    )
    from .shapes._mesh import Mesh

    __version__: str

_MODULES = {
    "analysis": ("Run", "Runs", "open_run", "open_runs"),
    "_values.checkpoint": ("Checkpoint",),
    "_live.controls": ("Control",),
    "_values.curves": ("Curve",),
    "_system.distributions": ("Normal", "Uniform", "along_normal", "surface_color"),
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
    "_interchange.export": ("Export",),
    "expressions": (
        *("a", "b", "column", "cross", "dot", "length", "maximum", "minimum", "normal", "normalize", "r"),
        *("relative_velocity", "time", "where"),
    ),
    "_picture.frame": ("Frame",),
    "_interchange.reading": ("open_particles",),
    "_values.live": ("Live",),
    "shapes._mesh": ("Mesh",),
    "_film.movie": ("Movie",),
    "_player.notebook": ("launch", "show"),
    "_player.player": ("Player",),
    "_particles.particles": ("Particles",),
    "_picture.rendering": ("Camera", "Renderer"),
    "_values.roles": ("Roles",),
    "_picture.skies": ("Gradient",),
    "_picture.solids": ("Light", "Solid"),
    "_picture.sprites": ("Sprite",),
    "_system.system": ("System",),
    "_values.ties": ("Ties",),
    "_values.wall": ("Wall", "WallForce"),
    "_world.world": ("World",),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}
_PUBLIC_MODULES = (
    *("actions", "analysis", "balance", "cluster", "course", "errors", "expressions", "replay"),
    *("script", "shapes", "workloads"),
)  # three of them are rooms of the laboratory

__all__ = [
    "ArgumentError",
    "Camera",
    "Checkpoint",
    "CheckpointError",
    "Control",
    "Curve",
    "Export",
    "Frame",
    "Gradient",
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
    "Wall",
    "WallForce",
    "World",
    "a",
    "actions",
    "along_normal",
    "analysis",
    "b",
    "balance",
    "cluster",
    "column",
    "course",
    "cross",
    "dot",
    "errors",
    "expressions",
    "launch",
    "length",
    "maximum",
    "minimum",
    "normal",
    "normalize",
    "open_particles",
    "open_run",
    "open_runs",
    "r",
    "relative_velocity",
    "replay",
    "script",
    "shapes",
    "show",
    "surface_color",
    "time",
    "where",
    "workloads",
]


if not TYPE_CHECKING:  # type checkers use the imports above, which give each name its type

    def __getattr__(name: str) -> Any:
        """Load a public name when it is first used."""
        if name == "_core":
            # `from . import _core` calls this function. The core binds to the MPI library that mpi4py loads.
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
            # Without its name, or a traceback would add a suggestion of Python's own.
            raise AttributeError(
                f"module 'motes' has no attribute {name!r}{_near(name)}", name=None, obj=None
            )
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def _near(name: str) -> str:
    if name.startswith("_"):  # `from . import _extras` calls `__getattr__` first
        return ""
    from .errors import near

    return near(name, __all__)


def _start_mpi() -> None:
    """Start MPI, unless mpi4py is configured not to; afterwards a failure of this rank ends the whole job."""
    from ._mpi import loading, presence

    presence.waits_for_mpi()
    loading.load_mpi()
    loading.load_core()
    from ._run import ending

    ending.install()
    presence.has_mpi()


_extras.find_laboratory()
if _rank_process.settle():
    _start_mpi()
