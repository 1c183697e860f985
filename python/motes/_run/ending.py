"""What happens when a rank fails: one message, and the job ends everywhere.

Left alone, a rank that fails waits in MPI_Finalize for the others, and the others wait for its messages:
the job hangs for ever. So each way out of a script (an exception, sys.exit, Ctrl-C, a thread's exception,
the script's early end, the death of a process) leads here, to one report on standard error and MPI_Abort.
With a single rank nothing can hang, and Python behaves as ever.
"""

from __future__ import annotations

import atexit
import contextlib
import faulthandler
import hashlib
import os
import select
import signal
import socket
import sys
import threading
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, NamedTuple, NoReturn

from ..errors import place

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["Peer", "PeerWatch", "begin", "end", "install", "report_lost", "state", "stop_job"]

EXIT_WAIT_S = 0.5  # how long the ranks' normal ends may lie apart before a departing rank says that it left
SPEAKER_WAIT_S = 2.5  # how long a silent rank waits for the speaker's abort to end it
ABORT_LIMIT_S = 2.0  # how long MPI_Abort may take before the system ends the process
TEARDOWN_S = 0.1  # an abort ends its peers within this time; a process that is gone without one was lost
PEER_CHECK_S = 0.02
REPORT_BYTES = 32768  # more would not fit into the pipe to the launcher in one piece
_LEFT_TAG = 32741  # on COMM_WORLD: "I left before the run started"; every MPI allows tags up to 32767


@dataclass
class State:
    """What this rank is doing. `World` keeps it up to date; messages and the way out depend on it."""

    rank: int = 0
    size: int = 1
    role: str = ""
    """In words, such as "calculator 0" or "image generator, manager"."""
    frame: int | None = None
    running: bool = False
    """Inside a run: to leave now would hang the others."""
    finished: bool = False
    """A run ended well on this rank."""

    def describe(self) -> str:
        """Name this rank: "rank 2 (calculator 0), frame 7"."""
        return place(self.rank, role=self.role, frame=self.frame)


state = State()
_installed = False
_ending = threading.Lock()
_previous_hook = sys.excepthook
_previous_thread_hook = threading.excepthook


def install() -> None:
    """Take over the ways out of the script; called once, after mpi4py.MPI is imported."""
    global _installed, _previous_hook, _previous_thread_hook
    from mpi4py import MPI

    if _installed or not MPI.Is_initialized() or MPI.Is_finalized():
        return
    _installed = True
    state.rank, state.size = MPI.COMM_WORLD.rank, MPI.COMM_WORLD.size
    if not faulthandler.is_enabled() and sys.__stderr__ is not None:
        with contextlib.suppress(OSError, ValueError, AttributeError):  # a notebook's stderr is no file
            faulthandler.enable(sys.__stderr__)
    if state.size == 1:
        return
    _previous_hook, sys.excepthook = sys.excepthook, _on_exception
    _previous_thread_hook, threading.excepthook = threading.excepthook, _on_thread_exception
    # The last registered runs first: mpi4py was imported before, so this runs before its MPI_Finalize.
    atexit.register(_on_exit)


# --- the run's start and end


def begin(comm: MPI.Comm) -> None:
    """Wait until every rank of `comm` is about to run. Collective.

    `World` calls it before anything that blocks. A rank whose script ended earlier is reported instead of
    waited for.
    """
    from mpi4py import MPI

    everybody = comm.Ibarrier() if comm.size > 1 else MPI.REQUEST_NULL
    pause = 0.0
    while not everybody.Test():
        left = _who_left(comm)
        if left is not None:
            text = f"{place(left)} left the script before the run started; the others would wait for ever"
            _end(text, "", 1)
        time.sleep(pause)
        pause = min(pause + 1e-4, 5e-3)
    state.running, state.finished = True, False


def end() -> None:
    """Note that the run ended well; from here on this rank may leave when it likes."""
    state.running, state.finished, state.frame = False, True, None


def _who_left(comm: MPI.Comm) -> int | None:
    """Name a rank (of COMM_WORLD) that `comm` needs and that has said it left."""
    from mpi4py import MPI

    status = MPI.Status()
    world = MPI.COMM_WORLD
    if state.size == 1 or not world.Iprobe(MPI.ANY_SOURCE, _LEFT_TAG, status):
        return None
    left = status.Get_source()
    inside = MPI.Group.Translate_ranks(world.Get_group(), [left], comm.Get_group())[0]
    return left if inside != MPI.UNDEFINED else None


# --- the ways out


def stop_job(error: BaseException) -> None:
    """End the whole job because `error` left the `with world:` block. Returns only when there is one rank."""
    if state.size == 1:
        return
    body = "".join(traceback.format_exception(error))
    if isinstance(error, SystemExit):
        shown = "" if error.code is None else repr(error.code)
        headline = f"{state.describe()}: called sys.exit({shown}) in the middle of the run"
        _end(headline, body, _exit_code(error))
    _end(_headline(error), body, _exit_code(error), speaker=getattr(error, "speaker", None))


def report_lost(rank: int, role: str, frame: int | None) -> NoReturn:
    """End the whole job because the process of another rank is gone."""
    # The process may be gone because its own abort is under way and has spoken already: then this one ends
    # here.
    time.sleep(TEARDOWN_S)
    _end(f"{place(rank, role=role, frame=frame)}: its process is gone (killed or crashed)", "", 1)


def _on_exception(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    body = "".join(traceback.format_exception(kind, error, trace))
    _end(_headline(error), body, _exit_code(error), speaker=getattr(error, "speaker", None), error=error)


def _on_thread_exception(args: threading.ExceptHookArgs) -> None:
    if args.exc_value is None or issubclass(args.exc_type, SystemExit):
        _previous_thread_hook(args)  # a thread may end itself by sys.exit
        return
    name = args.thread.name if args.thread is not None else "a thread"
    body = "".join(traceback.format_exception(args.exc_type, args.exc_value, args.exc_traceback))
    _end(f"{_headline(args.exc_value)} (in thread {name})", body, _exit_code(args.exc_value))


def _on_exit() -> None:
    """Last act of a rank whose script ended without an error, before MPI_Finalize."""
    from mpi4py import MPI

    if MPI.Is_finalized():
        return
    if state.running:
        _end(f"{state.describe()}: the script left in the middle of the run", "", 1)
    _leave()


def _leave() -> None:
    """Leave together with the others; if they stay longer, tell the next rank, in case it starts a run.

    Those who wait for this rank in `begin` find the note, however much later they get there: of the ranks
    that wait, at least one stands next to one that left. Nobody is hurried: a rank may close a movie for
    minutes.
    """
    from mpi4py import MPI

    world = MPI.COMM_WORLD
    everybody = world.Ibarrier()
    note = MPI.REQUEST_NULL
    start = time.monotonic()
    while not everybody.Test():
        waited = time.monotonic() - start
        if waited > EXIT_WAIT_S and note == MPI.REQUEST_NULL:
            note = world.Isend([b"", 0, MPI.BYTE], (state.rank + 1) % state.size, _LEFT_TAG)
        if waited > 2 * EXIT_WAIT_S:
            return  # MPI_Finalize waits for the others just as well, and for those without motes too
        time.sleep(2e-3)


def _headline(error: BaseException) -> str:
    text = "".join(traceback.format_exception_only(error)).strip()
    # An error that all ranks agreed on names the guilty rank by itself; it need not be this one.
    return text if getattr(error, "speaker", None) is not None else f"{state.describe()}: {text}"


def _exit_code(error: BaseException) -> int:
    if isinstance(error, KeyboardInterrupt):
        return 130
    code = error.code if isinstance(error, SystemExit) else 1
    return (code & 0xFF) or 1 if isinstance(code, int) else 1  # an 8-bit code must not wrap to "well done"


# --- one message, one end


def _end(
    headline: str, body: str, code: int, *, speaker: int | None = None, error: BaseException | None = None
) -> NoReturn:
    """Print the report, if it is this rank's to print, and end every rank."""
    if _ending.acquire(blocking=False):
        with contextlib.suppress(BaseException):
            for stream in (sys.stdout, sys.stderr):
                with contextlib.suppress(Exception):
                    stream.flush()
            if _may_speak(speaker):
                _call_previous_hook(error)
                _print(headline, body)
    else:  # another thread of this rank is at it
        with contextlib.suppress(BaseException):
            time.sleep(SPEAKER_WAIT_S)
    _abort(code)


def _abort(code: int) -> NoReturn:
    from mpi4py import MPI

    with contextlib.suppress(BaseException):
        # Without a handler this signal ends the process whatever state Python and MPI are in, and with it
        # the job.
        signal.setitimer(signal.ITIMER_REAL, ABORT_LIMIT_S)
        if MPI.Is_initialized() and not MPI.Is_finalized():
            MPI.COMM_WORLD.Abort(code)
    os._exit(code)


def _may_speak(speaker: int | None) -> bool:
    """Decide whether this rank prints; a rank that must not waits here for the speaker's abort to end it."""
    if speaker is not None and speaker != state.rank:
        time.sleep(SPEAKER_WAIT_S)  # should the speaker never speak, somebody must
    if not _take_voice():
        time.sleep(SPEAKER_WAIT_S)
        return False
    if speaker is None and not _one_host():
        # One rank of each host got its host's voice: the lowest speaks, and its abort ends the others
        # meanwhile.
        time.sleep(min(1.0, 0.05 * state.rank))
    return True


def mark() -> str | None:
    """Name the file whose maker alone speaks for this host in this job, where there is a place for it.

    The launcher's own directory lasts to the job's end, and so does the claim: even for a rank that finds the
    speaker dead.
    """
    directory = os.environ.get("PMIX_SERVER_TMPDIR")
    return None if directory is None else os.path.join(directory, f"motes-voice-{_key(_job())}")


def _take_voice() -> bool:
    """Claim this host's only right to speak in this job; true for the first that asks."""
    made = mark()
    if made is not None:
        with contextlib.suppress(OSError):
            try:
                os.close(os.open(made, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
                return True
            except FileExistsError:
                return False
    # A socket's name is free again when the speaker dies, which is soon enough in nearly all cases.
    claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        claim.bind(f"\0motes-{_key(_job())}-{os.getuid()}")
    except OSError:
        claim.close()
        return sys.platform != "linux"  # no such names there: only the delay keeps ranks apart
    claim.detach()  # open, and the name taken, until this process ends
    return True


def _job() -> str:
    return os.environ.get("PMIX_NAMESPACE") or str(os.getppid())


def _key(job: str) -> str:
    return hashlib.sha256(job.encode()).hexdigest()[:16]


def _one_host() -> bool:
    names = ("OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS")
    return str(state.size) in [os.environ.get(name) for name in names]


def _call_previous_hook(error: BaseException | None) -> None:
    """Let the user's own hook (a logger, a crash reporter) see the error; Python's would print it twice."""
    if error is not None and _previous_hook is not sys.__excepthook__:
        with contextlib.suppress(BaseException):
            _previous_hook(type(error), error, error.__traceback__)


def _print(headline: str, body: str) -> None:
    text = f"\n*** motes: {headline}\n{body}".rstrip("\n").encode(errors="replace") + b"\n"
    if len(text) > REPORT_BYTES:
        half = REPORT_BYTES // 2
        text = text[:half] + b"\n  ...\n" + text[-half:]
    while text:  # one write, unless the pipe is full
        text = text[os.write(2, text) :]


# --- whether the other processes live


class Peer(NamedTuple):
    """How to find another rank's process."""

    rank: int
    role: str
    host: str
    pid: int
    started: int
    """Start of the process in ticks since the host's start: the same number again is another process."""
    space: str
    """Where that number means something: the host's boot and its space of process numbers (containers)."""

    @classmethod
    def here(cls, *, rank: int, role: str) -> Peer:
        """Describe this process, for the others."""
        space = ""
        with contextlib.suppress(OSError), open("/proc/sys/kernel/random/boot_id") as file:
            space = f"{file.read().strip()} {os.readlink('/proc/self/ns/pid')}"
        return cls(rank, role, socket.gethostname(), os.getpid(), _started(os.getpid()) or 0, space)


class PeerWatch:
    """Notices that a process on this host is gone. Watches by the system's own handles where it has them."""

    def __init__(self, peers: Sequence[Peer], *, rank: int) -> None:
        """Watch the peers that share the host of `rank`, this process."""
        mine = next(peer for peer in peers if peer.rank == rank)
        self.peers = {
            peer.rank: peer for peer in peers if mine.space and peer.space == mine.space and peer.rank != rank
        }
        self._by_handle: dict[int, Peer] = {}
        self._by_number: list[Peer] = []
        self._poll = select.poll()
        self._last = float("-inf")
        for peer in self.peers.values():
            try:
                handle = os.pidfd_open(peer.pid)
            except (OSError, AttributeError):  # gone already, or an old system: its number tells
                self._by_number.append(peer)
            else:
                self._by_handle[handle] = peer
                self._poll.register(handle, select.POLLIN)
                if not _alive(peer):  # the number went to another process before the handle was opened
                    self._by_number.append(peer)

    def check(self, now: float | None = None) -> int | None:
        """Name a rank whose process is gone or a zombie, or None; looks at most once in 20 ms.

        `now` is a monotonic time in seconds, for a caller who has it at hand.
        """
        now = time.monotonic() if now is None else now
        if now - self._last < PEER_CHECK_S:
            return None
        self._last = now
        for handle, _ in self._poll.poll(0) if self._by_handle else ():
            return self._by_handle[handle].rank
        for peer in self._by_number:
            if not _alive(peer):
                return peer.rank
        return None

    def close(self) -> None:
        """Give the handles back."""
        for handle in self._by_handle:
            os.close(handle)
        self._by_handle, self._by_number, self._poll = {}, [], select.poll()

    def __del__(self) -> None:
        """Give the handles back."""
        with contextlib.suppress(Exception):
            self.close()


def _alive(peer: Peer) -> bool:
    return _started(peer.pid) == peer.started


def _started(pid: int) -> int | None:
    """When a live process started, in ticks since the host's start; None if it is gone or a zombie."""
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            # The name, in parentheses, may hold anything; the state and 18 numbers on, the start, come
            # after it.
            fields = file.read().rpartition(b")")[2].split()
    except OSError:
        return None
    return None if fields[0] in (b"Z", b"X") else int(fields[19])
