"""Decides which process is the rank that the launcher's environment variables describe.

A launcher sets environment variables that tell a process its rank. All its children inherit them: helper
scripts, pools of workers, their own children. Only one process is the rank. The others must not start MPI in
its name: they run as without a launcher, and a world there has one rank.

The rank leaves its process id in the environment for its children: `motes run` does so before Python starts,
other launchers' ranks at `import motes`. A child that was started earlier looks for an ancestor that has
loaded an MPI library (Linux). A wrapper (`mpirun time python script.py`) has loaded none: its child is the
rank.
"""

from __future__ import annotations

import contextlib
import os
import sys

__all__ = ["JOB", "LAUNCHED", "MARK", "became_fork", "hide", "hide_pmi", "is_child", "is_fork", "settle"]

MARK = "MOTES_RANK_PROCESS"
"""The environment variable with the rank's process id and its values of the variables in `JOB`."""

JOB = ("PMIX_NAMESPACE", "PMIX_RANK", "PMI_RANK", "SLURM_STEP_ID", "SLURM_PROCID")
"""Variables that tell ranks and jobs apart: a rank may start another job, whose processes are ranks again."""

LAUNCHED = (
    *("OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE", "MPI_LOCALNRANKS"),
    *("MV2_COMM_WORLD_RANK", "FLUX_TASK_RANK", "JSM_NAMESPACE_RANK", "PALS_RANKID"),
)
"""Variables that reveal an MPI launcher: each launcher sets one of them in the processes it starts."""

_CONNECTIONS = ("PMIX_", "PMI_", "MPI_LOCAL", "OMPI_MCA_orte_", "OMPI_MCA_ess_", "OMPI_MCA_pmix_")
"""Prefixes of the variables by which an MPI library finds its launcher and its rank."""

_PARAMETERS = "PMIX_MCA_"
_ADDRESSES = ("PMIX_NAMESPACE", "PMIX_SERVER_URI", "PMI_FD", "PMI_PORT")
"""Prefixes of variables without which MPI cannot find its launcher, and which scripts hardly ever read."""

_OF_THE_RUN = (
    *("MOTES_ANYWAY", "MOTES_FRESH", "MOTES_LIVE", "MOTES_OPEN_WORLDS"),
    *("MOTES_RANK_PIPE", "MOTES_STEERING"),
)
"""Variables that `motes run` and its options set for the rank's own run."""

_child = False
_fork = False


def settle() -> bool:
    """Decide, at `import motes`, whether this process is a rank, which must start MPI at once.

    In a rank's child, hide the launcher from MPI.
    """
    if not any(name in os.environ for name in LAUNCHED):
        return False
    job = _job()
    pid, _, marked = os.environ.get(MARK, "").partition(" ")
    below = marked == job and pid != str(os.getpid())
    ranks = _ranks_of_mpi()
    if marked != job or (below and ranks > 1):  # the marked process may be a wrapper
        below = _below_a_rank()
    if below:
        _become_child(fork=ranks > 1)
        return False
    _mark(os.getpid())
    return True


def hide() -> None:
    """Remove the launcher's address from the environment, once MPI has started in this rank.

    So children that start MPI without motes run alone, too: a second process with the same rank would write
    into the shared memory of the other ranks.
    """
    _remove(_ADDRESSES)
    _mark(os.getpid())


def hide_pmi() -> None:
    """Remove the environment variables of a launcher that the MPI library does not support."""
    _remove(("PMI_", "MPI_LOCAL"))


def is_child() -> bool:
    """Return whether a rank has started this process, directly or not; then it runs alone."""
    return _child


def is_fork() -> bool:
    """Return whether this process was forked while MPI was running; then it cannot use MPI."""
    return _fork


def became_fork() -> None:
    """Note, in a new process, that it was forked while MPI was running."""
    _become_child(fork=True)


def _become_child(*, fork: bool) -> None:
    global _child, _fork
    _child, _fork = True, _fork or fork
    _remove(_CONNECTIONS + _OF_THE_RUN)
    _mark(0)  # its children are not ranks either


def _remove(beginnings: tuple[str, ...]) -> None:
    for name in list(os.environ):
        if name.startswith(beginnings) and not name.startswith(_PARAMETERS):
            del os.environ[name]


def _mark(pid: int) -> None:
    os.environ[MARK] = f"{pid} {_job()}"


def _job() -> str:
    return " ".join(os.environ.get(name, "") for name in JOB)


def _ranks_of_mpi() -> int:
    """Return how many ranks MPI sees in this process; 0 if it is not running."""
    module = sys.modules.get("mpi4py.MPI")
    if module is None or not module.Is_initialized() or module.Is_finalized():
        return 0
    return int(module.COMM_WORLD.size)


def _below_a_rank() -> bool:
    """Return whether an ancestor with the same variables has loaded an MPI library (Linux)."""
    names = [name for name in (*JOB, *LAUNCHED, "OMPI_COMM_WORLD_RANK") if name in os.environ]
    with contextlib.suppress(OSError, ValueError, IndexError):
        above = os.getppid()
        while above > 1:
            theirs = _facts(above, "environ").split("\0")
            if any(f"{name}={os.environ[name]}" not in theirs for name in names):
                return False  # the launcher or its ancestor
            if "/libmpi" in _facts(above, "maps"):
                return True
            above = int(_facts(above, "stat").rpartition(")")[2].split()[1])
    return False


def _facts(process: int, what: str) -> str:
    with open(f"/proc/{process}/{what}", errors="replace") as file:
        return file.read()
