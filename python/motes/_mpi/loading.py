"""Loads MPI and the compiled core; if they do not load, one process of the job prints why in one sentence.

mpi4py finds the MPI library, and the core binds to the one that mpi4py has loaded. Where several MPIs are
installed, mpi4py is told which of them the core is linked to (`linked_library`).
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import mmap
import os
import re
import sys
import warnings
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from types import ModuleType
from typing import NamedTuple

from . import launchers, rank_process

__all__ = [
    "Linked",
    "chosen_library",
    "import_mpi",
    "linked_library",
    "load_core",
    "load_mpi",
    "other_libraries",
    "paths",
    "problem_of_mpi",
]

_NOT_THERE = re.compile(r"(\S*/)?libmpi\S*: (cannot open shared object file: No such file|file too short)")
"""mpi4py tries several names of the library; these lines of its error are about files that do not exist."""
_NAMES = re.compile(rb"\0(libmpi\w*\.so[.\d]*)\0")
"""An MPI library in the core's table of names: one that it is linked to."""
_FOLDERS = re.compile(rb"\0(\$ORIGIN/\.\./\.\./\.\.[^\0]*)\0")  # cpp/comm/mpi.cmake
_LIBRARY = re.compile(r"libmpi(ch)?\.so\.\d+")
_FAMILIES = {".so.40": "Open MPI", ".so.12": "MPICH"}
_BTL = "OMPI_MCA_btl"


class Linked(NamedTuple):
    """The MPI library that the core is linked to."""

    name: str
    """Its name, such as "libmpi.so.40"; "" if the core is missing."""
    path: str
    """Where the environment or the core's own search path has it; "" if neither does."""

    @property
    def family(self) -> str:
        """The MPI that it belongs to, or ""."""
        return next((family for end, family in _FAMILIES.items() if self.name.endswith(end)), "")

    def __str__(self) -> str:
        """Return name and family."""
        return f"{self.name} ({self.family})" if self.family else self.name


@cache
def linked_library() -> Linked:
    """Find out which MPI library the core is linked to, without loading it."""
    spec = find_spec("motes._core")
    if spec is None or spec.origin is None:
        return Linked("", "")
    with open(spec.origin, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as core:
        matches = [pattern.search(core) for pattern in (_NAMES, _FOLDERS)]
        name, folders = (match[1].decode() if match else "" for match in matches)
    origin = os.path.dirname(spec.origin)
    places = [os.path.normpath(place.replace("$ORIGIN", origin)) for place in folders.split(":") if place]
    linker = re.sub(r"\.so.*", ".so", name)  # Debian: in a folder of its own, a link to where the library is
    places += [os.path.dirname(os.path.realpath(os.path.join(place, linker))) for place in places]
    site = sys.modules.get("site")  # the same prefixes as mpi4py's
    prefixes = (sys.exec_prefix, getattr(site, "USER_BASE", None), sys.base_exec_prefix)
    places += [os.path.join(prefix, "lib") for prefix in prefixes if prefix]
    files = (os.path.join(place, name) for place in places)
    return Linked(name, next((file for file in files if os.path.isfile(file)), ""))


def chosen_library() -> dict[str, str]:
    """Return the variable with which mpi4py loads the library that the core is linked to.

    Empty if the user has chosen a library, or if there is none in this environment or where the core looks.
    """
    if "MPI4PY_LIBMPI" in os.environ or "MPI4PY_MPIABI" in os.environ:
        return {}
    path = linked_library().path
    return {"MPI4PY_LIBMPI": path} if path else {}


def other_libraries() -> list[str]:
    """List the libraries of other MPIs in the folder of the one that the core is linked to."""
    path = linked_library().path
    if not path:
        return []
    folder = os.path.dirname(path)
    names = (name for name in sorted(os.listdir(folder)) if _LIBRARY.fullmatch(name))
    others = (os.path.join(folder, name) for name in names)
    return [other for other in others if not os.path.samefile(other, path)]


@contextlib.contextmanager
def _variables(changes: dict[str, str]) -> Iterator[None]:
    """Set environment variables that are for this process alone, not for its children."""
    before = {name: os.environ.get(name) for name in changes}
    os.environ.update(changes)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def import_mpi() -> ModuleType:
    """Import mpi4py's module with the library that the core is linked to; starts MPI as mpi4py is told to."""
    if "mpi4py.MPI" in sys.modules:
        return sys.modules["mpi4py.MPI"]
    changes = chosen_library()
    if os.environ.get(_BTL) == "^ofi" and not any(name in os.environ for name in rank_process.LAUNCHED):
        # Open MPI 5.0.11 leaves the shared memory of a process that no launcher started in /dev/shm. It is
        # for other ranks, and here are none.
        changes[_BTL] = "^ofi,sm,vader"
    with _variables(changes):
        return importlib.import_module("mpi4py.MPI")


def load_mpi() -> None:
    """Load MPI and start it, unless mpi4py was told not to.

    Hides a launcher that the MPI library does not support: otherwise MPI and mpi4py would complain on each
    rank before a world can report what is wrong.
    """
    import mpi4py

    rc = mpi4py.rc
    try:
        if "mpi4py.MPI" in sys.modules or not rc.initialize or not launchers.speaks_pmi_alone(os.environ):
            import_mpi()
            return
        rc.initialize, rc.finalize = False, True if rc.finalize is None else rc.finalize
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            MPI = import_mpi()
        rc.initialize = True
    except (ImportError, RuntimeError) as error:
        launchers.give_up(problem_of_mpi(error))
    version = re.match(r"Open MPI v(\d+)", MPI.Get_library_version())
    if version is not None and int(version[1]) >= 5:  # it supports only PMIx
        launchers.remember(os.environ)
        rank_process.hide_pmi()
    MPI.Init_thread(MPI.THREAD_MULTIPLE)


def load_core() -> ModuleType:
    """Load the compiled core, after MPI."""
    module = sys.modules.get("mpi4py.MPI")
    if module is not None and not _is_loaded(linked_library().name):
        launchers.give_up(_mismatch(module))
    try:
        return importlib.import_module("motes._core")
    except ImportError as error:
        if module is None or "undefined symbol" not in str(error):
            raise
        launchers.give_up(_mismatch(module, f" ({error})"))


def _is_loaded(name: str) -> bool:
    """Return whether this process has loaded a library of this name; calls to a second MPI would end it."""
    try:
        ctypes.CDLL(name, mode=os.RTLD_NOLOAD)
    except OSError:
        return False
    return True


def _mismatch(module: ModuleType, error: str = "") -> str:
    """Say that mpi4py has loaded another MPI than the core needs, and what to do."""
    linked = linked_library()
    loaded = " ".join(module.Get_library_version().split(",")[0].splitlines()[0].split())
    if error:
        remedy = "build motes for that MPI (MPICC)"
    elif not linked.path:
        package = linked.family.lower().replace(" ", "")
        install = f"run `pip install {package}`" if package else "install that MPI"
        remedy = f"{install}, or build motes for the MPI that is loaded (MPICC)"
    else:
        remedy = f"set MPI4PY_LIBMPI={linked.path}"
        if chosen_library():
            remedy = f"import motes before mpi4py, or {remedy}"
    return (
        f"the compiled core was built for a different MPI, {linked}, but mpi4py has loaded {loaded}{error}: "
        f"{remedy}{paths()}; `python -m motes doctor` shows more"
    )


def problem_of_mpi(error: Exception) -> str:
    """Return why mpi4py cannot load an MPI library, without the missing files that its error lists."""
    lines = [line.strip() for line in str(error).splitlines()]
    reasons = [line for line in lines[1:] if line and not _NOT_THERE.match(line)]
    return f"mpi4py cannot load an MPI library: {reasons[0] if reasons else '; '.join(lines)}{paths()}"


def paths() -> str:
    """Return a clause about LD_LIBRARY_PATH, or "" if it is not set."""
    path = os.environ.get("LD_LIBRARY_PATH", "")
    return (
        f"; LD_LIBRARY_PATH={path} may put the libraries of a different MPI first: unset it" if path else ""
    )
