"""Loads MPI and the compiled core; if they do not load, one process of the job prints why in one sentence.

mpi4py finds the MPI library, and the core binds to the one that mpi4py has loaded.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
import warnings
from types import ModuleType

from . import launchers, rank_process

__all__ = ["load_core", "load_mpi", "paths", "problem_of_mpi"]

_NOT_THERE = re.compile(r"(\S*/)?libmpi\S*: (cannot open shared object file: No such file|file too short)")
"""mpi4py tries several names of the library; these lines of its error are about files that do not exist."""


def load_mpi() -> None:
    """Load MPI and start it, unless mpi4py was told not to.

    Hides a launcher that the MPI library does not support: otherwise MPI and mpi4py would complain on each
    rank before a world can report what is wrong.
    """
    import mpi4py

    rc = mpi4py.rc
    try:
        if "mpi4py.MPI" in sys.modules or not rc.initialize or not launchers.speaks_pmi_alone(os.environ):
            from mpi4py import MPI

            return
        rc.initialize, rc.finalize = False, True if rc.finalize is None else rc.finalize
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            from mpi4py import MPI
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
    try:
        return importlib.import_module("motes._core")
    except ImportError as error:
        module = sys.modules.get("mpi4py.MPI")
        if module is None or "undefined symbol" not in str(error):
            raise
        loaded = module.Get_library_version().split(",")[0].splitlines()[0]
        launchers.give_up(
            f"the compiled core was built for a different MPI, but mpi4py has loaded {loaded} "
            f"({error}){paths()}; `python -m motes doctor` shows more"
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
