"""When a rank fails, print one report and end the whole job.

Without this, a rank that fails waits in MPI_Finalize for the others, and the others wait for its messages:
the job hangs forever. Every exit from a script (an exception, sys.exit, Ctrl-C, a thread's exception, the
script's early end, the death of a process) therefore leads here: to one report on standard error and
MPI_Abort. With a single rank nothing can hang, and Python behaves as usual.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import faulthandler
import os
import signal
import sys
import threading
import time
import traceback
from types import TracebackType
from typing import NoReturn

from .. import _core
from .._mpi import rank_process
from ..errors import MotesError, place
from . import attendance, continuing, losses
from .process import OpenRun, process
from .speaking import SPEAKER_WAIT_S, free_reserve, may_speak, print_report, reserve

__all__ = ["end_fork", "end_left", "install", "report_lost", "stop_job"]

ABORT_LIMIT_S = 2.0  # how long MPI_Abort may take before the watchdog ends the process
_ARRIVAL_S = 0.1  # for the report to reach a launcher that no longer listens once it aborts (MPICH's)
TEARDOWN_S = 0.1  # an abort ends all peers within this time; otherwise a process that is gone was lost

_installed = False
_ending = threading.Lock()
_previous_hook = sys.excepthook
_previous_thread_hook = threading.excepthook

_PR_SET_PDEATHSIG = 1


def install() -> None:
    """Install hooks on all exits from the script, once, after mpi4py.MPI is imported."""
    global _installed, _previous_hook, _previous_thread_hook
    from mpi4py import MPI

    if _installed or not MPI.Is_initialized() or MPI.Is_finalized():
        return
    _installed = True
    if rank_process.is_fork():  # motes was first imported in the forked process
        atexit.register(_on_exit_of_fork)
        return
    os.register_at_fork(after_in_child=_become_fork)
    process.rank, process.size = MPI.COMM_WORLD.rank, MPI.COMM_WORLD.size
    process.job = os.environ.get("PMIX_NAMESPACE", "")
    if process.size > 1:
        rank_process.hide()
    if not faulthandler.is_enabled() and sys.__stderr__ is not None:
        with contextlib.suppress(OSError, ValueError, AttributeError):  # in notebooks, stderr is not a file
            faulthandler.enable(sys.__stderr__)
    if process.size == 1:
        return
    process.survives = losses.survived()
    reserve()
    _end_with_parent()
    _previous_hook, sys.excepthook = sys.excepthook, _on_exception
    _previous_thread_hook, threading.excepthook = threading.excepthook, _on_thread_exception
    # Exit handlers run in reverse order, so this one runs before mpi4py's MPI_Finalize.
    atexit.register(_on_exit)


def _end_with_parent() -> None:
    """Let the kernel kill this rank when its parent, the launcher or its daemon, is gone (Linux)."""
    if sys.platform != "linux":
        return
    parent = os.getppid()
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)
    if os.getppid() != parent:  # the daemon died before the call above
        os._exit(1)


# --- processes that this rank forks off


def _become_fork() -> None:
    """Detach a process that this rank has just forked off from the job: one rank, no open run."""
    rank_process.became_fork()
    if process.entered:  # crashes would be reported as the rank's
        _core.name_crashes("", losses.lost_line())
        _core.set_place(f"a process forked by {place(process.rank)}")
    _core.forget_stop_signal()
    process.forget()
    if sys.excepthook is _on_exception:
        sys.excepthook = _previous_hook
    if threading.excepthook is _on_thread_exception:
        threading.excepthook = _previous_thread_hook
    atexit.unregister(_on_exit)
    atexit.register(_on_exit_of_fork)


def _on_exit_of_fork() -> None:
    """Keep mpi4py from finalizing MPI on behalf of the rank that forked this process."""
    if not _core.forget_mpi():
        end_fork(None)


def end_fork(error: BaseException | None) -> NoReturn:
    """End a forked process as Python would; the run of the rank that forked it continues silently."""
    with contextlib.suppress(BaseException):
        if error is not None and not isinstance(error, SystemExit):
            traceback.print_exception(error)
        elif isinstance(error, SystemExit) and error.code is not None and not isinstance(error.code, int):
            print(error.code, file=sys.stderr)
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(Exception):
                stream.flush()
    code = None if error is None else error.code if isinstance(error, SystemExit) else 1
    os._exit(0 if code is None else code & 0xFF if isinstance(code, int) else 1)


# --- exits


def stop_job(error: BaseException, run: OpenRun | None = None) -> None:
    """End the whole job because `error` left the `with world:` block of `run`.

    Returns only if there is a single rank.
    """
    if process.size == 1:
        return
    free_reserve()
    body = _trace(error)
    if isinstance(error, SystemExit):
        shown = "" if error.code is None else repr(error.code)
        headline = f"{process.describe(run)}: called sys.exit({shown}) in the middle of the run"
        _end(headline, body, _exit_code(error))
    _end(_headline(error, run), body, _exit_code(error), speaker=_speaker(error, run), lost=_lost(error))


def end_left(rank: int | None, *, lost: bool = False) -> NoReturn:
    """End the whole job because a rank left the script, or was lost, before a run that needs it started."""
    who = "another rank" if rank is None else place(rank)
    if lost:
        _end(f"{who} is lost (killed or crashed), and a run needs all its ranks to start", "", 1, lost=True)
    _end(f"{who} left the script before the run started; the others would wait forever", "", 1)


def report_lost(rank: int, role: str, frame: int | None) -> NoReturn:
    """End the whole job because the process of another rank (of COMM_WORLD) is gone."""
    # The process may be gone because it has reported an error and is aborting the job, which then ends this
    # process during the sleep.
    time.sleep(TEARDOWN_S)
    _end(f"{place(rank, role=role, frame=frame)}: its process is gone (killed or crashed)", "", 1, lost=True)


def _on_exception(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    free_reserve()
    body = "".join(traceback.format_exception(kind, error, trace))
    _end(_headline(error), body, _exit_code(error), speaker=_speaker(error), error=error, lost=_lost(error))


def _on_thread_exception(args: threading.ExceptHookArgs) -> None:
    if args.exc_value is None or issubclass(args.exc_type, SystemExit):
        _previous_thread_hook(args)  # sys.exit may end a thread
        return
    free_reserve()
    name = args.thread.name if args.thread is not None else "a thread"
    body = "".join(traceback.format_exception(args.exc_type, args.exc_value, args.exc_traceback))
    _end(f"{_headline(args.exc_value)} (in thread {name})", body, _exit_code(args.exc_value))


def _on_exit() -> None:
    """Leave the job after a script that ended without an error, before MPI_Finalize."""
    from mpi4py import MPI

    if MPI.Is_finalized():
        return
    if process.running:
        _end(f"{process.describe()}: the script left in the middle of the run", "", 1)
    if process.stopped:  # flush now: mpirun ends this rank as soon as another exits with the signal's code
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(Exception):
                stream.flush()
    films = process.survives and bool(continuing.outlasting_movies())
    if attendance.leave(wait=films) and films:
        _close_films()


def _close_films() -> None:
    """Close films whose writer was lost after the end of its world; all live ranks are here."""
    from mpi4py import MPI

    try:
        lost = losses.lost_ranks(MPI.COMM_WORLD)
        first = next(rank for rank in range(process.size) if rank not in lost)
        for movie in continuing.outlasting_movies() if lost and process.rank == first else ():
            movie.close_for_lost()
    except Exception as error:  # of any kind, from a film's file
        _end(_headline(error), _trace(error), 1)


def _trace(error: BaseException) -> str:
    """Format an error with its traceback, including the outer frames that it has not propagated to yet."""
    text, head = "".join(traceback.format_exception(error)), "Traceback (most recent call last):\n"
    caller = error.__traceback__.tb_frame.f_back if error.__traceback__ is not None else None
    if caller is None or head not in text:
        return text
    callers = traceback.StackSummary.extract(traceback.walk_stack(caller))
    callers.reverse()
    before, _, after = text.rpartition(head)
    return before + head + "".join(callers.format()) + after


def _headline(error: BaseException, run: OpenRun | None = None) -> str:
    text = "".join(traceback.format_exception_only(error)).strip()
    # The text of an error that all ranks raise names the rank that failed, which may be another one.
    return text if getattr(error, "speaker", None) is not None else f"{process.describe(run)}: {text}"


def _speaker(error: BaseException, run: OpenRun | None = None) -> int | None:
    """Return the rank of COMM_WORLD that prints an agreed error; `error.speaker` is its rank in the run."""
    speaker: int | None = getattr(error, "speaker", None)
    if run is None and process.runs:
        run = process.runs[-1]
    return speaker if speaker is None or run is None else run.world_rank(speaker)


def _exit_code(error: BaseException) -> int:
    if isinstance(error, KeyboardInterrupt):
        return 130
    code = error.code if isinstance(error, SystemExit) else 1
    return (code & 0xFF) or 1 if isinstance(code, int) else 1  # 8 bits must not wrap to 0, success


# --- the report and the end


def _end(
    headline: str,
    body: str,
    code: int,
    *,
    speaker: int | None = None,
    error: BaseException | None = None,
    lost: bool = False,
) -> NoReturn:
    """Print the report, if this rank is the one to print it, and end every rank; `lost`: a rank was lost."""
    if _ending.acquire(blocking=False):
        with contextlib.suppress(BaseException):
            free_reserve()
            for stream in (sys.stdout, sys.stderr):
                with contextlib.suppress(Exception):
                    stream.flush()
            if may_speak(speaker):
                _call_previous_hook(error)
                print_report(headline, body, before=losses.lost_line() if lost else "")
                time.sleep(_ARRIVAL_S)
    else:  # another thread of this rank is already aborting
        with contextlib.suppress(BaseException):
            time.sleep(SPEAKER_WAIT_S)
    abort(code)


def abort(code: int) -> NoReturn:
    """End every rank with this exit code, or at least this process, in any state of Python and MPI."""
    from mpi4py import MPI

    if process.survives:
        losses.end_job(code)
    with contextlib.suppress(BaseException):
        _core.end_process_after(ABORT_LIMIT_S, code)
        if MPI.Is_initialized() and not MPI.Is_finalized():
            MPI.COMM_WORLD.Abort(code)
    os._exit(code)


def _lost(error: BaseException) -> bool:
    return isinstance(error, MotesError) and error.lost


def _call_previous_hook(error: BaseException | None) -> None:
    """Call the user's exception hook (a logger, a crash reporter); Python's would print the error twice."""
    if error is not None and _previous_hook is not sys.__excepthook__:
        with contextlib.suppress(BaseException):
            _previous_hook(type(error), error, error.__traceback__)
