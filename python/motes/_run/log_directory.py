"""A log directory belongs to one run.

An earlier run's log is moved aside (`today` becomes `today.1`, or the next free number), unless this run
continues it. A directory that holds other files is refused. So is one into which another run is writing: that
run holds a lock, which the system releases whenever its process ends.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import re
import socket
import stat
from pathlib import Path
from typing import Self

from .._io import files
from .._io.output import tell
from ..errors import ArgumentError, LogError
from .run_file import earlier_run

__all__ = ["LogDirectory"]

ALLOWED = "a new or empty directory, or an earlier run's log"
LOCK = ".lock"
_ATTEMPTS = 100
_OWN = re.compile(
    r"(run\.json|(load|frames|balance|density|events|steer)\.jsonl|spans\.r\d+\.jsonl|report\.html|trace\.json"
    r"|\.run\.json\.[0-9a-f]+\.tmp|\.(load|frames|balance|density|events)\.jsonl\.tmp)"
)
_ANEW = re.compile(r"spans\.r\d+\.jsonl|\..*\.tmp")  # files that a continued run starts again
_OWNER = re.compile(rb"process \d+ on ")


class LogDirectory:
    """The directory of this run's log, claimed until `release` or the end of the process."""

    def __init__(self, path: Path, lock: int, moved: Path | None) -> None:
        """Hold the lock, an open file; created by `LogDirectory.claim`."""
        self.path = path
        self.moved = moved
        """The directory that an earlier run's log was moved to, or None."""
        self._lock = lock

    @classmethod
    def claim(cls, directory: str | os.PathLike[str], *, continued: bool = False) -> Self:
        """Create the directory, empty, for this run only.

        `continued`: keep the log of the earlier run that this one continues, except timelines (spans), which
        count from a run's start.

        Raises ArgumentError if it holds files other than a run's log or if another run writes into it, before
        anything is changed; LogError if it cannot be created.
        """
        path = Path(directory).absolute()
        with contextlib.suppress(OSError, RuntimeError):  # RuntimeError: a loop of symbolic links
            path = path.resolve()
        try:
            return cls._claim(path, os.fspath(directory), continued)
        except OSError as error:
            reason = error.strerror or str(error)
            raise LogError(f"the log directory {path} cannot be created: {reason}") from error

    @classmethod
    def _claim(cls, path: Path, given: str, continued: bool) -> Self:
        moved: Path | None = None
        for _ in range(_ATTEMPTS):
            try:
                _make(path)
                _check_content(path, given)  # before anything is changed
                lock = _lock(path, given)
            except FileNotFoundError:
                continue  # another run has moved the directory aside
            if lock is None:  # another run has moved it aside just before the lock
                continue
            try:
                if not _own(path):
                    return cls(path, lock, moved)
                _check_content(path, given)
                if continued:
                    earlier_run(path / "run.json")  # raises if it is damaged, before anything is changed
                    _clear(path)
                    return cls(path, lock, None)
                moved, stays = _move_aside(path)
            except BaseException:
                os.close(lock)
                raise
            if stays:  # then so does the lock
                return cls(path, lock, moved)
            os.close(lock)
        raise LogError(f"other runs keep claiming the log directory {path}")

    def release(self) -> None:
        """Release the lock; do nothing if it has been released."""
        lock, self._lock = self._lock, -1
        if lock >= 0:
            os.close(lock)

    def __del__(self) -> None:
        """Release the lock."""
        with contextlib.suppress(Exception):
            self.release()


def _make(path: Path) -> None:
    """Create a directory if there is none. Raises FileNotFoundError if it has just been moved away."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        if not stat.S_ISDIR(os.lstat(path).st_mode):
            raise


def _check_content(path: Path, given: str) -> None:
    """Raise ArgumentError if a directory is neither empty nor a run's log."""
    names = [name for name in os.listdir(path) if name != LOCK]
    if names and not _is_log(path, names):
        strange = next((name for name in sorted(names) if not _OWN.fullmatch(name)), min(names))
        raise ArgumentError("log", given, f"{ALLOWED} (this one holds {strange!r} and no run.json of a run)")


def _is_log(path: Path, names: list[str]) -> bool:
    """Return whether a run has claimed this directory; it may hold other files, and no run.json yet."""
    with contextlib.suppress(OSError):
        if (path / LOCK).is_file() and _OWNER.match((path / LOCK).read_bytes()[:200]):
            return True
    with contextlib.suppress(OSError, ValueError, RecursionError):
        run = json.loads((path / "run.json").read_bytes())
        return isinstance(run, dict) and {"schema", "argv"} <= set(run)
    return {"load.jsonl", "frames.jsonl"} <= set(names) and all(_OWN.fullmatch(name) for name in names)


def _own(path: Path) -> list[str]:
    """List the files of a run's log; run.json, which marks a directory as a log, comes last."""
    own = [name for name in os.listdir(path) if _OWN.fullmatch(name)]
    return sorted(own, key=lambda name: (name == "run.json", name))


def _clear(path: Path) -> None:
    """Remove files that a continued run starts again, and temporary files of the earlier run."""
    for name in _own(path):
        if _ANEW.fullmatch(name):
            (path / name).unlink()


def _lock(path: Path, given: str) -> int | None:
    """Lock a directory. Returns the open lock file, or None if the directory has been moved away.

    Raises ArgumentError if another run has the lock.
    """
    file = files.open_lock(path / LOCK)
    if files.is_locked_elsewhere(
        file,
        without=lambda error: tell(
            f"motes: {path} is on a file system without locks ({error.strerror}): "
            "another run that uses it at the same time would not be noticed"
        ),
    ):
        allowed = f"{ALLOWED} (the run of {files.owner_of_lock(file)} is writing to this one)"
        raise ArgumentError("log", given, allowed)
    try:
        same = os.path.samestat(os.fstat(file), os.stat(path / LOCK))
    except FileNotFoundError:
        same = False
    if not same:
        os.close(file)
        return None
    with contextlib.suppress(OSError):  # on a full disk, writing the log will report the error
        os.ftruncate(file, 0)
        os.pwrite(file, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
    return file


def _move_aside(path: Path) -> tuple[Path, bool]:
    """Move an earlier run's log to the first free name of `today.1`, `today.2`, ...

    Returns the new directory, and whether only the log's files were moved and the old directory stayed.
    """
    names = [name for name in os.listdir(path) if name != LOCK]
    # If the current directory is inside, or other files are, the directory itself stays.
    stays = not all(_OWN.fullmatch(name) for name in names) or path in [Path.cwd(), *Path.cwd().parents]
    number = 1
    while True:
        aside = path.with_name(f"{path.name}.{number}")
        number += 1
        if os.path.lexists(aside):
            continue
        try:
            if not stays:
                path.rename(aside)
                return aside, False
            aside.mkdir()
        except OSError as error:
            if error.errno in (errno.EEXIST, errno.ENOTEMPTY):  # another run has just taken the name
                continue
            raise LogError(
                f"the earlier log in {path} cannot be moved aside to {aside}: {error.strerror}"
            ) from error
        for name in _own(path):
            (path / name).rename(aside / name)
        return aside, True
