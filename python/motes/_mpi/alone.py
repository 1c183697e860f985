"""The communicator of a world in a process that must leave MPI alone: one that a rank has forked off.

It does what the package asks of mpi4py's communicators, for one rank: it sends nothing and waits for nobody.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["communicator"]


class _Done:
    """A conversation with nobody."""

    def Test(self) -> bool:  # noqa: N802  (as mpi4py names it)
        """It is over."""
        return True


class _Alone:
    """One rank without others."""

    rank, size = 0, 1

    def Idup(self) -> tuple[_Alone, _Done]:  # noqa: N802
        """Return another one."""
        return _Alone(), _Done()

    def Ibcast(self, _: Any, root: int = 0) -> _Done:  # noqa: N802
        """Leave the data as they are: the root has them."""
        return _Done()

    def Iallgather(self, own: Any, every: Any) -> _Done:  # noqa: N802
        """Copy this rank's data to those of all."""
        _buffer(every)[:] = _buffer(own)
        return _Done()

    def Iallreduce(self, own: Any, every: Any, _: Any) -> _Done:  # noqa: N802
        """Copy this rank's data: one is its own minimum, maximum and sum."""
        return self.Iallgather(own, every)

    def Iprobe(self, *_: Any) -> bool:  # noqa: N802
        """Find no message."""
        return False

    def Free(self) -> None:  # noqa: N802
        """Hold nothing to give back."""

    def py2f(self) -> None:
        """Tell the core that there is no MPI."""


def _buffer(data: Any) -> memoryview:
    """Return the bytes of what mpi4py takes: a buffer, or a list of one and its type."""
    return memoryview(data[0] if isinstance(data, list) else data).cast("B")


def communicator() -> MPI.Intracomm:
    """Return a communicator of this process alone."""
    return cast("MPI.Intracomm", _Alone())
