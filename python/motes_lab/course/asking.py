"""The grader's side of a submission's process: sends requests, waits, and explains failures in a sentence."""

from __future__ import annotations

import ast
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from motes.balance import Orders, Targets
from motes.errors import MotesError

__all__ = ["Asked", "StartError", "SubmissionError"]

IDLE_S = 8
"""Seconds for which a submission may sleep in all; time spent waiting for a core does not count."""
CHECKED_S = 1.0
KEPT, MOST = 2000, 1_000_000
"""Bytes of a submission's output that are kept, and the most that it may write."""
_KEPT_VARIABLES = (
    *("PATH", "LD_LIBRARY_PATH", "LD_PRELOAD", "LANG", "LC_ALL", "VIRTUAL_ENV", "PYTHONHOME"),
    *("MPI4PY_LIBMPI", "MPI4PY_MPIABI", "OPAL_PREFIX", "PMIX_PREFIX", "MPI_ROOT", "I_MPI_ROOT"),
)
"""What a process needs to find programs, libraries and MPI; nothing that may hold a secret."""


class SubmissionError(MotesError):
    """A submission fails: it raises, takes too long, or does something forbidden."""


class StartError(MotesError):
    """The process for a submission does not start: the fault is the installation's, not the student's."""


class Asked:
    """A submission in a separate process: `with Asked(...) as submission: submission.ask("call", ...)`."""

    def __init__(self, path: Path, source: bytes) -> None:
        """`path` is the student's file, `source` its content. Raises SubmissionError if it is not Python."""
        self._path = path
        try:
            self._source = source.decode()
            ast.parse(self._source)
        except SyntaxError as error:
            raise SubmissionError(
                f"it does not parse: {error.msg} ({path.name}, line {error.lineno})"
            ) from None
        except ValueError as error:  # not UTF-8, or zeros in it
            raise SubmissionError(f"{path.name} is not Python: {error}") from None
        self._printed = bytearray()
        self._floods = False
        self._asleep = 0

    def __enter__(self) -> Self:
        """Start the process and load the file into it."""
        self._folder = tempfile.TemporaryDirectory(prefix="motes-grade-")
        there, self._requests = os.pipe()
        self._answers, back = os.pipe()
        command = [sys.executable, "-P", "-s", "-u", str(Path(__file__).parent / "_child.py")]
        self._process = subprocess.Popen(
            [*command, str(there), str(back)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            pass_fds=(there, back),
            env=_environment(self._folder.name, self._path),
            cwd=self._folder.name,
            start_new_session=True,
        )
        os.close(there)
        os.close(back)
        self._reader = threading.Thread(target=self._keep_output, daemon=True)
        self._reader.start()
        self._rest = b""
        try:
            self._start()
            self.ask("load", source=self._source, file=self._path.name)
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process."""
        self._close()

    def _start(self) -> None:
        """Wait until the process is ready for requests. Raises StartError if it ends before."""
        try:
            self._line()
        except EOFError:
            self._process.wait()
            self._reader.join(1.0)
            said = self.printed.strip().splitlines() or [f"exit code {self._process.returncode}"]
            raise StartError(
                f"motes does not start in the process for the submission: {said[-1]}; does "
                f"`{sys.executable} -m motes doctor` pass?"
            ) from None

    @property
    def printed(self) -> str:
        """The start of the submission's output, complete once the process has ended."""
        return self._printed.decode(errors="replace")

    def call(self, function: str, **arguments: Any) -> Any:
        """Call one of the submission's functions.

        Args:
            function: its name.
            arguments: numbers, or arrays as lists.

        Returns:
            The function's result as plain JSON types.
        """
        return self.ask("call", function=function, arguments=arguments)["value"]

    def make(self, options: dict[str, float]) -> float:
        """Make a new `Mine`; return its `smoothing`."""
        return float(self.ask("make", options=options)["smoothing"])

    def decide(self, table: dict[str, Any]) -> Targets | Orders:
        """Return the newest `Mine`'s decision for loads, given as the arguments of the core's table."""
        answer = self.ask("decide", table=table)
        return Targets(answer["shares"]) if "shares" in answer else Orders(answer["orders"])

    def ask(self, do: str, **request: Any) -> Any:
        """Send a request and wait for the answer.

        Args:
            do: the request, a function of `Submission` in `_child.py`.
            request: its arguments; arrays as lists.

        Returns:
            The answer.

        Raises:
            SubmissionError: if the submission fails.
        """
        try:
            _write(self._requests, json.dumps({"do": do, **request}).encode() + b"\n")
            answer = json.loads(self._line())
        except (BrokenPipeError, EOFError):
            raise SubmissionError(self._ended()) from None
        if "forbidden" in answer:
            raise SubmissionError(f"it {answer['forbidden']}: a submission may only compute")
        if "error" in answer:
            where = f" ({answer['where']})" if answer["where"] else ""
            raise SubmissionError(f"it raises {answer['error']}{where}")
        return answer

    def _line(self) -> bytes:
        """Return the next line of the answers."""
        while b"\n" not in self._rest:
            self._wait()
            if not (part := os.read(self._answers, 1 << 16)):
                raise EOFError
            self._rest += part
        line, _, self._rest = self._rest.partition(b"\n")
        return line

    def _wait(self) -> None:
        """Wait for an answer. Raises SubmissionError if the process sleeps for too long."""
        before = -1
        while not select.select([self._answers], [], [], CHECKED_S)[0]:
            state, ticks = _state(self._process.pid)
            self._asleep += state not in "RD" and ticks == before
            before = ticks
            if self._asleep * CHECKED_S >= IDLE_S:
                raise SubmissionError("it does not answer: is it waiting for something?")

    def _ended(self) -> str:
        """Return why the process has ended."""
        code = self._process.wait()
        if self._floods:
            return "it prints endlessly"
        if code in (-signal.SIGXCPU, -signal.SIGKILL):
            return "it takes more than 4 s of processor time: is there an endless loop?"
        if code < 0:
            return f"it ends the process: {signal.strsignal(-code)}"
        return f"it ends the process (exit code {code})"

    def _keep_output(self) -> None:
        assert self._process.stdout is not None
        left = MOST
        while part := self._process.stdout.read1(1 << 16):  # type: ignore[attr-defined]
            self._printed += part[: max(KEPT - len(self._printed), 0)]
            left -= len(part)
            if left < 0:
                self._floods = True
                os.killpg(self._process.pid, signal.SIGKILL)
                return

    def _close(self) -> None:
        os.close(self._requests)
        try:
            self._process.wait(0.5)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        self._reader.join(1.0)
        if self._process.stdout is not None:
            self._process.stdout.close()
        os.close(self._answers)
        self._folder.cleanup()


def _environment(folder: str, submission: Path) -> dict[str, str]:
    """Return the process's environment variables, without any that belong to the grader."""
    kept = {name: os.environ[name] for name in _KEPT_VARIABLES if name in os.environ}
    package = str(Path(__file__).resolve().parents[2])
    paths = os.pathsep.join([package, *_module_folders(submission)])
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    own = {"PYTHONPATH": paths, "PYTHONHASHSEED": "0", "PYTHONDONTWRITEBYTECODE": "1", "HOME": folder}
    return {**kept, **threads, **own}


def _module_folders(submission: Path) -> list[str]:
    """Return the folders of PYTHONPATH that a submission may read: not where it or the grader's files are."""
    given = [Path(one).resolve() for one in os.environ.get("PYTHONPATH", "").split(os.pathsep) if one]
    private = {Path.cwd().resolve(), *submission.resolve().parents}
    return [str(one) for one in given if one not in private]


def _state(process: int) -> tuple[str, int]:
    """Return a process's state, "S" for asleep, and how much processor time it has used, in ticks."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return fields[0], int(fields[11]) + int(fields[12])


def _write(file: int, data: bytes) -> None:
    while data:
        data = data[os.write(file, data) :]
