"""Open worlds as the launcher sees them: one file per open world of each rank, in the launcher's folder.

`RANK-WORLD-...` is there while a rank is in a world, `ended-WORLD` once one of its ranks came to the end,
where losses are survived: those that were lost a moment later do not count.

Open MPI 5 returns 0 from a run that lost a whole host. A rank on the launcher's host that entered a world and
never left it shows that such a run did not finish. The files also say where signals must go that ask a run to
stop: mpirun would kill its ranks half a second after it got one.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from .._values import environment
from .peers import Peer, lives

__all__ = ["FOLDER", "end", "enter", "forget", "leave", "left_open", "send"]

_ENDED = "ended"
FOLDER = "MOTES_OPEN_WORLDS"  # the environment variable that names it; ranks of other hosts do not find it


def enter(rank: int, world: str) -> Path | None:
    """Note that a world of this rank is open, of this name on all its ranks; returns what `leave` takes."""
    folder = environment.read(FOLDER)
    if not folder or not Path(folder).is_dir():
        return None
    file = Path(folder) / f"{rank}-{world}-{os.urandom(4).hex()}"
    with contextlib.suppress(OSError):
        here = Peer.here(rank=rank, role="")
        file.write_text(f"{here.pid} {here.started} {here.space}")
    return file


def leave(file: Path | None) -> None:
    """Note that the world of `enter` is closed."""
    if file is not None:
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)


def end(file: Path | None) -> None:
    """Note that all ranks of the world of `enter` have agreed on its end."""
    if file is not None:
        with contextlib.suppress(OSError):
            (file.parent / f"{_ENDED}-{file.name.split('-')[1]}").touch()


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
    """List the ranks that entered a world and did not leave it, though it has not ended."""
    notes = [file.name.split("-") for file in Path(folder).iterdir()]
    ended = {note[1] for note in notes if note[0] == _ENDED}
    return sorted({int(rank) for rank, world, *_ in notes if rank != _ENDED and world not in ended})
