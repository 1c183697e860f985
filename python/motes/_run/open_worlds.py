"""Open worlds as seen by the launcher: one file per open world of each rank, in the launcher's folder.

`RANK-WORLD-...` exists while a rank is in a world. `ended-WORLD` is created once a rank reaches the world's
end in a job that survives losses: ranks that are lost afterwards do not count.

Open MPI 5 returns 0 from a run that lost a whole host. A rank on the launcher's host that entered a world and
never left it shows that the run did not finish. The files also tell which processes to signal to stop a run:
mpirun would kill its ranks half a second after it got a signal.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from .._values import environment
from .peers import Peer, lives

__all__ = [
    *("FOLDER", "end", "enter", "forget", "keeps_checkpoints", "leave", "left_open", "note_checkpoints"),
    "send",
]

_ENDED = "ended"
FOLDER = "MOTES_OPEN_WORLDS"  # environment variable with the folder's path, which other hosts do not have


def enter(rank: int, world: str) -> Path | None:
    """Note that this rank is in a world; `world`: its name, equal on all ranks. Return `leave`'s argument."""
    folder = environment.read(FOLDER)
    if not folder or not Path(folder).is_dir():
        return None
    file = Path(folder) / f"{rank}-{world}-{os.urandom(4).hex()}"
    with contextlib.suppress(OSError):
        here = Peer.here(rank=rank, role="")
        file.write_text(f"{here.pid} {here.started} {here.space}")
    return file


def note_checkpoints(has: bool) -> None:
    """Note whether the world that this rank is in could go on from a checkpoint."""
    folder = environment.read(FOLDER)
    if folder and Path(folder).is_dir():
        with contextlib.suppress(OSError):
            _mark(folder).write_text(str(int(has)))


def keeps_checkpoints(folder: str | os.PathLike[str]) -> bool | None:
    """Return whether the last world that opened could go on from a checkpoint; None: no world has opened."""
    try:
        return bool(int(_mark(folder).read_text()))
    except (OSError, ValueError):
        return None


def _mark(folder: str | os.PathLike[str]) -> Path:
    return Path(folder).with_name("checkpoints")


def leave(file: Path | None) -> None:
    """Note that this rank has left the world; `file`: the result of `enter`."""
    if file is not None:
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)


def end(file: Path | None) -> None:
    """Note that all ranks of the world have agreed on its end; `file`: the result of `enter`."""
    if file is not None:
        with contextlib.suppress(OSError):
            (file.parent / f"{_ENDED}-{file.name.split('-')[1]}").touch()


def send(folder: str | os.PathLike[str], number: int) -> int:
    """Send a signal to each rank of this host that is in a world; return the number of ranks."""
    here = Peer.here(rank=0, role="")
    reached = set()
    for file in Path(folder).iterdir():
        with contextlib.suppress(OSError, ValueError):  # the file is half written, or the process is gone
            pid, started, space = file.read_text().split(" ", 2)
            its = here._replace(pid=int(pid), started=int(started))
            if space == here.space and its.pid not in reached and lives(its):
                os.kill(its.pid, number)
                reached.add(its.pid)
    return len(reached)


def forget(rank: int) -> None:
    """Remove all notes of a lost rank."""
    folder = environment.read(FOLDER)
    if folder and Path(folder).is_dir():
        for file in Path(folder).glob(f"{rank}-*"):
            leave(file)


def left_open(folder: str | os.PathLike[str]) -> list[int]:
    """List the ranks that entered a world and never left it, except worlds that have ended."""
    notes = [file.name.split("-") for file in Path(folder).iterdir()]
    ended = {note[1] for note in notes if note[0] == _ENDED}
    return sorted({int(rank) for rank, world, *_ in notes if rank != _ENDED and world not in ended})
