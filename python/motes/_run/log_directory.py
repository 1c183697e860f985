"""A log directory belongs to one run.

An earlier run's log is moved aside (`today` becomes `today.1`, or the next number that is free), unless this
run continues it. A directory that holds other things is refused, and so is one into which another run is
writing: that run holds a lock, which the system releases when its process ends, however it ends.
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
_ANEW = re.compile(r"spans\.r\d+\.jsonl|\..*\.tmp")  # what a run that goes on does not continue
_OWNER = re.compile(rb"process \d+ on ")


class LogDirectory:
    """The directory of this run's log, claimed until `release` or the end of the process."""

    def __init__(self, path: Path, lock: int, moved: Path | None) -> None:
        """Hold the lock, an open file; `LogDirectory.claim` makes one."""
        self.path = path
        self.moved = moved
        """Where an earlier run's log went, if there was one."""
        self._lock = lock

    @classmethod
    def claim(cls, directory: str | os.PathLike[str], *, continued: bool = False) -> Self:
        """Create the directory, empty, for this run alone.

        `continued`: this run goes on with what an earlier one has logged there, which then stays. Timelines
        (spans) count from a run's start, so they begin anew.

        Raises ArgumentError if it holds other files than a run's log or if another run writes into it, before
        anything is changed; LogError if it cannot be created.
        """
        path = Path(directory).absolute()
        with contextlib.suppress(OSError, RuntimeError):  # RuntimeError: symbolic links in a circle
            path = path.resolve()
        try:
            return cls._claim(path, os.fspath(directory), continued)
        except OSError as error:
            reason = error.strerror or str(error)
            raise LogError(f"the log directory {path} cannot be made: {reason}") from error

    @classmethod
    def _claim(cls, path: Path, given: str, continued: bool) -> Self:
        moved: Path | None = None
        for _ in range(_ATTEMPTS):
            try:
                _make(path)
                _check_content(path, given)  # before anything is changed here
                lock = _lock(path, given)
            except FileNotFoundError:
                continue  # another run has moved the directory aside meanwhile
            if lock is None:  # the same, a moment later
                continue
            try:
                if not _own(path):
                    return cls(path, lock, moved)
                _check_content(path, given)
                if continued:
                    earlier_run(path / "run.json")  # a damaged one is told before anything is changed
                    _clear(path)
                    return cls(path, lock, None)
                moved, stays = _move_aside(path)
            except BaseException:
                os.close(lock)
                raise
            if stays:  # and the lock with it
                return cls(path, lock, moved)
            os.close(lock)
        raise LogError(f"other runs keep on claiming the log directory {path}")

    def release(self) -> None:
        """Let another run have the directory. Calling it again does nothing."""
        lock, self._lock = self._lock, -1
        if lock >= 0:
            os.close(lock)

    def __del__(self) -> None:
        """Let another run have the directory."""
        with contextlib.suppress(Exception):
            self.release()


def _make(path: Path) -> None:
    """Make a directory where there is none. Raises FileNotFoundError where there was one a moment ago."""
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
    """Tell whether a run has claimed this directory before; it may hold other files, and no run.json yet."""
    with contextlib.suppress(OSError):
        if (path / LOCK).is_file() and _OWNER.match((path / LOCK).read_bytes()[:200]):
            return True
    with contextlib.suppress(OSError, ValueError, RecursionError):
        run = json.loads((path / "run.json").read_bytes())
        return isinstance(run, dict) and {"schema", "argv"} <= set(run)
    return {"load.jsonl", "frames.jsonl"} <= set(names) and all(_OWN.fullmatch(name) for name in names)


def _own(path: Path) -> list[str]:
    """List what a run has logged; run.json, which says that this is a log, comes last."""
    own = [name for name in os.listdir(path) if _OWN.fullmatch(name)]
    return sorted(own, key=lambda name: (name == "run.json", name))


def _clear(path: Path) -> None:
    """Remove what a run that goes on writes anew, and drafts of the earlier one."""
    for name in _own(path):
        if _ANEW.fullmatch(name):
            (path / name).unlink()


def _lock(path: Path, given: str) -> int | None:
    """Lock a directory. Returns the open lock file, or None if the directory no longer has that name.

    Raises ArgumentError if another run has the lock.
    """
    file = files.open_lock(path / LOCK)
    if files.is_locked_elsewhere(
        file,
        without=lambda error: tell(
            f"motes: {path} is on a file system without locks ({error.strerror}): "
            "another run into it at the same time would not be noticed"
        ),
    ):
        allowed = f"{ALLOWED} (the run of {files.owner_of_lock(file)} is writing into this one)"
        raise ArgumentError("log", given, allowed)
    try:
        same = os.path.samestat(os.fstat(file), os.stat(path / LOCK))
    except FileNotFoundError:
        same = False
    if not same:
        os.close(file)
        return None
    with contextlib.suppress(OSError):  # a full disk: the log itself will say so
        os.ftruncate(file, 0)
        os.pwrite(file, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
    return file


def _move_aside(path: Path) -> tuple[Path, bool]:
    """Give an earlier run's log the first free name of `today.1`, `today.2`, ...

    Returns where it is now, and whether the directory itself stayed where it was.
    """
    names = [name for name in os.listdir(path) if name != LOCK]
    # Where the script works inside the directory, or keeps other files there, the directory itself stays.
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
            if error.errno in (errno.EEXIST, errno.ENOTEMPTY):  # another run took the name meanwhile
                continue
            raise LogError(
                f"the earlier log in {path} cannot be moved aside to {aside}: {error.strerror}"
            ) from error
        for name in _own(path):
            (path / name).rename(aside / name)
        return aside, True
