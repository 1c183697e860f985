"""Real jobs for the tests: each in its own session, with a time limit, and ended with all its children."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

__all__ = ["Hang", "Result", "command", "launches", "mpirun", "python", "said"]

POLL_S = 0.01


class Hang(AssertionError):
    """A job that did not end within its limit; shows everything that it printed."""


def said(text: str, opening: str) -> list[str]:
    """Return the text after an opening, to the end of the line, for each line that contains it.

    The opening may also be inside a line: mpirun may leave a stray byte after its notice of an abort.
    """
    return re.findall(f"{re.escape(opening)}(.*)$", text, re.MULTILINE)


@dataclass(frozen=True)
class Result:
    """How a job ended."""

    code: int
    out: str
    err: str
    seconds: float
    trailer: str = ""
    """mpirun's own output about a failed run, which `motes run` writes to a file."""

    @property
    def text(self) -> str:
        """All of its output, for messages of failed tests."""
        return f"exit code {self.code} after {self.seconds:.1f} s\n--- out\n{self.out}\n--- err\n{self.err}"

    @property
    def lines(self) -> list[str]:
        """The lines of standard output; the run must have succeeded."""
        assert self.code == 0, self.text
        return self.out.splitlines()


@dataclass
class Count:
    """Counts of the session's jobs, and their costs."""

    jobs: int = 0
    seconds: float = 0.0
    bodies: int = 0
    """Number of scripts run in standing jobs (tests/support/standing.py)."""
    body_seconds: float = 0.0
    replaced: list[str] = field(default_factory=list)
    """Why standing jobs had to be replaced."""

    def told(self) -> list[Any]:
        """Return all counts as plain values."""
        return [self.jobs, self.seconds, self.bodies, self.body_seconds, self.replaced]

    def add(self, told: list[Any] | None) -> None:
        """Add the counts reported by another process, if any."""
        for name, value in zip(vars(self), told or [], strict=False):
            setattr(self, name, getattr(self, name) + value)

    def lines(self) -> list[str]:
        """Return the lines of a summary."""
        jobs = f"{self.jobs} jobs started, {self.seconds:.0f} s in them"
        bodies = f"{self.bodies} bodies in standing jobs, {self.body_seconds:.0f} s in them"
        replaced = [f"a standing job was replaced after {why}" for why in self.replaced]
        return [jobs, bodies, *replaced] if self.jobs else []


launches = Count()


def mpirun(
    n: int,
    script: str | Path,
    *arguments: object,
    timeout: float = 60,
    env: dict[str, str] | None = None,
    watch: Callable[[int], None] | None = None,
) -> Result:
    """Run a script (a path, or its text) on `n` ranks as a user does; `watch(pid)` is called meanwhile."""
    return _job(["-m", "motes", "run", "-n", str(n)], script, arguments, timeout, env, watch)


def python(
    script: str | Path, *arguments: object, timeout: float = 60, env: dict[str, str] | None = None
) -> Result:
    """Run a script in one process, without a launcher."""
    return _job([], script, arguments, timeout, env, None)


def _job(
    argv: list[str],
    script: str | Path,
    arguments: tuple[object, ...],
    timeout: float,
    env: dict[str, str] | None,
    watch: Callable[[int], None] | None,
) -> Result:
    with tempfile.TemporaryDirectory(prefix="motes-test-") as folder:
        path = script if isinstance(script, Path) else Path(folder) / "script.py"
        if not isinstance(script, Path):
            path.write_text(script)
        return command([sys.executable, *argv, path, *arguments], timeout=timeout, env=env, watch=watch)


def command(
    argv: Sequence[object],
    *,
    timeout: float = 60,
    env: dict[str, str] | None = None,
    watch: Callable[[int], None] | None = None,
) -> Result:
    """Run any program with its arguments; repeat it once if mpirun itself crashes."""
    result = _once(argv, timeout, env, watch)
    # mpirun of Open MPI 5 may crash in libpmix, once in thousands of aborts; a rank's crash has another code.
    if argv[0] != sys.executable and result.code == -signal.SIGSEGV:
        result = _once(argv, timeout, env, watch)
    return result


def _once(
    argv: Sequence[object],
    timeout: float,
    env: dict[str, str] | None,
    watch: Callable[[int], None] | None,
) -> Result:
    with tempfile.TemporaryDirectory(prefix="motes-test-") as folder:
        texts = [str(argument) for argument in argv]
        out, err = Path(folder) / "out", Path(folder) / "err"
        start = time.monotonic()
        with out.open("wb") as out_file, err.open("wb") as err_file:
            # Files, not pipes: a child that outlives the job must not keep this process waiting.
            process = subprocess.Popen(
                texts,
                stdin=subprocess.DEVNULL,
                stdout=out_file,
                stderr=err_file,
                env={**os.environ, "MOTES_PROGRESS": "", **(env or {})},
                start_new_session=True,
            )
            try:
                ended = _wait(process, start + timeout, watch)
            finally:
                kill_session(process.pid)
                process.wait()
        seconds = time.monotonic() - start
        launches.jobs += 1
        launches.seconds += seconds
        told = [file.read_text(errors="replace") for file in (out, err)]
        result = Result(process.returncode, told[0], told[1], seconds, take_trailer(told[1]))
        if not ended:
            raise Hang(f"{' '.join(texts)}: no end within {timeout:g} s\n{result.text}")
        return result


def take_trailer(err: str) -> str:
    """Return mpirun's output, and remove the files to which `motes run` wrote it."""
    files = [Path(name) for name in said(err, "mpirun's own messages: ")]
    trailer = "".join(file.read_text(errors="replace") for file in files)
    for file in files:
        file.unlink()
    return trailer


def _wait(process: subprocess.Popen[bytes], limit: float, watch: Callable[[int], None] | None) -> bool:
    while process.poll() is None:
        if time.monotonic() > limit:
            return False
        if watch is not None:
            watch(process.pid)
        time.sleep(POLL_S)
    return True


def kill_session(session: int) -> None:
    """Kill what remains of a job: its ranks have their own process groups, but the same session."""
    for _ in range(3):
        left = [pid for pid, its in _sessions() if its == session]
        for pid in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        if not left:
            return


def _sessions() -> list[tuple[int, int]]:
    """Yield pairs of process and session, without zombies."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        with contextlib.suppress(OSError, ValueError, IndexError):
            fields = (entry / "stat").read_text(errors="replace").rpartition(")")[2].split()
            if fields[0] not in ("Z", "X"):
                found.append((int(entry.name), int(fields[3])))
    return found
