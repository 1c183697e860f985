"""Who enters a run and who has left the script before it: no rank waits for one that never comes.

Every rank takes part in the same collective, whether it starts a run (`begin`) or ends its script (`leave`).
So the ranks that start a run learn at once that another one leaves.
"""

from __future__ import annotations

import time
from array import array
from typing import TYPE_CHECKING

from .process import process

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["LEAVE_WAIT_S", "Left", "begin", "leave"]

LEAVE_WAIT_S = 0.5  # how far apart the ranks' normal ends may lie before a rank sends notes that it left
_LEFT_TAG = 32741  # on COMM_WORLD: "I left before the run started"; every MPI allows tags up to 32767
_NOBODY = 2**31 - 1
_gone: set[int] = set()  # ranks of COMM_WORLD from which a note has come


class Left(Exception):
    """A rank that a run needs has left the script."""

    def __init__(self, rank: int) -> None:
        """Name it by its rank in COMM_WORLD."""
        super().__init__(f"rank {rank} left the script")
        self.rank = rank


def begin(comm: MPI.Comm) -> None:
    """Wait until every rank of `comm` is about to run. Collective.

    Raises Left if one of them has left the script, or leaves it meanwhile.
    """
    from mpi4py import MPI

    if comm.size == 1:
        return
    everybody = MPI.Comm.Compare(comm, MPI.COMM_WORLD) != MPI.UNEQUAL
    said, told = array("i", [_NOBODY]), array("i", [_NOBODY])
    # Among all ranks this is the collective of `leave`; a part of them has its own, and relies on the notes.
    request = (MPI.COMM_WORLD if everybody else comm).Iallreduce(said, told, MPI.MIN)
    pause = 0.0
    while not request.Test():
        _check_notes(comm)
        time.sleep(pause)
        pause = min(pause + 1e-4, 5e-3)
    if told[0] != _NOBODY:
        raise Left(told[0])


def leave() -> None:
    """Leave the script together with the others; where they stay longer, send notes in case they start a run.

    Notes go to the ranks 1, 2, 4, 8, ... further on, which wait for this rank in `begin` if they wait at all.
    Nobody is hurried: a rank may close a movie for minutes.
    """
    from mpi4py import MPI

    world = MPI.COMM_WORLD
    said, told = array("i", [process.rank]), array("i", [_NOBODY])
    everybody = world.Iallreduce(said, told, MPI.MIN)
    notes: list[MPI.Request] = []
    start = time.monotonic()
    while not everybody.Test():
        waited = time.monotonic() - start
        if waited > LEAVE_WAIT_S and not notes:
            steps = (1 << k for k in range(process.size.bit_length()) if 1 << k < process.size)
            others = [(process.rank + step) % process.size for step in steps]
            notes = [world.Isend([b"", 0, MPI.BYTE], other, _LEFT_TAG) for other in others]
        if waited > 2 * LEAVE_WAIT_S:
            return  # MPI_Finalize waits for the others just as well, and for those without motes too
        time.sleep(2e-3)


def _check_notes(comm: MPI.Comm) -> None:
    """Raise Left if a rank that `comm` needs has sent a note that it left."""
    from mpi4py import MPI

    status = MPI.Status()
    world = MPI.COMM_WORLD
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
