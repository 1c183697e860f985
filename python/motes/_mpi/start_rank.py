"""Starts a rank and leaves a watcher beside it. A program: `start_rank.py PIPE MARK PROGRAM [ARGUMENT ...]`.

The process becomes PROGRAM, so that the launcher sees the rank's own end. PIPE names the environment variable
with the descriptor of the pipe to the watcher. MARK lists the variable that gets the rank's process id and
those whose values follow it (`rank_process.MARK`); it is empty if PROGRAM only starts the rank.

The watcher is another process, and no child of the rank, which might wait for its children. It reports to
`motes run` what the rank says, and the rank's end (`presence.py`). Nothing here may import motes, which would
start MPI, or what takes long to import.
"""

from __future__ import annotations

import os
import select
import sys
import time

__all__ = ["main"]

_RANK = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK")
_LOOK_S = 0.2  # between two looks at the rank's process
_ENDING_S = 0.02  # the same at its end: it closes its files, is a zombie, and then gone
_ENDINGS = 50  # such looks; a script may close all files that it did not open, and live on


def main(pipe: str, mark: str, program: list[str]) -> None:
    """Become a program under a watcher; without one if it has no rank, or if no process can be started."""
    rank = next((os.environ[name] for name in _RANK if os.environ.get(name)), "")
    if rank:
        try:
            os.environ[pipe] = str(_leave_watcher(rank))
        except OSError:
            os.environ.pop(pipe, None)
    if mark:
        name, *job = mark.split()
        os.environ[name] = " ".join([str(os.getpid()), *(os.environ.get(each, "") for each in job)])
    for name in list(os.environ):  # other hosts do not have the folder of the job (_launch/files.py)
        if name.endswith("_backing_directory") and not os.path.isdir(os.environ[name]):
            del os.environ[name]
    os.execv(program[0], program)


def _leave_watcher(rank: str) -> int:
    """Start the watcher of this process; return the descriptor of the pipe to it."""
    reader, writer = os.pipe()  # whichever descriptors are free: a launcher's own may have any number
    this = os.getpid()
    child = os.fork()
    if child == 0:
        try:
            if os.fork() == 0:
                _keep_only(reader)
                _watch(this, rank)
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    os.close(reader)
    os.set_inheritable(writer, True)
    return writer


def _keep_only(pipe: int) -> None:
    """Make a pipe standard input and close all other files but standard error.

    A launcher takes a rank for alive as long as somebody has the rank's output or its connection open.
    """
    os.dup2(pipe, 0)
    for name in os.listdir("/proc/self/fd"):
        try:
            if int(name) not in (0, 2):
                os.close(int(name))
        except OSError:  # that of the list itself
            continue


def _watch(pid: int, rank: str) -> None:
    _tell(rank, "starts")
    left = _ENDINGS
    while left > 0:
        gone = _is_gone(pid)  # before the pipe is read: what the process said comes before its end
        if select.select([0], [], [], 0 if gone else _LOOK_S)[0]:
            words = os.read(0, 64).split()
            for word in words:
                _tell(rank, word.decode())
                if word != b"waits":
                    return
            if words:
                continue
            left -= 1
            time.sleep(_ENDING_S)
        if gone:
            _tell(rank, "ended")
            return


def _is_gone(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] in "ZX"
    except OSError:
        return True


def _tell(rank: str, word: str) -> None:
    os.write(2, f"*** motes: of rank {rank}: {word}\n".encode())


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
