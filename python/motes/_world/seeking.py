"""Seeking: `World.seek` jumps to another frame, through a checkpoint or the state before the first frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from .._picture.sprites import Sprite
from .._system.session import Session
from .._values import arguments
from ..errors import ArgumentError, MotesError

if TYPE_CHECKING:
    from .._checkpoint.resuming import Checkpoints

__all__ = ["Seeking"]

_BORN = "the script recorded births or actions before its loop, which the loop does not record again"
_NO_LOOP = "the script has no loop of frames(n)"


class Start(NamedTuple):
    """A world before its first frame."""

    state: bytes
    configured: list[Any]
    """What newborn particles of each system get."""
    sprites: list[Sprite]


class Seeking:
    """Which frame a world goes on with, and from which one on pictures are drawn."""

    def __init__(self, session: Session) -> None:
        """Start at frame 0, where all pictures are drawn."""
        self._session = session
        self.drawn_from = 0
        """Frames before this one are computed without pictures."""
        self.sought = False
        """Whether the script has called `seek` since the loop began its iteration."""
        self.jumped = False
        """Whether that has changed the frame."""
        self._start: Start | str = _NO_LOOP

    def note_start(self) -> None:
        """Keep the state before the first frame, to which the world can go back; the loop begins."""
        session, engine = self._session, self._session.engine
        if engine is None or session.frame > 0:
            return
        if any(system.entries for system in session.systems):
            self._start = _BORN
            return
        systems = session.systems
        configured = [system.newborn.state() for system in systems]
        self._start = Start(engine.shared_state(), configured, [system.sprite for system in systems])

    def seek(self, frame: int, checkpoints: Checkpoints | None) -> None:
        """Go on with a frame: `World.seek`. Collective."""
        session = self._session
        frame = arguments.integer("frame", frame, high=2**62)
        self._check(frame)
        if checkpoints is not None and checkpoints.waiting:
            checkpoints.go_on()
        now = session.frame
        engine = session.engine_for("seek()")
        engine.tell(lambda: "")  # all cuts that balancing has planned are known, and then forgotten
        if checkpoints is not None and checkpoints.seek(frame, now):
            self.jumped = True
        elif frame < now:
            self._restart(frame)
            self.jumped = True
        self.drawn_from, self.sought = frame, True

    def _check(self, frame: int) -> None:
        session = self._session
        if session.engine is None or session.ended:
            raise MotesError("seek() works only inside `with world:` or after world.open()")
        if any(system.entries for system in session.systems):
            raise MotesError(
                f"seek() after actions of frame {session.frame} were recorded: call it before they are"
            )
        if session.recording is not None:
            raise MotesError("seek() while the script is recorded: a scene holds all frames in order")
        if frame >= session.frame:
            return
        if session.settings.log is not None:
            allowed = f"the current frame ({session.frame}) or a later one in a world with a log"
            raise ArgumentError("frame", frame, f"{allowed}, whose rows are in order")
        if session.files:
            allowed = f"the current frame ({session.frame}) or a later one while an export is open"
            raise ArgumentError("frame", frame, allowed)

    def _restart(self, frame: int) -> None:
        """Go back to the state before the first frame."""
        session, engine = self._session, self._session.engine_for("seek()")
        start = self._start
        if isinstance(start, str) or len(start.configured) != len(session.systems):
            reason = start if isinstance(start, str) else "a system was created after the first frame"
            allowed = (
                f"the current frame ({session.frame}), a later one, or one that has a checkpoint before it"
            )
            raise ArgumentError("frame", frame, f"{allowed}; the world cannot start again: {reason}")
        engine.restore_state(start.state, [([], [], []) for _ in session.systems])
        engine.copy_restored()
        for system, configured, sprite in zip(session.systems, start.configured, start.sprites, strict=True):
            system.forget()
            system.show_as(sprite, engine)
            system.newborn.restore(configured)
            system.tell_clump(engine)
