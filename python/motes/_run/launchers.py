"""Detects launchers that started several processes which do not see each other: each would be rank 0 of 1."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

from .. import environment
from ..errors import MotesError
from .output import tell
from .rank_process import is_child

__all__ = ["Launcher", "check_alone", "launcher_of"]


class _Variables(NamedTuple):
    """What a launcher sets in each process that it starts."""

    launcher: str
    size: str
    """Variable with the number of processes."""
    rank: str
    """Variable with this process's number."""


# Only variables of the processes that a launcher started, not of the shell in which it is called:
# SLURM_NTASKS is set in any shell of an allocation. The first variable that is set counts: launchers that
# start other launchers come last.
_KNOWN = (
    _Variables("Open MPI's mpirun", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"),
    _Variables("MVAPICH's mpirun", "MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"),
    _Variables("a launcher of the PMI family (MPICH's or Intel's mpirun, srun)", "PMI_SIZE", "PMI_RANK"),
    _Variables("MPICH's or Intel's mpirun", "MPI_LOCALNRANKS", "MPI_LOCALRANKID"),
    _Variables("Flux", "FLUX_JOB_SIZE", "FLUX_TASK_RANK"),
    _Variables("jsrun", "JSM_NAMESPACE_SIZE", "JSM_NAMESPACE_RANK"),
    _Variables("PALS", "PALS_SIZE", "PALS_RANKID"),
    _Variables("srun", "SLURM_STEP_NUM_TASKS", "SLURM_PROCID"),
)
_PMIX_RANK = "PMIX_RANK"


class Launcher(NamedTuple):
    """What the environment says about who started this process."""

    name: str
    size: int | None
    """How many processes there are; None if only the rank is known."""
    variables: tuple[str, ...]
    """As "PMI_SIZE=4"."""


def launcher_of(variables: Mapping[str, str]) -> Launcher | None:
    """Return the launcher that started several processes, this one among them, or None."""
    for launcher, size, rank in _KNOWN:
        text = variables.get(size, "")
        if not text.isdigit() or (launcher == "srun" and rank not in variables):
            continue
        if int(text) < 2:
            return None  # it says that there is one
        set_here = tuple(f"{name}={variables[name]}" for name in (size, rank) if name in variables)
        return Launcher(launcher, int(text), set_here)
    text = variables.get(_PMIX_RANK, "")
    if text.isdigit() and int(text) > 0:
        return Launcher("a launcher of the PMIx family", None, (f"{_PMIX_RANK}={text}",))
    tasks, number = variables.get("SLURM_NTASKS", ""), variables.get("SLURM_PROCID", "")
    in_step = variables.get("SLURM_STEP_ID", "").isdigit() and tasks.isdigit() and int(tasks) > 1
    if number.isdigit() and (int(number) > 0 or in_step):
        return Launcher("srun", None, (f"SLURM_NTASKS={tasks}", f"SLURM_PROCID={number}"))
    return None


def check_alone() -> None:
    """Raise MotesError if MPI sees one process and the launcher's variables say that there are more.

    `MOTES_ALONE=1` lets each process run by itself.
    """
    if is_child():
        return
    from mpi4py import MPI

    if environment.alone() or MPI.COMM_WORLD.size > 1:
        return
    found = launcher_of(os.environ)
    if found is not None:
        processes = f"{found.size} processes" if found.size is not None else "several processes"
        library = MPI.Get_library_version().split(",")[0].strip().splitlines()[0]
        seen = ", ".join(found.variables)
        raise MotesError(
            f"{found.name} seems to have started {processes} ({seen}), but MPI here sees only this one: "
            "each would compute the whole animation and overwrite the files of the others. "
            f"The launcher does not belong to the MPI library in use, {library}. Start the script with "
            "`python -m motes run -n N script.py`, or set MOTES_ALONE=1 if each process is to run by itself"
        )
    tasks = os.environ.get("SLURM_NTASKS", "")
    if "SLURM_JOB_ID" in os.environ and tasks.isdigit() and int(tasks) > 1:
        tell(
            f"motes: the scheduler gave this job {tasks} tasks, and this script runs on one; "
            f"`python -m motes run -n {tasks} script.py` uses them all"
        )
