"""Notices ranks that end before MPI has started: the others would wait in MPI_Init for ever.

mpirun ends the job if a rank fails before MPI_Init, but not if one exits with code 0, and with `--survive` in
neither case. So `motes run` starts each rank through a shell, which becomes the rank and leaves a watcher
behind. The rank writes to the watcher through a pipe. The watcher reports to `motes run` in lines on standard
error, which arrive from any host: the rank waits for MPI, has MPI, or has ended. It exits once the rank has
MPI.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
import threading
from collections.abc import Callable, Sequence

from .rank_process import JOB, MARK

__all__ = ["PIPE", "Presence", "has_mpi", "started_by", "waits_for_mpi"]

PIPE = "MOTES_RANK_PIPE"
"""The environment variable with the file descriptor of the pipe to the watcher."""

_GRACE_S = 1.0  # for mpirun to end the job by itself, with the rank's exit code
_LINE = re.compile(rb"\*\*\* motes: of rank (\d+): (waits|has|ended)\b")
_SIGNAL = re.compile(rb"exited on\s+signal (\d+ \([^)]*\))")
_FAILED = re.compile(rb"Process name: \[[^]]*,\s*(\d+)\]|process\s+rank\s+(\d+)")

# A process that exits closes its files first; then it is a zombie, and then gone. A script may also close all
# files that it did not open, the pipe among them: then its process lives on, and the watcher reports nothing.
_SHELL = """
folder=$(mktemp -d "${TMPDIR:-/tmp}/motes-rank-XXXXXX") && mkfifo "$folder/pipe" || exec "$@"
rank=${OMPI_COMM_WORLD_RANK:-${PMIX_RANK:-$PMI_RANK}}
watch() {
  while read -r word; do
    echo "*** motes: of rank $rank: $word"
    [ "$word" = waits ] || exit
  done
  for pause in 0.01 0.02 0.05 0.1 0.2 0.5; do
    state=Z
    if kill -0 $$; then state=; read -r state </proc/$$/stat; fi
    case $state in Z | *") Z "* | *") X "*) echo "*** motes: of rank $rank: ended"; exit ;; esac
    sleep $pause
  done
}
(watch <"$folder/pipe" 2>/dev/null >&3 3>&- &) 3>&2
exec 9>"$folder/pipe"
rm -r "$folder"
export MOTES_RANK_PIPE=9
"""
_MARKED = f'export {MARK}="$$ {" ".join(f"${name}" for name in JOB)}"\n'


def started_by(program: Sequence[str], *, is_rank: bool) -> list[str]:
    """Return the command that starts a program under a watcher; `is_rank`: the program itself is the rank."""
    return ["/bin/sh", "-c", f'{_SHELL}{_MARKED if is_rank else ""}exec "$@"', "motes-rank", *program]


def waits_for_mpi() -> None:
    """Tell the watcher that this rank is about to start MPI."""
    _say(b"waits\n")


def has_mpi() -> None:
    """Tell the watcher that MPI has started in this rank."""
    _say(b"has\n")
    pipe = os.environ.pop(PIPE, "")
    if pipe:
        with contextlib.suppress(OSError):
            os.close(int(pipe))


def _say(word: bytes) -> None:
    pipe = os.environ.get(PIPE, "")
    if not pipe:
        return
    try:
        if not stat.S_ISFIFO(os.fstat(int(pipe)).st_mode):
            raise OSError
        os.write(int(pipe), word)
    except OSError:  # closed by the script, which may have opened another file since
        os.environ.pop(PIPE, None)


class Presence:
    """Collects the watchers' reports, and ends a job that can no longer start."""

    def __init__(self, end: Callable[[], object]) -> None:
        """`end` is called, in another thread, when ranks wait for one that is gone."""
        self._end = end
        self._waiting: set[int] = set()
        self._gone: list[int] = []
        self._timer: threading.Timer | None = None
        self.hopeless = False
        """Whether `end` was called."""

    def take(self, line: bytes) -> bool:
        """Process a line of output if it is a watcher's; return whether it is."""
        said = _LINE.search(line)
        if said is None:
            return False
        rank = int(said[1])
        if said[2] == b"waits":
            self._waiting.add(rank)
        elif said[2] == b"has":
            self._waiting.discard(rank)
        else:
            self._waiting.discard(rank)
            self._gone.append(rank)
        if self._gone and self._waiting and self._timer is None:
            self._timer = threading.Timer(_GRACE_S, self._give_up)
            self._timer.daemon = True
            self._timer.start()
        return True

    def sentence(self, error: str, launcher: bytes) -> str:
        """Name the ranks that ended before MPI had started, with the error that was printed; or return "".

        `launcher` is the launcher's own messages, which name the rank that failed first.
        """
        if not self._gone:
            return ""
        first = _FAILED.search(launcher)
        failed = {int(next(filter(None, first.groups())))} & set(self._gone) if first else set()
        gone = sorted(failed or self._gone)
        who = f"rank{'s' if len(gone) > 1 else ''} {', '.join(map(str, gone))}"
        others = "; the others would wait forever" if self.hopeless else ""
        signal = _SIGNAL.search(launcher)
        how = f", on signal {signal[1].decode()}" if signal else ""
        return f"{who} ended before MPI had started{how}{others}" + (f": {error}" if error else "")

    def close(self) -> None:
        """Stop waiting: the launcher has ended."""
        if self._timer is not None:
            self._timer.cancel()

    def _give_up(self) -> None:
        if self._waiting:
            self.hopeless = True
            self._end()
