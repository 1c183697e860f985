"""Environment variables that change a run: their table, and the only code that reads them.

They take precedence over the script's arguments. `python -m motes doctor` prints the table and what is set.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, NamedTuple

from ..errors import ArgumentError

__all__ = [
    "FRAMES",
    "LIVE_HELD",
    "LIVE_OFF",
    "TABLE",
    "Variable",
    "alone",
    "births",
    "fan_out",
    "frames",
    "grain",
    "is_set",
    "read",
    "shares_pictures",
    "skin",
    "stall_s",
    "threads",
]

BIRTHS = ("auto", "manager", "calculators")
PROGRESS = ("lines", "bar", "off")
SIMD = ("sse2", "avx2", "avx512", "neon")
MOST_RANKS = 2**31 - 1
MOST_THREADS = 1024
MOST_SKIN = 100
LEAST_SPEED = 1e-3
LIVE_OFF = "off"
LIVE_HELD = ("paused", "wait")
"""Words of MOTES_LIVE that hold a run at its start."""
FRAMES = "frames such as 400:500, which are 400 to 499; 400: or :500"


class Variable(NamedTuple):
    """One environment variable."""

    name: str
    meaning: str
    allowed: str
    """What is allowed, as error messages say it: "a number of seconds > 0"."""
    parse: Callable[[str], Any]
    """Parse the text. Raises ValueError or ArgumentError if it is not allowed."""
    default: Any = None
    """The value if the variable is not set; None leaves it to the script."""
    default_text: str = ""
    """The default as text, if `default` does not express it."""


def read(name: str) -> Any:
    """Return a variable's parsed value, or its default if it is not set or empty.

    Raises ArgumentError, naming the variable and what is allowed.
    """
    variable = TABLE[name]
    text = os.environ.get(name, "")
    if not text:
        return variable.default
    try:
        return variable.parse(text)
    except ArgumentError:
        raise
    except ValueError:
        raise ArgumentError(name, text, variable.allowed) from None


def is_set(name: str) -> bool:
    """Return whether a variable of the table is set and not empty."""
    return bool(os.environ.get(TABLE[name].name))


def stall_s() -> float | None:
    """Return after how many seconds without an answer a rank gives up: MOTES_STALL_S; None: not set."""
    seconds: float | None = read("MOTES_STALL_S")
    return seconds


def alone() -> bool:
    """Return whether each process of an unknown launcher may run by itself: MOTES_ALONE."""
    return bool(read("MOTES_ALONE"))


def births(given: Any) -> str:
    """Return who creates births: MOTES_BIRTHS, or else `World`'s `births`."""
    from . import arguments

    value: str | None = read("MOTES_BIRTHS")
    return value or str(arguments.choice("births", given, BIRTHS))


def fan_out(given: Any) -> int:
    """Return how many ranks each rank relays messages to: MOTES_FAN_OUT, or else `World`'s `fan_out`."""
    from . import arguments

    return read("MOTES_FAN_OUT") or arguments.integer("fan_out", given, low=1, high=MOST_RANKS)


def threads(given: Any) -> int | None:
    """Return the number of this rank's threads: MOTES_THREADS, or else `World`'s `threads`."""
    from . import arguments

    value: int | None = read("MOTES_THREADS")
    if value is None and given is not None:
        value = arguments.integer("threads", given, low=1, high=MOST_THREADS)
    return value


def grain() -> int | None:
    """Return the most particles that a thread processes at once: MOTES_GRAIN."""
    value: int | None = read("MOTES_GRAIN")
    return value


def skin() -> float | None:
    """Return the skin of neighbour lists as a fraction of a law's reach: MOTES_SKIN."""
    value: float | None = read("MOTES_SKIN")
    return value


def wait_no_longer() -> None:
    """Let later starts of a job not wait for viewers again, who may have left."""
    words = os.environ.get("MOTES_LIVE", "").split(",")
    if set(words) & set(LIVE_HELD):
        os.environ["MOTES_LIVE"] = ",".join(word for word in words if word not in LIVE_HELD)


def shares_pictures() -> bool:
    """Return whether this rank may draw into the image generator's memory: MOTES_SHARED_PICTURES."""
    return bool(read("MOTES_SHARED_PICTURES"))


def _one_of(*names: str) -> Callable[[str], str]:
    def parse(text: str) -> str:
        if text not in names:
            raise ValueError(text)
        return text

    return parse


def _flag(text: str) -> bool:
    return _one_of("0", "1")(text) == "1"


def _seconds(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise ValueError(text)
    return value


def _skin(text: str) -> float:
    value = float(text)
    if not 0 <= value <= MOST_SKIN:
        raise ValueError(text)
    return value


def _up_to(most: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= most:
            raise ValueError(text)
        return int(text)

    return parse


def frames(text: str) -> tuple[int, int | None]:
    """Parse a range of frames, `400:500`, `400:` or `:500`, of which the last is not drawn.

    Raises ValueError.
    """
    first, colon, end = text.partition(":")
    if not colon or any(part and not (part.isascii() and part.isdigit()) for part in (first, end)):
        raise ValueError(text)
    low, high = int(first or 0), int(end) if end else None
    if high is not None and not low < high or max(low, high or 0) > 2**62:
        raise ValueError(text)
    return low, high


def _speeds(text: str) -> dict[int, float]:
    chosen = {}
    for pair in text.split(","):
        rank, _, speed = pair.partition(":")
        chosen[int(rank)] = float(speed)
    if any(rank < 0 or not LEAST_SPEED <= speed <= 1 for rank, speed in chosen.items()):
        raise ValueError(text)
    return chosen


def _live(text: str) -> dict[str, Any] | str:
    """Parse `off`, or a port and options: 8080,host=0.0.0.0,paused,wait."""
    if text == LIVE_OFF:
        return text
    port, *words = text.split(",")
    if not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise ValueError(text)
    options: dict[str, Any] = {"port": int(port)}
    for word in words:
        name, _, value = word.partition("=")
        if name == "host" and value:
            options["host"] = value
        elif word in LIVE_HELD:
            options[word] = True
        else:
            raise ValueError(text)
    return options


TABLE = {
    variable.name: variable
    for variable in (
        Variable(
            "MOTES_PROGRESS",
            "how a run shows its progress",
            "lines, bar or off",
            _one_of(*PROGRESS),
            default_text="the script's `World(progress=...)`",
        ),
        Variable(
            "MOTES_STALL_S",
            "seconds without an answer after which a rank gives up, even if the process is alive",
            "a number of seconds > 0",
            _seconds,
            default_text="a rank waits while the process is alive, or for 600 s if that is unknown",
        ),
        Variable(
            "MOTES_ALONE",
            "1: each process of an unknown launcher runs the whole animation by itself",
            "0 or 1",
            _flag,
            default=False,
            default_text="an error",
        ),
        Variable(
            "MOTES_SPEEDS",
            "ranks that behave like slower machines, such as 2:1.0,3:0.5",
            f"rank:speed pairs such as 2:1.0,3:0.5 with speeds {LEAST_SPEED}..1",
            _speeds,
            default_text="the script's `Roles(speeds=...)`",
        ),
        Variable(
            "MOTES_BIRTHS",
            "who creates births",
            "auto, manager or calculators",
            _one_of(*BIRTHS),
            default_text="the script's `World(births=...)`",
        ),
        Variable(
            "MOTES_FAN_OUT",
            "how many ranks each rank relays the manager's messages to, at most",
            f"an integer 1..{MOST_RANKS}",
            _up_to(MOST_RANKS),
            default_text="the script's `World(fan_out=...)`",
        ),
        Variable(
            "MOTES_THREADS",
            "threads per rank for calculating and drawing; the bits are the same",
            f"an integer 1..{MOST_THREADS}",
            _up_to(MOST_THREADS),
            default_text="the script's `World(threads=...)`",
        ),
        Variable(
            "MOTES_GRAIN",
            "the most particles that one thread takes at once; for tests of threads with few particles",
            f"an integer 1..{MOST_RANKS}",
            _up_to(MOST_RANKS),
            default_text="whatever is fastest",
        ),
        Variable(
            "MOTES_SKIN",
            "skin of neighbour lists as a fraction of the reach, for tests; the bits are the same",
            f"a number 0..{MOST_SKIN}",
            _skin,
            default_text="whatever is cheapest",
        ),
        Variable(
            "MOTES_SHARED_PICTURES",
            "0: ranks of one host also send the pixels of tiles as messages; the pictures are the same",
            "0 or 1",
            _flag,
            default=True,
            default_text="ranks on the image generator's host draw into its memory",
        ),
        Variable(
            "MOTES_SIMD",
            "the vector instructions of the kernels; the bits are the same",
            "sse2, avx2, avx512 or neon",
            _one_of(*SIMD),
            default_text="the widest that the processor supports",
        ),
        Variable(
            "MOTES_MPIRUN",
            "the launcher that `motes run` starts",
            "a program",
            str,
            default_text="the mpirun of the MPI library that mpi4py uses",
        ),
        Variable(
            "MOTES_OPEN_WORLDS",
            "set by `motes run`: the folder in which ranks record that they are inside `with world:`",
            "a directory",
            str,
            default_text="nothing is recorded",
        ),
        Variable(
            "MOTES_LAUNCHER",
            "set by `motes run`: where `motes resize` finds it",
            "the host and the process of a launcher",
            str,
            default_text="the number of ranks cannot change",
        ),
        Variable(
            "MOTES_RANK_PROCESS",
            "set by `motes run` and by each rank: which process is the rank, for processes that it starts",
            "a process number, and the launcher's variables",
            str,
            default_text="a process that a launcher describes is the rank",
        ),
        Variable(
            "MOTES_RANK_PIPE",
            "set by `motes run`: where a rank reports that its MPI has started",
            "a file descriptor",
            str,
            default_text="nothing is reported",
        ),
        Variable(
            "MOTES_FRESH",
            "1: start from the beginning, and remove existing checkpoints and exports",
            "0 or 1",
            _flag,
            default=False,
            default_text="continue from the newest complete one",
        ),
        Variable(
            "MOTES_ANYWAY",
            "1: continue from a checkpoint although the script has changed since",
            "0 or 1",
            _flag,
            default=False,
            default_text="an error",
        ),
        Variable(
            "MOTES_FRAMES",
            "set by `motes run --frames`: only these frames are drawn, and the run ends after them",
            FRAMES,
            frames,
            default_text="all frames",
        ),
        Variable(
            "MOTES_STILL",
            "set by `motes frame`: where the only frame of MOTES_FRAMES is saved; nothing else is written",
            "a file",
            str,
            default_text="the script's films, logs and exports are written",
        ),
        Variable(
            "MOTES_PREVIEW",
            "1: pictures have half their size, and sprites sized in pixels shrink along",
            "0 or 1",
            _flag,
            default=False,
            default_text="the renderer's size",
        ),
        Variable(
            "MOTES_LIVE",
            "serve the run to browsers: a port and options, such as 8080,paused,wait,host=0.0.0.0; or off",
            "off, or a port 0..65535 followed by paused, wait or host=ADDRESS, separated by commas",
            _live,
            default_text="the script's `World(live=...)`",
        ),
        Variable(
            "MOTES_REHEARSAL",
            "set by `motes live`: run this many frames without writing any file, then end the process",
            f"an integer 1..{MOST_RANKS}",
            _up_to(MOST_RANKS),
            default_text="an ordinary run",
        ),
        Variable(
            "MOTES_STEERING",
            "a steer.jsonl of an earlier run, whose orders are repeated",
            "a file",
            str,
            default_text="the script's `World(steering=...)`",
        ),
        Variable(
            "MOTES_SWEEP",
            "set by `motes sweep`: what it sets in a run, and where the run reports",
            "a file of `motes sweep`",
            str,
            default_text="the script's own values",
        ),
        Variable("MOTES_SMPIRUN", "SimGrid's launcher", "a program", str, default="smpirun"),
        Variable(
            "MOTES_SMPI_REPLAY",
            "`motes_replay` built for SimGrid",
            "a file",
            str,
            default_text="the one that `motes cluster build` built",
        ),
    )
}
"""All variables by name. The core reads MOTES_SIMD, `motes_replay` reads MOTES_SPEEDS and MOTES_STALL_S."""
