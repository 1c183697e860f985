"""Checkpoints: the checkpoints of a world from its start to its end."""

from __future__ import annotations

import contextlib
import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from .. import _core
from .._io.output import tell
from .._run import same_script
from .._run.continuing import continued, secure_movies
from .._run.losses import taken_over
from .._run.process import OpenRun, process
from .._run.run_file import motes_version
from .._run.settings import RunSettings
from .._values.space import ends_of
from ..errors import CheckpointError
from . import folder
from .finding import Origin, find
from .manifest import Manifest
from .plain_data import data_of
from .restoring import restore
from .saving import Saver

if TYPE_CHECKING:
    from mpi4py import MPI

    from .._live.steering import Steering
    from .._system.system_state import SystemState

__all__ = ["EARLIER", "Checkpoints"]


PICKLES = "Checkpoint(pickles=True)"
EARLIER = "this frame was made by the earlier run that this one continues"


class Checkpoints:
    """The checkpoints of one run: continues from an earlier one, and writes new ones."""

    def __init__(
        self, run: OpenRun, settings: RunSettings, origin: Origin, engine: _core.Engine, steering: Steering,
        secure: Callable[[], None], systems: Sequence[SystemState],
    ) -> None:  # fmt: skip
        """Store what the ranks agreed on in the handshake; `secure` flushes the record of viewers to disk.

        `systems`: the world's own list, which may grow.
        """
        assert run.comm is not None and settings.checkpoint is not None
        self._run = run
        self._settings = settings
        self._writes = settings.excerpt is None
        self._origin = origin
        self._engine = engine
        self._steering = steering
        self._systems = systems
        self.skipped = 0
        """How many frames of the earlier run the script has gone through."""
        self.waiting = origin.frame > 0
        """Whether the run has a checkpoint that it has not restored yet."""
        self._script = same_script.facts()
        self._refused: set[str] = set()
        self._saver = Saver(
            engine,
            run.comm,
            (settings.roles[0], settings.roles[1], list(settings.roles[2])),
            origin.directory,
            settings.checkpoint,
            settings.stall_s,
            lambda: process.describe(run),
            secure,
        )
        if self.waiting:
            assert origin.manifest is not None
            self._saver.go_on_from(origin.manifest)
            draws = run.comm.rank == settings.roles[1]
            continued.begin(origin.frame, origin.manifest.movies, draws=draws)

    @property
    def frame(self) -> int:
        """The first frame that is still to do."""
        return self._origin.frame

    def go_on(self) -> None:
        """Restore the world from the checkpoint; do nothing if that is done. Collective."""
        if not self.waiting:
            return
        manifest, comm = self._origin.manifest, self._run.comm
        assert manifest is not None and comm is not None
        self.waiting = False
        restore(self._engine, self._origin, comm, list(self._settings.roles[2]), self._settings.stall_s)
        self._engine.copy_restored()
        self._origin.samples = None
        self._restore_script(manifest)
        if self._saver.manages:
            tell(f"motes: continues with frame {manifest.frame}, from {self._origin.place}")

    def _restore_script(self, manifest: Manifest) -> None:
        state = manifest.unpacked(self._origin.place)
        try:
            for system in self._systems:
                system.forget()
                system.newborn.restore(state["configured"][system.name])
                system.tell_clump(self._engine)
            self._steering.restore(state.get("steering", {}))
            name, known = state.get("balancer") or ("", None)
        except Exception as error:  # of any kind: the data may be anything
            raise CheckpointError(f"{self._origin.place} is damaged: {error!r}") from error
        balancer = self._settings.balancer
        if type(balancer).__qualname__ == name:
            vars(balancer).update(self._known(name, known))

    def seek(self, frame: int, now: int) -> bool:
        """Restore the newest checkpoint up to `frame` unless the world, before frame `now`, is nearer.

        Returns whether it was restored. Collective.
        """
        assert self._run.comm is not None
        with self._counted():
            self._saver.finish()
            wishes = replace(self._origin.wishes, most=frame, fresh=False, seed=self._settings.seed)
            found = find(self._run.comm, self._settings.roles[0], wishes)
            if found.manifest is None or found.frame <= now <= frame:
                return False
            for system in self._systems:  # the checkpoint holds a sprite that the script has changed by then
                system.show_as(system.definition["sprite"], self._engine)
            found.lock = self._origin.lock
            self._origin, self.waiting = found, True
            self._saver.go_on_from(found.manifest)
            self.go_on()
        return True

    def skip(self) -> bool:
        """Return whether an earlier run has computed the frame that ends outside `frames`. Collective.

        After the last such frame, restore the world from the checkpoint.
        """
        if not self.waiting:
            return False
        for system in self._systems:
            system.forget()
        self.skipped += 1
        if self.skipped == self._origin.frame:
            self.go_on()
        return True

    def at_border(self, frame: int) -> None:
        """Between two frames, begin a checkpoint that is due, or look after the pending one. Collective."""
        with self._counted():
            if self.waiting:
                self.go_on()
            elif not self._writes:
                if self._saver.cuts_films(frame):  # where the whole run's films have a cut
                    secure_movies(self._engine)
            elif self._saver.due(frame):
                self._saver.begin(frame, lambda: self._manifest(frame))
            else:
                self._saver.look()

    @contextlib.contextmanager
    def _counted(self) -> Iterator[None]:
        """Count the block's time as work on checkpoints in the log."""
        self._engine.set_saving(True)
        try:
            yield
        finally:
            self._engine.set_saving(False)

    def save_now(self, frame: int) -> None:
        """Write a checkpoint of this frame, and wait until it is complete. Collective."""
        if self.waiting or not self._writes:
            return
        if frame > 0:
            with self._counted():
                self._saver.save(frame, lambda: self._manifest(frame))

    def go_on_with(self, comm: MPI.Intracomm, settings: RunSettings) -> None:
        """Continue with the surviving ranks in new roles, and give up the pending checkpoint.

        Raises ArgumentError if this rank has become the manager and another run has taken the directory.
        """
        self._settings = settings
        self._saver.go_on_with(comm, settings.roles)
        if self._saver.manages and self._origin.lock is None:
            self._origin.lock = taken_over(lambda: folder.Lock(self._origin.directory))

    def end(self) -> None:
        """Release the directory, and reset the state of the run that was continued."""
        continued.end()
        if self._origin.lock is not None:
            self._origin.lock.release()

    def _manifest(self, frame: int) -> Manifest:
        settings = self._settings
        assert settings.seed is not None
        manifest = Manifest(
            frame=frame,
            time_s=frame * settings.dt,
            seed=settings.seed,
            dt_s=settings.dt,
            substeps=settings.substeps,
            periodic=ends_of(settings.periodic),
            motes=motes_version(),
            script=self._script,
            systems=[system.name for system in self._systems],
            parts=[],
            world={},
            stepped_s=0 if self._saver.pace is None else self._saver.pace.total_s,
        )
        if not self._saver.manages:
            return manifest
        configured = {system.name: system.newborn.state() for system in self._systems}
        state = {"configured": configured, "balancer": self._balancer(), "steering": self._steering.state()}
        return manifest.with_script_state(state)

    def _balancer(self) -> tuple[str, Any] | None:
        """Return class name and attributes of a custom balancer; None if they cannot be saved."""
        balancer: Any = self._settings.balancer
        name = type(balancer).__qualname__
        if type(balancer).__module__.partition(".")[0] == __package__.partition(".")[0]:
            return None  # balancers of motes have no state
        try:
            data_of(vars(balancer))
            return name, vars(balancer)
        except TypeError as error:
            reason = f"{error}; {PICKLES} stores it as a pickle"
        if self._settings.checkpoint is not None and self._settings.checkpoint.pickles:
            try:
                return name, pickle.dumps(vars(balancer))
            except Exception as error:  # of any kind, from a user's class
                reason = f"it cannot be pickled: {error}"
        if name not in self._refused:
            self._refused.add(name)
            tell(f"motes: checkpoints do not contain the state of the balancer {name}: {reason}")
        return None

    def _known(self, name: str, known: Any) -> dict[str, Any]:
        """Return a balancer's saved attributes. Raises CheckpointError for a pickle if none is allowed."""
        assert self._settings.checkpoint is not None
        if isinstance(known, bytes):
            if not self._settings.checkpoint.pickles:
                raise CheckpointError(
                    f"{self._origin.place} holds the state of the balancer {name} as a pickle, which can run "
                    f"any code; if you trust its author, {PICKLES} reads it"
                )
            known = pickle.loads(known)
        if not isinstance(known, dict):
            raise CheckpointError(
                f"{self._origin.place} is damaged: the state of the balancer {name} is not a dict"
            )
        return known
