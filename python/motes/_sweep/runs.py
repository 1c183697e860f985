"""The runs of a sweep: each in a folder of its own, which is complete once it holds a result."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from .._io import files
from .._launch.supervisor import start_of_child
from ..errors import ArgumentError, MotesError
from . import grid
from .grid import Case

__all__ = ["Row", "Sweep", "stopping"]

DONE = "done.json"
"""The mark of a complete run: its values, figures and digests."""
OUTPUT = "output.txt"
LOCK = ".lock"
Row = dict[str, Any]
_LINES = 3  # of a failed run's output, in its row
_GRACE_S = 30.0  # for a run to end its frame


class Sweep:
    """A script, and the directory of its runs."""

    def __init__(self, program: Sequence[str], directory: Path, figures: Callable[[Path], Row]) -> None:
        """Take the script with its arguments; `figures` reads a log."""
        self.directory = directory.absolute()
        self.program = [os.path.abspath(one) if os.path.exists(one) else one for one in program]
        text = Path(self.program[0]).read_bytes()
        facts = json.dumps([hashlib.sha256(text).hexdigest(), self.program[1:]])
        self.script = hashlib.sha256(facts.encode()).hexdigest()
        self._figures = figures
        self._lock = threading.Lock()
        self._running: set[subprocess.Popen[bytes]] = set()
        self.stopped = 0
        """The signal that ended the sweep, or 0."""

    # --- what the script has

    def probe(self, ranks: int) -> dict[str, Any]:
        """Return which controls the script has, and its world's axis. Raises MotesError."""
        with tempfile.TemporaryDirectory(prefix="motes-sweep-") as name:
            folder = Path(name)
            result = folder / "probe.json"
            code = self._run(None, ranks, folder, result)
            if result.exists():
                read: dict[str, Any] = json.loads(result.read_bytes())
                return read
            reason = _last_lines(folder / OUTPUT) or f"exit code {code}"
        if code:
            raise MotesError(f"{self.program[0]} fails before its first frame: {reason}")
        raise MotesError(f"{self.program[0]} has no loop over world.frames(n), where a sweep sets its values")

    # --- its runs

    def row(self, case: Case) -> Row | None:
        """Return the row of a complete run; None: it is missing.

        Raises ArgumentError if it is another script's.
        """
        mark = self.directory / case.folder / DONE
        try:
            row: Row = json.loads(mark.read_bytes())
        except FileNotFoundError:
            return None
        except ValueError:
            raise MotesError(f"{mark} is damaged: remove it, and its run starts again") from None
        if row.pop("script") != self.script:
            allowed = "a directory of runs of this script, with these arguments"
            hint = "the script has changed since; --fresh removes its runs"
            raise ArgumentError("-o", os.fspath(self.directory), allowed, hint=hint)
        return row

    def forget(self, chosen: Sequence[Case]) -> None:
        """Remove the runs of these cases."""
        for case in chosen:
            shutil.rmtree(self.directory / case.folder, ignore_errors=True)

    def run(self, chosen: Sequence[Case], jobs: int, tell: Callable[[int, Row], None]) -> None:
        """Run these cases, `jobs` at a time; `tell(number, row)` is called after each."""
        count = 0

        def one(case: Case) -> None:
            nonlocal count
            if self.stopped:
                return
            row = self.run_one(case)
            with self._lock:
                count += 1
                if not self.stopped:
                    tell(count, row)

        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(one, chosen))

    def run_one(self, case: Case) -> Row:
        """Run a case, and return its row, with an `error` if it failed."""
        folder = self.directory / case.folder
        folder.mkdir(parents=True, exist_ok=True)
        with _locked(folder) as lock:
            if lock < 0:
                return {**case.values, "error": "another sweep is running it"}
            if (row := self.row(case)) is not None:
                return row
            result = folder / "result.json"
            result.unlink(missing_ok=True)
            start = time.monotonic()
            code = self._run(case, case.ranks, folder, result, lock)
            seconds = time.monotonic() - start
            if code != 0 or not result.exists():
                said = _last_lines(folder / OUTPUT) or "it said nothing"
                reason = f"exit code {code}: {said}" if code else f"it did not do all its frames: {said}"
                return {**case.values, "error": reason}
            told = json.loads(result.read_bytes())
            row = {**case.values, "seconds": round(seconds, 3), **self._figures(folder / "log"), **told}
            row |= {"folder": case.folder, "error": ""}
            files.write_whole(folder / DONE, json.dumps({**row, "script": self.script}).encode())
            return row

    def _run(self, case: Case | None, ranks: int, folder: Path, result: Path, lock: int = -1) -> int:
        """Run the script in a folder, and return the exit code; `lock`: what the run keeps while it lasts."""
        wishes = folder / "sweep.json"
        files.write_whole(wishes, grid.wishes_of(case, os.fspath(folder), os.fspath(result)))
        argv = [sys.executable, "-m", "motes", "run", "-n", str(ranks), *self.program]
        variables = {"MOTES_SWEEP": os.fspath(wishes), "MOTES_PROGRESS": "off", "MOTES_LIVE": "off"}
        left_out = ("MOTES_STEERING", "MOTES_FRESH")
        environment = {name: value for name, value in os.environ.items() if name not in left_out}
        if "PYTHONPATH" in environment:
            paths = environment["PYTHONPATH"].split(os.pathsep)
            environment["PYTHONPATH"] = os.pathsep.join(map(os.path.abspath, paths))
        with (folder / OUTPUT).open("wb") as output, self._lock:
            if self.stopped:
                return 128 + self.stopped
            process = subprocess.Popen(
                argv, cwd=folder, env={**environment, **variables}, stdin=subprocess.DEVNULL,
                stdout=output, stderr=subprocess.STDOUT, preexec_fn=start_of_child(),
                pass_fds=() if lock < 0 else (lock,),
            )  # fmt: skip
            self._running.add(process)
        if self.stopped:
            process.send_signal(signal.SIGTERM)
        try:
            return process.wait()
        finally:
            with self._lock:
                self._running.discard(process)

    def stop(self, number: int) -> None:
        """End the running jobs, and start no others."""
        self.stopped = number
        for process in tuple(self._running):
            process.send_signal(signal.SIGTERM)


@contextmanager
def stopping(sweep: Sweep) -> Iterator[None]:
    """Let SIGINT and SIGTERM end the sweep and its runs while the block runs."""

    def stop(number: int, _: FrameType | None) -> None:
        sweep.stop(number)

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _locked(folder: Path) -> Iterator[int]:
    """Reserve a folder, and yield the lock's file; below 0: another run has it, and does not end soon."""
    file = files.open_lock(folder / LOCK)
    deadline = time.monotonic() + _GRACE_S
    try:
        while (taken := files.is_locked_elsewhere(file)) and time.monotonic() < deadline:
            time.sleep(0.2)  # the run of a sweep that was killed ends its frame
        yield -1 if taken else file
    finally:
        os.close(file)


def _last_lines(path: Path) -> str:
    """Return the last lines of a run's output that say something, as one line."""
    lines = path.read_text(errors="replace").splitlines() if path.exists() else []
    said = [line.strip() for line in lines if line.strip(" -*\t")]
    starred = [line for line in said if line.startswith("*** motes")]
    most = 1 if any(line.startswith("Traceback") for line in said) else _LINES
    return " / ".join(starred[:1] or said[-most:])[:500]
