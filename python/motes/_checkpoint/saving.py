"""Write checkpoints while frames continue: each calculator writes its part, and the manager the manifest."""

from __future__ import annotations

import contextlib
import shutil
import threading
from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .. import _core
from .._io import files
from .._io.output import tell
from .._run.busy import Busy
from .._run.continuing import frames_of_movies, secure_movies
from .._run.losses import lost_ranks, unless_lost
from .._run.waiting import Wait, poll
from .._values.checkpoint import AUTO, Checkpoint
from . import folder
from .manifest import Manifest, PartEntry
from .pacing import Pace, thin

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["Roles", "Saver"]

_WHAT = "other ranks to write their parts of a checkpoint"
_LOOK_S = 0.05

Roles = tuple[int, int, Sequence[int]]
"""The ranks of the manager, the image generator and the calculators."""


@dataclass
class _Pending:
    """A checkpoint whose parts are being written."""

    manifest: Manifest
    place: Path
    request: MPI.Request | None = None
    own: array[int] | None = None
    agreed: array[int] | None = None
    finishing: threading.Thread | None = None
    """On the manager, once all parts are on disk: the thread that completes the checkpoint."""


_WHOLE, _FAILED = b"whole", b"failed"  # outcomes of a checkpoint
_given_up: list[_Pending] = []  # kept, since MPI may still write into their buffers


class Saver:
    """Writes a run's checkpoints. All ranks call the same methods between the same frames.

    If ranks are lost, the pending checkpoint is given up; `save` writes it again.
    """

    def __init__(
        self, engine: _core.Engine, comm: MPI.Intracomm, cast: Roles, directory: Path,
        checkpoint: Checkpoint, stall_s: float | None, describe: Callable[[], str],
        secure: Callable[[], None],
    ) -> None:  # fmt: skip
        """Store the parts of a run.

        `describe` names this rank in messages; `secure` flushes the record of viewers to disk.
        """
        self._engine = engine
        self._secure = secure
        self._take_roles(comm, cast)
        self._directory = directory
        self._checkpoint = checkpoint
        self._stall_s = stall_s
        self._describe = describe
        self._pending: _Pending | None = None
        self.pace = Pace(checkpoint.seconds, 0) if checkpoint.every == AUTO else None
        """Decides when a checkpoint is due; None: the number of frames does."""
        self.last: int | None = None
        """The frame of the newest checkpoint that was begun or that the run continues from."""
        self._ended: tuple[int, bytes] | None = None
        """Frame and outcome of the last checkpoint whose outcome this rank knows."""

    @property
    def manages(self) -> bool:
        """Whether this rank writes the manifests."""
        return bool(self._comm.rank == self._manager)

    def due(self, frame: int) -> bool:
        """Return whether a checkpoint is due before this frame. Collective with every="auto"."""
        if frame == 0 or frame == self.last:
            return False
        if self.pace is not None:
            return self.pace.due(self._engine)
        return self.cuts_films(frame)

    def cuts_films(self, frame: int) -> bool:
        """Return whether the checkpoints of any run of this script cut its films before this frame."""
        every = self._checkpoint.every
        return isinstance(every, int) and frame % every == 0

    def look(self) -> None:
        """Check, without waiting, whether the pending checkpoint is complete. Collective."""
        pending = self._pending
        if pending is None:
            return
        busy, _, _ = self._engine.part_outcome()
        with unless_lost(self._give_up):
            if pending.request is None and not busy:
                self._tell_outcome(pending)
            if pending.request is not None and pending.request.Test():
                self._conclude(pending)

    def go_on_from(self, manifest: Manifest) -> None:
        """Note that the run continues from this complete checkpoint."""
        self.last, self._ended = manifest.frame, (manifest.frame, _WHOLE)
        if self.pace is not None:
            self.pace = Pace(self._checkpoint.seconds, manifest.stepped_s)

    def save(self, frame: int, describe: Callable[[], Manifest]) -> None:
        """Write a checkpoint of this frame, if there is none, and wait until it is complete. Collective."""
        for _ in range(self._comm.size + 1):  # retries after each loss
            if frame != self.last:
                self.begin(frame, describe)
            self.finish()
            ends = self._engine.tell(lambda: self._end_of(frame))
            for end in (_WHOLE, _FAILED):
                if end in ends:
                    self._ended = frame, end
                    if self.manages:
                        folder.sweep(self._directory)  # remove checkpoints given up when ranks were lost
                    return
            self.last = None

    def begin(self, frame: int, describe: Callable[[], Manifest]) -> None:
        """Wait for the pending checkpoint, then begin to write one of this frame. Collective.

        `describe` returns a manifest without parts, world and movies, which are added here. When this
        returns, films and the log are on disk up to here.
        """
        self.finish()
        secure_movies(self._engine, self._secure)
        self.last = frame
        if self.pace is not None:
            self.pace.begin(self._engine)
        manifest = describe()
        manifest.movies = frames_of_movies()
        place = folder.begun(self._directory, frame, self._engine.losses)
        world = self._engine.shared_state()
        manifest.world = {"file": folder.WORLD, "bytes": len(world), "crc32c": _core.crc32c(world)}
        failure = ""
        try:
            folder.make_begun(place)
            if self.manages:
                files.write_whole(place / folder.WORLD, world)
            if self._calculator >= 0:
                self._engine.save_part(str(place / folder.part_name(self._calculator)))
        except OSError as error:
            failure = f"{error.strerror or error}: {place}"
        self._pending = _Pending(manifest, place)
        if failure:
            self._complain(manifest.frame, failure)
            self._post(self._pending, well=False)

    def finish(self) -> None:
        """Wait until the pending checkpoint is complete or has failed. Collective."""
        pending = self._pending
        if pending is None:
            return
        if pending.request is None:
            with Busy("writing a checkpoint") as busy:
                while self._engine.part_outcome()[0]:
                    threading.Event().wait(_LOOK_S)
                    busy.look()
            self._engine.wait_for_part()
        with unless_lost(self._give_up):
            if pending.request is None:
                self._tell_outcome(pending)
            assert pending.request is not None
            if not self._all_have_said(pending.request):
                self._give_up()
                return
            self._conclude(pending)
            if pending.finishing is not None:
                pending.finishing.join()
        self._pending = None

    def _end_of(self, frame: int) -> bytes:
        return self._ended[1] if self._ended is not None and self._ended[0] == frame else b""

    def _all_have_said(self, request: MPI.Request) -> bool:
        """Wait until all ranks have reported on their parts; return False if one is lost before that."""
        done = False

        def ended() -> bool:
            nonlocal done
            done = request.Test()
            return done or bool(lost_ranks(self._comm))

        poll(ended, Wait(self._stall_s, _WHAT))
        return done

    def go_on_with(self, comm: MPI.Intracomm, cast: Roles) -> None:
        """Continue with the ranks of `comm` in these roles; give up the pending checkpoint."""
        self._give_up()
        self._take_roles(comm, cast)

    def _take_roles(self, comm: MPI.Intracomm, cast: Roles) -> None:
        self._comm = comm
        self._manager, _, calculators = cast
        self._calculators = len(calculators)
        self._calculator = calculators.index(comm.rank) if comm.rank in calculators else -1

    def _give_up(self) -> None:
        pending, self._pending = self._pending, None
        if pending is None:
            return
        _given_up.append(pending)
        if not self.manages:
            return
        if pending.finishing is None:
            shutil.rmtree(pending.place, ignore_errors=True)
        else:
            pending.finishing.join()  # complete it, since all parts are on disk

    def _tell_outcome(self, pending: _Pending) -> None:
        _, written, error = self._engine.part_outcome()
        well = self._calculator < 0 or (written == pending.manifest.frame and not error)
        if not well:
            self._complain(pending.manifest.frame, error)
        self._post(pending, well=well)

    def _post(self, pending: _Pending, *, well: bool) -> None:
        from mpi4py import MPI

        pending.own, pending.agreed = array("i", [int(well)]), array("i", [0])
        pending.request = self._comm.Iallreduce(pending.own, pending.agreed, MPI.MIN)

    def _complain(self, frame: int, error: str) -> None:
        whole = [number for number, _ in folder.whole(self._directory)]
        rest = f"the newest complete one is of frame {whole[0]}" if whole else "there is none yet"
        tell(
            f"motes: {self._describe()}: the checkpoint of frame {frame} could not be written: {error}; "
            f"the run continues, {rest}"
        )

    def _conclude(self, pending: _Pending) -> None:
        """Let the manager complete the checkpoint, now that all ranks have reported on their parts."""
        if not self.manages:
            self._pending = None
            return
        if pending.finishing is None:
            assert pending.agreed is not None
            well = bool(pending.agreed[0])
            pending.finishing = threading.Thread(target=self._make_whole, args=(pending, well), daemon=True)
            pending.finishing.start()
        elif not pending.finishing.is_alive():
            self._pending = None

    def _make_whole(self, pending: _Pending, well: bool) -> None:
        try:
            if not well:
                shutil.rmtree(pending.place, ignore_errors=True)
                self._ended = pending.manifest.frame, _FAILED
                return
            pending.manifest.parts = [self._entry(pending.place, i) for i in range(self._calculators)]
            pending.manifest.write(pending.place)
            folder.finish(pending.place, pending.manifest.frame)
            self._ended = pending.manifest.frame, _WHOLE
            if self.pace is None:
                folder.prune(self._directory, self._checkpoint.keep)
            else:
                thin(self._directory, self._checkpoint)
        except (OSError, RuntimeError) as error:
            with contextlib.suppress(OSError):
                shutil.rmtree(pending.place, ignore_errors=True)
            self._ended = pending.manifest.frame, _FAILED
            self._complain(pending.manifest.frame, str(error))

    def _entry(self, place: Path, calculator: int) -> PartEntry:
        path = place / folder.part_name(calculator)
        part = _core.PartFile(str(path), False)
        return PartEntry(path.name, path.stat().st_size, [rows for _, rows in part.rows])
