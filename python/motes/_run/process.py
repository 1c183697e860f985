"""This process and its open runs, for messages that say where a rank was."""

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
    """A world's run, with the state that messages and exits from the script need."""

    role: str = ""
    """This rank's role as text, such as "calculator 0" or "image generator, manager"."""
    frame: int | None = None
    ranks: list[int] = field(default_factory=list)
    """The rank in COMM_WORLD of each rank of the world; empty if they are the same."""

    comm: MPI.Intracomm | None = None
    """A duplicate of the world's communicator, for messages sent by Python rather than by the core."""
    peers: list[Peer] = field(default_factory=list)
    """The processes of the world's ranks."""
    threads: list[int] = field(default_factory=list)
    """The number of threads of each rank."""
    watch: PeerWatch | None = None
    log: LogDirectory | None = None
    """The log's directory, on the manager of a run with a log."""
    noted: Path | None = None
    """The file that tells the launcher that this run is open."""
    warn_s: float = 60.0
    """Seconds without an answer after which other ranks warn or give up."""
    busy: dict[int, str] = field(default_factory=dict)
    """Ranks that do long work and cannot answer -> what they do."""

    def world_rank(self, rank: int) -> int:
        """Return the rank in COMM_WORLD of a rank of this run."""
        return self.ranks[rank] if rank < len(self.ranks) else rank


@dataclass(eq=False, repr=False)
class Process:
    """This process: its rank, its open runs, and how it was stopped."""

    rank: int = 0
    """This process's rank in COMM_WORLD."""
    size: int = 1
    """The number of ranks of COMM_WORLD."""
    job: str = ""
    """The launcher's name of the job; "": it has none."""
    survives: bool = False
    """Whether the job continues when a rank is lost (`motes run --survive`)."""
    left: MPI.Intracomm | None = None
    """The surviving ranks, once a world of all ranks has lost some; None before."""
    runs: list[OpenRun] = field(default_factory=list)
    """The open runs, in the order of their start; several may be open at once."""
    entered: int = 0
    """The number of runs that this process has taken part in."""
    stopped: int = 0
    """The signal that stopped a run of this process, or 0."""

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
        """Reset the state in a process that a rank has forked."""
        self.rank, self.size, self.survives = 0, 1, False
        self.runs, self.entered, self.stopped = [], 0, 0

    def describe(self, run: OpenRun | None = None) -> str:
        """Name this rank in the given or the last opened run: "rank 2 (calculator 0), frame 7"."""
        if run is None and self.runs:
            run = self.runs[-1]
        return place(self.rank) if run is None else place(self.rank, role=run.role, frame=run.frame)


process = Process()
