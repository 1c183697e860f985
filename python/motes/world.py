"""World: one run of an animation, from its first frame to its last."""

from __future__ import annotations

import os
import warnings
import weakref
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import TracebackType
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from . import _core, arguments, environment, scenefile
from . import roles as _roles
from . import world_arguments as checks
from ._run import busy, ending, handshake, run_file, script_lines
from ._run.output import tell
from ._run.process import OpenRun, process
from ._run.progress import Progress
from ._run.progress import check as check_progress
from ._run.settings import RunSettings
from ._run.speaking import mark
from .balance import Balancer
from .errors import ArgumentError, MotesError, MotesWarning
from .first_frame import remarks_on
from .frame import Frame
from .rendering import Renderer
from .sprites import Sprite
from .system import System
from .usage import Usage, Weakly, describe
from .values import Settings, says_near_names

__all__ = ["World"]


class World(Settings):
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
        checkpoint: None = None,
        progress: str | Callable[[dict[str, Any]], None] = "lines",
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
        pictures, one row per frame. `progress`: "lines", "bar", "off" or a function of a row. `comm`: an
        mpi4py communicator.
        """
        if checkpoint is not None:
            raise ArgumentError("checkpoint", checkpoint, "None")
        self._comm = checks.communicator(comm)
        self._settings = RunSettings(
            seed=None if seed is None else arguments.integer("seed", seed, high=2**64 - 1),
            dt=arguments.number("dt", dt, low=1e-9, high=1e9),
            substeps=arguments.integer("substeps", substeps, low=1, high=10_000),
            axis=checks.axis(axis),
            space=checks.interval(space),
            roles=_roles.cast(roles, self._comm.size),
            balancer=checks.balancer(balancer, checks.axis(axis)),
            combine=arguments.choice("combine", combine, ("one_by_one", "together", "overlapped")),
            births=environment.births(births),
            fan_out=environment.fan_out(fan_out),
            threads=environment.threads(threads),
            clock=arguments.choice("clock", clock, ("cpu", "wall")),
            digest=arguments.flag("digest", digest),
            log=checks.directory(log),
            spans=checks.spans(spans, log=log),
            speeds=_roles.speeds(roles, self._comm.size),
            stall_s=environment.stall_s(),
        )
        self._cast = self._settings.roles
        self.renderer = renderer
        self._progress_way = check_progress(progress)
        self._systems: list[System] = []
        self._names: set[str] = set()
        self._unseen: list[System] = []  # whose first list has not run yet
        self._usage = Usage()
        self._open_views: list[System] = []  # inside `with system.local()`, one entry per block
        self._engine: _core.Engine | None = None
        self._progress: Progress | None = None
        self._run_state: OpenRun | None = None
        self._recording: scenefile.Recording | None = None
        self._total = 0
        self._ran = False  # a frame, in this process
        self._rendered = False
        self._last_picture: Callable[[], Frame | None] = lambda: None
        self._ended = False

    # --- facts that never communicate

    @property
    def rank(self) -> int:
        """This process among the world's ranks."""
        return self._comm.rank

    @property
    def size(self) -> int:
        """How many ranks the world has."""
        return self._comm.size

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
        """Print once, on the manager."""
        if self.rank == self._cast[0]:
            print(text, flush=True)

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
        axes = self._settings.axis if axis == "world" else checks.axis(axis)
        cuts = self._settings.space if space is None else checks.interval(space)
        leader = None if domains_of is None else self._leader(domains_of, axis, space)
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

    def _leader(self, domains_of: Any, axis: str | None, space: Any) -> System:
        """Return the system whose domains a new one shares; its own wishes must be the same."""
        if not isinstance(domains_of, System) or domains_of.world is not self:
            raise ArgumentError("domains_of", domains_of, "None or an earlier system of this world")
        leader = self._systems[domains_of._leads]
        whose = f"that of {leader.name!r}, whose domains it shares"
        if axis != "world" and checks.axis(axis) != leader._axes:
            raise ArgumentError("axis", axis, f"{leader.axis!r}, {whose}, or not given")
        wanted = leader._definition["space"]
        if space is not None and checks.interval(space) != wanted:
            raise ArgumentError("space", space, f"{wanted!r}, {whose}, or not given")
        return leader

    def _define(self, system: System) -> None:
        assert self._engine is not None
        definition = dict(system._definition, sprite=system._sprite.core)
        self._engine.add_system(name=system.name, **definition)

    # --- the run

    def __enter__(self) -> World:
        """Start the run: communicator, roles, log. Collective."""
        if self._engine is not None or self._ended:
            raise MotesError("a world runs once; make a new one")
        try:
            self._run_state = handshake.begin(self._comm)
            self._start(self._run_state)
        except BaseException as error:
            ending.stop_job(error, self._run_state)
            self._leave(well=False)
            raise
        return self

    def _start(self, run: OpenRun) -> None:
        announce = self.seed is None
        role = _core.describe_role(self._cast, self.rank)
        settings = self._settings = handshake.meet(run, self._comm, self._settings, role)
        _core.name_crashes(mark() or "")
        _core.set_place(process.describe(run))
        hosts = [peer.host for peer in run.peers]
        self._engine = _core.Engine(
            comm=self._comm.py2f(),
            roles=self._cast,
            facts=settings.for_core(rank=self.rank, hosts=hosts),
            # The garbage collector cannot see what the engine holds: it must not hold the world.
            while_waiting=lambda _: busy.look_around(run),
            describe=partial(describe, self._cast),
            stall_s=settings.stall_s,
            alive=lambda rank: bool(run.watch and run.watch.alive(rank)),
            warn=lambda text: tell(f"motes: {text}"),
        )
        for system in self._systems:
            self._define(system)
        self._engine.on_callback(Weakly(self._call_back))
        self._recording = scenefile.claim(self._engine)
        self._progress = Progress(self._progress_way, hosts)
        self._engine.start()
        if announce and self.rank == self._cast[0]:  # whatever `progress` is: nobody could repeat the run
            tell(f"seed {self.seed}")
        if settings.log is not None and self.rank == self._cast[0]:
            run_file.write_run(settings.log, self._facts(), hosts, run.threads)

    def _facts(self) -> dict[str, Any]:
        return {
            **self._settings.for_log(),
            "systems": [system.name for system in self._systems],
            "axes": [system._axes for system in self._systems],
        }

    def _call_back(self, system: int, *call: Any) -> NDArray[np.float32] | None:
        return self._systems[system]._called(*call)

    def _leave(self, *, well: bool) -> None:
        if self._run_state is not None:
            handshake.close(self._run_state, well=well)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the run. Collective; after an exception the whole job ends."""
        well = False
        try:
            if error is not None:
                ending.stop_job(error, self._run_state)  # returns where this is the only rank
                return
            engine = self._begin("the end of the world")
            try:
                engine.finish()
            finally:
                self._usage.end()
            self._show(last=True)
            if self._recording is not None:
                self._recording.keep(self._engine_for("the end"), self._facts(), "manager" in self.role)
            well = True
        except BaseException as failure:
            ending.stop_job(failure, self._run_state)
            raise
        finally:
            self._ended = True
            self._leave(well=well)

    def open(self) -> World:
        """Start the run, as `with world:` does; for notebooks. Collective."""
        return self.__enter__()

    def close(self) -> None:
        """End the run, as leaving `with world:` does; does nothing if it has ended. Collective."""
        if not self._ended:
            self.__exit__(None, None, None)

    def frames(self, n: int) -> Iterator[int]:
        """Yield those frames of 0..n-1 that are still to do; end each pass of the loop by `render` or `step`.

        Frames count from the world's first one: after `frames(5)`, `frames(8)` yields 5, 6 and 7.
        """
        self._total = arguments.integer("n", n)
        if self.frame >= self._total and self._ran:
            self._warn(
                f"frames({n}): all {n} frames are done; frames(n) counts from the world's first frame", 3
            )
        return self._frames(self._total)

    def _frames(self, n: int) -> Iterator[int]:
        while self.frame < n:
            frame = self.frame
            yield frame
            if self.frame != frame + 1:
                raise MotesError(f"frame {frame} must end with one world.render() or world.step()")

    def render(self) -> Frame:
        """End the frame with a picture. Collective. Off the image generator the result is falsy."""
        if self.renderer is None:
            raise ArgumentError(
                "renderer", None, "given to World(renderer=...) before render(); step() needs none"
            )
        index = self.frame
        engine = self._run("render()", self.renderer.view())
        home = self._cast[1]
        time = (index + 1) * self.dt
        if self._recording is not None and not self._recording.full:
            return Frame(index, time, None, home=None, rank=self.rank, missing=scenefile.NO_PICTURE)
        kept = self.renderer.kept(engine)
        if self.rank != home:
            return Frame(index, time, None, **kept, home=home, rank=self.rank)
        pixels = engine.take_pixels(self.renderer.width, self.renderer.height)
        frame = Frame(index, time, pixels, **kept, home=home, rank=self.rank)
        self._last_picture = weakref.ref(frame)
        if self._settings.digest:
            engine.set_image_sha256(frame.digest())
        return frame

    def step(self) -> Frame:
        """End the frame without a picture. Collective. The result is falsy, and saving it does nothing."""
        index = self.frame
        self._run("step()", None)
        return Frame(index, (index + 1) * self.dt, None, home=None, rank=self.rank)

    def _run(self, call: str, view: _core.View | None) -> _core.Engine:
        engine = self._begin(call)
        try:
            if self._open_views:
                name = self._open_views[-1].name
                raise MotesError(f"{call} inside `with` {name!r}`.local()`: leave the block first")
            picture = self._last_picture()
            if picture is not None:
                picture._keep_all()  # the engine forgets it
            with script_lines.located(self._line_of, lambda: engine.failed_at):
                engine.run_frame(view)
        finally:
            self._end_call(engine)
        self._ran = True
        if self._run_state is not None:
            self._run_state.frame = engine.frame
        self._look_at_first_frames(view)
        for remark in engine.take_remarks():
            self._warn(remark, 4)
        for system in self._systems:
            system._list.clear()
            system._lines.clear()
            system._callbacks.clear()
        self._show()
        return engine

    def _line_of(self, place: tuple[int, int]) -> script_lines.Line | None:
        """Return where a call of this frame was recorded: `place` is its system and its number there."""
        system, call = place
        if system < 0 or not 0 <= call < len(self._systems[system]._lines):
            return None
        return self._systems[system]._lines[call]

    def _look_at_first_frames(self, view: _core.View | None) -> None:
        """Warn, once per system, of what its first frame with births probably lacks."""
        renderer = None
        if view is not None and not self._rendered:
            self._rendered, renderer = True, self.renderer
        for remark in remarks_on(self._unseen, renderer):
            self._warn(remark, 5)
        self._unseen = [system for system in self._unseen if system._first is not None]

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
            raise MotesError(f"{call} works inside `with world:` only")
        return self._engine

    def _end_call(self, engine: _core.Engine) -> None:
        """End what `_begin` started. Where all ranks have given up, nobody waits for this one any more."""
        self._usage.end()
        if engine.gave_up:
            self._leave(well=False)

    def _begin(self, call: str, *, reads: bool = False) -> _core.Engine:
        """Start a call of the engine, which `_usage.end` ends. Raises MotesError while another one runs."""
        engine = self._engine_for(call)
        self._usage.begin(call)
        for system in self._open_views if reads else ():
            if len(system._list) != system._views[0]:
                self._usage.end()
                raise MotesError(
                    f"{call} inside `with` {system.name!r}`.local()`, after more was recorded for it: "
                    "its views would no longer show its particles; leave the block first"
                )
        return engine
