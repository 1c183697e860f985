"""One rank of a standing job (tests/support/standing.py): runs bodies, each as if in a new process.

Argument: the socket from which orders come. Between orders the rank sleeps while reading it; when it is
closed, the rank ends, even within a body.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import importlib
import json
import os
import pkgutil
import re
import resource
import runpy
import select
import signal
import socket
import stat
import sys
import sysconfig
import threading
import time
import traceback
import types
import warnings
import weakref
from typing import Any, NoReturn

import numpy as np
from mpi4py import MPI

import motes
from motes import _core
from motes._run import ending, speaking
from motes._run.process import process

WORLD = MPI.COMM_WORLD
LAUNCHERS = ("OMPI_", "PMIX_", "PRTE_", "PMI_", "HWLOC_", "MOTES_OPEN_WORLDS")
COUNTS = ("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_SIZE", "OMPI_UNIVERSE_SIZE", "OMPI_MCA_num_procs")
UNNEEDED = ("motes.__main__", "motes._player.widget", "motes.cli")
INSTALLED = tuple(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib"))
PACKAGE = os.path.dirname(os.path.abspath(motes.__file__))
THREADS_S = 1.0  # how long threads that a body leaves behind may take to end
LIMITS = [getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")]
communicators: dict[tuple[int, int], MPI.Intracomm] = {}
codes: list[int] = []  # exit codes with which the body ended its job


def load_package() -> None:
    """Import every module that bodies may import, so its initial state is known."""
    for module in pkgutil.walk_packages(motes.__path__, "motes."):
        if not module.name.startswith(UNNEEDED):
            with contextlib.suppress(ImportError):
                importlib.import_module(module.name)


class Kept:
    """The state of the package: names in modules, classes and objects, and containers found there."""

    def __init__(self) -> None:
        self._names: list[tuple[Any, dict[str, Any]]] = []
        self._contents: list[tuple[Any, Any]] = []
        for name, module in list(sys.modules.items()):
            if name.partition(".")[0] == "motes" and isinstance(module, types.ModuleType):
                self._keep_names(module)
                for value in list(vars(module).values()):
                    self._keep(value)

    def _keep(self, value: Any) -> None:
        if type(value) in (dict, list, set):
            self._contents.append((value, value.copy()))
        elif type(value) is weakref.WeakSet:
            self._contents.append((value, set(value)))
        elif _is_ours(value):
            self._keep_names(value)
            for own in vars(value).values():
                if type(own) in (dict, list, set):
                    self._contents.append((own, own.copy()))

    def _keep_names(self, owner: Any) -> None:
        self._names.append((owner, dict(vars(owner))))

    def restore(self) -> None:
        """Restore the saved state."""
        for owner, before in self._names:
            now = vars(owner)
            if now.keys() == before.keys() and all(now[name] is value for name, value in before.items()):
                continue
            for name in [name for name in now if name not in before and not name.startswith("__")]:
                if not isinstance(now[name], types.ModuleType):
                    delattr(owner, name)
            for name, value in before.items():
                if now.get(name, owner) is not value:
                    setattr(owner, name, value)
        for container, before in self._contents:
            if container != before:
                container.clear()
                container.extend(before) if isinstance(container, list) else container.update(before)


def _is_ours(value: Any) -> bool:
    """Return whether a value is a class of the package or an instance of one."""
    ours = getattr(value, "__module__", "").partition(".")[0] == "motes"
    return ours and hasattr(value, "__dict__") and not isinstance(value, types.FunctionType)


def open_files() -> set[int]:
    """Return the descriptors of regular files, except shared memory."""
    found = set()
    for name in os.listdir("/proc/self/fd"):
        with contextlib.suppress(OSError):
            path = os.readlink(f"/proc/self/fd/{name}")
            if stat.S_ISREG(os.stat(int(name)).st_mode) and not re.match("/dev/|.*/ompi[.]", path):
                found.add(int(name))
    return found


class Surroundings:
    """The state of the interpreter and the process that a script may change."""

    def __init__(self) -> None:
        self._environment, self._cwd = dict(os.environ), os.getcwd()
        self._modules, self._path = set(sys.modules), list(sys.path)
        self._threads = set(threading.enumerate())
        self._files = open_files()
        self._names = {
            name: getattr(sys, name)
            for name in ("argv", "stdin", "stdout", "stderr", "excepthook", "unraisablehook", "displayhook")
        }
        self._thread_hook = threading.excepthook
        self._recursion, self._numbers = sys.getrecursionlimit(), np.geterr()
        self._mask = signal.pthread_sigmask(signal.SIG_BLOCK, [])
        self._handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
        self._limits = {limit: resource.getrlimit(limit) for limit in LIMITS}
        self._umask = os.umask(0o22)
        os.umask(self._umask)

    def restore(self) -> list[str]:
        """Restore the state; return descriptions of what cannot be restored."""
        left = [f"a thread named {thread.name!r}" for thread in self._threads_left()]
        for file in open_files() - self._files:  # left by a failed body; they may be locked
            os.close(file)
        os.environ.clear()
        os.environ.update(self._environment)
        os.chdir(self._cwd)
        os.umask(self._umask)
        for name, value in self._names.items():
            setattr(sys, name, value)
        for name in ("ps1", "ps2"):
            if hasattr(sys, name):
                delattr(sys, name)
        threading.excepthook = self._thread_hook
        sys.setrecursionlimit(self._recursion)
        np.seterr(**self._numbers)
        sys.path[:] = self._path
        for name in set(sys.modules) - self._modules:
            file = getattr(sys.modules[name], "__file__", None) or ""
            if not file.startswith((*INSTALLED, PACKAGE)):
                del sys.modules[name]
        return [*left, *self._restore_signals(), *self._restore_limits()]

    def _threads_left(self) -> set[threading.Thread]:
        limit = time.monotonic() + THREADS_S
        while (left := set(threading.enumerate()) - self._threads) and time.monotonic() < limit:
            gc.collect()
            next(iter(left)).join(0.02)
        return left

    def _restore_signals(self) -> list[str]:
        left = ["a signal that asks for a stop"] if _core.stop_signal() else []
        _core.release_stop_signals()
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.pthread_sigmask(signal.SIG_SETMASK, self._mask)
        for number, handler in self._handlers.items():
            if signal.getsignal(number) is not handler:
                if handler is None:
                    left.append(f"a handler of signal {number}")
                else:
                    signal.signal(number, handler)
        return left

    def _restore_limits(self) -> list[str]:
        left = []
        for limit, before in self._limits.items():
            if resource.getrlimit(limit) != before:
                try:
                    resource.setrlimit(limit, before)
                except (OSError, ValueError):
                    left.append(f"a resource limit ({limit})")
        return left


@contextlib.contextmanager
def output(files: list[str]) -> Any:
    """Redirect this process's output, also from C++, to files to which all ranks append."""
    own = [os.dup(1), os.dup(2)]
    for number, file in enumerate(files, start=1):
        target = os.open(file, os.O_WRONLY | os.O_APPEND)
        os.dup2(target, number)
        os.close(target)
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__):
            with contextlib.suppress(Exception):
                stream.flush()
        ctypes.CDLL(None).fflush(None)
        for number, before in enumerate(own, start=1):
            os.dup2(before, number)
            os.close(before)


def enter(order: dict[str, Any]) -> None:
    """Make this process look like a rank of a new job."""
    codes.clear()
    n, key = order["ranks"], (order["ranks"], order["round"])
    if key not in communicators:
        communicators[key] = WORLD.Create_group(WORLD.group.Incl(range(n)))
    MPI.COMM_WORLD = communicators[key]
    process.rank, process.size = MPI.COMM_WORLD.rank, n
    launched = {name: text for name, text in os.environ.items() if name.startswith(LAUNCHERS)}
    launched.update({name: str(n) for name in COUNTS if name in launched})
    launched["PMIX_SERVER_TMPDIR"] = os.path.dirname(order["files"][0])  # where a rank claims the report
    os.environ.clear()
    os.environ.update(order["environment"])
    if n > 1:
        os.environ.update(launched)
        speaking.reserve()
        ending._ending = threading.Lock()
    else:
        threading.excepthook = threading.__excepthook__
    os.chdir(order["cwd"])
    sys.argv = order["argv"]
    told = [entry for entry in os.environ.get("PYTHONPATH", "").split(os.pathsep) if entry]
    told = [entry for entry in told if entry not in sys.path]
    sys.path[:1] = [os.path.dirname(os.path.abspath(sys.argv[0])), *told]


class Ended(BaseException):
    """Raised where the package would end the whole job with this exit code; it ends only the body."""


def abort(code: int) -> NoReturn:
    """Replace `ending.abort`."""
    codes.append(code)
    raise Ended(codes[0])  # abort may be called again during unwinding


def may_speak(speaker: int | None) -> bool:
    """Replace `ending.may_speak`; there, the speaker's abort would end the other ranks."""
    limit = time.monotonic() + speaking.SPEAKER_WAIT_S
    while speaker not in (None, process.rank) and not os.path.exists(str(speaking.mark())):
        if time.monotonic() > limit:
            break
        time.sleep(0.005)
    return speaking.claim_report()


def run(script: str) -> int:
    """Run a script; return the exit code that it would have as a process."""
    try:
        runpy.run_path(script, run_name="__main__")
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return (end.code or 0) & 0xFF
        print(end.code, file=sys.stderr)
        return 1
    except Ended as end:
        return end.args[0]
    except BaseException as error:
        trace = error.__traceback__
        while trace is not None and trace.tb_frame.f_code.co_filename != script:
            trace = trace.tb_next
        error = error.with_traceback(trace or error.__traceback__)
        if process.size == 1:
            traceback.print_exception(error)
            return 130 if isinstance(error, KeyboardInterrupt) else 1
        try:
            sys.excepthook(type(error), error, error.__traceback__)
        except Ended as end:
            return end.args[0]
        return 1  # the script's own hook has returned
    return 0


def answer(order: dict[str, Any]) -> dict[str, Any]:
    """Run a body and restore the process afterwards."""
    left = []
    with output(order["files"]), warnings.catch_warnings():
        surroundings = Surroundings()
        enter(order)
        code = run(order["argv"][0])
        if process.running and process.size > 1 and not code:
            print(f"{process.describe()}: the script left in the middle of the run", file=sys.stderr)
            code, left = 1, ["an open world"]
        speaking.free_reserve()
        gc.collect()
        left += surroundings.restore()
    MPI.COMM_WORLD = WORLD
    kept.restore()
    gc.collect()
    return {"code": code, "left": left}


def end_with(link: socket.socket) -> None:
    """End this process once no process is left to send orders."""
    poll = select.poll()
    poll.register(link, select.POLLHUP)
    poll.poll()
    os._exit(1)


sys.stdout.reconfigure(line_buffering=True)
load_package()
ending.abort, ending.may_speak, ending.SPEAKER_WAIT_S = abort, may_speak, 0.0
speaking.free_reserve()
kept = Kept()
with socket.socket(socket.AF_UNIX) as link:
    link.connect(sys.argv[1])
    link.sendall(WORLD.rank.to_bytes(4, "little"))
    threading.Thread(target=end_with, args=(link,), name="end with the tests", daemon=True).start()
    gc.collect()
    gc.freeze()
    try:
        for line in link.makefile("rb"):
            link.sendall(json.dumps(answer(json.loads(line))).encode() + b"\n")
    except BaseException:
        traceback.print_exc()
        os._exit(1)
os._exit(0)  # without MPI_Finalize, which may wait for operations of failed bodies
