"""Session: a world's engine and ranks, and who may use the engine now."""

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
    from .recorded import Recorded

__all__ = ["Earlier", "OpenFiles", "Session", "outside"]


def outside(call: str) -> MotesError:
    """Return the error of a call before a world's start or after its end."""
    return MotesError(f"{call} works inside `with world:` only, or after world.open()")


class Earlier(Protocol):
    """Frames that an earlier run has done, behind which this one goes on."""

    waiting: bool
    """Whether the script still asks for these."""
    skipped: int

    def go_on(self) -> None:
        """Go on behind them. Collective. Does nothing a second time."""


class OpenFiles(NamedTuple):
    """What has written files and is not closed: the end of the run closes it."""

    owner: object
    close: Callable[[], None]
    """Finishes the files. Collective."""
    abandon: Callable[[], None]
    """Leaves what is whole so far."""


class Session:
    """What a world, its systems and its files share: settings, ranks, the engine, and one call at a time."""

    def __init__(self, settings: RunSettings, comm: MPI.Intracomm) -> None:
        """Begin before the run, without an engine."""
        self.settings = settings
        self.usage = Usage()
        self.engine: _core.Engine | None = None
        self.ended = False
        self.total = 0
        """Frames that the script's loop asks for; 0 where it has none."""
        self.run: OpenRun | None = None
        self.recording: Recording | None = None
        self.earlier: Earlier | None = None
        self.survives = False
        """Whether the run goes on when ranks are lost: then the engine is told of what scripts write."""
        self.systems: list[Recorded] = []
        """In order of creation."""
        self.open_views: list[Recorded] = []
        """Inside `with system.local()`, one entry per block."""
        self.files: list[OpenFiles] = []
        self.given_up: Callable[[], None] = lambda: None
        """What follows when all ranks have given up."""
        self.describe = Describing(settings.roles)
        self.take_ranks(comm, settings.roles)

    # --- ranks

    def take_ranks(self, comm: MPI.Intracomm, cast: Core) -> None:
        """These are the world's ranks from here on, in these roles."""
        self.comm, self.rank, self.size = comm, comm.rank, comm.size  # kept: a communicator may be gone
        self.cast = self.describe.cast = cast

    @property
    def role(self) -> set[str]:
        """The roles of this rank: any of "manager", "image_generator" and "calculator"."""
        manager, image_generator, calculators = self.cast
        played = {"manager": [manager], "image_generator": [image_generator], "calculator": calculators}
        return {name for name, ranks in played.items() if self.rank in ranks}

    @property
    def manages(self) -> bool:
        """Whether this rank is the manager, which speaks for all."""
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
    def time(self) -> float:
        """Seconds of the animation at the frame's start."""
        return self.frame * self.settings.dt

    def particles(self) -> int:
        """Particles on all ranks, as last agreed."""
        engine = self.engine
        return 0 if engine is None else sum(engine.count(system.index) for system in self.systems)

    # --- calls of the engine

    def engine_for(self, call: str) -> _core.Engine:
        """Return the engine; raise MotesError outside of the run."""
        if self.engine is None or self.ended:
            raise outside(call)
        return self.engine

    def begin(self, call: str, *, reads: bool = False) -> _core.Engine:
        """Start a call of the engine, which `end` ends. Raises MotesError while another one runs."""
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
        """End a call that holds no conversation."""
        self.usage.end()

    def end_conversation(self, engine: _core.Engine) -> None:
        """End a collective call. Where all ranks have given up, nobody waits for this one any more."""
        self.usage.end()
        if engine.gave_up:
            self.given_up()

    def line_of(self, place: tuple[int, int]) -> script_lines.Line | None:
        """Return where a call of this frame was recorded: `place` is its system and its number there."""
        system, call = place
        return None if system < 0 else self.systems[system].line(call)

    def facts(self) -> dict[str, Any]:
        """Return what run.json and a recorded scene say about the run."""
        names, axes = [system.name for system in self.systems], [system.axes for system in self.systems]
        return {**self.settings.for_log(), "systems": names, "axes": axes}
