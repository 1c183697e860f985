"""Atomic files: written under a temporary name, synced, then renamed."""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

try:
    import fcntl
except ImportError:  # not a Unix system: abandoned drafts stay
    fcntl = None  # type: ignore[assignment]

__all__ = [
    "append_to",
    "is_locked_elsewhere",
    "make_draft",
    "open_lock",
    "owner_of_lock",
    "sweep",
    "sweep_directory",
    "sync",
    "try_lock",
    "whole_file",
    "whole_path",
    "write_whole",
]

_SUFFIX = ".tmp"
_DRAFT = r"\..+\.[0-9a-f]{16}" + re.escape(_SUFFIX)
_swept: set[str] = set()
_NO_FOLLOW = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)


@contextmanager
def whole_path(path: str | os.PathLike[str], *, remove_abandoned: bool = False) -> Iterator[Path]:
    """Yield a new, empty file in the same directory; on success it becomes `path`, else it is removed.

    The block opens the file by its name, writes and closes it. The name is random and the file is created
    here, so nobody else's file or symbolic link is ever written to. `remove_abandoned`: first remove drafts
    of `path` that killed processes have left; this lists the directory.
    """
    path = Path(path)
    if path.is_dir():  # fail now, not after minutes of writing
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    if remove_abandoned:
        sweep(path)
    draft, lock = make_draft(path)
    try:
        yield draft
        sync(draft)
        os.replace(draft, path)
    except BaseException:
        with suppress(OSError):
            draft.unlink()
        raise
    finally:
        os.close(lock)
    sync(path.parent)


@contextmanager
def whole_file(path: str | os.PathLike[str], mode: str = "wb", **options: Any) -> Iterator[IO[Any]]:
    """Open a file for writing that appears at `path` only if the block succeeds.

    `options` are passed to `open`, such as `encoding="utf-8"`.
    """
    if "w" not in mode or "+" in mode:
        raise ValueError(f"mode must be 'w' or 'wb', got {mode!r}")
    with whole_path(path) as draft, open(draft, mode, opener=_open_made, **options) as file:
        yield file


def write_whole(path: str | os.PathLike[str], content: bytes | Callable[[IO[bytes]], object]) -> None:
    """Write a file atomically: bytes, or what a function writes into the open binary file."""
    with whole_file(path, "wb") as file:
        if callable(content):
            content(file)
        else:
            file.write(content)


def append_to(path: Path) -> IO[str]:
    """Open an existing text file for appending, never through a symbolic link."""
    return os.fdopen(os.open(path, os.O_WRONLY | os.O_APPEND | _NO_FOLLOW), "a", encoding="utf-8")


def _open_made(name: str, flags: int) -> int:
    return os.open(name, (flags & ~os.O_CREAT) | _NO_FOLLOW)


def make_draft(path: Path) -> tuple[Path, int]:
    """Create and lock a draft beside `path`; a draft that is not locked is abandoned.

    Returns its name and the open file, which holds the lock.
    """
    while True:
        draft = path.with_name(f".{path.name}.{os.urandom(8).hex()}{_SUFFIX}")
        lock = os.open(draft, os.O_RDWR | os.O_CREAT | os.O_EXCL | _NO_FOLLOW, 0o666)
        try_lock(lock)
        try:
            if os.path.samestat(os.fstat(lock), os.lstat(draft)):
                return draft, lock
        except FileNotFoundError:  # removed as abandoned, before it was locked
            pass
        os.close(lock)


def sweep(path: Path) -> None:
    """Remove abandoned drafts of `path`: those that nobody has locked."""
    with suppress(OSError):
        pattern = re.compile(re.escape(f".{path.name}.") + r"[0-9a-f]{16}" + re.escape(_SUFFIX))
        for name in os.listdir(path.parent):
            if pattern.fullmatch(name):
                _remove_if_unlocked(path.with_name(name))


def sweep_directory(path: Path) -> None:
    """Remove all abandoned drafts in a directory; once per directory in this process."""
    place = str(path.absolute())
    if place in _swept:
        return
    with suppress(OSError):
        for name in os.listdir(path):
            if re.fullmatch(_DRAFT, name):
                _remove_if_unlocked(path / name)
        _swept.add(place)


def _remove_if_unlocked(draft: Path) -> None:
    with suppress(OSError):
        file = os.open(draft, os.O_RDWR | os.O_NONBLOCK | _NO_FOLLOW)
        try:
            if stat.S_ISREG(os.fstat(file).st_mode) and try_lock(file):
                draft.unlink()
        finally:
            os.close(file)


def try_lock(file: int) -> bool:
    """Lock an open file without waiting; return False if it is locked already or locks are not supported."""
    if fcntl is None:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def open_lock(path: Path) -> int:
    """Open a lock file, whose text names the owner, never through a symbolic link."""
    return os.open(path, os.O_RDWR | os.O_CREAT | _NO_FOLLOW, 0o666)


def owner_of_lock(file: int) -> str:
    """Return the owner that a lock file names, and close it."""
    owner = os.pread(file, 200, 0).decode(errors="replace").strip() or "another process"
    os.close(file)
    return owner


def is_locked_elsewhere(file: int, *, without: Callable[[OSError], object] | None = None) -> bool:
    """Try to lock an open file; tell whether another one holds the lock.

    `without` is called with the error of a file system without locks, where the result is False.
    """
    if fcntl is None:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            return True
        if without is not None:
            without(error)
    return False


def sync(path: Path) -> None:
    """Flush a file or a directory to the disk, where the system can do that."""
    try:
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
    except OSError:
        # A directory cannot be opened on every system, and some file systems refuse to sync one.
        if not path.is_dir():
            raise
