"""Decide which rank of a failed job prints the report, and print it, even without free file descriptors."""

from __future__ import annotations

import contextlib
import os
import sys
import time
import zlib

from .._io.output import write_all
from .process import process

__all__ = ["free_reserve", "mark", "may_speak", "print_report", "reserve"]

SPEAKER_WAIT_S = 2.5  # how long a rank that does not print waits for the printing rank's abort
REPORT_BYTES = 32768  # the longest report that fits into the pipe to the launcher in one piece
_RESERVED_FILES = 4  # a report opens source files for its traceback, and maybe a socket
_reserved: list[int] = []


def reserve() -> None:
    """Reserve file descriptors for the report: a process may fail because it has run out of them."""
    with contextlib.suppress(OSError):
        while len(_reserved) < _RESERVED_FILES:
            _reserved.append(os.open(os.devnull, os.O_RDONLY))


def free_reserve() -> None:
    """Release the reserved file descriptors, before a report is printed."""
    while _reserved:
        with contextlib.suppress(OSError):
            os.close(_reserved.pop())


def may_speak(speaker: int | None) -> bool:
    """Return whether this rank prints; otherwise wait for the abort of the rank that does.

    `speaker`: the rank (of COMM_WORLD) that all ranks agreed on, if they did.
    """
    if speaker is not None and speaker != process.rank:
        time.sleep(SPEAKER_WAIT_S)  # if the speaker has not printed by then, another rank must
    if not claim_report():
        time.sleep(SPEAKER_WAIT_S)
        return False
    if speaker is None and not _one_host():
        # One rank per host gets here: the lowest prints first, and its abort ends the others.
        time.sleep(min(1.0, 0.05 * process.rank))
    return True


def mark() -> str | None:
    """Return the folder whose creator prints for this host; None without a launcher.

    It is in the launcher's directory, which lasts until the job ends. The claim therefore holds even after
    the process that made it has died.
    """
    directory = os.environ.get("PMIX_SERVER_TMPDIR")  # processes started by a rank do not inherit it
    return None if directory is None else os.path.join(directory, f"motes-speaker-{_key(_job())}")


def claim_report() -> bool:
    """Claim the report of this host in this job; return True for the first rank that calls."""
    folder = mark()
    if folder is not None:
        with contextlib.suppress(OSError):
            try:
                os.mkdir(folder, 0o700)  # a folder, because it needs no file descriptor
                return True
            except FileExistsError:
                return False
    # A socket's name is freed when the claiming process dies, which is late enough in nearly all cases.
    try:
        import socket  # late: importing it takes half as long as importing this package

        claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    except OSError:
        return True  # out of file descriptors: two reports are better than none
    try:
        claim.bind(f"\0motes-{_key(_job())}-{os.getuid()}")
    except OSError:
        claim.close()
        return sys.platform != "linux"  # other systems lack such names: only the delay separates ranks
    claim.detach()  # keep the name until this process ends
    return True


def print_report(headline: str, body: str, *, before: str = "") -> None:
    """Print a report in one write, cutting its middle if it is too long; `before`: a line for `motes run`."""
    text = f"\n{before}*** motes: {headline}\n{body}".rstrip("\n").encode(errors="replace") + b"\n"
    if len(text) > REPORT_BYTES:
        half = REPORT_BYTES // 2
        text = text[:half] + b"\n  ...\n" + text[-half:]
    write_all(2, text)


def _job() -> str:
    return process.job or os.environ.get("PMIX_NAMESPACE") or str(os.getppid())


def _key(job: str) -> str:
    return f"{zlib.crc32(job.encode()):08x}"


def _one_host() -> bool:
    names = ("OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS")
    return str(process.size) in [os.environ.get(name) for name in names]
