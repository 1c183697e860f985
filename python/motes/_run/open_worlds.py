"""Open worlds as the launcher sees them: one file per open world of each rank, in the launcher's folder.

Open MPI 5 returns 0 from a run that lost a whole host. A rank on the launcher's host that entered a world and
never left it shows that such a run did not finish.
"""

from __future__ import annotations

import contextlib
import os
import secrets
from pathlib import Path

from .. import environment

__all__ = ["FOLDER", "enter", "leave", "left_open"]

FOLDER = "MOTES_OPEN_WORLDS"  # the environment variable that names it; ranks of other hosts do not find it


def enter(rank: int) -> Path | None:
    """Note that a world of this rank is open; returns what `leave` takes."""
    folder = environment.read(FOLDER)
    if not folder or not Path(folder).is_dir():
        return None
    file = Path(folder) / f"{rank}-{secrets.token_hex(4)}"
    with contextlib.suppress(OSError):
        file.touch()
    return file


def leave(file: Path | None) -> None:
    """Note that the world of `enter` is closed."""
    if file is not None:
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)


def left_open(folder: str | os.PathLike[str]) -> list[int]:
    """List the ranks that entered a world and did not leave it."""
    return sorted({int(file.name.partition("-")[0]) for file in Path(folder).iterdir()})
