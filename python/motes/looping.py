"""The part of `World` that is the loop of its frames: what comes next, and where the loop ends."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from . import arguments
from ._run import stopping
from .errors import MotesError
from .frame import Frame
from .steered import Steered
from .usage import outside

if TYPE_CHECKING:
    from ._notebook.cells import CellProgress

__all__ = ["Looping"]


class Looping(Steered):
    """The loop of a world's frames."""

    _ran: bool
    _shows_in_cell = False  # a notebook shows the loop
    _in_cell: CellProgress | None = None

    if TYPE_CHECKING:

        def _warn(self, text: str, level: int) -> None: ...

    def frames(self, n: int) -> Iterator[int]:
        """Yield the frames of 0..n-1 that are still to do. Collective: every rank runs the same loop.

        Each pass of the loop ends its frame by `render` or `step`. Frames count from the world's first one:
        after `frames(5)`, `frames(8)` yields 5, 6 and 7. A world with checkpoints goes on from the newest
        whole one, where there is one, and writes new ones between two passes of the loop. SIGINT (Ctrl-C),
        SIGTERM or SIGUSR1 on any rank ends the loop on all ranks once its frame is done. At a prompt or in a
        notebook Ctrl-C then raises KeyboardInterrupt, and `frames(n)` goes on later.

        Args:
            n: how many frames the run has in all.

        Yields:
            The number of the frame to record.

        Raises:
            MotesError: outside `with world:`, and if a pass did not end its frame.
        """
        self._usage.check("frames()")
        if self._ended:
            raise outside("frames()")
        self._total = arguments.integer("n", n)
        if self.frame >= self._total and self._ran:
            self._warn(
                f"frames({n}): all {n} frames are done; frames(n) counts from the world's first frame", 3
            )
        return self._frames(self._total)

    def _frames(self, n: int) -> Iterator[int]:
        self._in_cell = None
        try:
            while True:
                if self._course is not None:
                    self._course.at_border(self.frame, self._systems)
                if self.frame >= n or self._at_border():
                    return
                frame = self.frame
                self._show_in_cell()
                self._looping = True
                stopping.arm()  # a notebook takes Ctrl-C back for each cell
                yield frame
                if self.frame != frame + 1:
                    raise MotesError(f"frame {frame} must end with one world.render() or world.step()")
                self._looping = False
        finally:
            self._looping = False
            stopping.disarm()
            self._show_in_cell(last=True)

    def _show_in_cell(self, *, last: bool = False) -> None:
        """Show in a notebook how far the loop is; nothing elsewhere."""
        if not self._shows_in_cell or self._attached:
            return
        if self._in_cell is None:
            if not last:
                from ._notebook.cells import CellProgress

                self._in_cell = CellProgress(self._total, self.frame, self._particles())
        elif last or self._in_cell.due():
            self._in_cell.show(self.frame, self._particles())

    def _particles(self) -> int:
        return sum(system.count for system in self._systems)

    def _stops(self) -> bool:
        """Tell whether the run stops at this border, as all ranks have agreed. Collective where it does."""
        if self._attached and stopping.interactive():
            return False  # an interrupt is meant for the cell, which is not where this runs
        if self._engine is not None and self._stop.due(self._engine.stop_asked, self.frame):
            self._before_stopping()
            self._stop.take(self._engine.stop_asked)
        return self._stop.signal > 0

    def _show_viewers(self, frame: Frame | None) -> None:
        """The frame has ended: keep its picture for the notebook, too."""
        if frame and self._in_cell is not None:
            self._in_cell.picture(frame.pixels, frame.index)
        super()._show_viewers(frame)

    def _before_stopping(self) -> None:
        """Do what must be done at the border where a signal stops the run. Collective."""
        self._note_stop(None)
        if self._course is not None:
            self._course.save_now(self.frame, self._systems)
