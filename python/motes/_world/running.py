"""Running: a world's run from its start to its end, and its frames."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._io.output import tell
from .._picture.frame import Frame
from .._picture.rendering import PARTICLES
from .._run import busy, ending, losses, scenefile, script_lines, stopping, waiting
from .._run.excerpt import LEFT_OUT, Excerpt, check_digest, logged_digests, missing
from .._run.process import OpenRun, process
from .._run.speaking import mark
from .._run.usage import Weakly
from .._system.first_frame import remarks_on
from .._system.session import Session
from .._system.system_state import SystemState
from .._values import environment
from .._values import roles as _roles
from .._values.wall import WallForce, wall_force
from ..errors import ArgumentError, MotesError, Stopped
from ..shapes import Shape
from ..shapes import native_of as shape_of
from . import arguments as checks
from . import handshake
from .loop import Loop
from .pictures import Pictures
from .telling import Telling, warn
from .viewers import Viewers

if TYPE_CHECKING:
    from mpi4py import MPI

    from .recovering import Recovery

__all__ = ["Running"]

HIDDEN = "it was stepped over, on the way to the frame where the page was"


class Running:
    """Starts a run, ends each of its frames, and ends the run."""

    def __init__(
        self,
        session: Session,
        pictures: Pictures,
        viewers: Viewers,
        loop: Loop,
        telling: Telling,
        *,
        given: tuple[MPI.Intracomm | None, str | _roles.Roles],
    ) -> None:
        """Put a world's parts together; `given`: communicator and roles as the script passed them."""
        self.session = session
        self.pictures = pictures
        self.viewers = viewers
        self.loop = loop
        self.given = given
        self._telling = telling
        self._recovery: Recovery | None = None
        self._unseen: list[SystemState] = []  # systems whose first list has not run yet
        self._logged: dict[int, str] | None = None  # the whole run's digests, on the image generator
        self._pictured = False  # whether this process has ended a frame with a picture
        viewers.before_stopping = loop.save_now
        session.given_up = lambda: self._leave(well=False)

    def add(self, system: SystemState) -> None:
        """Add a new system."""
        self.session.systems.append(system)
        self._unseen.append(system)
        if self.session.engine is not None:
            system.define(self.session.engine)

    # --- start and end

    def start(self) -> None:
        """Start the run: `World.__enter__`."""
        session = self.session
        session.usage.check("open()")
        if session.engine is not None or session.ended:
            raise MotesError("a world runs once; make a new one")
        stopping.check_stopped()
        try:
            self._join_those_left()
            if session.settings.on_loss == "recover":
                from . import recovering

                recovering.check(session.size)
            comm, _ = self.given
            later = comm is None and session.settings.on_loss == "recover" and process.entered > 0
            session.run = handshake.begin(session.comm, without_lost=later)
            self._join_those_left()
            self._start(session.run)
        except BaseException as error:
            ending.stop_job(error, session.run)
            self._leave(well=False)
            raise

    def _join_those_left(self) -> None:
        """Use the ranks that exist now: an earlier world may have lost some since this one was created."""
        comm, roles = self.given
        joined, ranks, of = checks.ranks_of(comm)
        session = self.session
        if joined != session.comm:
            cast = _roles.cast(roles, ranks, of)
            session.take_ranks(joined, cast)
            session.settings = session.settings.of_roles(cast, _roles.speeds(roles, ranks, of))

    def _start(self, run: OpenRun) -> None:
        session = self.session
        if not stopping.interactive():
            stopping.arm()
        announce = session.settings.seed is None
        role = _core.describe_role(session.cast, session.rank)
        met = handshake.meet(run, session.comm, session.settings, role)
        settings = session.settings = met.settings
        _core.name_crashes(mark() or "", losses.lost_line())
        _core.set_place(process.describe(run))
        hosts = [peer.host for peer in run.peers]
        engine = session.engine = _core.Engine(
            comm=session.comm.py2f(),
            roles=session.cast,
            facts=settings.for_core(rank=session.rank, hosts=hosts),
            # The engine must not refer to the world: the garbage collector cannot see its references.
            while_waiting=lambda _: busy.look_around(run),
            describe=session.describe,
            warn_s=waiting.WARN_S,
            limit_s=settings.stall_s,
            life=lambda rank: (None, "") if run.watch is None else run.watch.life(rank),
            warn=lambda text: tell(f"motes: {text}"),
        )
        for system in session.systems:
            system.define(engine)
        engine.on_callback(Weakly(self._call_back))
        session.recording = scenefile.claim(engine)
        self.loop.shows_in_cell = self._telling.start(hosts)
        engine.start()
        if settings.on_loss == "recover" and session.size > 1:
            from .recovering import Recovery

            self._recovery = Recovery(self, engine, run)
            session.survives = True
        self.viewers.open(met.repeats, engine)
        if met.origin is not None:
            from .._checkpoint.resuming import Checkpoints

            steering, secure = self.viewers.steering, Weakly(self._secure)
            checkpoints = Checkpoints(run, settings, met.origin, engine, steering, secure, session.systems)
            session.earlier = self.loop.checkpoints = checkpoints
        if announce and session.manages:  # whatever `progress` is: without the seed nobody can repeat the run
            tell(f"seed {settings.seed}")
        if settings.log is not None and session.manages:
            from .._run.run_file import write_run

            facts = session.facts()
            write_run(settings.log, facts, hosts, run.threads, continued_from=settings.continued_from)

    def _secure(self) -> None:
        """Flush the files that a checkpoint counts on to disk: what viewers did, and open exports."""
        self.viewers.secure()
        for files in self.session.files:
            files.secure()

    def _call_back(self, system: int, *call: Any) -> NDArray[np.float32] | None:
        return self.session.systems[system].called(*call)

    def _leave(self, *, well: bool) -> None:
        session = self.session
        self.viewers.close()
        for files in list(session.files):
            files.abandon()
        if session.run is not None:
            handshake.close(session.run, well=well)
            stopping.disarm()

    def end(self, error: BaseException | None) -> None:
        """End the run: `World.__exit__`."""
        session = self.session
        if session.usage.inherited:  # a forked process ends only itself
            if error is not None:
                ending.end_fork(error)
            return
        session.usage.check("close()")
        well = False
        remarks: list[str] = []
        try:
            if error is not None and not isinstance(error, Stopped):
                ending.stop_job(error, session.run)  # returns only if this is the only rank
                return
            remarks = self._finish()
            self._miss_frames(told=error is not None)
            well = True
            if self.viewers.stop.signal and session.manages:
                goes_on, number = self.loop.checkpoints is not None, self.viewers.stop.signal
                tell(
                    stopping.closing_line(number, frames=session.frame, total=session.total, goes_on=goes_on)
                )
        except BaseException as failure:
            ending.stop_job(failure, session.run)
            raise
        finally:
            session.ended = True
            if self.loop.checkpoints is not None:
                self.loop.checkpoints.end()
            if self._recovery is not None:
                self._recovery.end()
            self._leave(well=well)
        for remark in remarks:
            warn(session, remark, 4)

    def _miss_frames(self, *, told: bool) -> None:
        """Say which frames of an excerpt the script lacks. Raises MotesError if it lacks all."""
        session, excerpt = self.session, self.session.settings.excerpt
        if excerpt is None or told or self.viewers.stop.signal or self.viewers.steering.stopped:
            return
        text = missing(excerpt, session.frame)
        if text and excerpt.first >= session.frame:
            failure = MotesError(text)
            failure.speaker = session.cast[0]
            raise failure
        if text and session.manages:
            tell(f"motes: {text}")

    def _finish(self) -> list[str]:
        """Close files, write the last checkpoint and finish the engine; return the engine's last remarks."""
        session = self.session
        self.viewers.end_rehearsal()
        for files in list(session.files):
            files.close()
        self.viewers.open_file()  # in case the run had no frame
        self.loop.save_now()
        self.viewers.hold_at_end()
        engine = session.begin("the end of the world")
        try:
            if self._recovery is not None:
                self._recovery.secure_films(engine)
            self._report(engine)
            engine.finish()
        finally:
            session.end()
        remarks = engine.take_remarks()
        self._telling.show(session, last=True)
        if session.recording is not None:
            session.recording.keep(session.engine_for("the end"), session.facts(), session.manages)
        return remarks

    def _report(self, engine: _core.Engine) -> None:
        """Tell `motes sweep` how a run ended that has done all its frames. Collective."""
        session, report = self.session, self.loop.report
        if report is None or report.probe or session.frame < session.total:
            return
        pictures = engine.tell(report.save_still)
        particles = engine.digest()
        if session.manages:
            picture = pictures[session.cast[1]].decode()
            report.write(
                particles=particles, picture=picture, frames=session.frame, count=session.particles()
            )

    # --- frames

    def force(self, wall: Shape) -> WallForce:
        """Return the force on a wall: `World.force`."""
        session = self.session
        if not isinstance(wall, Shape):
            raise ArgumentError("wall", wall, "a shape that is a wall of contact()")
        if session.engine is None:
            raise MotesError("force() before the run: walls are pressed only inside `with world:`")
        if session.earlier is not None and session.earlier.waiting:
            return wall_force([math.nan] * 6)
        with session.usage.during("force()"):
            force = session.engine.wall_force(shape_of(wall))
        if force is None:
            allowed = "the shape of a wall of a contact() in the last frame; a mesh at the place it had there"
            raise ArgumentError("wall", wall, allowed)
        return wall_force(force)

    def render(self) -> Frame:
        """End the frame with a picture: `World.render`."""
        if self.pictures.renderer is None:
            raise ArgumentError(
                "renderer", None, "given to World(renderer=...) before render(); step() needs none"
            )
        if self.loop.skips():
            return self._skipped()
        session, index = self.session, self.session.frame
        why = "" if self._is_drawn(index) else LEFT_OUT
        if not why and self.viewers.steering.hidden(index):
            why = HIDDEN
        if why:
            self._run("render()", None)
            self.loop.shows(None)
            return self.pictures.absent(index, why, left_out=why == LEFT_OUT)
        view = self.pictures.view(session.time)
        if (excerpt := session.settings.excerpt) is not None and excerpt.still is not None:
            view.set_linear(view.linear or excerpt.still.lower().endswith(".exr"))
        engine = self._run("render()", view)
        if session.recording is not None and not session.recording.full:
            return self.pictures.absent(index, scenefile.NO_PICTURE)
        frame = self.pictures.take(engine, index, (index + 1) * session.settings.dt, view)
        if environment.read("MOTES_REHEARSAL"):
            self.loop.shows(None)
            return self.pictures.absent(index, "a rehearsal keeps no pictures")
        if not frame and self._recovery is not None:
            self._recovery.note_picture(frame)
        if frame and session.settings.digest:
            engine.set_image_sha256(frame.digest())
        if PARTICLES in self.pictures.renderer.layers:
            engine = session.begin("render()")
            try:
                self.pictures.add_particles(engine, frame, view)
            finally:
                session.end_conversation(engine)
        if excerpt is not None:
            self._check_excerpt(engine, frame, excerpt)
        self.loop.shows(frame)
        return frame

    def _is_drawn(self, index: int) -> bool:
        excerpt = self.session.settings.excerpt
        return index >= self.loop.seeking.drawn_from and (excerpt is None or index in excerpt)

    def _check_excerpt(self, engine: _core.Engine, frame: Frame, excerpt: Excerpt) -> None:
        """Compare a picture with the whole run's log. Of `motes frame`, save it and end the job; collective.

        Raises MotesError if they differ, Stopped after the only frame.
        """

        def check() -> str:
            if frame and not environment.read("MOTES_ANYWAY"):
                log = self.session.settings.whole_log
                self._logged = logged_digests(log) if self._logged is None else self._logged
                check_digest(frame, self._logged, log)
            if frame and excerpt.still is not None:
                frame.save(excerpt.still)
                tell(f"motes: frame {frame.index} is in {excerpt.still}")
            return ""

        if excerpt.still is None:
            check()
            return
        engine.tell(check)
        raise Stopped(0)

    def seek(self, frame: int) -> None:
        """Go on with another frame: `World.seek`."""
        self.session.usage.check("seek()")
        self.loop.seeking.seek(frame, self.loop.checkpoints)

    def step(self) -> Frame:
        """End the frame without a picture: `World.step`."""
        if self.loop.skips():
            return self._skipped()
        index = self.session.frame
        self._run("step()", None)
        self.loop.shows(None)
        return self.pictures.absent(index)

    def _skipped(self) -> Frame:
        """Return the placeholder for a frame that an earlier run has computed."""
        from .._checkpoint.resuming import EARLIER

        return self.pictures.absent(self.session.frame - 1, EARLIER)

    def _run(self, call: str, view: _core.View | None) -> _core.Engine:
        session, viewers = self.session, self.viewers
        if viewers.steering.stopped or session.is_over:
            raise Stopped(0)
        if viewers.looping and self.loop.seeking.jumped:
            raise MotesError("seek() has changed the frame: `continue` with the loop's next iteration")
        if viewers.stops():
            raise Stopped(stopping.code_of(viewers.stop.signal))
        engine = session.begin(call)
        try:
            if session.open_views:
                block = f"{session.open_views[-1].name!r}`.local()`"
                raise MotesError(f"{call} inside `with` {block}: leave the block first")
            self.pictures.keep_last()
            if self._recovery is not None:
                self._recovery.tell_unsaved(engine)
            with script_lines.located(session.line_of, lambda: engine.failed_at):
                if view is None and self.pictures.renderer is not None:
                    engine.pass_camera(self.pictures.view(session.time, camera_only=True))
                engine.run_frame(view, viewers.steering.agreement())
        finally:
            session.end_conversation(engine)
        self.loop.ran = True
        viewers.after_frame(engine, pictured=view is not None)
        if session.run is not None:
            session.run.frame = engine.frame
        first_picture = view is not None and not self._pictured
        self._pictured = self._pictured or first_picture
        remarks = [
            *remarks_on(self._unseen, self.pictures.renderer if first_picture else None),
            *engine.take_remarks(),
        ]
        for remark in remarks:
            warn(session, remark, 5)
        self._unseen = [system for system in self._unseen if system.first is not None]
        for system in session.systems:
            system.forget()
        self._telling.show(session)
        return engine
