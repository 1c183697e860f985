"""Detect ranks that leave the script before a run, so that no rank waits for one that never comes.

Every rank takes part in the same collective, whether it starts a run (`begin`) or ends its script (`leave`).
The ranks that start a run therefore learn at once that another rank leaves.

If the job survives the loss of ranks, the collective is an agreement among live ranks: it completes even if
ranks die, with the same result everywhere.
"""

from __future__ import annotations

import time
from array import array
from typing import TYPE_CHECKING

from .losses import lost_ranks
from .process import process

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["LEAVE_WAIT_S", "Left", "begin", "leave"]

LEAVE_WAIT_S = 0.5  # how long a rank that leaves waits for the others before it sends them notes
_LEFT_TAG = 32741  # on COMM_WORLD: "I left before the run started"; every MPI allows tags up to 32767
_NOBODY = 2**31 - 1
_FAILED = 2**30  # a rank that is here, but whose call has failed
_MARKS = 31  # bits of an agreement that identify the ranks that leave
_gone: set[int] = set()  # ranks of COMM_WORLD that have sent a note


class Left(Exception):
    """A rank that a run needs has left the script, or is lost."""

    def __init__(self, rank: int | None, *, lost: bool = False) -> None:
        """Store the rank in COMM_WORLD, or None if it is unknown."""
        super().__init__(f"rank {rank} {'is lost' if lost else 'left the script'}")
        self.rank = rank
        self.lost = lost


class _Collective:
    """A collective by which all ranks learn whether a rank leaves, and which one."""

    def __init__(self, comm: MPI.Comm, *, leaves: bool, failed: bool = False) -> None:
        from mpi4py import MPI

        self._comm = comm
        self._everything = (1 << _MARKS) - 1
        if process.survives:
            mark = 1 << process.rank % _MARKS
            self._agreed = array("i", [self._everything ^ mark if leaves else self._everything])
            self._request = comm.Iagree(self._agreed)
        else:
            says = process.rank if leaves else _FAILED if failed else _NOBODY
            own, self._agreed = array("i", [says]), array("i", [_NOBODY])
            self._own = own  # must live until the request is done
            self._request = comm.Iallreduce(own, self._agreed, MPI.MIN)

    def done(self) -> bool:
        """Return whether all live ranks have taken part."""
        from mpi4py import MPI

        try:
            return self._request.Test()
        except MPI.Exception as error:
            if process.survives and error.Get_error_class() == MPI.ERR_PROC_FAILED:
                return self._request == MPI.REQUEST_NULL  # an agreement reports losses even if it succeeds
            raise

    def check(self) -> bool:
        """Raise Left if a rank leaves; return whether a rank may have failed."""
        if not process.survives:
            if self._agreed[0] < _FAILED:
                raise Left(self._agreed[0])
            return self._agreed[0] == _FAILED
        if gone := self._everything & ~self._agreed[0]:
            ranks = [rank for rank in range(process.size) if gone >> rank % _MARKS & 1]
            raise Left(ranks[0] if len(ranks) == 1 or process.size <= _MARKS else None)
        return True  # an agreement has no bit for that


def begin(comm: MPI.Comm, *, without_lost: bool = False, failed: bool = False) -> bool:
    """Wait until every rank of `comm` is about to run. Collective.

    Raises Left if one of them leaves the script or is lost; `without_lost`: lost ranks are ignored. Returns
    whether a rank may have been `failed`; all ranks return the same.
    """
    from mpi4py import MPI

    if comm.size == 1:
        return failed
    everybody = comm == process.left or MPI.Comm.Compare(comm, MPI.COMM_WORLD) != MPI.UNEQUAL
    # If `comm` has all live ranks, this matches the collective in `leave`. A subset has its own collective
    # and learns about ranks that leave from notes.
    all_begin = _Collective(MPI.COMM_WORLD if everybody else comm, leaves=False, failed=failed)
    pause = 0.0
    while not all_begin.done():
        if not without_lost:
            check_lost(comm)
        _check_notes(comm)
        time.sleep(pause)
        pause = min(pause + 1e-4, 5e-3)
    may_have_failed = all_begin.check()
    if not without_lost:
        check_lost(comm)
    return may_have_failed


def check_lost(comm: MPI.Comm) -> None:
    """Raise Left if a rank of `comm` is lost."""
    for rank in lost_ranks(comm):
        raise Left(_in_world(comm, rank), lost=True)


def leave(*, wait: bool = False) -> bool:
    """Leave the script together with the others; if they stay longer, send notes in case they start a run.

    Notes go to the ranks 1, 2, 4, 8, ... after this one: any of them in `begin` would wait for this rank.
    `wait`: wait for the others without a limit, since closing a movie may take minutes. Returns whether all
    live ranks have come.
    """
    from mpi4py import MPI

    world = MPI.COMM_WORLD
    everybody = _Collective(world, leaves=True)
    notes: list[MPI.Request] = []
    start = time.monotonic()
    while not everybody.done():
        waited = time.monotonic() - start
        if waited > LEAVE_WAIT_S and not notes:
            steps = (1 << k for k in range(process.size.bit_length()) if 1 << k < process.size)
            lost = lost_ranks(world)
            others = [(process.rank + step) % process.size for step in steps]
            others = [rank for rank in others if rank not in lost]
            notes = [world.Isend([b"", 0, MPI.BYTE], other, _LEFT_TAG) for other in others]
        if waited > 2 * LEAVE_WAIT_S and not wait:
            return False  # MPI_Finalize waits for the others, too, even for ranks without motes
        time.sleep(2e-3 if waited < LEAVE_WAIT_S else 2e-2)
    return True


def _check_notes(comm: MPI.Comm) -> None:
    """Raise Left if a rank of `comm` has sent a note that it left."""
    from mpi4py import MPI

    status = MPI.Status()
    world = MPI.COMM_WORLD
    if lost_ranks(world):
        world.Ack_failed()  # until then MPI refuses to receive from MPI.ANY_SOURCE
    while world.Iprobe(MPI.ANY_SOURCE, _LEFT_TAG, status):
        left = status.Get_source()
        world.Recv([bytearray(0), 0, MPI.BYTE], left, _LEFT_TAG)
        _gone.add(left)
    if _gone:
        gone = sorted(_gone)
        inside = MPI.Group.Translate_ranks(world.Get_group(), gone, comm.Get_group())
        for rank, its in zip(gone, inside, strict=True):
            if its != MPI.UNDEFINED:
                raise Left(rank)


def _in_world(comm: MPI.Comm, rank: int) -> int:
    from mpi4py import MPI

    return comm.Get_group().Translate_ranks([rank], MPI.COMM_WORLD.Get_group())[0]
