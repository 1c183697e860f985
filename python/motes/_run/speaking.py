"""Which rank of a failed job prints the report, also where the process has no file descriptor left."""

from __future__ import annotations

import contextlib
import os
import sys
import time
import zlib

from .output import write_all
from .process import process

__all__ = ["free_reserve", "mark", "may_speak", "print_report", "reserve"]

SPEAKER_WAIT_S = 2.5  # how long a silent rank waits for the speaker's abort to end it
REPORT_BYTES = 32768  # more would not fit into the pipe to the launcher in one piece
_RESERVED_FILES = 4  # a report opens sources for its traceback, and maybe a socket
_reserved: list[int] = []


def reserve() -> None:
    """Keep a few file descriptors for the report: a process may fail because it has no more of them."""
    with contextlib.suppress(OSError):
        while len(_reserved) < _RESERVED_FILES:
            _reserved.append(os.open(os.devnull, os.O_RDONLY))


def free_reserve() -> None:
    """Give the reserved file descriptors back, before a report is made."""
    while _reserved:
        with contextlib.suppress(OSError):
            os.close(_reserved.pop())


def may_speak(speaker: int | None) -> bool:
    """Decide whether this rank prints; a rank that must not waits here until the speaker's abort ends it.

    `speaker`: the one rank (of COMM_WORLD) that all ranks agreed on, if they did.
    """
    if speaker is not None and speaker != process.rank:
        time.sleep(SPEAKER_WAIT_S)  # should the speaker never speak, another rank must
    if not claim_report():
        time.sleep(SPEAKER_WAIT_S)
        return False
    if speaker is None and not _one_host():
        # One rank of each host may speak for it: the lowest speaks, and its abort ends the others meanwhile.
        time.sleep(min(1.0, 0.05 * process.rank))
    return True


def mark() -> str | None:
    """Name the folder that claims the report: the rank that creates it prints for this host.

    None without a launcher. It is in the launcher's own directory, which lasts until the job ends, and so
    does the claim, even if a rank finds the speaker dead.
    """
    directory = os.environ.get("PMIX_SERVER_TMPDIR")  # not in what a rank starts, which speaks for itself
    return None if directory is None else os.path.join(directory, f"motes-speaker-{_key(_job())}")


def claim_report() -> bool:
    """Claim the report of this host in this job; true for the first rank that asks."""
    made = mark()
    if made is not None:
        with contextlib.suppress(OSError):
            try:
                os.mkdir(made, 0o700)  # a folder, because that takes no file descriptor
                return True
            except FileExistsError:
                return False
    # A socket's name is free again when the speaker dies, which is soon enough in nearly all cases.
    try:
        import socket  # takes as long as half of this package: few processes report

        claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    except OSError:
        return True  # out of file descriptors: two reports are better than none
    try:
        claim.bind(f"\0motes-{_key(_job())}-{os.getuid()}")
    except OSError:
        claim.close()
        return sys.platform != "linux"  # no such names there: only the delay keeps ranks apart
    claim.detach()  # open, and the name taken, until this process ends
    return True


def print_report(headline: str, body: str, *, before: str = "") -> None:
    """Print a report in one piece, without its middle if too long; `before`: a line for `motes run`."""
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
