"""Text for the user on standard error. It never ends a run: text for a full disk or closed pipe is lost."""

from __future__ import annotations

import contextlib
import os
import sys

__all__ = ["tell", "write_all"]


def tell(text: str, *, end: str = "\n") -> None:
    """Write a line to standard error; ignore failures."""
    stream, own = sys.stderr, sys.__stderr__
    with contextlib.suppress(OSError, ValueError, AttributeError):  # stderr is closed or None
        if own is not None and stream is own:
            # Bypass Python's buffer: text that a failed write leaves there would fail again at exit and turn
            # the exit code into 120.
            own.flush()
            write_all(own.fileno(), (text + end).encode(own.encoding or "utf-8", "backslashreplace"))
        else:
            stream.write(text + end)
            stream.flush()


def write_all(file: int, data: bytes) -> None:
    """Write all data to a file descriptor, in one call unless it is a full pipe."""
    while data:
        data = data[os.write(file, data) :]
