"""What a world knows without asking other ranks: who this rank is, and where the run is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._run import script_lines
from ._run.settings import RunSettings
from .roles import Core

if TYPE_CHECKING:
    from mpi4py import MPI

    from . import _core
    from ._checkpoint.course import Course
    from .system import System

__all__ = ["Facts"]


class Facts:
    """The part of `World` that never communicates."""

    _comm: MPI.Intracomm
    _rank: int  # kept: a communicator may be gone when the script asks
    _size: int
    _settings: RunSettings
    _cast: Core
    _engine: _core.Engine | None
    _course: Course | None
    _systems: list[System]

    def _take_ranks(self, comm: MPI.Intracomm, cast: Core) -> None:
        """These are the world's ranks from here on, in these roles."""
        self._comm, self._rank, self._size, self._cast = comm, comm.rank, comm.size, cast

    @property
    def rank(self) -> int:
        """This process among the world's ranks."""
        return self._rank

    @property
    def size(self) -> int:
        """How many ranks the world has."""
        return self._size

    @property
    def role(self) -> set[str]:
        """The roles of this rank: any of "manager", "image_generator" and "calculator"."""
        manager, image_generator, calculators = self._cast
        played = {"manager": [manager], "image_generator": [image_generator], "calculator": calculators}
        return {name for name, ranks in played.items() if self.rank in ranks}

    @property
    def calculators(self) -> tuple[int, ...]:
        """The calculators' ranks, in the order of their domains."""
        return tuple(self._cast[2])

    @property
    def frame(self) -> int:
        """The frame that is being recorded."""
        if self._course is not None and self._course.waiting:
            return self._course.skipped
        return 0 if self._engine is None else self._engine.frame

    @property
    def time(self) -> float:
        """Seconds of the animation at the frame's start."""
        return self.frame * self.dt

    @property
    def dt(self) -> float:
        """Seconds per frame."""
        return self._settings.dt

    @property
    def seed(self) -> int | None:
        """The seed; None before a run that draws its own."""
        return self._settings.seed

    @property
    def threads(self) -> int | None:
        """This rank's threads; None before a run that leaves them to the machine."""
        return self._settings.threads

    @property
    def systems(self) -> tuple[System, ...]:
        """All systems in order of creation."""
        return tuple(self._systems)

    @property
    def timings(self) -> dict[str, float]:
        """Seconds that this rank spent in each phase of the last frame."""
        return {} if self._engine is None else self._engine.times

    def say(self, text: object) -> None:
        """Print once, on the manager.

        Args:
            text: what to print.
        """
        if self.rank == self._cast[0]:
            print(text, flush=True)

    def _facts(self) -> dict[str, Any]:
        names, axes = [system.name for system in self._systems], [system._axes for system in self._systems]
        return {**self._settings.for_log(), "systems": names, "axes": axes}

    def _line_of(self, place: tuple[int, int]) -> script_lines.Line | None:
        """Return where a call of this frame was recorded: `place` is its system and its number there."""
        system, call = place
        if system < 0 or not 0 <= call < len(self._systems[system]._lines):
            return None
        return self._systems[system]._lines[call]
