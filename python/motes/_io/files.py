"""Files that are whole or not there: written under a temporary name, synced, then renamed."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

__all__ = ["whole_file", "whole_path", "write_whole"]


@contextmanager
def whole_path(path: str | os.PathLike[str], *, temporary: str | None = None) -> Iterator[Path]:
    """Lend a temporary name in the same directory; on success it becomes `path`, on failure it goes away.

    The block writes and closes the file itself. `temporary` fixes the name, for a long job whose remains a
    later run should overwrite; otherwise the name is new each time, so that two writers never share it.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(temporary or f".{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        yield draft
        _sync(draft)
        os.replace(draft, path)
    except BaseException:
        with suppress(OSError):
            draft.unlink()
        raise
    _sync(path.parent)


@contextmanager
def whole_file(path: str | os.PathLike[str], mode: str = "wb", **options: Any) -> Iterator[IO[Any]]:
    """Open a file for writing that appears at `path` only when the block ends well.

    `options` go to `open`, such as `encoding="utf-8"`.
    """
    if "w" not in mode or "+" in mode:
        raise ValueError(f"mode must be 'w' or 'wb', got {mode!r}")
    with whole_path(path) as draft, open(draft, mode.replace("w", "x"), **options) as file:
        yield file


def write_whole(path: str | os.PathLike[str], content: bytes | Callable[[IO[bytes]], object]) -> None:
    """Write bytes, or what a function writes into the open binary file, whole or not at all."""
    with whole_file(path, "wb") as file:
        if callable(content):
            content(file)
        else:
            file.write(content)


def _sync(path: Path) -> None:
    """Bring a file or a directory to the disk, where the system can do that."""
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
