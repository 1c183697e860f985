"""Long work that keeps a rank from answering although it is not stuck: the others wait without a limit.

Closing a movie may take minutes on a slow disk. The rank notifies all others long before they would warn or
give up, and again when it is done. The time in between does not count towards their limits.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Self, TypeVar

from .._io.output import tell
from .ending import report_lost
from .losses import lost_ranks, unless_lost
from .process import OpenRun, process

if TYPE_CHECKING:
    from mpi4py import MPI

T = TypeVar("T")
__all__ = ["Busy", "busy_with", "look_around", "take_notes"]

_TAG = 1  # on the run's own communicator
_MOST_BYTES = 256
_ANNOUNCE_AT = 0.25  # fraction of the time after which the other ranks would warn
_LOOK_S = 0.02
_JOIN_S = 0.1
_sent: list[MPI.Request] = []  # kept until they are done, since they hold the buffers


class Busy:
    """A period of long work on this rank; call `look` regularly during it."""

    def __init__(self, what: str) -> None:
        """Start the period; `what` completes the message "rank 0 is still ..."."""
        self.what = what
        self._runs = [run for run in process.runs if run.comm is not None and run.comm.size > 1]
        if threading.current_thread() is not threading.main_thread():
            self._runs = []  # work in another thread does not keep this rank from answering
        self._start = time.monotonic()
        self._announced = False

    def look(self) -> None:
        """Notify the other ranks once the work has taken long enough."""
        if self._announced or not self._runs:
            return
        if time.monotonic() - self._start > _ANNOUNCE_AT * min(run.warn_s for run in self._runs):
            self._announced = True
            self._send(self.what)
            tell(f"motes: {process.describe()} is still {self.what}; the other ranks are waiting for it")

    def _send(self, text: str) -> None:
        from mpi4py import MPI

        note = text.encode()[:_MOST_BYTES]
        for run in self._runs:
            assert run.comm is not None
            lost = {run.comm.rank, *lost_ranks(run.comm)}
            with unless_lost():
                others = (rank for rank in range(run.comm.size) if rank not in lost)
                _sent.extend(run.comm.Isend([note, MPI.BYTE], rank, _TAG) for rank in others)
        _sent[:] = [request for request in _sent if not _has_left(request)]

    def __enter__(self) -> Self:
        """Return the object itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Notify the other ranks that the work is done, if they were notified that it continues."""
        if self._announced:
            self._send("")


def busy_with(what: str, work: Callable[[], T]) -> T:
    """Run long work in a thread while this thread notifies the other ranks; return or raise its outcome."""
    done: list[T] = []
    failed: list[BaseException] = []

    def run() -> None:
        try:
            done.append(work())
        except BaseException as error:
            failed.append(error)

    thread = threading.Thread(target=run, name=what, daemon=True)
    thread.start()
    with Busy(what) as busy:
        while thread.is_alive():
            thread.join(_JOIN_S)
            busy.look()
    if failed:
        raise failed[0]
    return done[0]


def look_around(run: OpenRun) -> None:
    """Check on the other ranks while this rank waits for one, in the core or in Python.

    Ends the job if a rank's process is gone, unless the job survives losses, which MPI reports to the core.
    Returns only when no rank is busy.
    """
    while True:
        lost = run.watch.check() if run.watch is not None and not process.survives else None
        if lost is not None and run.watch is not None:
            report_lost(run.world_rank(lost), run.watch.peers[lost].role, run.frame)
        take_notes(run)
        for rank in lost_ranks(run.comm) if run.busy and run.comm is not None else ():
            run.busy.pop(rank, None)
        if not run.busy:
            return
        time.sleep(_LOOK_S)


def take_notes(run: OpenRun) -> None:
    """Receive the other ranks' notes about being busy, without waiting."""
    if run.comm is None:
        return
    from mpi4py import MPI

    status = MPI.Status()
    with unless_lost():
        if lost_ranks(run.comm):
            run.comm.Ack_failed()  # until then MPI refuses to receive from MPI.ANY_SOURCE
        while run.comm.Iprobe(MPI.ANY_SOURCE, _TAG, status):
            rank, note = status.Get_source(), bytearray(status.Get_count(MPI.BYTE))
            run.comm.Recv([note, MPI.BYTE], rank, _TAG)
            if note:
                run.busy[rank] = note.decode(errors="replace")
            else:
                run.busy.pop(rank, None)


def _has_left(request: MPI.Request) -> bool:
    with unless_lost():
        return request.Test()
    return True
