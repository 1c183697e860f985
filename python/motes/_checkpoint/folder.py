"""A directory of checkpoints: frame-000096 is complete, frame-000096.tmp is being written."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import shutil
import socket
from pathlib import Path
from typing import Self

from .._io import files
from ..errors import ArgumentError, CheckpointError

try:
    import fcntl
except ImportError:  # not a Unix system: simultaneous runs are not detected
    fcntl = None  # type: ignore[assignment]

__all__ = [
    "MANIFEST",
    "WORLD",
    "Lock",
    "begun",
    "finish",
    "make_begun",
    "part_name",
    "prune",
    "start_anew",
    "sweep",
    "whole",
]

MANIFEST = "manifest.json"
WORLD = "world.bin"
_LOCK = ".lock"
_WHOLE = re.compile(r"frame-(\d{6,19})")
_BEGUN = re.compile(r"frame-\d{6,19}(-\d+)?\.tmp")


def begun(directory: Path, frame: int, losses: int = 0) -> Path:
    """Return the folder into which the parts of a checkpoint are written until it is complete.

    `losses`: how often ranks were lost. Parts from before a loss divide the particles differently; they must
    not get into the same folder, even if one is still being written.
    """
    return directory / f"frame-{frame:06}{f'-{losses}' if losses else ''}.tmp"


def make_begun(place: Path) -> None:
    """Create the folder, unless another rank has. Raises OSError if it is a symbolic link."""
    place.mkdir(parents=True, exist_ok=True)
    if place.is_symlink():
        raise FileExistsError(errno.EEXIST, f"it is a symbolic link to {os.readlink(place)}", str(place))


def part_name(calculator: int) -> str:
    """Return the name of the file with a calculator's particles."""
    return f"part-{calculator:05}.safetensors"


def whole(directory: Path) -> list[tuple[int, Path]]:
    """List the folders named as complete checkpoints, as (frame, folder), the newest first."""
    checkpoints = []
    with contextlib.suppress(FileNotFoundError):
        for name in os.listdir(directory):
            if match := _WHOLE.fullmatch(name):
                checkpoints.append((int(match[1]), directory / name))
    return sorted(checkpoints, reverse=True)


def finish(folder: Path, frame: int) -> Path:
    """Rename a checkpoint whose files are all on disk to its final name."""
    target = folder.with_name(f"frame-{frame:06}")
    files.sync(folder)
    if target.exists():  # a damaged checkpoint of the same frame, or another run's
        shutil.rmtree(target)
    folder.rename(target)
    files.sync(folder.parent)
    return target


def prune(directory: Path, keep: int) -> None:
    """Remove all but the newest `keep` complete checkpoints."""
    for _, folder in whole(directory)[keep:]:
        shutil.rmtree(folder, ignore_errors=True)


def sweep(directory: Path) -> None:
    """Remove unfinished checkpoints, which killed runs left behind."""
    with contextlib.suppress(FileNotFoundError):
        for name in os.listdir(directory):
            if _BEGUN.fullmatch(name):
                shutil.rmtree(directory / name, ignore_errors=True)


def start_anew(directory: Path) -> None:
    """Remove all checkpoints, so that a run that starts again is not continued from an earlier one's."""
    prune(directory, 0)


class Lock:
    """A lock that reserves a directory for one run; the system releases it if the run is killed."""

    def __init__(self, directory: Path) -> None:
        """Create the directory if needed, and lock it.

        Raises ArgumentError if another run has it, CheckpointError if it cannot be created.
        """
        try:
            directory.mkdir(parents=True, exist_ok=True)
            flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
            self._file = os.open(directory / _LOCK, flags, 0o666)
        except OSError as error:
            raise CheckpointError(f"cannot use the directory {directory}: {error.strerror}") from error
        try:
            if fcntl is not None:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            owner = os.pread(self._file, 200, 0).decode(errors="replace").strip() or "another process"
            os.close(self._file)
            self._file = -1
            allowed = f"a directory that no other run uses (the run of {owner} writes its checkpoints there)"
            raise ArgumentError("checkpoint", os.fspath(directory), allowed) from None
        except OSError:
            pass  # a file system without locks
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)

    def release(self) -> None:
        """Release the directory for other runs; do nothing if that is done."""
        file, self._file = self._file, -1
        if file >= 0:
            os.close(file)

    def __enter__(self) -> Self:
        """Return the lock itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Release the lock."""
        self.release()
