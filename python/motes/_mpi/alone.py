"""A communicator of one rank without MPI, for worlds in processes that a rank has forked.

It has the methods of mpi4py's communicators that the package calls. They neither send nor wait.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["communicator"]


class _Done:
    """A completed request."""

    def Test(self) -> bool:  # noqa: N802  (as mpi4py names it)
        """Return True: the request is complete."""
        return True


class _Alone:
    """A communicator of one rank."""

    rank, size = 0, 1

    def Idup(self) -> tuple[_Alone, _Done]:  # noqa: N802
        """Return a new communicator and a completed request."""
        return _Alone(), _Done()

    def Ibcast(self, _: Any, root: int = 0) -> _Done:  # noqa: N802
        """Leave the data unchanged: this rank is the root."""
        return _Done()

    def Iallgather(self, own: Any, every: Any) -> _Done:  # noqa: N802
        """Copy this rank's data to the result."""
        _buffer(every)[:] = _buffer(own)
        return _Done()

    def Iallreduce(self, own: Any, every: Any, _: Any) -> _Done:  # noqa: N802
        """Copy this rank's data to the result: with one rank, minimum, maximum and sum are the same."""
        return self.Iallgather(own, every)

    def Iprobe(self, *_: Any) -> bool:  # noqa: N802
        """Return False: there are no messages."""
        return False

    def Free(self) -> None:  # noqa: N802
        """Do nothing."""

    def py2f(self) -> None:
        """Return None, which tells the core that there is no MPI."""


def _buffer(data: Any) -> memoryview:
    """Return the bytes of a message as mpi4py takes it: a buffer, or a list of a buffer and its type."""
    return memoryview(data[0] if isinstance(data, list) else data).cast("B")


def communicator() -> MPI.Intracomm:
    """Return a communicator of only this process."""
    return cast("MPI.Intracomm", _Alone())
