"""Which line of the script an error belongs to, also where another rank raised it."""

from __future__ import annotations

import re
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

from ..errors import RankError

__all__ = ["located", "rank_error"]

_PACKAGE = str(Path(__file__).resolve().parents[1])
_LIBRARIES = tuple(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib"))
# How the core writes down a Python error: "TypeError: text", notes, then its frames, innermost first.
_FRAMES = "\n\nAt:\n"
_FRAME = re.compile(r"^  (.*)\((\d+)\): (.*)$", re.MULTILINE)
_CALLS_BACK = "_call_back"  # the method of System that calls a script's function


def rank_error(
    text: str, *, rank: int, role: str, frame: int, action: str, speaker: int | None = None
) -> RankError:
    """Return the error for a failure on another rank, as the core describes it.

    If Python code of the script failed there, the description holds its line and its callers.
    """
    message, _, shown = text.partition(_FRAMES)
    frames = [(file, int(line), function) for file, line, function in _FRAME.findall(shown)]
    for (_, _, function), (file, _, caller) in pairwise(frames):
        if caller == _CALLS_BACK and _is_ours(file):
            action = f"callback {function}"
            break
    where = _innermost([(file, line) for file, line, _ in frames])
    return RankError(
        re.sub(r"\n__notes__ \(len=\d+\):\n", "\n", message),
        rank=rank,
        role=role,
        frame=frame,
        action=action,
        line=where,
        speaker=speaker,
    )


@contextmanager
def located() -> Iterator[None]:
    """Give a RankError without a line the script's line that is running here."""
    try:
        yield
    except RankError as error:
        if error.line is None:
            error.line = _running()
            RankError.__init__(
                error,
                error.text,
                rank=error.rank,
                role=error.role,
                frame=error.frame,
                action=error.action,
                line=error.line,
                speaker=error.speaker,
            )
        raise


def _running() -> str | None:
    frames = []
    frame = sys._getframe(1)
    while frame is not None:
        frames.append((frame.f_code.co_filename, frame.f_lineno))
        frame = frame.f_back  # type: ignore[assignment]
    return _innermost(frames)


def _innermost(frames: Sequence[tuple[str, int]]) -> str | None:
    """Return the first frame, innermost first, that belongs to the script, as "snow.py:21"."""
    others = [(file, line) for file, line in frames if not _is_ours(file) and not file.startswith("<frozen")]
    script = [(file, line) for file, line in others if not file.startswith(_LIBRARIES)]
    for file, line in script or others:
        return f"{Path(file).name}:{line}"
    return None


def _is_ours(file: str) -> bool:
    return file.startswith(_PACKAGE)
