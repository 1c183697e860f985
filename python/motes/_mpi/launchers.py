"""Detects launchers that started several processes which do not see each other: each would be rank 0 of 1."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping
from types import ModuleType
from typing import NamedTuple, NoReturn

from .._io.output import tell
from .._values import environment
from ..errors import MotesError
from .rank_process import is_child

__all__ = [
    "Launcher",
    "check_alone",
    "give_up",
    "is_open_mpi",
    "kind",
    "launcher_of",
    "name_of",
    "remember",
    "speaks_pmi_alone",
]


class _Variables(NamedTuple):
    """Environment variables that a launcher sets in each process that it starts."""

    launcher: str
    size: str
    """Variable with the number of processes."""
    rank: str
    """Variable with this process's number."""


# Only variables that a launcher sets in its processes, not in the shell that calls it: SLURM_NTASKS, for
# example, is set in any shell of an allocation. The first variable that is set counts, so launchers that
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
_SPEAKER_S = 1.0  # how long the other processes wait: a launcher ends the job with the first that ends


class Launcher(NamedTuple):
    """The launcher that started this process, according to the environment."""

    name: str
    size: int | None
    """The number of processes; None if only the rank is known."""
    variables: tuple[str, ...]
    """The variables that reveal the launcher, such as "PMI_SIZE=4"."""
    speaks: bool = True
    """Whether this process prints for all: the lowest rank that can see that there are others."""


_remembered: Launcher | None = None


def remember(variables: Mapping[str, str]) -> None:
    """Remember this process's launcher, before its variables are hidden from the MPI library."""
    global _remembered
    _remembered = launcher_of(variables)


def speaks_pmi_alone(variables: Mapping[str, str]) -> bool:
    """Return whether the launcher of this process uses only the old PMI, not PMIx."""
    return _PMIX_RANK not in variables and ("PMI_RANK" in variables or "PMI_SIZE" in variables)


def is_open_mpi(variables: Mapping[str, str]) -> bool:
    """Return whether Open MPI's mpirun started this process."""
    return "OMPI_COMM_WORLD_SIZE" in variables


def kind(variables: Mapping[str, str]) -> str:
    """Return which libraries a launcher can connect: "MPICH", "Open MPI 4", or "" if it does not tell."""
    if speaks_pmi_alone(variables):
        return "MPICH"
    return "Open MPI 4" if any(name.startswith("OMPI_MCA_orte_") for name in variables) else ""


def name_of(module: ModuleType) -> str:
    """Return name and version of the MPI library that mpi4py has loaded."""
    return " ".join(module.Get_library_version().split(",")[0].splitlines()[0].split())


def launcher_of(variables: Mapping[str, str]) -> Launcher | None:
    """Return the launcher that started several processes, this one among them, or None."""
    for launcher, size, rank in _KNOWN:
        text = variables.get(size, "")
        if not text.isdigit() or (launcher == "srun" and rank not in variables):
            continue
        if int(text) < 2:
            return None  # a job of one process
        set_here = tuple(f"{name}={variables[name]}" for name in (size, rank) if name in variables)
        return Launcher(launcher, int(text), set_here, variables.get(rank, "0") == "0")
    text = variables.get(_PMIX_RANK, "")
    if text.isdigit() and int(text) > 0:
        return Launcher("a launcher of the PMIx family", None, (f"{_PMIX_RANK}={text}",), text == "1")
    tasks, number = variables.get("SLURM_NTASKS", ""), variables.get("SLURM_PROCID", "")
    in_step = variables.get("SLURM_STEP_ID", "").isdigit() and tasks.isdigit() and int(tasks) > 1
    if number.isdigit() and (int(number) > 0 or in_step):
        first = "0" if in_step else "1"
        set_here = (f"SLURM_NTASKS={tasks}", f"SLURM_PROCID={number}")
        return Launcher("srun", None, set_here, number == first)
    return None


def check_alone() -> None:
    """End this process if MPI sees only one process but the launcher's variables show more.

    `MOTES_ALONE=1` lets each process run by itself.
    """
    if is_child():
        return
    from mpi4py import MPI

    if environment.alone() or MPI.COMM_WORLD.size > 1:
        return
    refuse(MPI)
    tasks = os.environ.get("SLURM_NTASKS", "")
    if "SLURM_JOB_ID" in os.environ and tasks.isdigit() and int(tasks) > 1:
        tell(
            f"motes: the scheduler gave this job {tasks} tasks, but this script runs on only one; "
            f"`python -m motes run -n {tasks} script.py` uses them all"
        )


def refuse(module: ModuleType) -> None:
    """End this process if its launcher started several, which this MPI library cannot connect."""
    launcher = _remembered or launcher_of(os.environ)
    if launcher is not None and not environment.alone():
        processes = f"{launcher.size} processes" if launcher.size is not None else "several processes"
        seen = ", ".join(launcher.variables)
        give_up(
            f"{launcher.name} seems to have started {processes} ({seen}), but MPI here sees only this one: "
            "each would compute the whole animation and overwrite the files of the others. "
            f"The launcher does not belong to the MPI library in use, {name_of(module)}. Start the script "
            "with `python -m motes run -n N script.py`, or set MOTES_ALONE=1 if each process should run "
            "on its own"
        )


def give_up(sentence: str) -> NoReturn:
    """End this process of a job that cannot run; only one process of the job prints why.

    Raises MotesError instead if there is one process, or in an interactive session.
    """
    launcher = _remembered or launcher_of(os.environ)
    if launcher is None or hasattr(sys, "ps1"):
        raise MotesError(sentence) from None
    if launcher.speaks:
        tell(f"motes: {sentence}")
    else:
        time.sleep(_SPEAKER_S)
    raise SystemExit(1)
