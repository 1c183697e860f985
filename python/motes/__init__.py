"""motes: a scriptable engine for particle-system animations on clusters.

A script issues the same calls on every rank; the engine gives each rank its role. See `World`.
"""

from __future__ import annotations

from importlib.metadata import version as _version

from ._run import mpi_settings  # noqa: F401  # isort: skip  (before MPI starts)
from mpi4py import MPI as _MPI  # noqa: F401  (starts MPI, and loads the library that the core binds to)

from . import actions, balance, errors, script, shapes
from ._run import ending
from .analysis import Run, Runs, open_run, open_runs
from .balance import (
    Balancer,
    Diffusive,
    LoadTable,
    Orders,
    Pairwise,
    PrefixCuts,
    Proportional,
    Static,
    Targets,
)
from .distributions import Normal, Uniform
from .errors import (
    ArgumentError,
    LogError,
    MotesError,
    MotesWarning,
    NotAssignable,
    NotHere,
    RankError,
    ScriptMismatch,
)
from .expressions import column, maximum, minimum
from .frame import Frame
from .movie import Movie
from .particles import Particles
from .rendering import Camera, Renderer, Solid, Sprite
from .roles import Roles
from .system import System
from .world import World

__all__ = [
    "ArgumentError",
    "Balancer",
    "Camera",
    "Diffusive",
    "Frame",
    "LoadTable",
    "LogError",
    "MotesError",
    "MotesWarning",
    "Movie",
    "Normal",
    "NotAssignable",
    "NotHere",
    "Orders",
    "Pairwise",
    "Particles",
    "PrefixCuts",
    "Proportional",
    "RankError",
    "Renderer",
    "Roles",
    "Run",
    "Runs",
    "ScriptMismatch",
    "Solid",
    "Sprite",
    "Static",
    "System",
    "Targets",
    "Uniform",
    "World",
    "actions",
    "balance",
    "column",
    "errors",
    "maximum",
    "minimum",
    "open_run",
    "open_runs",
    "script",
    "shapes",
]

__version__ = _version("motes")

ending.install()
