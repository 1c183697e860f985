"""The part of a run that is drawn: `motes run --frames` and `motes frame`.

The frames before it are computed without pictures, from the newest checkpoint. An excerpt only reads
checkpoints. Its films, logs and exports get names of their own, so that several jobs can draw one film.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Self

from .._values import environment
from ..errors import MotesError

if TYPE_CHECKING:
    from .._picture.frame import Frame

__all__ = ["LEFT_OUT", "Excerpt", "check_digest", "logged_digests", "missing"]

LEFT_OUT = "only other frames are drawn"
_DIGITS = 6


class Excerpt(NamedTuple):
    """Which frames are drawn."""

    first: int
    end: int | None
    """The first frame that is no longer drawn; None: all until the script ends."""
    still: str | None
    """Where to save the only frame of `motes frame`, after which the job ends. Nothing else is written."""

    @classmethod
    def current(cls) -> Self | None:
        """Return what the environment asks for; None: the whole run is drawn."""
        frames = environment.read("MOTES_FRAMES")
        if frames is None:
            return None
        first, end = frames
        return cls(first, end, environment.read("MOTES_STILL"))

    def __contains__(self, frame: object) -> bool:
        """Return whether a frame is drawn."""
        return isinstance(frame, int) and self.first <= frame and not self.over(frame)

    def over(self, frame: int) -> bool:
        """Return whether a frame is behind the last that is drawn."""
        return self.end is not None and frame >= self.end

    def beside(self, path: Path) -> Path:
        """Return the path of the excerpt's own file in place of the whole run's: film.000400-000500.mp4."""
        end = "end" if self.end is None else f"{self.end:0{_DIGITS}}"
        return path.with_name(f"{path.stem}.{self.first:0{_DIGITS}}-{end}{path.suffix}")


def missing(excerpt: Excerpt, frames: int) -> str:
    """Return a sentence on the frames of an excerpt that a script of so many frames lacks, or ""."""
    first = max(excerpt.first, frames)
    if excerpt.end is None and excerpt.first < frames:
        return ""
    if excerpt.end is not None and frames >= excerpt.end:
        return ""
    last = first if excerpt.end is None else excerpt.end - 1
    named = f"frame {first} does" if first == last else f"frames {first} to {last} do"
    have = "no frame" if frames == 0 else "only frame 0" if frames == 1 else f"frames 0 to {frames - 1}"
    return f"{named} not exist: the script has {have}"


def logged_digests(log: str | None) -> dict[int, str]:
    """Return the digests of pictures in a log, by frame, as far as they can be read."""
    digests: dict[int, str] = {}
    with (
        contextlib.suppress(OSError, ValueError, AttributeError, KeyError, TypeError),
        open(Path(log or "") / "frames.jsonl", encoding="utf-8") as table,
    ):
        for row in map(json.loads, table):
            digests[int(row["frame"])] = row.get("image_sha256") or ""
    return digests


def check_digest(frame: Frame, logged: Mapping[int, str], log: str | None) -> None:
    """Raise MotesError if the log of the whole run has another digest of this picture."""
    if logged.get(frame.index, "") not in ("", frame.digest()):
        raise MotesError(
            f"frame {frame.index} differs from the one that {log} describes: the script, its arguments or "
            "motes have changed since, or what it records depends on more than the frame and the particles; "
            "--anyway (MOTES_ANYWAY=1) does not compare"
        )
