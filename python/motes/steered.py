"""The part of `World` that viewers see: controls, redraws, and the border between two frames."""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from . import _core, scenefile
from ._checkpoint import same_script
from ._live.pose import Pose
from ._live.steer_file import NAME, SteerFile
from ._live.steering import Steering
from ._run import stopping
from ._run.output import tell
from ._run.settings import RunSettings
from .controls import Choice, Control
from .errors import ArgumentError, MotesError
from .frame import Frame
from .live import Live
from .rendering import Renderer, kept
from .usage import EngineCalls, Weakly
from .values import at, says_near_names

if TYPE_CHECKING:
    from ._live.viewing import Viewing
    from ._run.process import OpenRun

__all__ = ["Steered"]

BEAT_S = 1.0  # how often ranks of a paused run hear from each other


class Steered(EngineCalls):
    """Viewers of a live run, their orders, and the record of these."""

    renderer: Renderer | None
    _recording: scenefile.Recording | None
    _run_state: OpenRun | None
    _stop: stopping.Stop
    _total: int
    _last_picture: Callable[[], Frame | None]

    if TYPE_CHECKING:

        def _stops(self) -> bool: ...

    def _init_steering(self, settings: RunSettings) -> None:
        """Start with what the arguments say, before the run."""
        live = settings.live
        self._steering = Steering(
            paused=live is not None and live.paused, wait=live is not None and live.wait
        )
        self._viewing: Viewing | None = None
        self._steer_file: SteerFile | None = None
        self._live = False  # there may be viewers: the same on all ranks
        self._writes_steering = False
        self._looping = False  # inside the loop of `frames`
        self._attached = False  # to a notebook, which looks on and steers

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
    ) -> Control:
        """Let viewers of a live run set `Control.value`; without viewers it stays `value`.

        Every rank makes the same calls. The value is the same on all ranks, and changes between two frames
        only: where the loop of `frames` begins its next pass. With whole numbers for `value` and all bounds
        it is an int.

        Args:
            name: a text that no other control of this world has.
            value: what it is set to at first: a number, a bool, or one of `choices`.
            low: the least number; needed for a number.
            high: the largest number; needed for a number.
            step: numbers go from `low` in steps of this; None: any number between the bounds.
            choices: the texts or numbers that it can be; None: it is a number or a bool.

        Returns:
            The control, whose `value` the script reads in each frame.

        Raises:
            MotesError: if the world has ended.
        """
        if self._ended:
            raise MotesError("this world has ended; make a new one")
        with self._usage.during("control()"):
            control = self._steering.control(name, value, low, high, step, choices)
            if self._viewing is not None:
                self._viewing.know(self._steering.controls)
        return control

    @property
    def live_url(self) -> str | None:
        """Where the run can be seen: the page's address, on the image generator; None elsewhere."""
        return None if self._viewing is None else self._viewing.url

    def redraw(self) -> Frame:
        """Draw the particles as they are between two frames once more. Collective.

        Nothing is computed and nothing counts as a frame: what was recorded for the next one is not in it.
        The picture is seen from where viewers look, or from where `renderer.camera` is now.

        Returns:
            The picture; on other ranks than the image generator it is falsy.

        Raises:
            ArgumentError: if particles were read after some of the frame's list, or the world has no
                renderer.
        """
        if self.renderer is None:
            raise ArgumentError("renderer", None, "given to World(renderer=...) before redraw()")
        engine = self._begin("redraw()", reads=True)
        index = max(self.frame - 1, 0)
        time = self.frame * self.dt
        try:
            if self._recording is not None and not self._recording.full:
                return Frame(index, time, None, home=None, rank=self.rank, missing=scenefile.NO_PICTURE)
            picture = self._last_picture()
            if picture is not None:
                picture._keep_all()  # the engine forgets it
            view = self._view(index * self.dt)
            engine.redraw(view, self._steering.agreement())
        finally:
            self._end_call(engine)
        return self._picture(engine, index, time, view)

    # --- pictures

    def _view(self, time: float) -> _core.View:
        """Return what the renderer shows at a time (s), from where viewers look."""
        assert self.renderer is not None
        pose = self._steering.camera
        return self.renderer._view(time, None if pose is None else tuple(pose))

    def _picture(self, engine: _core.Engine, index: int, time: float, view: _core.View) -> Frame:
        """Return the picture that the engine has made of a view."""
        home = self._cast[1]
        pixels = engine.take_pixels(view.width, view.height) if self.rank == home else None
        frame = Frame(index, time, pixels, **kept(view, engine), home=home, rank=self.rank)
        if frame:
            self._last_picture = weakref.ref(frame)
        return frame

    # --- from the run's start to its end

    def _open_steering(self, run: OpenRun, settings: RunSettings, engine: _core.Engine) -> None:
        """Serve viewers, where the run has them, and begin the record of what they do."""
        if run.repeats is not None:
            self._steering.rows = run.repeats.rows
        if self._recording is not None and not self._recording.full:
            return
        self._live = self._live or settings.live is not None
        if settings.live is not None and settings.log is None and self.rank == self._cast[0]:
            tell("motes: what viewers do is not kept: the run has no log")
        self._take_part(settings, engine)

    def _take_part(self, settings: RunSettings, engine: _core.Engine) -> None:
        """Record what viewers do, or serve them, where that is this rank's part."""
        earlier = settings.continued_from > 0 and os.path.exists(os.path.join(settings.log or "", NAME))
        wanted = self._live or settings.steering is not None or earlier
        self._writes_steering = wanted and settings.log is not None and self.rank == self._cast[0]
        if self._live and self.rank == self._cast[1]:
            if self._viewing is None:
                self._serve(settings.live)
            engine.on_orders(Weakly(self._take_orders))

    def _serve_again(self) -> None:
        """Ranks were lost: what they did for viewers is done by those that have their roles now."""
        if self._engine is not None and (self._recording is None or self._recording.full):
            self._take_part(self._settings, self._engine)

    def _serve(self, live: Live | None, **about: Any) -> Viewing:
        """Serve viewers from now on; `about` is said of the run beside what it says itself."""
        from ._live.viewing import Viewing

        assert live is not None
        told = self._attached and stopping.interactive()  # a widget shows the page
        viewing = Viewing(live, self._about() | about, self._settings.steering, quiet=told)
        viewing.know(self._steering.controls)
        self._viewing = viewing
        return viewing

    def _attach(self, title: str) -> Viewing:
        """Let a notebook look on and steer a world of one rank, from its next border on."""
        self._attached = self._live = True
        settings = self._settings
        viewing = self._viewing or self._serve(settings.live or Live(0), title=title)
        if self._engine is not None:
            self._writes_steering = settings.log is not None
            self._engine.on_orders(Weakly(self._take_orders))
        return viewing

    def _detach(self) -> None:
        """Take the world back from the notebook: no pause, no stop and no camera of a viewer is left."""
        self._attached = False
        if self._settings.live is None:
            self._live = False
            if self._viewing is not None:
                self._tell_viewers()
                self._viewing.close()
                self._viewing = None
        self._steering.release()

    def _about(self) -> dict[str, Any]:
        import sys

        title = os.path.basename(sys.argv[0]) if sys.argv and sys.argv[0] else "motes"
        size = (0, 0) if self.renderer is None else (self.renderer.width, self.renderer.height)
        return {"title": title, "width": size[0], "height": size[1], "repeats": self._settings.steering}

    def _take_orders(self) -> str:
        """Return what viewers ask for, when the engine can carry it to all ranks."""
        if self._viewing is None:
            return ""
        near = 0.0 if self.renderer is None else at(self.renderer.camera.near, self.time)
        return self._viewing.take(self._pose, near)

    def _pose(self) -> Pose | None:
        if self._steering.camera is not None or self.renderer is None:
            return self._steering.camera
        return Pose.of(self.renderer.camera, self.time)

    def _show_viewers(self, frame: Frame | None) -> None:
        """The frame has ended: show its picture, and come to the border, unless `frames` does that."""
        if self._viewing is not None and frame is not None:
            self._viewing.show(frame)
            self._viewing.keep_pace(self.dt)
        if not self._looping:
            self._at_border()

    def _after_frame(self, engine: _core.Engine, *, pictured: bool) -> None:
        """All ranks have heard what viewers asked for during the frame."""
        self._steering.shown = pictured
        if self._live:
            self._steering.hear(engine.orders)

    def _close_steering(self) -> None:
        if self._viewing is not None:
            self._tell_viewers()
            self._viewing.close()
            self._viewing = None
        if self._steer_file is not None:
            self._steer_file.close()

    # --- the border

    def _at_border(self) -> bool:
        """Obey viewers before the next frame; tell whether the run ends here. Collective in a live run."""
        if self._live:
            self._hold()
        if self._stops():
            return True
        row = self._steering.commit(self.frame)
        if self._steering.stopped:
            self._note_stop("the run that is repeated" if self._steering.rows else "a viewer")
            return True
        if self._viewing is not None:
            self._viewing.begin_picture()
        self._open_steer_file()
        if row:
            self._write_row(row)
        self._tell_viewers()
        return False

    def _hold(self) -> None:
        """Wait while the run is paused, with new pictures for viewers who look around."""
        if not self._steering.held:
            return
        self._tell_viewers()
        stall_s = self._settings.stall_s
        beat_s = BEAT_S if stall_s is None else min(BEAT_S, stall_s / 4)
        stopping.arm()  # a notebook takes Ctrl-C back for each cell
        try:
            while self._steering.held and not self._stops():
                self._ask_viewers(beat_s)
        finally:
            stopping.disarm()

    def _ask_viewers(self, most_s: float) -> None:
        """Let all ranks hear what viewers ask for, as soon as they do, or after so many seconds."""
        if self._viewing is not None:
            self._viewing.wait(most_s)
        engine = self._begin("a pause")
        try:
            engine.hear_orders(self._steering.agreement())
        finally:
            self._end_call(engine)
        self._stop.ask_again()
        self._steering.hear(engine.orders)
        if not self._steering.shown and self._steering.held and self.renderer is not None:
            self._show_again()
        self._tell_viewers()

    def _show_again(self) -> None:
        if self._viewing is not None:
            self._viewing.begin_picture()
        frame = self.redraw()
        self._steering.shown = True
        if self._viewing is not None:
            self._viewing.show(frame)

    def _tell_viewers(self) -> None:
        if self._viewing is not None:
            self._viewing.tell(self._steering, frame=self.frame, total=self._total)

    def _open_steer_file(self) -> None:
        """Begin steer.jsonl, once the script has made its controls; on the manager of a steered run."""
        settings = self._settings
        if self._steer_file is not None or not self._writes_steering:
            return
        assert settings.log is not None
        header = {
            "seed": settings.seed,
            "script_sha256": same_script.facts()["sha256"],
            "controls": {name: one._definition for name, one in self._steering.controls.items()},
        }
        self._steer_file = SteerFile(settings.log, header, continued_from=settings.continued_from)

    def _write_row(self, row: dict[str, Any]) -> None:
        self._open_steer_file()
        if self._steer_file is not None:
            self._steer_file.add(self.frame, row)

    def _secure_steering(self) -> None:
        """Wait until the disk has what viewers did so far: a checkpoint is about to be written."""
        if self._steer_file is not None:
            self._steer_file.secure()

    def _note_stop(self, who: str | None) -> None:
        """Write that the run ends before this frame, and say why, where no signal did it."""
        if self._attached:  # a notebook says it by itself, and its next cell may go on
            return
        self._write_row({"stop": True})
        if who is not None and self.rank == self._cast[0]:
            of = f" of {self._total}" if self._total else ""
            tell(f"motes: stopped by {who} after frame {self.frame}{of}")
