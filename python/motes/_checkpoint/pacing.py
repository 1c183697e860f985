"""`Checkpoint(every="auto")`: when a checkpoint is due, and which old ones are dropped."""

from __future__ import annotations

import contextlib
import shutil
from pathlib import Path
from typing import NamedTuple

from .. import _core
from .._io.output import tell
from .._values.checkpoint import Checkpoint
from ..errors import CheckpointError
from . import folder
from .manifest import Manifest

__all__ = ["Pace", "thin"]

_UNSEEN = 0.01  # part of the seconds in which the ranks do not ask how long frames take


class Pace:
    """Measures how long frames take to compute without pictures; all ranks agree on the result.

    Ranks talk only now and then, so that it costs little where frames are short.
    """

    def __init__(self, seconds: float, total_s: float) -> None:
        """Start behind a checkpoint, or at frame 0; `total_s`: seconds of computing up to here."""
        self.total_s = total_s
        """Seconds of computing from frame 0 to the newest checkpoint, as agreed."""
        self._seconds = seconds
        self._own_s = 0.0
        self._frames = 0
        self._next_look = 1

    def due(self, engine: _core.Engine) -> bool:
        """Note the frame that has ended; return whether a checkpoint must follow it. Collective."""
        times = engine.times
        self._own_s += max(times["t_frame_s"] - times["t_render_s"], 0.0)
        self._frames += 1
        if self._frames < self._next_look:
            return False
        # Ranks that wait for the picture seem slow: the fastest rank tells how long computing takes.
        spent = self._agree(engine)
        each = max(spent / self._frames, 1e-9)
        self._next_look = self._frames + max(1, int(self._seconds * _UNSEEN / each))
        return spent + each > self._seconds

    def begin(self, engine: _core.Engine) -> None:
        """Start again behind a checkpoint that is written now. Collective."""
        self.total_s += self._agree(engine)
        self._own_s, self._frames, self._next_look = 0.0, 0, 1

    def _agree(self, engine: _core.Engine) -> float:
        self._own_s = min(map(float, engine.tell(lambda: repr(self._own_s))))
        return self._own_s


class _Kept(NamedTuple):
    path: Path
    stepped_s: float
    size: int


def thin(directory: Path, checkpoint: Checkpoint) -> None:
    """Drop checkpoints that are not needed: without them, at most `seconds` of computing lie between two.

    If the others exceed the budget of disk, drop those that leave the smallest gaps. The newest `keep` stay.
    """
    kept = _complete(directory)
    budget = checkpoint.gigabytes * 1e9
    while len(kept) > checkpoint.keep:
        before = [0.0, *(one.stepped_s for one in kept)]
        gaps = [kept[i + 1].stepped_s - before[i] for i in range(len(kept) - checkpoint.keep)]
        least = min(range(len(gaps)), key=gaps.__getitem__)
        over = sum(one.size for one in kept) > budget
        if gaps[least] > checkpoint.seconds and not over:
            break
        if gaps[least] > checkpoint.seconds and directory not in _told:
            _told.add(directory)
            tell(
                f"motes: the checkpoints in {directory} fill their {checkpoint.gigabytes:g} GB: from now on "
                f"up to {gaps[least]:.2g} s of computing lie between two of them, more as the run goes on"
            )
        shutil.rmtree(kept.pop(least).path, ignore_errors=True)


_told: set[Path] = set()


def _complete(directory: Path) -> list[_Kept]:
    kept = []
    for _, path in reversed(folder.whole(directory)):
        with contextlib.suppress(CheckpointError, OSError):
            manifest = Manifest.from_bytes((path / folder.MANIFEST).read_bytes(), path)
            size = sum(part.bytes for part in manifest.parts) + manifest.world["bytes"]
            kept.append(_Kept(path, manifest.stepped_s, size))
    return kept
