"""Text for the user on standard error. It never ends a run: a full disk or a closed pipe loses the text."""

from __future__ import annotations

import contextlib
import os
import sys

__all__ = ["tell", "write_all"]


def tell(text: str, *, end: str = "\n") -> None:
    """Write a line to standard error, if that can be written."""
    stream, own = sys.stderr, sys.__stderr__
    with contextlib.suppress(OSError, ValueError, AttributeError):  # closed, or there is none
        if own is not None and stream is own:
            # Past Python's buffer: what stays there after a failed write would fail once more at exit, and
            # turn the exit code into 120.
            own.flush()
            write_all(own.fileno(), (text + end).encode(own.encoding or "utf-8", "backslashreplace"))
        else:
            stream.write(text + end)
            stream.flush()


def write_all(file: int, data: bytes) -> None:
    """Write to a file descriptor, in one piece unless it is a full pipe."""
    while data:
        data = data[os.write(file, data) :]
