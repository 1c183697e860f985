"""This process and the runs that are open in it: what messages say about where a rank was."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import place

if TYPE_CHECKING:
    from mpi4py import MPI

    from .log_directory import LogDirectory
    from .peers import Peer, PeerWatch

__all__ = ["OpenRun", "Process", "process"]


@dataclass(eq=False, repr=False)
class OpenRun:
    """A world from its start to its end, as messages and the way out of the script need to know it."""

    role: str = ""
    """As text, such as "calculator 0" or "image generator, manager"."""
    frame: int | None = None
    ranks: list[int] = field(default_factory=list)
    """The rank in COMM_WORLD of each rank of the world; empty where they are the same."""

    comm: MPI.Intracomm | None = None
    """A duplicate of the world's communicator, for messages that Python sends beside the core."""
    peers: list[Peer] = field(default_factory=list)
    """One per rank of the world."""
    threads: list[int] = field(default_factory=list)
    """Of each rank."""
    watch: PeerWatch | None = None
    log: LogDirectory | None = None
    """On the manager, where there is a log."""
    noted: Path | None = None
    """The launcher's note that this run is open."""
    warn_s: float = 60.0
    """After so many seconds without an answer the others speak of this rank, or give up."""
    busy: dict[int, str] = field(default_factory=dict)
    """Ranks that reported long work, which keeps them from answering."""

    def world_rank(self, rank: int) -> int:
        """Return the rank in COMM_WORLD of a rank of this run."""
        return self.ranks[rank] if rank < len(self.ranks) else rank


@dataclass(eq=False, repr=False)
class Process:
    """What this process is doing."""

    rank: int = 0
    """In COMM_WORLD, as `size`."""
    size: int = 1
    job: str = ""
    """The launcher's name of the job, where it gave one."""
    survives: bool = False
    """The launcher lets the other ranks go on when one is lost (`motes run --survive`)."""
    left: MPI.Intracomm | None = None
    """The ranks that are left, once a world of all ranks has gone on without some; None before."""
    runs: list[OpenRun] = field(default_factory=list)
    """The open ones, in the order of their start; any number may be open at once."""
    entered: int = 0
    """How many runs it has taken part in."""
    stopped: int = 0
    """The signal because of which a run of this process was stopped, or 0."""

    @property
    def running(self) -> bool:
        """Whether a run is open: leaving the script now would make the other ranks hang."""
        return bool(self.runs)

    def open(self, run: OpenRun) -> OpenRun:
        """Note that a run has started."""
        self.runs.append(run)
        return run

    def close(self, run: OpenRun) -> None:
        """Note that a run has ended. The other open runs stay open."""
        if run in self.runs:
            self.runs.remove(run)

    def forget(self) -> None:
        """Start again, in a process that a rank has forked off."""
        self.rank, self.size, self.survives = 0, 1, False
        self.runs, self.entered, self.stopped = [], 0, 0

    def describe(self, run: OpenRun | None = None) -> str:
        """Name this rank, by the given run or the last that was opened: "rank 2 (calculator 0), frame 7"."""
        if run is None and self.runs:
            run = self.runs[-1]
        return place(self.rank) if run is None else place(self.rank, role=run.role, frame=run.frame)


process = Process()
