"""The Python side of a rank that continues when others are lost: `World(on_loss="recover")`.

The core restores the world (cpp/engine/recovering_engine.cpp). It calls Python for what only Python knows:
the surviving ranks, films and pictures whose writer was lost, the log's directory.
"""

from __future__ import annotations

import weakref
from collections import deque
from typing import TYPE_CHECKING, Any, Literal

from .. import _core
from .._io.output import tell
from .._picture.frame import Frame, arrive, keep_all, tell_saves
from .._run import continuing
from .._run.losses import taken_over
from .._run.peers import PeerWatch
from .._run.process import process
from ..errors import MotesError

if TYPE_CHECKING:
    from pathlib import Path

    from .._run.process import OpenRun
    from .._system.session import Session
    from .running import Running

__all__ = ["EVERY", "Recovery", "check"]

EVERY = 12
"""Frames between two replicas of all particles."""

_SAVES = 64  # the most recent saves, which a lost rank may not have written; it was at most one frame ahead


def check(size: int) -> None:
    """Raise MotesError if this job cannot survive losses."""
    if size > 1 and not process.survives:
        raise MotesError(
            'World(on_loss="recover") needs a job that survives the loss of ranks: start it with '
            "`python -m motes run --survive ...`"
        )


class Recovery:
    """What one rank keeps in case others are lost, and what it does then."""

    def __init__(self, running: Running, engine: _core.Engine, run: OpenRun) -> None:
        """Let the core survive losses from here on. Every rank does this right after the engine's start."""
        self._running = weakref.ref(running)  # the engine holds this, and the world holds the engine
        self._run = run
        self._picture: weakref.ref[Frame] | None = None
        self._saves: deque[tuple[int, Path, Literal[8, 16]]] = deque(maxlen=_SAVES)
        self._lost: list[str] = []
        continuing.keep_closed_movies(True)
        engine.survive_losses(EVERY, self)

    def secure_films(self, engine: _core.Engine) -> None:
        """Flush films that stay open after the run's end to disk. Collective.

        If the rank that writes a film is then lost, another rank can still give the film its name.
        """
        if continuing.open_movies():
            continuing.secure_movies(engine)

    def end(self) -> None:
        """Release what is kept: the run is over."""
        continuing.keep_closed_movies(False)

    # --- what is kept

    def note_picture(self, picture: Frame) -> None:
        """Remember a frame drawn on another rank: this rank may have to take over saving it."""
        self._picture = weakref.ref(picture)
        tell_saves(picture, self._note_save)

    def _note_save(self, index: int, path: Path, bits: Literal[8, 16]) -> None:
        self._saves.append((index, path, bits))

    def tell_unsaved(self, engine: _core.Engine) -> None:
        """Tell the core the first picture that is not yet in a film, if this rank draws."""
        running = self._running()
        if running is not None and running.session.draws:
            first = [movie.first_unsaved() for movie in continuing.open_movies()]
            engine.set_unsaved_from(min((index for index in first if index is not None), default=None))

    # --- what the core calls after a loss

    def regroup(self, loss: dict[str, Any]) -> str | None:
        """Find the other survivors; return why this rank cannot continue, or "". Collective.

        Returns None if another rank was lost meanwhile.
        """
        from mpi4py import MPI

        running = self._running()
        assert running is not None
        try:
            self._meet(running, loss)
            refusal = self._refusal(running)
            if not refusal:
                self._claim_log(running.session)
                running.viewers.serve_again()
            return refusal
        except MPI.Exception:
            return None
        except Exception as error:  # of any kind: the other ranks must learn about it
            return f"{process.describe(self._run)}: {error}"

    def _meet(self, running: Running, loss: dict[str, Any]) -> None:
        from mpi4py import MPI

        run, survivors = self._run, loss["survivors"]
        self._lost = [f"rank {rank} ({run.peers[rank].role})" for rank in loss["lost"]]
        left = MPI.Intracomm(MPI.Comm.f2py(loss["comm"]))
        # Not a duplicate: Open MPI 5.0 crashes if a rank is lost while a communicator is being duplicated.
        comm = MPI.Intracomm(left.Shrink())
        if comm.size < left.size:
            raise MPI.Exception(MPI.ERR_PROC_FAILED)
        session = running.session
        session.take_ranks(comm, loss["roles"])
        session.settings = session.settings.of_those_left(session.cast, survivors)
        if running.given[0] is None:  # the world uses all ranks
            process.left = comm
        names = [_core.describe_role(session.cast, rank) for rank in range(comm.size)]
        run.ranks = [run.world_rank(rank) for rank in survivors]
        run.peers = [
            run.peers[then]._replace(rank=now, role=names[now]) for now, then in enumerate(survivors)
        ]
        run.threads = [run.threads[rank] for rank in survivors]
        run.comm, run.role = comm, names[comm.rank]
        run.busy.clear()
        if run.watch is not None:
            run.watch.close()
        run.watch = PeerWatch(run.peers, rank=comm.rank)
        if running.loop.checkpoints is not None:
            running.loop.checkpoints.go_on_with(comm, session.settings)

    def _refusal(self, running: Running) -> str:
        session = running.session
        if running.viewers.steering.steered or session.settings.steering is not None:
            return "the run is steered, and only one rank knows what viewers requested"
        if session.open_views:
            return f"the script was inside `with` {session.open_views[-1].name!r}`.local()`"
        if session.files:
            return f"the files of {session.files[0].owner} lack the lost ranks' particles"
        return ""

    def _claim_log(self, session: Session) -> None:
        directory, run = session.settings.log, self._run
        if directory is not None and session.manages and run.log is None:
            from .._run.log_directory import LogDirectory

            run.log = taken_over(lambda: LogDirectory.claim(directory, continued=True))

    def unsaved_from(self) -> int | None:
        """Return the first frame whose picture must be redrawn by this rank, in place of a lost one."""
        ran = self._run.frame or 0
        wanted = [index for index, *_ in self._saves if index + 2 >= ran]
        picture = None if self._picture is None else self._picture()
        if picture is not None:
            wanted.append(picture.index)
        for movie in continuing.movies_to_take_over():
            wanted += movie.take_over()
        return min(wanted, default=None)

    def resumed(self, frame: int) -> None:
        """Report that the run continues; the world has been restored to its state before `frame`."""
        running = self._running()
        assert running is not None
        session = running.session
        if not session.manages:
            return
        hosts = [peer.host for peer in self._run.peers]
        left = f"{len(hosts)} {'rank continues' if len(hosts) == 1 else 'ranks continue'}"
        tell(f"motes: lost {', '.join(self._lost)}; {left} from replicas of frame {frame}")
        if session.settings.log is not None:
            from .._run.run_file import write_run

            write_run(session.settings.log, session.facts(), hosts, self._run.threads, continued_from=frame)

    def redrawn(self, index: int, view: _core.View) -> None:
        """Write a redrawn picture to the files and films that the lost rank may not have finished."""
        running = self._running()
        assert running is not None and running.session.engine is not None
        settings, engine = running.session.settings, running.session.engine
        picture = running.pictures.take(engine, index, (index + 1) * settings.dt, view)
        expected = None if self._picture is None else self._picture()
        if expected is not None and expected.index == index:
            arrive(expected, picture)
            picture = expected
        keep_all(picture)
        if settings.digest:
            engine.set_image_sha256(picture.digest())
        for _, path, bits in [save for save in self._saves if save[0] == index]:
            picture.save(path, bits=bits)
        for movie in continuing.movies_to_take_over():
            movie.write_again(index, picture)
