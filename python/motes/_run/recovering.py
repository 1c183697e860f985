"""The script's side of a rank that goes on when others are lost: `World(on_loss="recover")`.

The core makes the world again (cpp/engine/recover.cpp) and asks for what only Python knows: who the others
are now, films and pictures whose writer is gone, the log's directory.
"""

from __future__ import annotations

import weakref
from collections import deque
from typing import TYPE_CHECKING, Any, Literal

from .. import _core
from ..errors import MotesError
from . import continuing
from .losses import lost_ranks, taken_over
from .output import tell
from .peers import PeerWatch
from .process import process

if TYPE_CHECKING:
    from pathlib import Path

    from ..frame import Frame
    from ..world import World
    from .process import OpenRun

__all__ = ["EVERY", "Recovery", "check", "close_films"]

EVERY = 12
"""Copies of all particles are made before every so many frames."""

_SAVES = 64  # pictures that the rank that is gone may not have written; it was one frame ahead at most


def close_films() -> None:
    """Close films whose writer was lost behind the end of its world: all ranks that live are here."""
    from mpi4py import MPI

    lost = lost_ranks(MPI.COMM_WORLD)
    first = next(rank for rank in range(process.size) if rank not in lost)
    for movie in continuing.outlasting_movies() if lost and process.rank == first else ():
        movie._close_for_lost()


def check(on_loss: str, size: int) -> None:
    """Raise MotesError where a run should survive losses and this job cannot."""
    if on_loss == "recover" and size > 1 and not process.survives:
        raise MotesError(
            'World(on_loss="recover") needs a job that goes on without lost ranks: start it with '
            "`python -m motes run --survive ...`"
        )


class Recovery:
    """What one rank keeps for the loss of others, and does when it happens."""

    def __init__(self, world: World, engine: _core.Engine, run: OpenRun) -> None:
        """Let the core survive losses from here on. All ranks make theirs behind the start of the engine."""
        self._world = weakref.ref(world)  # the engine holds this, and the world holds the engine
        self._run = run
        self._picture: weakref.ref[Frame] | None = None
        self._saves: deque[tuple[int, Path, Literal[8, 16]]] = deque(maxlen=_SAVES)
        self._lost: list[str] = []
        continuing.keep_closed_movies(True)
        engine.survive_losses(EVERY, self)

    def secure_films(self, engine: _core.Engine) -> None:
        """Bring films that stay open behind the run's end to the disk. Collective.

        Then another rank can give them their names where the one that writes them is lost meanwhile.
        """
        if continuing.open_movies():
            continuing.secure_movies(engine)

    def end(self) -> None:
        """Forget what is kept: the run is over."""
        continuing.keep_closed_movies(False)

    # --- what is kept

    def note_picture(self, picture: Frame) -> None:
        """Note a frame that was drawn on another rank: what the script does with it may be done here."""
        self._picture = weakref.ref(picture)
        picture._elsewhere = self._note_save

    def _note_save(self, index: int, path: Path, bits: Literal[8, 16]) -> None:
        self._saves.append((index, path, bits))

    def tell_unsaved(self, engine: _core.Engine) -> None:
        """Tell the core which pictures are in no film yet, where this rank draws."""
        world = self._world()
        if world is not None and "image_generator" in world.role:
            first = [movie._first_unsaved() for movie in continuing.open_movies()]
            engine.set_unsaved_from(min((index for index in first if index is not None), default=None))

    # --- what the core asks for after a loss

    def regroup(self, loss: dict[str, Any]) -> str | None:
        """Find the others that are left; return why this rank cannot go on, or "". Collective.

        None: one more rank was lost meanwhile.
        """
        from mpi4py import MPI

        world = self._world()
        assert world is not None
        try:
            self._meet(world, loss)
            refusal = self._refusal(world)
            if not refusal:
                self._claim_log(world)
                world._serve_again()
            return refusal
        except MPI.Exception:
            return None
        except Exception as error:  # any: the others must hear of it
            return f"{process.describe(self._run)}: {error}"

    def _meet(self, world: World, loss: dict[str, Any]) -> None:
        from mpi4py import MPI

        run, survivors = self._run, loss["survivors"]
        self._lost = [f"rank {rank} ({run.peers[rank].role})" for rank in loss["lost"]]
        left = MPI.Intracomm(MPI.Comm.f2py(loss["comm"]))
        # Not a duplicate: Open MPI 5.0 crashes where a rank is lost while that is being made.
        made = MPI.Intracomm(left.Shrink())
        if made.size < left.size:
            raise MPI.Exception(MPI.ERR_PROC_FAILED)
        world._take_ranks(made, loss["roles"])
        world._describe.cast = world._cast
        world._settings = world._settings.of_those_left(world._cast, survivors)
        if world._given[0] is None:  # it was a world of all ranks
            process.left = made
        names = [_core.describe_role(world._cast, rank) for rank in range(made.size)]
        run.ranks = [run.world_rank(rank) for rank in survivors]
        run.peers = [
            run.peers[then]._replace(rank=now, role=names[now]) for now, then in enumerate(survivors)
        ]
        run.threads = [run.threads[rank] for rank in survivors]
        run.comm, run.role = made, names[made.rank]
        run.busy.clear()
        if run.watch is not None:
            run.watch.close()
        run.watch = PeerWatch(run.peers, rank=made.rank)
        if world._course is not None:
            world._course.go_on_with(made, world._settings)

    def _refusal(self, world: World) -> str:
        if world._steering.steered or world._settings.steering is not None:
            return "the run is steered: what viewers ask for is known to one rank alone"
        if world._open_views:
            return f"the script was inside `with` {world._open_views[-1].name!r}`.local()`"
        if world._exports:
            return f"the files of {world._exports[0]} lack the lost ranks' particles"
        return ""

    def _claim_log(self, world: World) -> None:
        directory, run = world._settings.log, self._run
        if directory is not None and "manager" in world.role and run.log is None:
            from .log_directory import LogDirectory

            run.log = taken_over(lambda: LogDirectory.claim(directory, continued=True))

    def unsaved_from(self) -> int | None:
        """Return the first frame whose picture must be made again: this rank draws in place of a lost one."""
        ran = self._run.frame or 0
        wanted = [index for index, *_ in self._saves if index + 2 >= ran]
        picture = None if self._picture is None else self._picture()
        if picture is not None:
            wanted.append(picture.index)
        for movie in continuing.movies_to_take_over():
            wanted += movie._take_over()
        return min(wanted, default=None)

    def resumed(self, frame: int) -> None:
        """Go on: the world is what it was before `frame`."""
        world = self._world()
        assert world is not None
        if "manager" not in world.role:
            return
        hosts = [peer.host for peer in self._run.peers]
        left = f"{len(hosts)} {'rank goes' if len(hosts) == 1 else 'ranks go'} on"
        tell(f"motes: lost {', '.join(self._lost)}; {left}, from copies of frame {frame}")
        if world._settings.log is not None:
            from .run_file import write_run

            write_run(world._settings.log, world._facts(), hosts, self._run.threads, continued_from=frame)

    def redrawn(self, index: int, view: _core.View) -> None:
        """Write a picture that was made again to where the lost rank may not have written it."""
        world = self._world()
        assert world is not None and world._engine is not None
        engine = world._engine
        picture = world._picture(engine, index, (index + 1) * world.dt, view)
        expected = None if self._picture is None else self._picture()
        if expected is not None and expected.index == index:
            expected._arrive(picture)
            picture = expected
        picture._keep_all()
        if world._settings.digest:
            engine.set_image_sha256(picture.digest())
        for _, path, bits in [save for save in self._saves if save[0] == index]:
            picture.save(path, bits=bits)
        for movie in continuing.movies_to_take_over():
            movie._write_again(index, picture)
