"""Collectives of all ranks in Python: their waits have a limit, and signals interrupt them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ..errors import MotesError
from .losses import lost_ranks, unless_lost
from .waiting import Wait, poll

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["broadcast", "first_text", "wait_for"]

_TEXT_BYTES = 1024


def wait_for(request: MPI.Request, comm: MPI.Intracomm, stall_s: float | None, what: str) -> None:
    """Wait until a request on `comm` is done; `what`: "other ranks to ...", for messages.

    Raises MotesError if a rank is lost: the others might wait for it, and for each other, forever.
    """
    failed = False

    def fail() -> None:
        nonlocal failed
        failed = True

    def done() -> bool:
        with unless_lost(fail):
            if request.Test():
                return True
        for rank in lost_ranks(comm):
            raise MotesError(f"rank {rank} is lost: its process was killed or has crashed")
        if failed:
            raise MotesError("a rank is lost: its process was killed or has crashed")
        return False

    poll(done, Wait(stall_s, what))


def broadcast(
    comm: MPI.Intracomm,
    data: bytes,
    root: int,
    stall_s: float | None,
    what: str,
    *,
    wait: Callable[[MPI.Request, MPI.Intracomm, float | None, str], None] = wait_for,
) -> bytes:
    """Return the data of `root` on all ranks; the other ranks' data does not matter. Collective."""
    from mpi4py import MPI

    head = bytearray(len(data).to_bytes(8, "little"))
    wait(comm.Ibcast([head, MPI.BYTE], root), comm, stall_s, what)
    buffer = bytearray(data if comm.rank == root else int.from_bytes(head, "little"))
    if buffer:
        wait(comm.Ibcast([buffer, MPI.BYTE], root), comm, stall_s, what)
    return bytes(buffer)


def first_text(comm: MPI.Intracomm, text: str, stall_s: float | None, what: str) -> tuple[int, str]:
    """Return the lowest rank whose text is not empty, and its text, or (-1, ""). Collective."""
    from mpi4py import MPI

    own = text.encode()[:_TEXT_BYTES].ljust(_TEXT_BYTES, b"\0")
    has_text, any_text = bytearray([1 if text else 0]), bytearray(1)
    wait_for(comm.Iallreduce([has_text, MPI.BYTE], [any_text, MPI.BYTE], MPI.MAX), comm, stall_s, what)
    if not any_text[0]:
        return -1, ""
    every = bytearray(_TEXT_BYTES * comm.size)
    wait_for(comm.Iallgather([own, MPI.BYTE], [every, MPI.BYTE]), comm, stall_s, what)
    texts = [bytes(every[i : i + _TEXT_BYTES]) for i in range(0, len(every), _TEXT_BYTES)]
    rank = next(rank for rank, one in enumerate(texts) if one.strip(b"\0"))
    return rank, texts[rank].rstrip(b"\0").decode(errors="replace")
