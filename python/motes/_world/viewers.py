"""Viewers: controls, redraws, and the border between two frames, where viewers' requests take effect."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from .. import _core
from .._io.output import tell
from .._live.controls import Choice, Control, definition_of
from .._live.pose import Pose
from .._live.steer_file import NAME, SteerFile
from .._picture.frame import Frame
from .._run import same_script, scenefile, stopping
from .._run.settings import RunSettings
from .._run.usage import Weakly
from .._system.session import Session
from .._values import environment
from .._values.live import Live
from .._values.values import at
from ..errors import ArgumentError, MotesError
from .pictures import Pictures

if TYPE_CHECKING:
    from .._live.repeating import Repeated
    from .._live.viewing import Viewing

__all__ = ["Viewers"]

BEAT_S = 1.0  # longest interval between two messages among the ranks of a paused run


class Viewers:
    """The viewers of a live run, their orders, and the record of the orders."""

    def __init__(self, session: Session, pictures: Pictures) -> None:
        """Create the viewers of a world whose run has not begun."""
        self._session = session
        self._pictures = pictures
        self.steering = pictures.steering
        """What viewers did, as all ranks agreed on it."""
        self.stop = stopping.Stop()
        self.before_stopping: Callable[[], None] = lambda: None
        """Called at the border where a signal stops the run. Collective."""
        self.looping = False
        """Whether the script is inside the loop of `frames`."""
        self.attached = False
        """Whether a notebook shows and steers the run."""
        self._viewing: Viewing | None = None
        self._steer_file: SteerFile | None = None
        self._live = False  # whether there may be viewers; equal on all ranks
        self._writes_steering = False
        self._finished = False  # whether the run is past its last frame

    def control(
        self,
        name: str,
        value: Any,
        low: float | None,
        high: float | None,
        step: float | None,
        choices: Sequence[Choice] | None,
        group: str | None,
    ) -> Control:
        """Declare a control for viewers: `World.control`."""
        if self._session.ended:
            raise MotesError("this world has ended; make a new one")
        with self._session.usage.during("control()"):
            control = self.steering.control(name, value, low, high, step, choices, group)
            if self._viewing is not None:
                self._viewing.know(self.steering.controls)
        return control

    @property
    def url(self) -> str | None:
        """The address of the run's page, on the image generator; None elsewhere."""
        return None if self._viewing is None else self._viewing.url

    def redraw(self) -> Frame:
        """Return another picture of the current particles: `World.redraw`."""
        session = self._session
        if self._pictures.renderer is None:
            raise ArgumentError("renderer", None, "given to World(renderer=...) before redraw()")
        engine = session.begin("redraw()", reads=True)
        index = max(session.frame - 1, 0)
        time = session.time
        try:
            if session.recording is not None and not session.recording.full:
                return Frame(index, time, None, home=None, rank=session.rank, missing=scenefile.NO_PICTURE)
            self._pictures.keep_last()
            view = self._pictures.view(index * session.settings.dt)
            engine.redraw(view, self.steering.agreement())
        finally:
            session.end_conversation(engine)
        return self._pictures.take(engine, index, time, view)

    def stops(self) -> bool:
        """Return whether the run stops at this border, as all ranks have agreed. Collective if it stops."""
        if self.attached and stopping.interactive():
            return False  # Ctrl-C is meant for the notebook's cell, and the run is not in it
        engine = self._session.engine
        if engine is not None and self.stop.due(engine.stop_asked, self._session.frame):
            self._note_stop(None)
            self.before_stopping()
            self.stop.take(engine.stop_asked)
        return self.stop.signal > 0

    # --- from the run's start to its end

    def open(self, repeats: Repeated | None, engine: _core.Engine) -> None:
        """Serve viewers if the run has them, and begin the record of what they do."""
        session, settings = self._session, self._session.settings
        if repeats is not None:
            self.steering.rows = repeats.rows
        if session.recording is not None and not session.recording.full:
            return
        self._live = self._live or settings.live is not None
        if settings.live is not None and settings.log is None and session.manages:
            tell("motes: what viewers do is not recorded: the run has no log")
        self._take_part(settings, engine)

    def _take_part(self, settings: RunSettings, engine: _core.Engine) -> None:
        """Record what viewers do on the manager; serve viewers on the image generator."""
        earlier = settings.continued_from > 0 and os.path.exists(os.path.join(settings.log or "", NAME))
        wanted = self._live or settings.steering is not None or earlier
        self._writes_steering = wanted and settings.log is not None and self._session.manages
        if self._live and self._session.draws:
            if self._viewing is None:
                self._serve(settings.live)
            engine.on_orders(Weakly(self._take_orders))

    def serve_again(self) -> None:
        """After a loss, let the ranks that took over the roles serve viewers."""
        session = self._session
        if session.engine is not None and (session.recording is None or session.recording.full):
            self._take_part(session.settings, session.engine)

    def _serve(self, live: Live | None, **about: Any) -> Viewing:
        """Serve viewers from now on; `about` is added to the run's description."""
        from .._live.viewing import Viewing
        from . import balancing

        assert live is not None
        quiet = self.attached and stopping.interactive()  # then a widget shows the page
        viewing = Viewing(live, self._about() | about, self._session.settings.steering, quiet=quiet)
        viewing.know(self.steering.controls)
        viewing.judge(lambda call: balancing.policy(call, self._session).name)
        viewing.resize(self._resize)
        self._viewing = viewing
        return viewing

    def _resize(self, ranks: int) -> None:
        """Ask the launcher for another number of ranks, in a thread of its own: it answers when it can."""
        from .._launch.resizing import LAUNCHER, Size, ask  # few runs change their ranks

        address, run = os.environ.get(LAUNCHER), self._session.settings.log or "the run"
        if address is None:
            raise ValueError("the number of ranks changes only under `motes run` and `motes live`")
        if self._finished:
            raise ValueError("the run is past its last frame")

        def request() -> None:
            try:
                ask(address, Size(ranks), run)
            except MotesError as error:
                if (viewing := self._viewing) is not None:
                    viewing.refuse(str(error))

        threading.Thread(target=request, name="motes-resize", daemon=True).start()

    def attach(self, title: str) -> Viewing:
        """Let a notebook show and steer a world of one rank, from its next border on."""
        self.attached = self._live = True
        settings = self._session.settings
        viewing = self._viewing or self._serve(settings.live or Live(0), title=title)
        if self._session.engine is not None:
            self._writes_steering = settings.log is not None
            self._session.engine.on_orders(Weakly(self._take_orders))
        return viewing

    def detach(self) -> None:
        """Detach the world from the notebook; cancel the viewer's pause, stop and camera."""
        self.attached = False
        if self._session.settings.live is None:
            self._live = False
            if self._viewing is not None:
                self._tell_viewers()
                self._viewing.close()
                self._viewing = None
        self.steering.release()

    def _about(self) -> dict[str, Any]:
        from . import balancing

        title = os.path.basename(sys.argv[0]) if sys.argv and sys.argv[0] else "motes"
        renderer = self._pictures.renderer
        size = (0, 0) if renderer is None else (renderer.width, renderer.height)
        return {
            "title": title,
            "width": size[0],
            "height": size[1],
            "dt": self._session.settings.dt,
            "repeats": self._session.settings.steering,
            **balancing.menu(self._session),
        }

    def _take_orders(self) -> str:
        """Return the viewers' requests; the engine calls this when it can send them to all ranks."""
        if self._viewing is None:
            return ""
        renderer = self._pictures.renderer
        near = 0.0 if renderer is None else at(renderer.camera.near, self._session.time)
        return self._viewing.take(self._pose, near)

    def _pose(self) -> Pose | None:
        if self.steering.camera is not None or self._pictures.renderer is None:
            return self.steering.camera
        return Pose.of(self._pictures.renderer.camera, self._session.time)

    def show(self, frame: Frame | None) -> None:
        """Show the picture of the frame that ended, and call `at_border`, unless `frames` calls it."""
        if self._viewing is not None and frame is not None:
            self._viewing.show(frame)
            self._viewing.keep_pace(self._session.settings.dt)
        if not self.looping:
            self.at_border()

    def after_frame(self, engine: _core.Engine, *, pictured: bool) -> None:
        """Apply the viewers' requests that all ranks received during the frame."""
        self.steering.shown = pictured
        if self._live:
            self.steering.hear(engine.orders)

    def close(self) -> None:
        """Stop serving viewers and close the record."""
        if self._viewing is not None:
            self._tell_viewers()
            self._viewing.close()
            self._viewing = None
        if self._steer_file is not None:
            self._steer_file.close()

    # --- the border

    def at_border(self) -> bool:
        """Apply viewers' orders before the next frame; return whether to stop. Collective in a live run."""
        if self._live:
            self._hold()
        if self.stops():
            return True
        self.end_rehearsal(self._session.frame)
        row = self.steering.commit(self._session.frame)
        if row:
            from . import balancing

            balancing.apply(row, self._session)
        if self.steering.stopped:
            self._note_stop("the repeated run" if self.steering.rows else "a viewer")
            return True
        if self._viewing is not None:
            self._viewing.begin_picture()
        self.open_file()
        row |= self._resized()
        if row:
            self._write_row(row)
            if self._viewing is not None:
                self._viewing.note(self._session.frame, row)
        self._tell_viewers()
        return False

    def end_rehearsal(self, frame: int | None = None) -> None:
        """End the process if it rehearses and has run its frames, or (None) the script's last one."""
        frames = environment.read("MOTES_REHEARSAL")
        if frames is not None and (frame is None or frame >= frames):
            with contextlib.suppress(OSError, ValueError):
                sys.stdout.flush()
            os._exit(0)  # nothing of the script's end may run: it would write files

    def hold_at_end(self) -> None:
        """After the last frame, let viewers of the desk look around as long as they like. Collective."""
        if not self._live or self.steering.stopped or self.stop.signal:
            return
        self._finished = True
        self._wait(lambda: self.steering.stays and not self.steering.stopped)

    def _hold(self) -> None:
        """Wait while the run is paused; redraw for viewers who move the camera."""
        self._wait(lambda: self.steering.held)

    def _wait(self, holds: Callable[[], bool]) -> None:
        """Obey viewers, and redraw for those who move the camera, as long as the run `holds`."""
        if not holds():
            return
        self._tell_viewers()
        stall_s = self._session.settings.stall_s
        beat_s = BEAT_S if stall_s is None else min(BEAT_S, stall_s / 4)
        stopping.arm()  # a notebook resets the handler of Ctrl-C for each cell
        try:
            while holds() and not self.stops():
                self._ask_viewers(beat_s, holds)
        finally:
            stopping.disarm()

    def _ask_viewers(self, most_s: float, holds: Callable[[], bool]) -> None:
        """Share viewers' requests with all ranks, as soon as there are any or after `most_s` seconds."""
        if self._viewing is not None:
            self._viewing.wait(most_s)
        engine = self._session.begin("a pause")
        try:
            engine.hear_orders(self.steering.agreement())
        finally:
            self._session.end_conversation(engine)
        self.stop.ask_again()
        self.steering.hear(engine.orders)
        if not self.steering.shown and holds() and self._pictures.renderer is not None:
            self._show_again()
        self._tell_viewers()

    def _show_again(self) -> None:
        if self._viewing is not None:
            self._viewing.begin_picture()
        frame = self.redraw()
        self.steering.shown = True
        if self._viewing is not None:
            self._viewing.show(frame)

    def _tell_viewers(self) -> None:
        if self._viewing is not None:
            from . import balancing

            watched = self._viewing.watched
            facts: dict[str, Any] = balancing.state(self._session, self.steering) if watched else {}
            facts |= {"frame": self._session.frame, "total": self._session.total, "finished": self._finished}
            self._viewing.tell(self.steering, self._pose, **facts)

    def open_file(self) -> None:
        """Begin steer.jsonl on the manager of a steered run, once the script has created its controls."""
        settings = self._session.settings
        if self._steer_file is not None or not self._writes_steering:
            return
        assert settings.log is not None
        header = {
            "seed": settings.seed,
            "script_sha256": same_script.facts()["sha256"],
            "controls": {name: definition_of(one) for name, one in self.steering.controls.items()},
        }
        self._steer_file = SteerFile(
            settings.log, header, ranks=self._session.size, continued_from=settings.continued_from
        )

    def _resized(self) -> dict[str, Any]:
        """Return, once, what the record says of another number of ranks than before."""
        if self._steer_file is None or self._steer_file.resized is None:
            return {}
        ranks, self._steer_file.resized = self._steer_file.resized, None
        return {"resize": ranks}

    def _write_row(self, row: dict[str, Any]) -> None:
        self.open_file()
        if self._steer_file is not None:
            self._steer_file.add(self._session.frame, row)

    def secure(self) -> None:
        """Flush the record of viewers to disk, before a checkpoint is written."""
        if self._steer_file is not None:
            self._steer_file.secure()

    def _note_stop(self, who: str | None) -> None:
        """Record that the run ends before this frame; print who stopped it, if it was no signal."""
        if self.attached:  # a notebook reports it, and its next cell may continue the run
            return
        self._write_row({"stop": True})
        if who is not None and self._session.manages:
            of = f" of {self._session.total}" if self._session.total else ""
            tell(f"motes: stopped by {who} after frame {self._session.frame}{of}")
