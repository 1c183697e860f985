"""Loop: yields a world's frames in order, saves checkpoints between them, shows progress in notebooks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from .._picture.frame import Frame
from .._run import stopping, sweeping
from .._system.session import Session, outside
from .._values import arguments
from ..errors import MotesError
from .seeking import Seeking
from .telling import warn
from .viewers import Viewers

if TYPE_CHECKING:
    from .._checkpoint.resuming import Checkpoints
    from .._notebook.cells import CellProgress

__all__ = ["Loop"]


class Loop:
    """The loop of a world's frames, and the checkpoints between them."""

    def __init__(self, session: Session, viewers: Viewers) -> None:
        """Create the loop of a world whose run has not begun."""
        self._session = session
        self._viewers = viewers
        self.checkpoints: Checkpoints | None = None
        """Writes checkpoints and restores them; None: the run has none."""
        self.ran = False
        """Whether this process has run a frame."""
        self.shows_in_cell = False
        """Whether a notebook shows the loop."""
        self._in_cell: CellProgress | None = None
        self.report: sweeping.Report | None = None
        """What `motes sweep` wants to know of this world; None: it does not run the script."""
        self.seeking = Seeking(session)

    def frames(self, n: int) -> Iterator[int]:
        """Check the argument of `World.frames`, and return an iterator over the numbers of its frames."""
        session = self._session
        session.usage.check("frames()")
        if session.ended:
            raise outside("frames()")
        session.total = arguments.integer("n", n)
        if session.frame >= session.total and self.ran:
            text = f"frames({n}): all {n} frames are done; frames(n) counts from the world's first frame"
            warn(session, text, 4)
        return self._frames(session.total)

    def _frames(self, n: int) -> Iterator[int]:
        session, viewers = self._session, self._viewers
        self._in_cell = None
        if self._probed():
            return
        try:
            while True:
                if self.checkpoints is not None:
                    self.checkpoints.at_border(session.frame)
                if session.frame >= n or session.is_over or viewers.at_border():
                    return
                frame = session.frame
                if frame == 0:
                    self.seeking.note_start()
                self.seeking.sought = self.seeking.jumped = False
                self._show_in_cell()
                viewers.looping = True
                stopping.arm()  # a notebook resets the handler of Ctrl-C for each cell
                yield frame
                if session.frame != frame + 1 and not self.seeking.sought:
                    raise MotesError(f"frame {frame} must end with one world.render() or world.step()")
                viewers.looping = False
        finally:
            viewers.looping = False
            stopping.disarm()
            self._show_in_cell(last=True)

    def _probed(self) -> bool:
        """Report to `motes sweep`, if it runs the script; return whether it only asks for the controls."""
        self.report = self.report or sweeping.claim()
        if self.report is None or not self.report.probe:
            return False
        if self._session.manages:
            self.report.write_controls(self._viewers.steering.controls, self._session.settings.axis)
        return True

    def skips(self) -> bool:
        """Return whether an earlier run has already computed the frame that ends. Collective."""
        return self.checkpoints is not None and self.checkpoints.skip()

    def save_now(self) -> None:
        """Write a checkpoint and wait until it is complete, if the run has checkpoints. Collective."""
        if self.checkpoints is not None:
            self.checkpoints.save_now(self._session.frame)

    def shows(self, frame: Frame | None) -> None:
        """Show a finished frame to viewers and in the notebook; None: a frame without a picture."""
        if frame and self.report is not None:
            self.report.last = frame
        if frame and self._in_cell is not None:
            self._in_cell.picture(frame.pixels, frame.index)
        self._viewers.show(frame)

    def _show_in_cell(self, *, last: bool = False) -> None:
        """Update the progress display in a notebook; do nothing elsewhere."""
        if not self.shows_in_cell or self._viewers.attached:
            return
        session = self._session
        if self._in_cell is None:
            if not last:
                from .._notebook.cells import CellProgress

                self._in_cell = CellProgress(session.total, session.frame, session.particles())
        elif last or self._in_cell.due():
            self._in_cell.show(session.frame, session.particles())
