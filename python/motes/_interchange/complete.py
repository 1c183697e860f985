"""Completes an export: columns that started late also go into the files of earlier frames.

While a run goes on, nobody knows which columns it will use. In the files of earlier frames `open_particles`
fills in the initial value; other programs would show zeros, or no column.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable

from .formats import Place
from .manifest import FrameParts, Manifest, Part, SystemColumns
from .reading import filled

__all__ = ["amended", "complete", "completed", "is_complete"]


def is_complete(manifest: Manifest) -> bool:
    """Return whether the files of each frame hold all columns that any file holds."""
    return not any(_incomplete(manifest))


def completed(system: SystemColumns, first: int) -> SystemColumns:
    """Return the system's columns as they are once all files from frame `first` on hold them."""
    columns = [
        dataclasses.replace(column, since=None if column.since is None else first)
        for column in system.columns
    ]
    return dataclasses.replace(system, columns=columns)


def complete(
    place: Place, manifest: Manifest, share: int, shares: int, stopped: Callable[[], bool]
) -> list[tuple[int, Part]]:
    """Write one of several equal shares of the incomplete files again, with all columns.

    Returns these parts, each with its frame. Each file is replaced whole. Ends early if `stopped` returns
    True.
    """
    written = []
    for frame, part in list(_incomplete(manifest))[share::shares]:
        if stopped():
            break
        system = manifest.systems[part.system]
        names = ["id", *(column.name for column in system.written(frame.frame))]
        path = place.folder / part.file
        stored = place.format.read(path, names, frame=frame.frame)
        rows = len(stored["id"])
        columns = {c.name: stored[c.name] if c.name in stored else filled(c, rows) for c in system.used}
        columns["id"] = stored["id"]
        kept = place.format.drawn
        drawn = kept(path, frame.frame) if system.drawn and kept is not None else None
        size = place.write_part(part.file, columns, frame=frame.frame, time=frame.time, drawn=drawn)
        written.append((frame.frame, dataclasses.replace(part, rows=rows, bytes=size)))
    return written


def amended(manifest: Manifest, parts: Iterable[tuple[int, Part]]) -> Manifest:
    """Return the finished manifest of an export of which these parts have been completed.

    If some are missing, as those of a rank that was lost meanwhile, columns start where they did.
    """
    new = {(frame, part.file): part for frame, part in parts}
    whole = all((frame.frame, part.file) in new for frame, part in _incomplete(manifest))
    frames = [
        dataclasses.replace(one, parts=tuple(new.get((one.frame, part.file), part) for part in one.parts))
        for one in manifest.frames
    ]
    first = frames[0].frame
    systems = [completed(system, first) if whole else system for system in manifest.systems]
    return dataclasses.replace(manifest, systems=systems, frames=frames, finished=True)


def _incomplete(manifest: Manifest) -> Iterable[tuple[FrameParts, Part]]:
    for frame in manifest.frames:
        for part in frame.parts:
            system = manifest.systems[part.system]
            if system.written(frame.frame) != system.used:
                yield frame, part
