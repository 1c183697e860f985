"""Export: writes the particles of frames to files, in background threads while the run continues."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._io.output import tell
from .._run.busy import Busy
from .._run.excerpt import Excerpt
from .._shot.drawn import Drawing, eye_of, needed
from .._shot.facts import Scene
from .._shot.shot import Shot
from .._system.session import OpenFiles
from .._system.system_state import SystemState
from .._values import arguments, environment
from .._world.world import World, session_of
from ..errors import ArgumentError, MotesError, Stopped
from .claim import Claim, check_free
from .complete import complete
from .formats import place_of
from .ledger import Ledger, note_of
from .manifest import Column, Manifest, Part, SystemColumns, stems
from .origin import origin_of
from .writer import FrameJob, Writer

__all__ = ["Export"]

_LOOK_S = 0.1
_ALWAYS = ("position", "velocity")


class Export:
    """Particles of a run as files: .usd (Blender, Houdini), .pvd (ParaView) or a directory of .npz (NumPy).

    Construct it on every rank. Each calculator writes its own particles in a background thread; `write`
    copies them and returns. The manager lists the complete frames in `manifest.json`, which it replaces
    atomically: `open_particles` reads these frames, even if the run was killed. The files of `snow.usd` and
    `snow.pvd` are in the directories `snow.usd.parts` and `snow.pvd.parts`.

    A later start of the same script continues the export: it keeps the frames before its first one, which
    follows the checkpoint, if any, and writes later ones again. An export that another script, other
    arguments or another seed have made is replaced only with `motes run --fresh` (MOTES_FRESH=1).
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        every: int = 1,
        attributes: Sequence[str] | None = None,
        scene: bool = False,
    ) -> None:
        """Name the files.

        Args:
            path: a name ending in .usd (extra [usd]) or .pvd, or a directory for .npz files.
            every: write only the frames whose number is a multiple of this.
            attributes: names of attributes to write beside position and id, in systems that have them; None:
                velocity, the user's attributes, and any attribute in which a particle has ever had a value
                other than the initial one. `close` adds late ones to the files of earlier frames.
            scene: also write what the world's renderer shows: camera, lights, sky and solids; particles
                become what their sprites are: points, instances of meshes and cards, or curves. Only for
                .usd.

        Raises:
            ArgumentError: if the path holds anything but an earlier export, or for `scene` with another
                format.
            MissingExtraError: if the format needs a package that is not installed.
        """
        self.path: Path = arguments.file_path("path", path)
        self._excerpt = Excerpt.current()
        if self._excerpt is not None:
            self.path = self._excerpt.beside(self.path)
        self.every = arguments.integer("every", every, low=1)
        self.attributes = _names(attributes)
        self._place = place_of("path", self.path)
        if arguments.flag("scene", scene) and self._place.format.drawn is None:
            raise ArgumentError("scene", scene, "left out for all paths but those ending in .usd")
        self._shot = Shot() if scene else None
        self._place.format.require()
        check_free("path", self._place)
        self.frames = 0
        """Frames written so far, those of an earlier start of the script included."""
        self._world: World | None = None
        self._writer = Writer(self._place)
        self._systems: list[SystemColumns] = []
        self._last = -1
        self._ledger: Ledger | None = None  # on the manager
        self._claim: Claim | None = None  # on the manager
        self._seen = 0  # frames that were published
        self._files: OpenFiles | None = None  # this export's entry in the world's session
        self._closed = False

    def write(self, world: World) -> None:
        """Write the particles of all systems, as `System.gather` would return them now. Collective.

        After `render()` or `step()` this writes the frame that has just ended; in the middle of a frame, the
        particles after the actions recorded so far, which does not change any result. Waits while two frames
        are still being written. Does nothing for a frame of the earlier run that this one continues.

        Args:
            world: the world whose particles are written.

        Raises:
            ArgumentError: by the first call on the manager, if the path holds an export of another script,
                other arguments or another seed; nothing has changed then. Other ranks raise RankError. On all
                ranks, with `scene`, if the world has no renderer.
            MotesError: before the first frame, if the frame was written before, or if an earlier write
                failed, as on a full disk; after the last `write`, `close` raises it.
        """
        frame = self._frame_of(world)
        if environment.read("MOTES_REHEARSAL"):
            return
        if frame % self.every or frame < session_of(world).settings.continued_from:
            return
        if self._excerpt is not None and (self._excerpt.still is not None or frame not in self._excerpt):
            return
        if frame <= self._last:
            raise MotesError(f"{self.path} already has frame {frame}: a frame is written only once")
        self._check_attributes(world)
        if self._shot is not None and world.renderer is None:
            raise ArgumentError("scene", True, "written of a world with a renderer: World(renderer=...)")
        self._wait(self._writer.has_room, f"writing particles to {self.path.name}")
        session = session_of(world)
        engine = session.begin("write()", reads=True)
        try:
            what = f"{self.path}, every={self.every}, attributes={self.attributes}"
            what += ", scene=True" * (self._shot is not None)
            totals, notes = engine.prepare_write(what, True, lambda: self._prepare(world, engine))
            self._settle(world, frame, totals, engine)
            if self._world is None:
                self.frames = totals.pop()
            self._put(world, engine, frame, notes)
        except BaseException as error:
            # Other errors refuse the call, which may be repeated.
            if engine.gave_up or not isinstance(error, Exception):
                self._abandon()
            raise
        finally:
            session.end_conversation(engine)
        if self._world is None:
            self._world = world
            self._files = OpenFiles(self, self.close, self._abandon, self._secure)
            session.files.append(self._files)
        self._last = frame
        self.frames += 1

    def close(self) -> None:
        """Finish the files. Collective if anything was written; the end of the world calls it, too.

        Waits until all ranks have written their files, adds the columns that started late to the files of
        earlier frames, and completes the manifest. Calling it again does nothing.
        """
        if self._closed:
            return
        world = self._world
        session = None if world is None else session_of(world)
        if world is None or session is None or session.ended:  # by an exception: the complete frames remain
            self._abandon()
            return
        try:
            self._wait(self._writer.is_idle, f"closing {self.path.name}")
            engine = session.begin(f"closing {self.path.name}")
            try:
                _, notes = engine.prepare_write(f"{self.path} ends", False, lambda: ([], self._report()))
                (late,), _ = engine.prepare_write(f"{self.path} is whole", False, lambda: self._finish(notes))
                if late:
                    parts = self._complete(world)
                    _, amended = engine.prepare_write(
                        f"{self.path} has all columns", False, lambda: ([], self._report(parts))
                    )
                    engine.prepare_write(f"{self.path} is complete", False, lambda: self._amend(amended))
            finally:
                session.end_conversation(engine)
        finally:
            self._abandon()

    def __enter__(self) -> Self:
        """Return the export itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the export. If the block failed, keep the frames that are complete."""
        # In a forked process the files belong to its parent.
        if self._world is not None and session_of(self._world).usage.inherited:
            return
        if kind is None or issubclass(kind, Stopped):
            self.close()
        else:
            self._abandon()

    def __repr__(self) -> str:
        """Name the files and what is in them."""
        return f"<Export {str(self.path)!r}, {self.frames} frames>"

    # --- before anything is written

    def _frame_of(self, world: World) -> int:
        """Return the number of the frame to write; raise if there is none."""
        if self._closed:
            raise MotesError(f"the export {self.path} is closed")
        if not isinstance(world, World):
            raise ArgumentError("world", world, "a motes.World")
        if self._world is not None and world is not self._world:
            raise ArgumentError("world", world, "the world of the earlier frames: an export has one world")
        session = session_of(world)
        session.engine_for("write()")
        recorded = any(system.entries for system in session.systems)
        if world.frame == 0 and not recorded:
            raise MotesError("write() before the first frame: write after world.render() or world.step()")
        return world.frame if recorded else world.frame - 1

    def _check_attributes(self, world: World) -> None:
        known = list(
            dict.fromkeys(
                ["id", *(name for system in session_of(world).systems for name in system.attributes)]
            )
        )
        for name in self.attributes or ():
            if name not in known:
                allowed = "attributes that a system has: " + ", ".join(known)
                raise ArgumentError("attributes", name, allowed, known=known)

    def _wait(self, ready: Callable[[float], bool], what: str) -> None:
        if ready(0):
            return
        with Busy(what) as busy:
            while not ready(_LOOK_S):
                busy.look()

    # --- what ranks tell each other

    def _prepare(self, world: World, engine: _core.Engine) -> tuple[list[int], bytes]:
        """Return which attributes are in use and how many frames there are, and a note of this rank's parts.

        The manager first claims the export's place, and then knows what an earlier start has written.
        """
        note = self._report()
        systems = session_of(world).systems
        used = [[0] * len(system.attributes) for system in systems]
        if self.attributes is None and "calculator" in world.role:
            used = [list(map(int, engine.used_attributes(system.index))) for system in systems]
        if "manager" in world.role:
            ledger = self._ledger or self._begin(world, engine)
            ledger.check(self._described(systems, engine))
            for system, counts in zip(systems, used, strict=True):
                written = ledger.columns_of(system.index)
                for i, name in enumerate(system.attributes):
                    counts[i] += name in written and written[name].since is not None
        frames = self._ledger.frames if self._ledger is not None else 0
        return [*(one for counts in used for one in counts), frames], note

    def _begin(self, world: World, engine: _core.Engine) -> Ledger:
        """Claim the export's place, on the manager, and note what an earlier start has written."""
        settings = session_of(world).settings
        systems = self._described(session_of(world).systems, engine)
        manifest = Manifest(
            self._place.format.kind,
            settings.seed,
            settings.dt,
            self.every,
            systems,
            origin=origin_of(settings, scene=self._shot is not None),
        )
        self._claim = Claim.make("path", self._place, manifest, first=settings.continued_from)
        if again := self._claim.replaced:
            some = f"frame {again[0]} is" if len(again) == 1 else f"frames {again[0]} to {again[-1]} are"
            tell(f"motes: {self.path}: {some} written again, in place of an earlier start's")
        self._ledger = Ledger(self._place, manifest)
        self._seen = self._ledger.frames
        return self._ledger

    def _report(self, completed: Sequence[tuple[int, Part]] = ()) -> bytes:
        try:
            return note_of([*self._writer.take(), *completed])
        except MotesError:
            raise
        except Exception as error:
            raise MotesError(f"particles could not be written to {self.path}: {error}") from error

    def _settle(self, world: World, frame: int, totals: list[int], engine: _core.Engine) -> None:
        """Decide which columns are written from this frame on; the same on all ranks."""
        systems = session_of(world).systems
        builtin = {name for name, _ in _core.builtin_attributes()}
        for i, described in enumerate(self._described(systems, engine)):
            if i == len(self._systems):
                written = {} if self._ledger is None else self._ledger.columns_of(i)
                for column in described.columns:
                    column.since = written[column.name].since if column.name in written else None
                self._systems.append(described)
            users = [totals.pop(0) for _ in systems[i].attributes]
            for column, count in zip(self._systems[i].columns, self._chosen(systems[i], users), strict=True):
                wanted = count or self.attributes is not None or column.name in _ALWAYS
                if column.since is None and (wanted or column.name not in builtin):
                    column.since = frame

    def _described(self, systems: Sequence[SystemState], engine: _core.Engine) -> list[SystemColumns]:
        """Describe systems for the manifest, with columns that no file holds yet."""
        stem = stems(system.name for system in systems)
        return [
            SystemColumns(system.name, stem[i], self._columns(system, engine), self._shot is not None)
            for i, system in enumerate(systems)
        ]

    def _columns(self, system: SystemState, engine: _core.Engine) -> list[Column]:
        initial = engine.initial_values(system.index)
        return [
            Column(name, width, tuple(initial[i][:width]))
            for i, (name, (_, width)) in enumerate(system.attributes.items())
            if self._takes(name)
        ]

    def _chosen(self, system: SystemState, counts: list[int]) -> list[int]:
        return [count for name, count in zip(system.attributes, counts, strict=True) if self._takes(name)]

    def _takes(self, name: str) -> bool:
        return self.attributes is None or name == "position" or name in self.attributes

    def _put(self, world: World, engine: _core.Engine, frame: int, notes: list[bytes]) -> None:
        """Hand the particles, and the frames complete by now, to the writer, which also keeps errors."""
        time = (frame + 1) * world.dt
        try:
            if self._ledger is not None:
                scene = self._scene(world, frame, self._ledger)
                self._ledger.announce(frame, time, self._systems, world.calculators, scene)
                self._ledger.hear(notes)
                self._publish_soon(self._ledger)
            if "calculator" in world.role:
                copies: list[tuple[int, str, Mapping[str, NDArray[Any]], Drawing | None]] = []
                for i, facts in enumerate(self._systems):
                    system, names = session_of(world).systems[i], [one.name for one in facts.written(frame)]
                    columns = _copied(system, engine, [*names, "id"])
                    copies.append(
                        (i, facts.stem, columns, self._drawing(world, engine, system, frame, columns))
                    )
                self._writer.put(FrameJob(frame, time, world.rank, copies))
        except Exception as error:  # such as too little memory: other ranks have continued
            self._writer.fail(error)

    def _scene(self, world: World, frame: int, ledger: Ledger) -> Scene | None:
        """Return what the picture of a frame shows besides particles, on the manager."""
        if self._shot is None or world.renderer is None:
            return None
        sprites = [system.sprite for system in session_of(world).systems]
        return self._shot.take(world.renderer, frame * world.dt, sprites, ledger.last_scene)

    def _drawing(
        self,
        world: World,
        engine: _core.Engine,
        system: SystemState,
        frame: int,
        written: Mapping[str, NDArray[Any]],
    ) -> Drawing | None:
        """Return how the particles of a system are drawn, with the columns that this needs besides others."""
        if self._shot is None or world.renderer is None:
            return None
        initial = dict(zip(system.attributes, engine.initial_values(system.index), strict=True))
        used = dict(zip(system.attributes, engine.used_attributes(system.index), strict=True))
        more = [name for name in needed(system.sprite) if name not in written and used.get(name)]
        known = {name: tuple(initial[name][:width]) for name, (_, width) in system.attributes.items()}
        eye = eye_of(world.renderer, frame * world.dt)
        place = (world.seed or 0, system.index, frame, world.dt)
        return Drawing(system.sprite, eye, known, _copied(system, engine, more), *place)

    def _publish_soon(self, ledger: Ledger) -> None:
        manifest = ledger.snapshot()

        def publish() -> None:
            if self._shot is not None:
                self._shot.write(self._place.folder)
            ledger.publish(manifest, seen=self._seen)
            self._seen = len(manifest.frames)

        self._place.format.begin()
        self._writer.publish(publish)

    def _finish(self, notes: list[bytes]) -> tuple[list[int], bytes]:
        """Complete the manifest, on the manager; return whether earlier files lack columns of later ones."""
        if self._ledger is None:
            return [0], b""
        try:
            self._ledger.hear(notes)
            late = self._ledger.is_late()
            self._ledger.publish(self._ledger.snapshot(finished=not late), seen=self._seen)
        except OSError as error:
            raise MotesError(f"particles could not be written to {self.path}: {error}") from error
        return [int(late)], b""

    def _complete(self, world: World) -> list[tuple[int, Part]]:
        """Add late columns to this rank's share of earlier files; the writer keeps errors for `_report`."""
        parts: list[tuple[int, Part]] = []
        place, share, shares = self._place, world.rank, world.size
        place.format.begin()  # a rank that is no calculator has written nothing yet
        self._writer.publish(
            lambda: parts.extend(
                complete(place, Manifest.read(place.folder), share, shares, lambda: self._closed)
            )
        )
        self._wait(self._writer.is_idle, f"completing the columns of {self.path.name}")
        return parts

    def _amend(self, notes: list[bytes]) -> tuple[list[int], bytes]:
        """Publish the manifest of the files that now hold all columns, on the manager."""
        if self._ledger is not None:
            try:
                self._ledger.amend(notes)
            except OSError as error:
                raise MotesError(f"particles could not be written to {self.path}: {error}") from error
        return [], b""

    def _secure(self) -> None:
        """Wait until this rank has written everything so far: a checkpoint follows, which counts on it."""
        self._wait(self._writer.is_idle, f"writing particles to {self.path.name}")
        self._writer.check()

    def _abandon(self) -> None:
        self._closed = True
        self._writer.end()
        if self._claim is not None:
            self._claim.release()
        if self._world is not None and self._files in session_of(self._world).files:
            session_of(self._world).files.remove(self._files)
        self._world = None


def _names(attributes: Any) -> tuple[str, ...] | None:
    if attributes is None:
        return None
    allowed = "None or a list of attributes' names"
    if isinstance(attributes, (str, bytes)):
        raise ArgumentError("attributes", attributes, allowed)
    names = arguments.listed("attributes", attributes, allowed)
    for name in names:
        if not isinstance(name, str):
            raise ArgumentError("attributes", attributes, allowed)
    return tuple(dict.fromkeys(names))


def _copied(system: SystemState, engine: _core.Engine, names: Sequence[str]) -> dict[str, NDArray[Any]]:
    """Copy columns of this rank's particles; "id", if it is among the names, is the last one."""
    indices = {name: i for i, name in enumerate(system.attributes)}
    arrays = engine.copy_columns(system.index, [indices[name] for name in names if name != "id"])
    return dict(zip(names, map(np.asarray, arrays), strict=False))
