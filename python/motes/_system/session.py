"""Session: a world's engine and ranks, and a guard against simultaneous calls of the engine."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from .. import _core
from .._run import script_lines
from .._run.settings import RunSettings
from .._run.usage import Describing, Usage
from .._values.roles import Core
from ..errors import MotesError

if TYPE_CHECKING:
    from mpi4py import MPI

    from .._run.process import OpenRun
    from .._run.scenefile import Recording
    from .system_state import SystemState

__all__ = ["Earlier", "OpenFiles", "Session", "outside"]


def outside(call: str) -> MotesError:
    """Return the error for a call before a world's start or after its end."""
    return MotesError(f"{call} works only inside `with world:` or after world.open()")


class Earlier(Protocol):
    """Frames that an earlier run has computed; this run continues after them."""

    waiting: bool
    """Whether the script is still at these frames."""
    skipped: int

    def go_on(self) -> None:
        """Continue after these frames; do nothing if that has happened already. Collective."""


class OpenFiles(NamedTuple):
    """An object with open output files; the end of the run closes them."""

    owner: object
    close: Callable[[], None]
    """Finishes the files. Collective."""
    abandon: Callable[[], None]
    """Closes the files early, keeping what is complete so far."""
    secure: Callable[[], None]
    """Waits until this rank's part of all frames so far is on disk."""


class Session:
    """What a world, its systems and its files share: settings, ranks and the engine."""

    def __init__(self, settings: RunSettings, comm: MPI.Intracomm) -> None:
        """Create the session of a world whose run has not begun."""
        self.settings = settings
        self.usage = Usage()
        self.engine: _core.Engine | None = None
        self.ended = False
        self.total = 0
        """The number of frames of the script's loop; 0 if it has no loop."""
        self.run: OpenRun | None = None
        self.recording: Recording | None = None
        self.earlier: Earlier | None = None
        self.survives = False
        """Whether the run continues when ranks are lost: then the engine must know what scripts write."""
        self.systems: list[SystemState] = []
        """All systems in order of creation."""
        self.open_views: list[SystemState] = []
        """The systems of the open `with system.local()` blocks, one entry per block."""
        self.files: list[OpenFiles] = []
        self.given_up: Callable[[], None] = lambda: None
        """Called once all ranks have given up."""
        self.describe = Describing(settings.roles)
        self.take_ranks(comm, settings.roles)

    # --- ranks

    def take_ranks(self, comm: MPI.Intracomm, cast: Core) -> None:
        """Set the world's communicator and roles from here on."""
        self.comm, self.rank, self.size = comm, comm.rank, comm.size  # still needed once `comm` is freed
        self.cast = self.describe.cast = cast

    @property
    def role(self) -> set[str]:
        """The roles of this rank: any of "manager", "image_generator" and "calculator"."""
        manager, image_generator, calculators = self.cast
        played = {"manager": [manager], "image_generator": [image_generator], "calculator": calculators}
        return {name for name, ranks in played.items() if self.rank in ranks}

    @property
    def manages(self) -> bool:
        """Whether this rank is the manager."""
        return self.rank == self.cast[0]

    @property
    def draws(self) -> bool:
        """Whether this rank is the image generator."""
        return self.rank == self.cast[1]

    # --- time

    @property
    def frame(self) -> int:
        """The frame that is being recorded."""
        if self.earlier is not None and self.earlier.waiting:
            return self.earlier.skipped
        return 0 if self.engine is None else self.engine.frame

    @property
    def is_over(self) -> bool:
        """Whether the frames that this job draws are done."""
        excerpt = self.settings.excerpt
        return excerpt is not None and excerpt.over(self.frame)

    @property
    def time(self) -> float:
        """The animation time at the frame's start, in seconds."""
        return self.frame * self.settings.dt

    def particles(self) -> int:
        """Return the number of particles on all ranks, as last agreed."""
        engine = self.engine
        return 0 if engine is None else sum(engine.count(system.index) for system in self.systems)

    # --- calls of the engine

    def engine_for(self, call: str) -> _core.Engine:
        """Return the engine; raise MotesError outside the run."""
        if self.engine is None or self.ended:
            raise outside(call)
        return self.engine

    def begin(self, call: str, *, reads: bool = False) -> _core.Engine:
        """Start a call of the engine, to be ended by `end`. Raises MotesError while another one runs.

        `reads`: the call reads particles; it is refused in a `local()` block once more has been recorded.
        """
        engine = self.engine_for(call)
        if reads and self.earlier is not None:
            self.earlier.go_on()
        self.usage.begin(call)
        for system in self.open_views if reads else ():
            if len(system.entries) != system.views[0]:
                self.usage.end()
                raise MotesError(
                    f"{call} inside `with` {system.name!r}`.local()`, after more was recorded for it: "
                    "its views would no longer show its particles; leave the block first"
                )
        return engine

    def end(self) -> None:
        """End a call that does not communicate."""
        self.usage.end()

    def end_conversation(self, engine: _core.Engine) -> None:
        """End a collective call. If all ranks have given up, leave the run: no rank waits for this one."""
        self.usage.end()
        if engine.gave_up:
            self.given_up()

    def line_of(self, place: tuple[int, int]) -> script_lines.Line | None:
        """Return the line that recorded a call of this frame; `place`: its system, its index in the list."""
        system, call = place
        return None if system < 0 else self.systems[system].line(call)

    def facts(self) -> dict[str, Any]:
        """Return the facts about the run for run.json and recorded scenes."""
        names, axes = [system.name for system in self.systems], [system.axes for system in self.systems]
        return {**self.settings.for_log(), "systems": names, "axes": axes}
