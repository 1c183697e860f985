"""Open worlds as the launcher sees them: one file per open world of each rank, in the launcher's folder.

Open MPI 5 returns 0 from a run that lost a whole host. A rank on the launcher's host that entered a world and
never left it shows that such a run did not finish. The files also say where signals must go that ask a run to
stop: mpirun would kill its ranks half a second after it got one.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from .. import environment
from .peers import Peer, lives

__all__ = ["FOLDER", "enter", "forget", "leave", "left_open", "send"]

FOLDER = "MOTES_OPEN_WORLDS"  # the environment variable that names it; ranks of other hosts do not find it


def enter(rank: int) -> Path | None:
    """Note that a world of this rank is open; returns what `leave` takes."""
    folder = environment.read(FOLDER)
    if not folder or not Path(folder).is_dir():
        return None
    file = Path(folder) / f"{rank}-{os.urandom(4).hex()}"
    with contextlib.suppress(OSError):
        here = Peer.here(rank=rank, role="")
        file.write_text(f"{here.pid} {here.started} {here.space}")
    return file


def leave(file: Path | None) -> None:
    """Note that the world of `enter` is closed."""
    if file is not None:
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)


def send(folder: str | os.PathLike[str], number: int) -> int:
    """Send a signal to each rank of this host that is in a world; returns how many there are."""
    here = Peer.here(rank=0, role="")
    reached = set()
    for file in Path(folder).iterdir():
        with contextlib.suppress(OSError, ValueError):  # half written, or the process is gone
            pid, started, space = file.read_text().split(" ", 2)
            its = here._replace(pid=int(pid), started=int(started))
            if space == here.space and its.pid not in reached and lives(its):
                os.kill(its.pid, number)
                reached.add(its.pid)
    return len(reached)


def forget(rank: int) -> None:
    """Take back every note of a rank that is lost."""
    folder = environment.read(FOLDER)
    if folder and Path(folder).is_dir():
        for file in Path(folder).glob(f"{rank}-*"):
            leave(file)


def left_open(folder: str | os.PathLike[str]) -> list[int]:
    """List the ranks that entered a world and did not leave it."""
    return sorted({int(file.name.partition("-")[0]) for file in Path(folder).iterdir()})
