"""World: one run of an animation, from its first frame to its last."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core, _extras, arguments, environment, scenefile
from . import roles as _roles
from . import world_arguments as checks
from ._live import repeating
from ._notebook import kernel
from ._run import busy, ending, handshake, losses, recovering, script_lines, stopping, waiting
from ._run.output import tell
from ._run.process import OpenRun, process
from ._run.progress import LINES, Progress
from ._run.progress import check as check_progress
from ._run.settings import RunSettings
from ._run.speaking import mark
from .balance import Balancer
from .checkpoint import Checkpoint
from .checkpoint import checked as checkpoint_of
from .errors import ArgumentError, MotesError, MotesWarning, Stopped
from .first_frame import remarks_on
from .frame import Frame
from .live import Live
from .live import checked as live_of
from .looping import Looping, outside
from .rendering import Renderer
from .sprites import Sprite
from .system import System
from .usage import Describing, Usage, Weakly
from .values import Settings, says_near_names
from .world_facts import Facts

if TYPE_CHECKING:
    from mpi4py import MPI

    from ._checkpoint.course import Course

__all__ = ["World"]


class World(Looping, Facts, Settings):
    """A world of particle systems, and the loop of its frames (the paper's Algorithm 1).

    Every rank makes the same calls; the engine gives each its role. A frame goes
    create -> act -> move -> agree -> exchange -> render::

        with world:
            for frame in world.frames(100):
                ...                          # births and actions of the systems, recorded
                world.render().save(...)     # the manager distributes births, calculators act and
                                             # move, particles go to their owners, a picture comes back
    """

    renderer: Renderer | None
    """What pictures look like; may change between frames."""

    _checks = {"renderer": checks.renderer}

    @says_near_names
    def __init__(
        self,
        *,
        seed: int | None = None,
        dt: float = 1 / 24,
        substeps: int = 1,
        axis: str | None = "x",
        space: tuple[float, float] | str | None = None,
        roles: str | _roles.Roles = "auto",
        balancer: Balancer | None = None,
        renderer: Renderer | None = None,
        combine: str = "together",
        births: str = "manager",
        fan_out: int = 8,
        threads: int | None = None,
        clock: str = "cpu",
        log: str | os.PathLike[str] | None = None,
        spans: bool = False,
        digest: bool = False,
        checkpoint: Checkpoint | str | os.PathLike[str] | None = None,
        on_loss: str = "stop",
        live: Live | int | None = None,
        steering: str | os.PathLike[str] | None = None,
        progress: str | Callable[[dict[str, Any]], None] = LINES,
        comm: MPI.Intracomm | None = None,
    ) -> None:
        """Take the run's settings; nothing is started before `with world:`.

        `seed`: 0..2^64-1, or None for one that rank 0 draws. `dt`: seconds per frame, in which the recorded
        list runs `substeps` times. `axis`: what domains cut: one axis makes slabs; two or three, "xy", "xyz",
        make bricks, by halving space again and again; None deals particles out by id, wherever they are.
        `space`: the interval (m) that they divide at the start, the same along each axis: (lo, hi), None for
        the paper's infinite space, or "fit" for quantiles of the first births. `roles`: "auto", "shared" or
        Roles(...). `balancer`: one of motes.balance; None keeps cuts. `renderer`: what `render` draws.
        `combine`: how several systems share a frame (paper 3.3): "one_by_one", "together" (one message per
        pair of ranks for all systems) or "overlapped" (the messages of one travel while the next computes).
        `births`: who creates newborn particles: the "manager", which distributes them, or the "calculators",
        each its part; the particles are the same. `fan_out`: each rank relays the manager's messages to at
        most this many others (docs/growth.md measures the benefit of both with many ranks). `threads`: of
        each rank; the bits are the same. None: the processors that it may use, shared among the ranks of its
        host (`MOTES_THREADS` overrides). `clock`: what measures a calculator's load: "cpu" (processor time of
        its threads, which other processes do not lengthen, divided by their number) or "wall". `log`: a
        directory. `spans`: also log a timeline of each rank. `digest`: also log fingerprints of particles and
        pictures, one row per frame. `checkpoint`: a directory, or Checkpoint(directory, every=48, keep=2):
        every so many frames all particles go there, and a later run of the script goes on behind the newest
        whole one (docs/checkpoints.md). `on_loss`: what follows when a rank is killed: "stop" ends the job;
        with "recover", under `motes run --survive`, the others take over its work and go on with the same
        bits. `live`: a port, or Live(port=8080): the run can be seen and steered in a browser. `steering`:
        the steer.jsonl of such a run, whose orders happen again (docs/live.md). `progress`: "lines", in a
        notebook a bar and the last picture below the cell (docs/notebooks.md), "bar", "off" or a function of
        a row. `comm`: an mpi4py communicator.
        """
        self._given = (comm, roles)
        joined, ranks, of = checks.ranks_of(comm)
        cast = _roles.cast(roles, ranks, of)
        self._take_ranks(joined, cast)
        self._settings = RunSettings(
            seed=None if seed is None else arguments.integer("seed", seed, high=2**64 - 1),
            dt=arguments.number("dt", dt, low=1e-9, high=1e9),
            substeps=arguments.integer("substeps", substeps, low=1, high=10_000),
            axis=checks.axis(axis),
            space=checks.interval(space),
            roles=cast,
            balancer=checks.balancer(balancer, checks.axis(axis)),
            combine=arguments.choice("combine", combine, ("one_by_one", "together", "overlapped")),
            births=environment.births(births),
            fan_out=environment.fan_out(fan_out),
            threads=environment.threads(threads),
            clock=arguments.choice("clock", clock, ("cpu", "wall")),
            digest=arguments.flag("digest", digest),
            log=checks.directory(log),
            spans=checks.spans(spans, log=log),
            speeds=_roles.speeds(roles, ranks, of),
            stall_s=environment.stall_s(),
            checkpoint=checkpoint_of(checkpoint),
            on_loss=arguments.choice("on_loss", on_loss, ("stop", "recover")),
            live=live_of(live),
            steering=repeating.checked(steering),
        )
        if self._settings.live is not None:
            _extras.require_live()
        self._describe = Describing(cast)
        self.renderer = renderer
        self._progress_way = check_progress(progress)
        self._progress_in_cell = progress == LINES and environment.read("MOTES_PROGRESS") is None
        self._systems: list[System] = []
        self._names: set[str] = set()
        self._unseen: list[System] = []  # whose first list has not run yet
        self._usage = Usage()
        self._open_views: list[System] = []  # inside `with system.local()`, one entry per block
        self._engine: _core.Engine | None = None
        self._progress: Progress | None = None
        self._run_state: OpenRun | None = None
        self._course: Course | None = None  # of its checkpoints
        self._recording: scenefile.Recording | None = None
        self._recovery: recovering.Recovery | None = None
        self._total = 0
        self._ran = self._rendered = False  # a frame, in this process
        self._last_picture: Callable[[], Frame | None] = lambda: None
        self._ended = False
        self._stop = stopping.Stop()
        self._exports: list[Any] = []  # that have written and are not closed
        self._init_steering(self._settings)

    # --- systems

    @says_near_names
    def system(
        self,
        name: str,
        *,
        capacity: int | None = None,
        sprite: Sprite | None = None,
        axis: str | None = "world",
        space: tuple[float, float] | str | None = None,
        domains_of: System | None = None,
        attributes: Mapping[str, Any] | None = None,
    ) -> System:
        """Create a particle system; every rank makes the same calls in the same order.

        `capacity`: most particles alive at once; births beyond it are dropped and counted. `attributes`:
        extra float32 columns with their initial values, e.g. {"heat": 0.0, "wind": (0, 0, 0)}. `axis` and
        `space` override the world's. `domains_of`: an earlier system whose domains this one shares, always:
        the same calculator then owns what is in the same place. Balancers see the sum of both loads, and
        count all particles alike where they look for a cut.
        """
        checks.system_name(name, taken=self._names)
        if capacity is not None:
            capacity = arguments.integer("capacity", capacity, high=2**62)
        axes = checks.axis(axis, self._settings.axis)
        cuts = self._settings.space if space is None else checks.interval(space)
        leader = None if domains_of is None else checks.leader(self._systems, domains_of, axis, space)
        if leader is not None:
            axes, cuts = leader._axes, leader._definition["space"]
        checks.balancer(self._settings.balancer, axes)
        definition = {
            "capacity": capacity,
            "axes": checks.axes_bits(axes),
            "domains_of": -1 if leader is None else leader._index,
            "space": cuts,
            "sprite": checks.sprite(sprite),
            "attributes": checks.user_attributes({} if attributes is None else attributes),
        }
        made = System(self, len(self._systems), name, axes, definition)
        if self._ended:
            raise MotesError("this world has ended; make a new one")
        with self._usage.during("system()"):
            self._systems.append(made)
            self._unseen.append(made)
            self._names.add(name)
            if self._engine is not None:
                self._define(made)
        return made

    def _define(self, system: System) -> None:
        assert self._engine is not None
        definition = dict(system._definition, sprite=system._sprite.core)
        self._engine.add_system(name=system.name, **definition)

    # --- the run

    def __enter__(self) -> World:
        """Start the run: communicator, roles, log. Collective."""
        self._usage.check("open()")
        if self._engine is not None or self._ended:
            raise MotesError("a world runs once; make a new one")
        stopping.check_stopped()
        try:
            self._join_those_left()
            recovering.check(self._settings.on_loss, self.size)
            later = self._given[0] is None and self._settings.on_loss == "recover" and process.entered > 0
            self._run_state = handshake.begin(self._comm, without_lost=later)
            self._join_those_left()
            self._start(self._run_state)
        except BaseException as error:
            ending.stop_job(error, self._run_state)
            self._leave(well=False)
            raise
        return self

    def _join_those_left(self) -> None:
        """Take the ranks that are there now: an earlier world may have lost some since this one was made."""
        comm, roles = self._given
        joined, ranks, of = checks.ranks_of(comm)
        if joined != self._comm:
            cast = _roles.cast(roles, ranks, of)
            self._take_ranks(joined, cast)
            self._describe.cast = cast
            self._settings = self._settings._replace(roles=cast, speeds=_roles.speeds(roles, ranks, of))

    def _start(self, run: OpenRun) -> None:
        if not stopping.interactive():
            stopping.arm()
        announce = self.seed is None
        role = _core.describe_role(self._cast, self.rank)
        settings = self._settings = handshake.meet(run, self._comm, self._settings, role)
        _core.name_crashes(mark() or "", losses.lost_line())
        _core.set_place(process.describe(run))
        hosts = [peer.host for peer in run.peers]
        self._engine = _core.Engine(
            comm=self._comm.py2f(),
            roles=self._cast,
            facts=settings.for_core(rank=self.rank, hosts=hosts),
            # The garbage collector cannot see what the engine holds: it must not hold the world.
            while_waiting=lambda _: busy.look_around(run),
            describe=self._describe,
            warn_s=waiting.WARN_S,
            limit_s=settings.stall_s,
            life=lambda rank: (None, "") if run.watch is None else run.watch.life(rank),
            warn=lambda text: tell(f"motes: {text}"),
        )
        for system in self._systems:
            self._define(system)
        self._engine.on_callback(Weakly(self._call_back))
        self._recording = scenefile.claim(self._engine)
        in_cell = self._progress_in_cell and self.size == 1 and kernel.running()
        self._progress = Progress("off" if in_cell else self._progress_way, hosts)
        self._shows_in_cell = in_cell
        self._engine.start()
        if settings.on_loss == "recover" and self.size > 1:
            self._recovery = recovering.Recovery(self, self._engine, run)
        self._open_steering(run, settings, self._engine)
        if run.found is not None:
            from ._checkpoint.course import Course

            self._course = Course(
                run, settings, run.found, self._engine, self._steering, Weakly(self._secure_steering)
            )
        if announce and self.rank == self._cast[0]:  # whatever `progress` is: nobody could repeat the run
            tell(f"seed {self.seed}")
        if settings.log is not None and self.rank == self._cast[0]:
            from ._run.run_file import write_run

            write_run(settings.log, self._facts(), hosts, run.threads, continued_from=settings.continued_from)

    def _call_back(self, system: int, *call: Any) -> NDArray[np.float32] | None:
        return self._systems[system]._called(*call)

    def _leave(self, *, well: bool) -> None:
        self._close_steering()
        for export in list(self._exports):
            export._abandon()
        if self._run_state is not None:
            handshake.close(self._run_state, well=well)
            stopping.disarm()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the run. Collective; after an exception the whole job ends."""
        if self._usage.inherited:  # a fork has nothing to end but itself
            if error is not None:
                ending.end_fork(error)
            return
        self._usage.check("close()")
        well = False
        remarks: list[str] = []
        try:
            if error is not None and not isinstance(error, Stopped):
                ending.stop_job(error, self._run_state)  # returns where this is the only rank
                return
            for export in list(self._exports):
                export.close()
            self._open_steer_file()  # of a run without a frame
            if self._course is not None:
                self._course.save_now(self.frame, self._systems)
            engine = self._begin("the end of the world")
            try:
                if self._recovery is not None:
                    self._recovery.secure_films(engine)
                engine.finish()
            finally:
                self._usage.end()
            remarks = engine.take_remarks()
            self._show(last=True)
            if self._recording is not None:
                self._recording.keep(self._engine_for("the end"), self._facts(), "manager" in self.role)
            well = True
            if self._stop.signal and "manager" in self.role:
                goes_on = self._course is not None
                number = self._stop.signal
                tell(stopping.closing_line(number, frames=self.frame, total=self._total, goes_on=goes_on))
        except BaseException as failure:
            ending.stop_job(failure, self._run_state)
            raise
        finally:
            self._ended = True
            if self._course is not None:
                self._course.end()
            if self._recovery is not None:
                self._recovery.end()
            self._leave(well=well)
        for remark in remarks:
            self._warn(remark, 3)

    def open(self) -> World:
        """Start the run, as `with world:` does; for notebooks. Collective."""
        return self.__enter__()

    def close(self) -> None:
        """End the run, as leaving `with world:` does; does nothing if it has ended. Collective."""
        if not self._ended:
            self.__exit__(None, None, None)

    def render(self) -> Frame:
        """End the frame with a picture. Collective. Off the image generator the result is falsy."""
        if self.renderer is None:
            raise ArgumentError(
                "renderer", None, "given to World(renderer=...) before render(); step() needs none"
            )
        if self._course is not None and self._course.skip(self._systems):
            return self._skipped()
        index = self.frame
        view = self._view(self.time)
        engine = self._run("render()", view)
        time = (index + 1) * self.dt
        if self._recording is not None and not self._recording.full:
            return Frame(index, time, None, home=None, rank=self.rank, missing=scenefile.NO_PICTURE)
        frame = self._picture(engine, index, time, view)
        if not frame and self._recovery is not None:
            self._recovery.note_picture(frame)
        if frame and self._settings.digest:
            engine.set_image_sha256(frame.digest())
        self._show_viewers(frame)
        return frame

    def step(self) -> Frame:
        """End the frame without a picture. Collective. The result is falsy, and saving it does nothing."""
        if self._course is not None and self._course.skip(self._systems):
            return self._skipped()
        index = self.frame
        self._run("step()", None)
        self._show_viewers(None)
        return Frame(index, (index + 1) * self.dt, None, home=None, rank=self.rank)

    def _skipped(self) -> Frame:
        """Return what stands for a frame that an earlier run has done."""
        from ._checkpoint.course import EARLIER

        index = self.frame - 1
        return Frame(index, (index + 1) * self.dt, None, home=None, rank=self.rank, missing=EARLIER)

    def _run(self, call: str, view: _core.View | None) -> _core.Engine:
        if self._steering.stopped:
            raise Stopped(0)
        if self._stops():
            raise Stopped(stopping.code_of(self._stop.signal))
        engine = self._begin(call)
        try:
            if self._open_views:
                block = f"{self._open_views[-1].name!r}`.local()`"
                raise MotesError(f"{call} inside `with` {block}: leave the block first")
            picture = self._last_picture()
            if picture is not None:
                picture._keep_all()  # the engine forgets it
            if self._recovery is not None:
                self._recovery.tell_unsaved(engine)
            with script_lines.located(self._line_of, lambda: engine.failed_at):
                engine.run_frame(view, self._steering.agreement())
        finally:
            self._end_call(engine)
        self._ran = True
        self._after_frame(engine, pictured=view is not None)
        if self._run_state is not None:
            self._run_state.frame = engine.frame
        first_picture = view is not None and not self._rendered
        self._rendered = self._rendered or first_picture
        remarks = [
            *remarks_on(self._unseen, self.renderer if first_picture else None),
            *engine.take_remarks(),
        ]
        for remark in remarks:
            self._warn(remark, 4)
        self._unseen = [system for system in self._unseen if system._first is not None]
        for system in self._systems:
            system._forget_list()
        self._show()
        return engine

    def _warn(self, text: str, level: int) -> None:
        if self.rank == self._cast[0]:
            warnings.warn(text, MotesWarning, stacklevel=level)

    def _show(self, *, last: bool = False) -> None:
        if self.rank == self._cast[0] and self._progress is not None and self._engine is not None:
            self._progress.update(self._engine.last_row, total=self._total, last=last)

    def digest(self) -> str:
        """Hash every particle of every system, all columns. Collective.

        Equal particles give equal digests, whatever the number of ranks and the order in memory.
        """
        engine = self._begin("digest()", reads=True)
        try:
            return engine.digest()
        finally:
            self._end_call(engine)

    def _engine_for(self, call: str) -> _core.Engine:
        if self._engine is None or self._ended:
            raise outside(call)
        return self._engine

    def _end_call(self, engine: _core.Engine) -> None:
        """End what `_begin` started. Where all ranks have given up, nobody waits for this one any more."""
        self._usage.end()
        if engine.gave_up:
            self._leave(well=False)

    def _begin(self, call: str, *, reads: bool = False) -> _core.Engine:
        """Start a call of the engine, which `_usage.end` ends. Raises MotesError while another one runs."""
        engine = self._engine_for(call)
        if reads and self._course is not None:
            self._course.go_on(self._systems)
        self._usage.begin(call)
        for system in self._open_views if reads else ():
            if len(system._list) != system._views[0]:
                self._usage.end()
                raise MotesError(
                    f"{call} inside `with` {system.name!r}`.local()`, after more was recorded for it: "
                    "its views would no longer show its particles; leave the block first"
                )
        return engine
