"""Standing jobs: ranks that are started once and then run one script (a body) after another.

`on_ranks(3, SCRIPT, *arguments)` takes the arguments of `launching.mpirun` and returns the same `Result` at a
fraction of the cost. Tests of starting, ending, dying, signals and launchers need separate jobs.

A body runs on the first ranks of a job of 5 or 9, in `tests/scenes/standing_rank.py`. The others sleep. A job
is replaced if a body kills it, hangs, or makes changes that cannot be undone.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import selectors
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from launching import POLL_S, Hang, Result, kill_session, launches, mpirun, python, take_trailer

__all__ = ["COMMAND_LINE", "alike", "end", "on_ranks"]

COMMAND_LINE = "import sys; from motes.cli import main; sys.exit(main())"
"""A script equivalent to `python -m motes`, with these arguments."""

SIZES = (5, 9)
READ_ONCE = ("GLIBC_", "LD_", "MOTES_SIMD", "OMPI_", "PYTHON")
RANK = Path(__file__).parents[1] / "scenes" / "standing_rank.py"
START_S = 120
END_S = 10
STEP_S = 5.0  # after a rank has failed, the others are expected at the body's end within this time


def on_ranks(
    n: int,
    script: str | Path,
    *arguments: object,
    timeout: float = 60,
    env: dict[str, str] | None = None,
    watch: Callable[[int], None] | None = None,
) -> Result:
    """Run a script (a path, or its text) on `n` ranks of a standing job; `watch(pid)` is called meanwhile.

    If `env` sets variables that a process reads only once, the script gets a separate job. Raises Hang, with
    everything printed, if it does not end within `timeout` seconds.
    """
    if any(name.startswith(READ_ONCE) for name in env or {}):
        return mpirun(n, script, *arguments, timeout=timeout, env=env, watch=watch)
    size = next(size for size in SIZES if n <= size)
    with _lock:
        job = _jobs.get(size)
        if job is None or not job.lives():
            job = _jobs[size] = _Job(size)
        start = time.monotonic()
        try:
            result = job.run(n, script, arguments, timeout, env or {}, watch)
        finally:
            launches.bodies += 1
            launches.body_seconds += time.monotonic() - start
            if not job.usable:
                _jobs.pop(size).kill()
    return result


def assert_goes_on(script: str, place: Path) -> None:
    """Check that two ranks continue from the checkpoint of one that died in frame 5, with the same digests.

    The script writes checkpoints to its first argument, one every two frames: the first is complete when the
    second begins. It dies with code 9 in frame KILL.
    """
    whole = on_ranks(1, script, place / "whole").lines
    assert python(script, place / "killed", env={"KILL": "5"}).code == 9
    rest = on_ranks(2, script, place / "killed")
    assert "continues with frame" in rest.err
    assert [line for line in rest.lines if line.startswith("digest")] == whole


def alike(script: str | Path, *arguments: object, ranks: Sequence[int] = (1, 2, 3)) -> list[str]:
    """Return the lines that a script prints, the same on each of these numbers of ranks."""
    first, *others = (on_ranks(n, script, *arguments).lines for n in ranks)
    for n, lines in zip(ranks[1:], others, strict=True):
        assert lines == first, f"{n} ranks print other lines than {ranks[0]}"
    return first


def end() -> None:
    """End the standing jobs, as a script ends."""
    while _jobs:
        _jobs.popitem()[1].end()


class _Job:
    """One job, and a connection to each of its ranks."""

    def __init__(self, size: int) -> None:
        start = time.monotonic()
        self.size, self.usable, self._round = size, True, 0
        self._folder = Path(tempfile.mkdtemp(prefix="motes-standing-"))
        self._own = [self._folder / "out", self._folder / "err"]
        self._links: dict[int, socket.socket] = {}
        with (
            socket.socket(socket.AF_UNIX) as door,
            self._own[0].open("wb") as out,
            self._own[1].open("wb") as err,
        ):
            door.bind(str(self._folder / "door"))
            door.listen(size)
            door.settimeout(POLL_S)
            argv = [
                sys.executable,
                "-m",
                "motes",
                "run",
                "-n",
                str(size),
                str(RANK),
                str(self._folder / "door"),
            ]
            self._process = subprocess.Popen(
                argv, stdin=subprocess.DEVNULL, stdout=out, stderr=err, start_new_session=True
            )
            try:
                while len(self._links) < size:
                    self._let_in(door, start + START_S)
            except BaseException:
                self.kill()
                raise
        launches.jobs += 1
        launches.seconds += time.monotonic() - start

    def _let_in(self, door: socket.socket, limit: float) -> None:
        try:
            link, _ = door.accept()
        except TimeoutError:
            if self._process.poll() is not None or time.monotonic() > limit:
                told = "\n".join(file.read_text(errors="replace") for file in self._own)
                raise Hang(f"a standing job of {self.size} ranks did not start\n{told}") from None
            return
        link.settimeout(None)
        self._links[int.from_bytes(link.recv(4), "little")] = link

    def lives(self) -> bool:
        """Return whether the job still runs."""
        if self._process.poll() is None:
            return True
        self.kill()
        return False

    def run(
        self,
        n: int,
        script: str | Path,
        arguments: tuple[object, ...],
        timeout: float,
        env: dict[str, str],
        watch: Callable[[int], None] | None,
    ) -> Result:
        """Run one body."""
        folder = Path(tempfile.mkdtemp(prefix="motes-body-"))
        try:
            if not isinstance(script, Path):
                (folder / "script.py").write_text(script)
                script = folder / "script.py"
            told = [folder / "out", folder / "err"]
            order = {
                "ranks": n,
                "round": self._round,
                "argv": [str(script), *map(str, arguments)],
                "cwd": os.getcwd(),
                "environment": {**os.environ, "MOTES_PROGRESS": "", **env},
                "files": [str(file) for file in told],
            }
            for file in told:
                file.touch()
            return self._follow(order, told, timeout, watch)
        except BaseException:
            self.usable = False
            raise
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _follow(
        self, order: dict[str, Any], told: list[Path], timeout: float, watch: Callable[[int], None] | None
    ) -> Result:
        start, name = time.monotonic(), os.environ.get("PYTEST_CURRENT_TEST", order["argv"][0])
        answers, ended = self._answers(order, start + timeout, watch)
        if len(answers) < order["ranks"]:
            self.usable = False
            launches.replaced.append(f"{name}: not all ranks came to its end")
            if not ended:
                kill_session(self._process.pid)
            code = self._process.wait(END_S)
            told = [*told, *self._own]
        else:
            code = next((answer["code"] for answer in answers if answer["code"] != 0), 0)
            self._round += code != 0  # some messages may not have been received
            left = sorted({text for answer in answers for text in answer["left"]})
            if left:
                self.usable = False
                launches.replaced.append(f"{name}: {', '.join(left)}")
        texts = [file.read_text(errors="replace") for file in told]
        out, err = "".join(texts[::2]), "".join(texts[1::2])
        seconds = time.monotonic() - start
        if len(answers) < order["ranks"] and not ended:
            failed = [answer["code"] for answer in answers if answer["code"] != 0]
            if not failed:
                shown = Result(code, out, err, seconds).text
                raise Hang(f"{' '.join(order['argv'])}: no end within {timeout:g} s\n{shown}")
            code = failed[0]
        return Result(code, out, err, seconds, take_trailer(err))

    def _answers(
        self, order: dict[str, Any], limit: float, watch: Callable[[int], None] | None
    ) -> tuple[list[dict[str, Any]], bool]:
        """Send an order; return the answers, and whether they are final: all are here, or the job ended."""
        answers: list[dict[str, Any]] = []
        with selectors.DefaultSelector() as waiting:
            for rank in range(order["ranks"]):
                link = self._links[rank]
                _send(link, order)
                waiting.register(link, selectors.EVENT_READ, link.makefile("rb"))
            while len(answers) < order["ranks"]:
                left_s = limit - time.monotonic()
                if left_s < 0:
                    return answers, False
                if watch is not None:
                    watch(self._process.pid)
                for key, _ in waiting.select(left_s if watch is None else POLL_S):
                    line = key.data.readline()
                    waiting.unregister(key.fileobj)
                    if not line:  # the rank has died; `motes run` ends the others and reports why
                        return answers, self._has_ended(limit)
                    answers.append(json.loads(line))
                    if answers[-1]["code"] != 0:
                        limit = min(limit, time.monotonic() + STEP_S)
        return answers, True

    def _has_ended(self, limit: float) -> bool:
        try:
            self._process.wait(max(limit - time.monotonic(), STEP_S))
        except subprocess.TimeoutExpired:
            return False
        return True

    def end(self) -> None:
        """Let the ranks end."""
        for link in self._links.values():
            link.shutdown(socket.SHUT_WR)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(END_S)
        self.kill()

    def kill(self) -> None:
        """Kill the remaining processes."""
        kill_session(self._process.pid)
        self._process.wait()
        for link in self._links.values():
            link.close()
        shutil.rmtree(self._folder, ignore_errors=True)


def _send(link: socket.socket, order: dict[str, Any]) -> None:
    with contextlib.suppress(OSError):  # the rank has died: reading will show it
        link.sendall(json.dumps(order).encode() + b"\n")


_jobs: dict[int, _Job] = {}
_lock = threading.Lock()
atexit.register(end)  # if no session of pytest does it
