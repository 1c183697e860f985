"""World: one run of an animation, from its first frame to its last."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal

from .. import _extras
from .._live.controls import Choice, Control
from .._picture.frame import Frame
from .._picture.rendering import Renderer
from .._picture.sprites import Sprite
from .._run.progress import LINES
from .._run.progress import check as check_progress
from .._system.session import Session
from .._system.system import System
from .._system.system_state import SystemState
from .._values import arguments, environment
from .._values import roles as _roles
from .._values.checkpoint import Checkpoint
from .._values.live import Live
from .._values.space import bits_of
from .._values.values import Settings, says_near_names
from .._values.wall import WallForce
from ..balance import Balancer
from ..errors import MotesError
from ..shapes import Shape
from . import arguments as checks
from .loop import Loop
from .pictures import Pictures
from .running import Running
from .telling import Telling
from .viewers import Viewers

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["World", "running_of", "session_of"]


class World(Settings):
    """A world of particle systems, and the loop of its frames (the paper's Algorithm 1).

    Every rank makes the same calls; the engine gives each its role. The phases of a frame are
    create -> act -> move -> agree -> exchange -> render::

        with world:
            for frame in world.frames(100):
                ...                          # births and actions of the systems, recorded
                world.render().save(...)     # the manager distributes births, calculators act and
                                             # move, particles go to their owners, a picture comes back
    """

    renderer: Renderer | None
    """How pictures are drawn; may change between frames."""

    _checks = {"renderer": checks.renderer}

    @says_near_names
    def __init__(
        self,
        *,
        seed: int | None = None,
        dt: float = 1 / 24,
        substeps: int = 1,
        axis: Literal["x", "y", "z", "xy", "xz", "yz", "xyz", "hilbert", "morton"] | None = "x",
        space: tuple[float, float] | Literal["fit"] | None = None,
        periodic: Mapping[str, tuple[float, float]] | None = None,
        roles: Literal["auto", "shared"] | _roles.Roles = "auto",
        balancer: Balancer | None = None,
        renderer: Renderer | None = None,
        combine: Literal["one_by_one", "together", "overlapped"] = "together",
        births: Literal["auto", "manager", "calculators"] = "auto",
        fan_out: int = 8,
        threads: int | None = None,
        clock: Literal["cpu", "wall"] = "cpu",
        log: str | os.PathLike[str] | None = None,
        spans: bool = False,
        digest: bool = False,
        checkpoint: Checkpoint | str | os.PathLike[str] | None = None,
        on_loss: Literal["stop", "recover"] = "stop",
        live: Live | int | None = None,
        steering: str | os.PathLike[str] | None = None,
        progress: Literal["lines", "bar", "off"] | Callable[[dict[str, Any]], None] = "lines",
        comm: MPI.Intracomm | None = None,
    ) -> None:
        """Take the run's settings; nothing starts before `with world:`.

        Args:
            seed: 0..2^64-1; None: rank 0 draws one, which the run prints and logs.
            dt: seconds per frame.
            substeps: how many times per frame the recorded list runs, each time for dt / substeps.
            axis: what domains cut. One axis makes slabs, two or three ("xy", "xyz") make bricks by recursive
                bisection; "hilbert" and "morton" cut that curve through 256^3 cells of `space`, or of the
                periods; None assigns particles to calculators by id, regardless of position.
            space: the interval in metres that domains divide at the start, the same along each axis: (lo,
                hi); None: the paper's infinite space; "fit": quantiles of the first births. Along periodic
                axes, domains divide the period.
            periodic: periodic axes and their bounds in metres, such as {"x": (0, 10)}: positions wrap into
                [low, high), and particles interact across the boundary. None: no periodic axes.
            roles: "auto": one rank plays all; of three or more, rank 0 draws, rank 1 manages, and the others
                calculate (the paper). "shared": every rank calculates. Or Roles(...).
            balancer: a balancer of `motes.balance`; None: cuts do not move.
            renderer: what `render` draws; may change between frames.
            combine: how several systems share a frame (paper 3.3). "one_by_one"; "together": one message per
                pair of ranks for all systems; "overlapped": one system's messages travel while the next
                computes.
            births: who creates newborn particles: the "manager", which sends them to their owners, or the
                "calculators", each its part. "auto" chooses for each frame by the number of births. The
                particles are the same.
            fan_out: each rank relays the manager's messages to at most this many others.
            threads: threads per rank; any number gives the same bits. None: the processors that this process
                may use, shared among the ranks of its host. `MOTES_THREADS` takes precedence.
            clock: how a calculator's load is measured: "cpu", the CPU time of its threads divided by their
                number, unaffected by other processes; or "wall".
            log: a directory for the run's log; None: no log.
            spans: also log a timeline of each rank.
            digest: also log hashes of particles and picture for each frame.
            checkpoint: a directory, or Checkpoint(directory, every=48, keep=2): all particles are written
                there every `every` frames, and a later run of the script continues from the newest complete
                checkpoint.
            on_loss: what happens when a rank is killed. "stop": the job ends; "recover", under `motes run
                --survive`: the other ranks take over its work and continue with the same bits.
            live: a port, or Live(port=8080): the run can be seen and steered in a browser.
            steering: the steer.jsonl of a live run, whose orders are repeated at the same frames.
            progress: "lines" (notebooks show a bar and the last picture instead); "bar"; "off"; or a function
                that takes a row of the log.
            comm: an mpi4py communicator; None: all ranks.

        Raises:
            ArgumentError: if a setting is not allowed; the message says what is.
        """
        joined, ranks, of = checks.ranks_of(comm)
        if environment.read("MOTES_REHEARSAL"):
            roles = "auto"  # it has one rank
        cast = _roles.cast(roles, ranks, of)
        settings = checks.settings(
            cast=cast,
            speeds=_roles.speeds(roles, ranks, of),
            **{"seed": seed, "dt": dt, "substeps": substeps, "axis": axis, "space": space},
            **{"periodic": periodic},
            **{"balancer": balancer, "combine": combine, "births": births, "fan_out": fan_out},
            **{"threads": threads, "clock": clock, "log": log, "spans": spans, "digest": digest},
            **{"checkpoint": checkpoint, "on_loss": on_loss, "live": live, "steering": steering},
        )
        if settings.live is not None:
            _extras.require_live()
        self.renderer = renderer
        telling = Telling(check_progress(progress), progress == LINES)
        self._session = session = Session(settings, joined)
        self._systems: list[System] = []
        self._names: set[str] = set()
        self._pictures = pictures = Pictures(session, lambda: self.renderer)
        self._viewers = viewers = Viewers(session, pictures)
        self._loop = loop = Loop(session, viewers)
        self._running = Running(session, pictures, viewers, loop, telling, given=(comm, roles))

    # --- systems

    @says_near_names
    def system(
        self,
        name: str,
        *,
        capacity: int | None = None,
        sprite: Sprite | None = None,
        axis: Literal["world", "x", "y", "z", "xy", "xz", "yz", "xyz", "hilbert", "morton"] | None = "world",
        space: tuple[float, float] | Literal["fit"] | None = None,
        domains_of: System | None = None,
        attributes: Mapping[str, Any] | None = None,
    ) -> System:
        """Create a particle system; every rank makes the same calls in the same order.

        Args:
            name: a string that no other system of this world has.
            capacity: most particles alive at once; births beyond it are dropped and counted. None: no limit.
            sprite: how its particles are drawn; None: Sprite().
            axis: what its domains cut, as in `World`; "world": the same as the world's.
            space: the interval in metres that its domains divide at the start; None: the world's.
            domains_of: an earlier system whose domains this one always shares: particles of both systems in
                the same place have the same owner. Balancers see the sum of both loads, and weigh all
                particles equally when they place a cut.
            attributes: extra float32 columns with their initial values, such as {"heat": 0.0, "wind": (0, 0,
                0)}.

        Returns:
            The system, which records births and actions.

        Raises:
            MotesError: if the world has ended.
        """
        session, settings = self._session, self._session.settings
        checks.system_name(name, taken=self._names)
        if capacity is not None:
            capacity = arguments.integer("capacity", capacity, high=2**62)
        axes = checks.axis(axis, settings.axis)
        cuts = settings.space if space is None else checks.interval(space)
        leader = None if domains_of is None else checks.leader(session.systems, domains_of, axis, space)
        if leader is not None:
            axes, cuts = leader.axes, leader.definition["space"]
        checks.check_room(axes, cuts, settings.periodic)
        if space is not None:
            checks.check_periods(axes, cuts, settings.periodic)
        checks.balancer(settings.balancer, axes)
        shown = checks.sprite(sprite)
        definition = {
            "capacity": capacity,
            "axes": bits_of(axes),
            "domains_of": -1 if leader is None else leader.index,
            "space": cuts,
            "sprite": shown,
            "attributes": checks.user_attributes(
                {} if attributes is None else attributes, settings.periodic, shown
            ),
            "periods": settings.periodic,
        }
        state = SystemState(session, len(self._systems), name, axes, definition)
        system = System(self, state)
        if session.ended:
            raise MotesError("this world has ended; make a new one")
        with session.usage.during("system()"):
            self._systems.append(system)
            self._names.add(name)
            self._running.add(state)
        return system

    # --- the run

    def __enter__(self) -> World:
        """Start the run: communicator, roles, log, files. Collective.

        Returns:
            The world itself.

        Raises:
            MotesError: if the world has run already; a world runs once.
            ScriptMismatchError: if ranks were given different settings.
            LogError: if the log cannot be written.
        """
        self._running.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the run. Collective; after an exception the whole job ends.

        Args:
            kind: the class of the exception that left the block, or None.
            error: the exception, or None.
            trace: its traceback, or None.
        """
        self._running.end(error)

    def open(self) -> World:
        """Start the run: an alias of `with world:` for notebooks. Collective.

        Returns:
            The world itself.
        """
        return self.__enter__()

    def close(self) -> None:
        """End the run: an alias of leaving `with world:`; does nothing if it has ended. Collective."""
        if not self._session.ended:
            self.__exit__(None, None, None)

    def render(self) -> Frame:
        """End the frame with a picture. Collective.

        Returns:
            The picture; on ranks other than the image generator it is falsy, and saving it does nothing.

        Raises:
            RankError: if a rank failed; all ranks raise it.
            ScriptMismatchError: if ranks recorded different lists; all ranks raise it.
            Stopped: when a signal or a viewer has stopped the run.
        """
        return self._running.render()

    def step(self) -> Frame:
        """End the frame without a picture. Collective. Raises the same errors as `render`.

        Returns:
            A frame without a picture: it is falsy, and saving it does nothing.
        """
        return self._running.step()

    def digest(self) -> str:
        """Hash every particle of every system, all columns. Collective.

        Returns:
            Hexadecimal digits; equal particles give equal digits for any number of ranks and any order in
            memory.
        """
        engine = self._session.begin("digest()", reads=True)
        try:
            return engine.digest()
        finally:
            self._session.end_conversation(engine)

    # --- the loop of frames

    def frames(self, n: int) -> Iterator[int]:
        """Yield the frames of 0..n-1 that are still to do. Collective: every rank runs the same loop.

        Each iteration must end its frame with `render` or `step`. Frames count from the world's first one:
        after `frames(5)`, `frames(8)` yields 5, 6 and 7. A world with checkpoints continues from the newest
        complete one, if any, and writes new ones between iterations. SIGINT (Ctrl-C), SIGTERM or SIGUSR1 on
        any rank ends the loop on all ranks once its frame is done. At a prompt or in a notebook, Ctrl-C then
        raises KeyboardInterrupt, and another `frames(n)` continues.

        Args:
            n: the total number of frames of the run.

        Yields:
            The number of the frame to record.

        Raises:
            MotesError: if called outside `with world:`, or if an iteration did not end its frame.
        """
        return self._loop.frames(n)

    def seek(self, frame: int) -> None:
        """Go on with another frame, as between two iterations of `frames`. Collective.

        The world goes on from the newest checkpoint that is not later than `frame`, or from where it is, if
        that is nearer. Without such a checkpoint it goes back by starting from frame 0 again. The loop of
        `frames` then yields the frames from there; those before `frame` are computed without pictures:
        `render` returns frames that are falsy. Each picture is the one that an undisturbed run makes if what
        the loop records depends only on the frame's number and the particles.

        Args:
            frame: the next frame to draw; at most the loop's last, or the loop ends before it is drawn.

        Raises:
            ArgumentError: for an earlier frame, if there is no checkpoint before it and the script recorded
                particles before its loop; or if the world has a log or an open export, whose frames are in
                order.
            MotesError: outside the run, or if actions have been recorded for the current frame.
        """
        self._running.seek(frame)

    # --- viewers

    @says_near_names
    def control(
        self,
        name: str,
        value: Any,
        *,
        low: float | None = None,
        high: float | None = None,
        step: float | None = None,
        choices: Sequence[Choice] | None = None,
        group: str | None = None,
    ) -> Control:
        """Let viewers of a live run set `Control.value`; without viewers it stays `value`.

        Every rank makes the same calls. The value is the same on all ranks and changes only between frames,
        when the loop of `frames` begins its next iteration. If `value` and all bounds are ints, it is an int.

        Args:
            name: a string that no other control of this world has.
            value: the initial value: a number, a bool, a colour as text ("orange", "#ff8800"), which becomes
                "#rrggbb", or one of `choices`.
            low: the lower bound; required for a number.
            high: the upper bound; required for a number.
            step: the increment, counted from `low`; None: any number between the bounds.
            choices: the strings or numbers to choose from; None: it is a number, a bool or a colour.
            group: the heading under which the page shows it; None: it stands above all groups.

        Returns:
            The control; the script reads its `value` in each frame.

        Raises:
            MotesError: if the world has ended.
        """
        return self._viewers.control(name, value, low, high, step, choices, group)

    @property
    def live_url(self) -> str | None:
        """The address of the run's live page, on the image generator; None elsewhere."""
        return self._viewers.url

    def redraw(self) -> Frame:
        """Draw the particles once more, as they are between two frames. Collective.

        No frame is computed or counted; what has been recorded for the next frame has no effect. The camera
        is where viewers have moved it, or the current `renderer.camera`.

        Returns:
            The picture; on ranks other than the image generator it is falsy.

        Raises:
            ArgumentError: if particles were read partway through the frame's list, or the world has no
                renderer.
        """
        return self._viewers.redraw()

    # --- known without communication

    @property
    def rank(self) -> int:
        """This process's rank in the world."""
        return self._session.rank

    @property
    def size(self) -> int:
        """The number of the world's ranks."""
        return self._session.size

    @property
    def role(self) -> set[str]:
        """The roles of this rank: any of "manager", "image_generator" and "calculator"."""
        return self._session.role

    @property
    def calculators(self) -> tuple[int, ...]:
        """The calculators' ranks, in the order of their domains."""
        return tuple(self._session.cast[2])

    def force(self, wall: Shape) -> WallForce:
        """Return the force of particles on a wall of `contact`; means over the last frame's sub-steps.

        The forces of all systems that touched the wall add up, exactly, so any number of ranks returns the
        same bits. Does not communicate. For frames that an earlier run computed, the numbers are NaN.

        Args:
            wall: the shape that `contact` was given in the last frame, or an equal one. A mesh that moves is
                recognised by its place at the frame's end; if it is the only wall made of this mesh, at any
                place.

        Returns:
            `force`, N, and `torque`, N m about the wall's origin: the first point of a shape (a plane's
            `point`, a box's lower corner, the start of a cylinder's axis, the centre of a sphere or disc), a
            mesh's own origin, the origin of the first part of a union.

        Raises:
            ArgumentError: if no contact had such a wall in the last frame, or if meshes at several places
                match.
            MotesError: if called before `with world:`.
        """
        return self._running.force(wall)

    @property
    def frame(self) -> int:
        """The frame that is being recorded."""
        return self._session.frame

    @property
    def time(self) -> float:
        """The animation time at the frame's start, in seconds."""
        return self._session.time

    @property
    def dt(self) -> float:
        """Seconds per frame."""
        return self._session.settings.dt

    @property
    def seed(self) -> int | None:
        """The seed; None before the start of a run that draws its own."""
        return self._session.settings.seed

    @property
    def threads(self) -> int | None:
        """The number of this rank's threads; None before the start of a run with `threads=None`."""
        return self._session.settings.threads

    @property
    def systems(self) -> tuple[System, ...]:
        """All systems in order of creation."""
        return tuple(self._systems)

    @property
    def timings(self) -> dict[str, float]:
        """Seconds that this rank spent in each phase of the last frame."""
        return {} if self._session.engine is None else self._session.engine.times

    def say(self, text: object) -> None:
        """Print a text once, on the manager.

        Args:
            text: what to print.
        """
        if self._session.manages:
            print(text, flush=True)


def running_of(world: World) -> Running:
    """Return a world's `Running`, for the rest of the package."""
    return world._running


def session_of(world: World) -> Session:
    """Return a world's `Session`, for the rest of the package."""
    return world._session
