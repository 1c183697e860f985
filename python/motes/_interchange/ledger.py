"""The manager's record of an export: which parts are written, and so which frames are complete."""

from __future__ import annotations

import copy
import dataclasses
import json
import os
import time
from collections.abc import Iterable, Sequence

from .._shot.facts import Scene
from ..errors import MotesError
from .complete import amended, is_complete
from .formats import Place
from .manifest import UNKNOWN, Column, Manifest, Part, SystemColumns
from .origin import unlike_systems

__all__ = ["Ledger", "note_of"]


def note_of(written: Iterable[tuple[int, Part]]) -> bytes:
    """Serialize the parts that a rank has written, each with its frame, for the manager."""
    return json.dumps([[frame, *dataclasses.astuple(part)] for frame, part in written]).encode()


class Ledger:
    """Collects parts until frames are complete, in the order of the frames."""

    def __init__(self, place: Place, manifest: Manifest) -> None:
        """Start with the manifest of no frame, or of those that an earlier start has written."""
        self._place = place
        self._manifest = manifest
        self._announced: dict[int, dict[tuple[int, int | None], Part]] = {}
        self._next_show_s = 0.0

    @property
    def frames(self) -> int:
        """The number of frames that are complete."""
        return len(self._manifest.frames)

    def columns_of(self, system: int) -> dict[str, Column]:
        """Return the columns of a system by name, as written so far; empty if it has not been written."""
        systems = self._manifest.systems[system : system + 1]
        return {column.name: column for one in systems for column in one.columns}

    def check(self, systems: Sequence[SystemColumns]) -> None:
        """Raise MotesError if a system is not the one that an earlier start has written."""
        if unlike := unlike_systems(self._manifest.systems, list(systems)):
            raise MotesError(f"{self._place.path} cannot be continued: {unlike}")

    @property
    def last_scene(self) -> Scene | None:
        """The scene of the frame before."""
        return self._manifest.last_scene

    def announce(
        self,
        frame: int,
        time: float,
        systems: Sequence[SystemColumns],
        calculators: Sequence[int],
        scene: Scene | None = None,
    ) -> None:
        """Expect a frame's parts: one per system and calculator."""
        self._manifest.systems = [*systems, *self._manifest.systems[len(systems) :]]
        parts = tuple(
            Part(number, rank, self._place.file(system.stem, frame, rank), UNKNOWN, UNKNOWN)
            for number, system in enumerate(systems)
            for rank in calculators
        )
        self._manifest.announce(frame, time, parts, scene)
        self._announced[frame] = {}

    def hear(self, notes: Iterable[bytes]) -> None:
        """Record the parts in the notes of all ranks, and move frames that are complete to `frames`."""
        for note in notes:
            for frame, *fields in json.loads(note):
                part = Part(*fields)
                self._announced[frame][part.system, part.rank] = part
        waiting = self._manifest.announced
        while waiting and len(self._announced[waiting[0].frame]) == len(waiting[0].parts):
            whole = waiting.pop(0)
            announced = self._announced.pop(whole.frame)
            parts = tuple(announced[part.system, part.rank] for part in whole.parts)
            self._manifest.frames.append(dataclasses.replace(whole, parts=parts))

    def is_late(self) -> bool:
        """Return whether files of earlier frames lack columns that later ones hold."""
        return not is_complete(self._manifest)

    def amend(self, notes: Iterable[bytes]) -> None:
        """Publish the finished manifest, in which the parts in the notes of all ranks hold all columns."""
        parts = ((frame, Part(*fields)) for note in notes for frame, *fields in json.loads(note))
        self._manifest = amended(self._manifest, parts)
        self._place.publish(self._manifest)

    def snapshot(self, *, finished: bool = False) -> Manifest:
        """Copy the manifest for another thread."""
        copied = copy.copy(self._manifest)
        copied.systems = copy.deepcopy(copied.systems)
        copied.frames, copied.announced = list(copied.frames), list(copied.announced)
        copied.finished = finished
        return copied

    def publish(self, manifest: Manifest, *, seen: int) -> None:
        """Check that the files of frames from index `seen` on exist, then publish a snapshot to readers.

        Raises MotesError if this rank cannot see what another has written.
        """
        for frame in manifest.frames[seen:]:
            for part in frame.parts:
                path = self._place.folder / part.file
                try:
                    size = os.stat(path).st_size
                except FileNotFoundError:
                    size = None
                if size != part.bytes:
                    raise MotesError(
                        f"rank {part.rank} has written {part.file}, but {path} is not what it wrote: "
                        "all ranks must see the same directory"
                    )
        # What other programs read lists all frames, so it takes longer each time: an eighth of all at most.
        begin = time.monotonic()
        shows = manifest.finished or begin >= self._next_show_s
        self._place.publish(manifest, shows=shows)
        if shows:
            self._next_show_s = time.monotonic() + 7 * (time.monotonic() - begin)
