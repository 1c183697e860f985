"""The process in which a submission runs: it receives requests and answers them.

`asking.py` starts it as a separate script. The grader's knowledge, such as future loads, stays in another
process. This one may read only files of the installation, and may not write files, start processes, use the
network or sleep. That prevents mistakes and shortcuts; it is not a sandbox against malice.
"""

from __future__ import annotations

import json
import linecache
import os
import random
import resource
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import mpi4py

mpi4py.rc.initialize = mpi4py.rc.finalize = False  # this process is not a rank

import numpy as np  # noqa: E402

import motes  # noqa: E402, F401  (submissions import it: what it reads must be loaded before reading is forbidden)
from motes import _core  # noqa: E402
from motes.balance import Balancer, LoadTable, Orders, Targets  # noqa: E402

CPU_S = 4
MEMORY = 4 << 30
FORBIDDEN = {
    "starts a process": ("subprocess.", "os.system", "os.exec", "os.fork", "os.posix_spawn", "os.spawn"),
    "uses the network": ("socket.",),
    "loads C libraries": ("ctypes.",),
    "changes files": ("os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "shutil."),
    "sends a signal": ("os.kill", "signal."),
}
"""What a submission may not do, and the prefixes of the audit events that Python raises for it."""


class ForbiddenError(BaseException):
    """The submission does something forbidden; a BaseException, so its `except Exception` cannot hide it."""


class Guard:
    """The audit hook that raises for forbidden actions."""

    def __init__(self) -> None:
        """Remember which folders may be read."""
        package = os.path.dirname(os.path.dirname(os.path.realpath(_core.__file__)))
        roots = {sys.prefix, sys.base_prefix, *sys.path, package}
        folders = {os.path.realpath(root) + os.sep for root in roots if os.path.isdir(root)}
        self._readable = (*folders, "/usr/share/zoneinfo/", "/etc/localtime")  # the last two: for pandas
        self.seen = ""

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Raise ForbiddenError if the event is forbidden."""
        if event == "open":
            self._open(*arguments)
        for what, events in FORBIDDEN.items():
            if event.startswith(events):
                self.refuse(f"{what} ({event})")

    def _open(self, path: Any, mode: Any, flags: int) -> None:
        if flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND):
            self.refuse(f"writes a file ({path!r})")
        if isinstance(path, int) or not os.path.realpath(os.fsdecode(path)).startswith(self._readable):
            self.refuse(f"reads a file ({path!r})")

    def refuse(self, what: str) -> None:
        """Raise ForbiddenError, and remember the first reason."""
        self.seen = self.seen or what
        raise ForbiddenError(what)


class Submission:
    """The student's module."""

    def __init__(self) -> None:
        """Start without a module."""
        self._names: dict[str, Any] = {}
        self._file = ""
        self._mine: Any = None

    def load(self, source: str, file: str) -> dict[str, Any]:
        """Run the submission's file."""
        self._file = file
        linecache.cache[file] = (len(source), None, source.splitlines(True), file)
        self._names = {"__name__": "submission", "__file__": file}
        exec(compile(source, file, "exec"), self._names)
        return {}

    def call(self, function: str, arguments: dict[str, Any]) -> dict[str, Any]:
        """Call one of the submission's functions, with lists as arrays."""
        return {"value": plain(self._of(function)(**{name: array(one) for name, one in arguments.items()}))}

    def make(self, options: dict[str, Any]) -> dict[str, Any]:
        """Make a new `Mine`."""
        kind = self._of("Mine")
        if not (isinstance(kind, type) and issubclass(kind, Balancer)):
            raise TypeError("Mine is not a subclass of motes.balance.Balancer")
        self._mine = kind(**options)
        return {"smoothing": float(self._mine.smoothing)}

    def decide(self, table: dict[str, Any]) -> dict[str, Any]:
        """Return the decision of `Mine` for a table of loads."""
        answer = self._mine.decide(LoadTable(_core.BalanceTable(**table)))
        if isinstance(answer, Targets):
            return {"shares": plain(np.asarray(answer.shares, np.float64))}
        if isinstance(answer, Orders):
            return {"orders": [[plain(number) for number in move] for move in answer.moves]}
        raise TypeError(f"decide returns {type(answer).__name__}, not Targets or Orders")

    def where(self, error: BaseException) -> str:
        """Return the submission's line that raised an error; "" if there is none."""
        lines = [line for name, line in _lines(error) if name == self._file]
        return f"{os.path.basename(self._file)}, line {lines[-1]}" if lines else ""

    def _of(self, name: str) -> Any:
        if name not in self._names:
            raise NameError(f"the file does not define {name}")
        return self._names[name]


def array(value: Any) -> Any:
    """Convert a list to an array; return other values unchanged."""
    return np.array(value, np.float64) if isinstance(value, list) else value


def plain(value: Any) -> Any:
    """Convert a value to plain types that JSON can hold."""
    if isinstance(value, (str, bool, int, float, type(None))):
        return value
    if isinstance(value, (np.generic, np.ndarray)):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    if isinstance(value, dict):
        return {str(name): plain(part) for name, part in value.items()}
    if hasattr(value, "to_numpy"):  # a table of pandas
        return plain(value.to_numpy())
    raise TypeError(
        f"the answer contains a {type(value).__name__}; only numbers, lists and dicts are allowed"
    )


def _lines(error: BaseException) -> list[tuple[str, int | None]]:
    if isinstance(error, SyntaxError) and error.filename:
        return [(error.filename, error.lineno)]
    return [(frame.filename, frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]


def answered(guard: Guard, submission: Submission, function: Callable[..., Any], request: Any) -> Any:
    """Return a function's answer, or its error."""
    try:
        answer = function(**request)
    except BaseException as error:
        text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        answer = {"error": text, "where": submission.where(error)}
    return {"forbidden": guard.seen} if guard.seen else answer


def restrict() -> Guard:
    """Limit this process's resources and forbid what a submission must not do; cannot be undone."""
    random.seed(0)
    np.random.seed(0)
    used = resource.getrusage(resource.RUSAGE_SELF)
    spent = int(used.ru_utime + used.ru_stime) + 1
    for limit, value in (
        (resource.RLIMIT_CPU, spent + CPU_S),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_CORE, 0),
    ):
        with suppress(ValueError, OSError):  # a lower limit is in force already
            resource.setrlimit(limit, (value, value))
    guard = Guard()
    time.sleep = lambda _: guard.refuse("sleeps")
    sys.addaudithook(guard)
    return guard


def main() -> None:
    """Answer requests, one line of JSON each, until the pipe closes."""
    requests, answers = os.fdopen(int(sys.argv[1])), os.fdopen(int(sys.argv[2]), "w")
    submission, guard = Submission(), restrict()
    answers.write("ready\n")
    answers.flush()
    for line in requests:
        request = json.loads(line)
        function = getattr(submission, request.pop("do"))
        try:
            text = json.dumps(answered(guard, submission, function, request))
        except BaseException as error:  # not JSON, such as a list that contains itself
            text = json.dumps({"error": f"{type(error).__name__}: {error}", "where": ""})
        answers.write(text + "\n")
        answers.flush()
    os._exit(0)  # do not wait for the submission's threads


if __name__ == "__main__":
    main()
