"""Claims the place of an export: removes an earlier export there, and nothing else.

An export holds a lock while it writes; the operating system releases it whenever the process ends.
"""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path
from typing import Self

from .._io import files
from ..errors import ArgumentError, MotesError
from .formats import FORMATS, Place
from .manifest import FORMAT, NAME

__all__ = ["Claim", "check_free"]

LOCK = ".lock"
_OWNER = b"particles of motes, process "
_MARK_WITHIN = 400


class Claim:
    """The emptied place of an export, held until `release` or the end of the process."""

    def __init__(self, place: Place, lock: int) -> None:
        """Hold the lock, an open file; `Claim.make` makes one."""
        self.place = place
        self._lock = lock

    @classmethod
    def make(cls, argument: str, place: Place) -> Self:
        """Remove an earlier export, and nothing else.

        Raises ArgumentError, before it changes anything, if the place holds other files or if another export
        is being written there; MotesError if the folder cannot be made.
        """
        try:
            return cls._make(argument, place)
        except OSError as error:
            reason = error.strerror or str(error)
            raise MotesError(f"particles cannot be written to {place.path}: {reason}") from error

    @classmethod
    def _make(cls, argument: str, place: Place) -> Self:
        folder = place.folder
        check_free(argument, place)
        folder.mkdir(parents=True, exist_ok=True)
        lock = _lock(argument, place)
        while not _same(lock, folder / LOCK):  # another export has just removed it
            os.close(lock)
            lock = _lock(argument, place)
        try:
            # Remove the manifest first: what an interrupted removal leaves cannot be read as an export.
            with contextlib.suppress(FileNotFoundError):
                (folder / NAME).unlink()
            if place.format.index:
                with contextlib.suppress(FileNotFoundError):
                    place.path.unlink()
            own = _own()
            for name in os.listdir(folder):
                if own.fullmatch(name):
                    (folder / name).unlink()
        except BaseException:
            os.close(lock)
            raise
        return cls(place, lock)

    def release(self) -> None:
        """Release the place for other exports. Calling it again does nothing."""
        lock, self._lock = self._lock, -1
        if lock >= 0:
            with contextlib.suppress(OSError):
                (self.place.folder / LOCK).unlink()
            os.close(lock)

    def __del__(self) -> None:
        """Release the lock."""
        lock, self._lock = self._lock, -1
        if lock >= 0:
            os.close(lock)


def _own() -> re.Pattern[str]:
    """Return a pattern for the names of all files that exports write into their folders, drafts included."""
    kinds = "|".join(map(re.escape, FORMATS))
    beside = "".join(f"|{re.escape(suffix)}" for format in FORMATS.values() for suffix in format.beside)
    part = rf"[A-Za-z][A-Za-z0-9_]*(\.\d{{6,}}(\.r\d{{4,}})?\.({kinds}){beside})"
    # USD writes its own temporary file first: the draft's name, but ending in six random letters.
    draft = rf"\.({re.escape(NAME)}|{part})\.[0-9a-f]{{16}}\.(tmp|\w{{6}})"
    return re.compile(rf"{re.escape(NAME)}|{part}|{draft}")


def check_free(argument: str, place: Place) -> None:
    """Raise ArgumentError if the place holds anything but an earlier export. Changes nothing."""
    _check_index(argument, place)
    if place.folder.is_dir():
        _check_content(argument, place)
    elif os.path.lexists(place.folder):
        raise ArgumentError(
            argument, str(place.path), f"a path for which {place.folder} is a directory or does not exist"
        )


def _check_index(argument: str, place: Place) -> None:
    """Raise ArgumentError if the index file exists and is not an earlier export's."""
    if not place.format.index or not os.path.lexists(place.path):
        return
    beginning = b""
    if place.path.is_file():
        with open(place.path, "rb") as file:
            beginning = file.read(_MARK_WITHIN)
    if place.format.mark.encode() not in beginning:
        raise ArgumentError(argument, str(place.path), "a new name, or that of an earlier export")


def _check_content(argument: str, place: Place) -> None:
    """Raise ArgumentError if a folder is neither empty nor an export's."""
    names = [name for name in os.listdir(place.folder) if name != LOCK]
    if not names or _is_export(place.folder):
        return
    allowed = f"a new or empty directory, or an earlier export (this one holds {min(names)!r})"
    raise ArgumentError(argument, str(place.folder), allowed)


def _is_export(folder: Path) -> bool:
    """Return whether an export has used this folder, even one killed before its first complete frame."""
    for name, wanted in ((NAME, FORMAT.encode()), (LOCK, _OWNER)):
        with contextlib.suppress(OSError), open(folder / name, "rb") as file:
            if wanted in file.read(_MARK_WITHIN):
                return True
    return False


def _same(file: int, path: Path) -> bool:
    """Return whether an open file still has its name."""
    try:
        return os.path.samestat(os.fstat(file), os.stat(path))
    except FileNotFoundError:
        return False


def _lock(argument: str, place: Place) -> int:
    file = files.open_lock(place.folder / LOCK)
    if files.is_locked_elsewhere(file):  # never true on a file system without locks
        allowed = f"a path that no other export is writing to ({files.owner_of_lock(file)} is)"
        raise ArgumentError(argument, str(place.path), allowed)
    with contextlib.suppress(OSError):  # on a full disk the export itself will fail
        os.ftruncate(file, 0)
        os.pwrite(file, _OWNER + f"{os.getpid()}\n".encode(), 0)
    return file
