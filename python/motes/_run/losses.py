"""Ranks that are lost while the others continue (`motes run --survive`): the Python side."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NoReturn, TypeVar

from .._io.output import write_all
from ..errors import ArgumentError
from . import open_worlds
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
"""Variables that a launcher sets. Without them, MPI_Finalize waits for lost ranks in about one run of ten."""

END = "*** motes: end of the job, exit code "
"""Printed by a rank on standard error, followed by the code, to make `motes run` end the whole job."""

LOST = "*** motes: the next report is of a lost rank"
"""Printed by a rank before its report to tell `motes run` that restarting may succeed."""

_END_WAIT_S = 5.0  # how long ending the job may take
_PATIENCE_S = 10.0
_LOOK_S = 0.02
_FAULT_TOLERANT = "OMPI_MCA_mpi_ft_enable"  # set by `mpirun --with-ft ulfm`


def survived() -> bool:
    """Return whether this job continues when a rank is lost."""
    from .. import _core

    return os.environ.get(_FAULT_TOLERANT, "").lower() in ("1", "true") and _core.mpi_can_survive()


def lost_ranks(comm: MPI.Comm) -> list[int]:
    """List the ranks of a communicator that are known to be lost; empty if a loss ends the job."""
    if not process.survives:
        return []
    lost = comm.Get_failed()
    ranks = lost.Translate_ranks(None, comm.Get_group()) if lost.size > 0 else []
    return sorted(ranks)


@contextlib.contextmanager
def unless_lost(give_up: Callable[[], object] = lambda: None) -> Iterator[None]:
    """Suppress MPI errors in the block and call `give_up` instead, if the job survives losses."""
    from mpi4py import MPI

    try:
        yield
    except MPI.Exception:
        if not process.survives:
            raise
        give_up()


def taken_over(claim: Callable[[], T]) -> T:
    """Return the result of `claim`, retrying while a lost process has not yet released its lock.

    Raises the ArgumentError of `claim` if the lock is not released in time.
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
    """Return the line `LOST` if `motes run` reads it, otherwise ""."""
    return f"{LOST}\n" if os.environ.get(open_worlds.FOLDER) else ""


def end_job(code: int) -> NoReturn:
    """End every rank of a job that survives losses: there MPI_Abort would count as the loss of one rank."""
    with contextlib.suppress(BaseException):
        if os.environ.get(open_worlds.FOLDER):
            write_all(2, f"\n{END}{code}\n".encode())
            time.sleep(_END_WAIT_S)
        os.kill(os.getppid(), signal.SIGTERM)  # the launcher, if `motes run` does not watch it, or its daemon
        time.sleep(_END_WAIT_S)
    os._exit(code)
