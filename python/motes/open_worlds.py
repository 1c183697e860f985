"""Open worlds as the launcher sees them: a file a rank while its world is open, in the launcher's folder.

Open MPI 5 returns 0 from a run that lost a whole host. A rank on the launcher's host that entered a world and
never left it tells that such a run did not end.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from . import environment

__all__ = ["FOLDER", "enter", "leave", "left_open"]

FOLDER = "MOTES_OPEN_WORLDS"  # the environment variable that names it; ranks of other hosts do not find it


def enter(rank: int) -> None:
    """Say that this rank's world is open."""
    if (file := _file(rank)) is not None:
        with contextlib.suppress(OSError):
            file.touch()


def leave(rank: int) -> None:
    """Say that it is closed."""
    if (file := _file(rank)) is not None:
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)


def left_open(folder: str | os.PathLike[str]) -> list[int]:
    """Ranks that entered a world and did not leave it."""
    return sorted(int(file.name) for file in Path(folder).iterdir() if file.name.isdigit())


def _file(rank: int) -> Path | None:
    folder = environment.read(FOLDER)
    return Path(folder) / str(rank) if folder and Path(folder).is_dir() else None
