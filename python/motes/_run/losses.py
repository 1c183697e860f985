"""Ranks that are lost while the others go on, as far as Python sees them: `motes run --survive`."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NoReturn, TypeVar

from ..errors import ArgumentError
from . import open_worlds
from .output import write_all
from .process import process

if TYPE_CHECKING:
    from mpi4py import MPI

T = TypeVar("T")
__all__ = [
    "END",
    "ENVIRONMENT",
    "end_job",
    "lost_line",
    "lost_ranks",
    "survived",
    "taken_over",
    "unless_lost",
]

ENVIRONMENT = {"OMPI_MCA_ompi_async_mpi_finalize": "1"}
"""For a launcher. Left alone, MPI_Finalize waits for the lost ranks, too, in about one run of ten."""

END = "*** motes: end of the job, exit code "
"""What a rank says on standard error for `motes run` to end the whole job, followed by the code."""

LOST = "*** motes: the next report is of a lost rank"
"""What a rank says before its report for `motes run` to know that another start may come to the end."""

_END_WAIT_S = 5.0  # how long this may take
_PATIENCE_S = 10.0
_LOOK_S = 0.02
_FAULT_TOLERANT = "OMPI_MCA_mpi_ft_enable"  # set by `mpirun --with-ft ulfm`


def survived() -> bool:
    """Tell whether this job goes on when a rank is lost."""
    from .. import _core

    return os.environ.get(_FAULT_TOLERANT, "").lower() in ("1", "true") and _core.mpi_can_survive()


def lost_ranks(comm: MPI.Comm) -> list[int]:
    """List the ranks of a communicator that are known to be lost; none where a loss ends the job."""
    if not process.survives:
        return []
    lost = comm.Get_failed()
    ranks = lost.Translate_ranks(None, comm.Get_group()) if lost.size > 0 else []
    return sorted(ranks)


@contextlib.contextmanager
def unless_lost(give_up: Callable[[], object] = lambda: None) -> Iterator[None]:
    """Do MPI's work inside, or give it up where a loss that is survived has made it impossible."""
    from mpi4py import MPI

    try:
        yield
    except MPI.Exception:
        if not process.survives:
            raise
        give_up()


def taken_over(claim: Callable[[], T]) -> T:
    """Return what `claim` gives; a process that is gone may need a while to let go of what it has locked.

    Raises the ArgumentError of `claim` where somebody else has it.
    """
    limit = time.monotonic() + _PATIENCE_S
    while True:
        try:
            return claim()
        except ArgumentError:
            if time.monotonic() > limit:
                raise
        time.sleep(_LOOK_S)


def lost_line() -> str:
    """Return the line `LOST` where `motes run` reads it, or nothing."""
    return f"{LOST}\n" if os.environ.get(open_worlds.FOLDER) else ""


def end_job(code: int) -> NoReturn:
    """End every rank where losses are survived: there the others take MPI_Abort for one more loss."""
    with contextlib.suppress(BaseException):
        if os.environ.get(open_worlds.FOLDER):
            write_all(2, f"\n{END}{code}\n".encode())
            time.sleep(_END_WAIT_S)
        os.kill(os.getppid(), signal.SIGTERM)  # a launcher that nobody watches over, or its daemon here
        time.sleep(_END_WAIT_S)
    os._exit(code)
