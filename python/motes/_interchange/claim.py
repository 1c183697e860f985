"""Claims the place of an export: continues or removes an earlier export there, and nothing else.

An export holds a lock while it writes; the operating system releases it whenever the process ends.
"""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path
from typing import Self

from .._io import files
from .._shot.facts import FILES
from .._values import environment
from ..errors import ArgumentError, MotesError
from .formats import FORMATS, Place
from .manifest import FORMAT, NAME, Manifest
from .origin import difference

__all__ = ["Claim", "check_free"]

LOCK = ".lock"
_OWNER = b"particles of motes, process "
_MARK_WITHIN = 400


class Claim:
    """The place of an export, held until `release` or the end of the process."""

    def __init__(self, place: Place, lock: int) -> None:
        """Hold the lock, an open file; `Claim.make` makes one."""
        self.place = place
        self.replaced: list[int] = []
        """The frames of the earlier export that were removed, since this run writes them again."""
        self._lock = lock

    @classmethod
    def make(cls, argument: str, place: Place, manifest: Manifest, *, first: int = 0) -> Self:
        """Claim the place of the export that `manifest` describes, which will write frames from `first` on.

        Of an earlier export with the same origin, frames before `first` are kept and noted in `manifest`;
        later ones are removed. With MOTES_FRESH any earlier export is removed. Nothing else ever is.

        Raises ArgumentError, before it changes anything, if the place holds other files or an export of
        another origin, or if another export is being written there; MotesError if the folder cannot be made.
        """
        try:
            return cls._make(argument, place, manifest, first)
        except OSError as error:
            reason = error.strerror or str(error)
            raise MotesError(f"particles cannot be written to {place.path}: {reason}") from error

    @classmethod
    def _make(cls, argument: str, place: Place, manifest: Manifest, first: int) -> Self:
        folder = place.folder
        check_free(argument, place)
        folder.mkdir(parents=True, exist_ok=True)
        marked = os.path.lexists(folder / LOCK)
        lock = _lock(argument, place)
        while not _same(lock, folder / LOCK):  # another export has just removed it
            os.close(lock)
            lock = _lock(argument, place)
        claim = cls(place, lock)
        try:
            earlier = None if environment.read("MOTES_FRESH") else _earlier(argument, place, manifest, first)
            if earlier is not None:
                manifest.continue_after(earlier, first)
                claim.replaced = [frame.frame for frame in earlier.frames if frame.frame >= first]
            # First: what an interrupted removal leaves is in no manifest, and the next claim removes it.
            place.publish(manifest)
            kept = {part.file for frame in manifest.frames for part in frame.parts}
            for name in _files(folder) - kept - place.beside(manifest) - manifest.scene_files():
                (folder / name).unlink()
        except BaseException:
            claim.release(keep_mark=marked)
            raise
        return claim

    def release(self, *, keep_mark: bool = False) -> None:
        """Release the place for other exports. Calling it again does nothing.

        `keep_mark`: the lock file stays, which marks the folder as that of an export.
        """
        lock, self._lock = self._lock, -1
        if lock >= 0:
            if not keep_mark:
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
    part = rf"([A-Za-z][A-Za-z0-9_]*(\.\d{{6,}}(\.r\d{{4,}})?\.({kinds}){beside})|{FILES.pattern})"
    # USD writes its own temporary file first: the draft's name, but ending in six random letters.
    draft = rf"\.({re.escape(NAME)}|{part})\.[0-9a-f]{{16}}\.(tmp|\w{{6}})"
    return re.compile(rf"{re.escape(NAME)}|{part}|{draft}")


def _files(folder: Path) -> set[str]:
    """Return the names of all files of exports in a folder, except its manifest."""
    own = _own()
    return {name for name in os.listdir(folder) if name != NAME and own.fullmatch(name)}


def _earlier(argument: str, place: Place, manifest: Manifest, first: int) -> Manifest | None:
    """Return the manifest of an earlier export in a place that is locked; None if there is none.

    Raises ArgumentError if the export is of another origin, or if that cannot be found out.
    """
    earlier: Manifest | None = None
    if os.path.lexists(place.folder / NAME):
        try:
            earlier = Manifest.read(place.folder)
            if not earlier.frames:  # nothing would be lost
                return None
            unlike = difference(earlier, manifest, first=first, anyway=environment.read("MOTES_ANYWAY"))
        except MotesError as error:
            unlike = str(error)
    else:
        whole = any(not name.startswith(".") for name in _files(place.folder))
        unlike = f"it lacks its {NAME}" if whole else ""
    if not unlike:
        return earlier
    allowed = f"a new path, or that of an export of the same script, arguments and settings ({unlike})"
    hint = "`python -m motes run --fresh ...` (or MOTES_FRESH=1) replaces it"
    raise ArgumentError(argument, str(place.path), allowed, hint=hint)


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
