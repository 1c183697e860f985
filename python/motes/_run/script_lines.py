"""Which line of the script an error belongs to, also where another rank raised it."""

from __future__ import annotations

import os
import re
import site
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from itertools import islice, pairwise
from pathlib import Path
from types import CodeType
from typing import TypeAlias

from ..errors import RankError

__all__ = ["Line", "located", "number_of", "rank_error", "running_line"]

_PACKAGE = str(Path(__file__).resolve().parents[1])
_LIBRARIES = (os.path.dirname(os.__file__), *site.getsitepackages())
# How the core writes down a Python error: "TypeError: text", notes, then its frames, innermost first.
_FRAMES = "\n\nAt:\n"
_FRAME = r"(?m)^  (.*)\((\d+)\): (.*)$"
_CALLS_BACK = "called"  # the method of Callbacks that calls a script's function
_of_script: dict[str, bool] = {}  # by file

Line: TypeAlias = "tuple[CodeType, int]"
"""An instruction of the script: its line is worked out when it is asked for."""


def rank_error(
    text: str,
    *,
    rank: int,
    role: str,
    frame: int,
    action: str,
    place: tuple[int, int] = (-1, -1),
    speaker: int | None = None,
) -> RankError:
    """Return the error for a failure on another rank, as the core describes it.

    If Python code of the script failed there, the description holds its line and its callers. `place`: system
    and call in this frame's list, if it is known.
    """
    message, _, shown = text.partition(_FRAMES)
    frames = [(file, int(line), function) for file, line, function in re.findall(_FRAME, shown)]
    for (_, _, function), (file, _, caller) in pairwise(frames):
        if caller == _CALLS_BACK and _is_ours(file):
            action = f"callback {function}"
            break
    where = _innermost([(file, line) for file, line, _ in frames])
    error = RankError(
        re.sub(r"\n__notes__ \(len=\d+\):\n", "\n", message),
        rank=rank,
        role=role,
        frame=frame,
        action=action,
        line=where,
        speaker=speaker,
    )
    error.__dict__["_place"] = place
    return error


@contextmanager
def located(
    line_of: Callable[[tuple[int, int]], Line | None], failed_at: Callable[[], tuple[int, int]]
) -> Iterator[None]:
    """Let errors name the script's line: where the call that failed was recorded, or what runs here.

    `line_of` gives the line of a call by its system and number; `failed_at` says which one failed on this
    rank.
    """
    try:
        yield
    except RankError as error:
        recorded = line_of(error.__dict__.pop("_place", (-1, -1)))
        if error.line is None:
            error.line = _shown(recorded) if recorded else _running()
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
    except Exception as error:
        recorded = line_of(failed_at())
        if recorded is not None:
            error.add_note(f"recorded at {_shown(recorded)}")
        raise


def running_line(depth: int) -> Line:
    """Return the innermost instruction under way that belongs to the script.

    `depth`: so many calls of the package at least stand between it and this one. Each frame that need not
    be looked at saves a tenth of a microsecond.
    """
    frame = sys._getframe(depth + 1)
    while (of_script := _of_script.get(frame.f_code.co_filename)) is not True:
        if of_script is None:  # a file that was not seen before
            file = frame.f_code.co_filename
            _of_script[file] = not (file.startswith(_LIBRARIES) or _is_ours(file))
        elif frame.f_back is None:
            break
        else:
            frame = frame.f_back
    return frame.f_code, frame.f_lasti


@lru_cache(maxsize=4096)
def number_of(place: Line | str) -> int:
    """Return 64 bits that stand for a line of the script, or for a text: the same ones in each process."""
    text = (place if isinstance(place, str) else _shown(place)).encode(errors="surrogatepass")
    import hashlib  # only where there is a source: a world starts without it

    return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little")


def _shown(line: Line) -> str:
    code, instruction = line
    number = next(islice(code.co_positions(), instruction // 2, None))[0]
    return f"{Path(code.co_filename).name}:{number}"


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
