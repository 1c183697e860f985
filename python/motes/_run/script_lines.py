"""Find the line of the script that an error belongs to, even if another rank raised it."""

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

from ..errors import RankError, ScriptMismatchError
from .process import process

__all__ = ["Line", "located", "mismatch_error", "number_of", "rank_error", "running_line"]

_PACKAGE = str(Path(__file__).resolve().parents[1])
_LIBRARIES = (os.path.dirname(os.__file__), *site.getsitepackages())
# The core's text of a Python error: "TypeError: text", notes, then its frames, innermost first.
_FRAMES = "\n\nAt:\n"
_NOTES = (
    r"\[WITH __notes__\](?=: )|(?<=\n)__notes__ \(len=\d+\):\n"  # pybind11's; the former from Python 3.12 on
)
_FRAME = r"(?m)^  (.*)\((\d+)\): (.*)$"
_CALLS_BACK = "called"  # the method of Callbacks that calls a script's function
_of_script: dict[str, bool] = {}  # file -> whether it belongs to the script

Line: TypeAlias = "tuple[CodeType, int]"
"""An instruction of the script; its line number is computed only when needed."""


def mismatch_error(text: str, *, frame: int, ranks: tuple[int, ...], speaker: int) -> ScriptMismatchError:
    """Return the error for ranks that recorded different lists, as the core describes them.

    If numbers differ only in their last bits, it names the machines of the two ranks that were compared.
    """
    peers = {peer.rank: peer for run in process.runs for peer in run.peers}
    compared = re.search(r"\(here: rank (\d+), there: rank (\d+)\)", text)
    if "last bits" in text and compared is not None:
        machines = [
            f"rank {rank} runs on {peers[rank].host} ({peers[rank].machine})"
            for rank in map(int, compared.groups())
            if rank in peers
        ]
        text += "; " + ", ".join(machines) if machines else ""
    return ScriptMismatchError(text, frame=frame, ranks=ranks, speaker=speaker)


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

    If Python code of the script failed there, `text` contains its line and its callers. `place`: the call's
    system and index in this frame's list, if known.
    """
    message, _, shown = text.partition(_FRAMES)
    frames = [(file, int(line), function) for file, line, function in re.findall(_FRAME, shown)]
    for (_, _, function), (file, _, caller) in pairwise(frames):
        if caller == _CALLS_BACK and _is_ours(file):
            action = f"callback {function}"
            break
    where = _innermost([(file, line) for file, line, _ in frames])
    error = RankError(
        re.sub(_NOTES, "", message),
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
    """Let errors from the block name the script's line that recorded the failed call, or that runs now.

    `line_of` returns the line of a call, given its system and index; `failed_at` returns system and index of
    the call that failed on this rank.
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
    """Return the innermost instruction of the script on the call stack.

    `depth`: at least this many calls of the package are between the script and this function. Each stack
    frame that can be skipped saves a tenth of a microsecond.
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


def number_of(place: Line | str) -> int:
    """Return a 64-bit hash of a line of the script or of a text, the same in each process."""
    # Code of equal files is equal: without its name a copy of a script would have the numbers of the first.
    return _number_of(place, None if isinstance(place, str) else place[0].co_filename)


@lru_cache(maxsize=4096)
def _number_of(place: Line | str, file: str | None) -> int:
    text = (place if isinstance(place, str) else _shown(place)).encode(errors="surrogatepass")
    import hashlib  # late: only scripts with sources need it

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
    """Return the innermost stack frame of the script, as "snow.py:21"; `frames`: innermost first."""
    others = [(file, line) for file, line in frames if not _is_ours(file) and not file.startswith("<frozen")]
    script = [(file, line) for file, line in others if not file.startswith(_LIBRARIES)]
    for file, line in script or others:
        return f"{Path(file).name}:{line}"
    return None


def _is_ours(file: str) -> bool:
    return file.startswith(_PACKAGE)
