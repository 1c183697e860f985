"""motes: a scriptable engine for particle-system animations on clusters.

A script issues the same calls on every rank; the engine gives each rank its role. See `World`.

`import motes` is quick and starts nothing: each name is loaded when it is first used, and MPI starts with the
first name that needs the compiled core. In a rank that a launcher started, MPI starts at once: a script that
fails on its first line then ends the job instead of leaving the other ranks waiting.
"""

from __future__ import annotations

import importlib
import warnings
from typing import Any

from . import _extras
from ._mpi import mpi_settings as _mpi_settings  # noqa: F401  (before MPI or NumPy starts)
from ._mpi import rank_process as _rank_process

_MODULES = {
    "analysis": "Run Runs open_run open_runs",
    "errors": "ArgumentError CheckpointError LogError MissingExtraError MotesError MotesWarning "
    "NotAssignableError NotHereError RankError ScriptMismatchError Stopped",
    "shapes._mesh": "Mesh",
    "_film.movie": "Movie",
    "_interchange.export": "Export",
    "_interchange.reading": "open_particles",
    "_live.controls": "Control",
    "_particles.particles": "Particles",
    "_picture.frame": "Frame",
    "_picture.rendering": "Camera Renderer",
    "_picture.skies": "Gradient",
    "_picture.solids": "Light Solid",
    "_picture.sprites": "Sprite",
    "_player.notebook": "launch show",
    "_player.player": "Player",
    "_system.distributions": "Normal Uniform along_normal surface_color",
    "_system.system": "System",
    "_values.checkpoint": "Checkpoint",
    "_values.curves": "Curve",
    "_values.live": "Live",
    "_values.roles": "Roles",
    "_values.rotations": "euler",
    "_values.ties": "Ties",
    "_values.wall": "Wall WallForce",
    "_world.drawing": "draw",
    "_world.world": "World",
}
"""The public names of each module; `__init__.pyi` lists them for type checkers and editors."""
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names.split()}
_PUBLIC_MODULES = (
    *("actions", "analysis", "balance", "cluster", "course", "errors", "expressions", "replay"),
    *("script", "shapes", "workloads"),
)
_LABORATORY = ("cluster", "course", "workloads")
"""Those of the public modules that are in the laboratory, and are listed only where that is installed."""
_MOVED = (
    *("a", "b", "column", "cross", "dot", "length", "maximum", "minimum", "normal", "normalize", "r"),
    *("relative_velocity", "time", "where"),
)
"""Names of `motes.expressions` found here, too, until the next release; the first use of each warns."""

__all__ = sorted([*_MODULE_OF, *_PUBLIC_MODULES])
if not _extras.has_laboratory():
    __all__ = [name for name in __all__ if name not in _LABORATORY]


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
    elif name in _MOVED:
        new = f"motes.expressions.{name}"
        warnings.warn(
            f"motes.{name} is now {new}; the next release knows only that name", DeprecationWarning, 2
        )
        value = getattr(importlib.import_module(".expressions", __name__), name)
    else:
        # Without its name, or a traceback would add a suggestion of Python's own.
        raise AttributeError(f"module 'motes' has no attribute {name!r}{_near(name)}", name=None, obj=None)
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
