"""Joins the files that all ranks wrote of an export into one per frame and system, sorted by id."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from .._io import files
from .._values import arguments
from ..errors import ArgumentError, MotesError
from . import npz
from .claim import Claim
from .complete import completed
from .formats import place_of
from .manifest import FrameParts, Manifest, Part, SystemColumns
from .origin import PACKED
from .reading import ParticleFiles, facts_of, manifest_of, open_particles

__all__ = ["pack"]


def pack(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    system: str | None = None,
    frame: int | None = None,
) -> dict[str, Any]:
    """Join an export's files into one per frame and system; return counts of frames, files and particles.

    Particles are sorted by id. `output` is a path as `Export` takes it, of any format, or an .npz file for
    one frame of one system. `system` and `frame` select what is written. The same particles make the same
    files for any number of ranks.
    """
    given = open_particles(source, system=system)
    names = given.systems if system is None else (system,)
    opened = [open_particles(source, system=name) for name in names]
    target = arguments.file_path("output", output)
    wanted = list(given.frames) if frame is None else [_checked(given, frame)]
    if target.suffix.lower() == ".npz":
        return _one_file(target, opened, wanted)
    return _export(given, opened, target, wanted)


def _checked(given: ParticleFiles, frame: int) -> int:
    number = arguments.integer("frame", frame, low=-(2**62))
    number = given.frames[number] if number < 0 and -number <= len(given) else number
    if number not in given.frames:
        raise ArgumentError("frame", frame, f"one of the {len(given)} frames of {given.path}")
    return number


def _one_file(target: Path, opened: list[ParticleFiles], frames: list[int]) -> dict[str, Any]:
    if len(opened) != 1:
        named = ", ".join(repr(files.system) for files in opened)
        raise ArgumentError("system", None, f"one of {named}, for a single .npz file")
    if len(frames) != 1:
        raise ArgumentError("frame", None, f"one of {len(frames)} frames, for a single .npz file")
    written = [column.name for column in facts_of(opened[0]).used]
    particles = opened[0][frames[0]]
    with files.whole_path(target) as draft:
        npz.write(draft, particles.columns(*written, "id"), frame=frames[0], time=0)
    return {"frames": 1, "files": 1, "particles": len(particles)}


def _export(
    given: ParticleFiles, opened: list[ParticleFiles], target: Path, frames: list[int]
) -> dict[str, Any]:
    place = place_of("output", target)
    place.format.require()
    if place.folder.resolve() == given.folder.resolve():
        raise ArgumentError("output", str(target), "a place other than the export being read")
    facts = manifest_of(given)
    manifest = Manifest(place.format.kind, facts.seed, facts.dt, facts.every, origin=PACKED)
    claim = Claim.make("output", place, manifest)
    try:
        first = min(frames, default=0)
        manifest.systems = [completed(facts_of(files), first) for files in opened]
        systems: list[SystemColumns] = manifest.systems
        count = 0
        for frame in frames:
            parts = []
            for number, source in enumerate(opened):
                if frame not in source.frames:
                    continue
                particles = source[frame]
                columns = particles.columns(*(column.name for column in systems[number].used), "id")
                file = place.file(systems[number].stem, frame, None)
                time = dict(zip(source.frames, source.times, strict=True))[frame]
                size = place.write_part(file, columns, frame=frame, time=time)
                parts.append(Part(number, None, file, len(particles), size))
                count += len(particles)
            manifest.frames.append(
                FrameParts(frame, dict(zip(given.frames, given.times, strict=True))[frame], tuple(parts))
            )
        manifest.finished = facts.finished
        place.publish(manifest)
    except (OSError, ValueError) as error:
        raise MotesError(f"particles could not be written to {target}: {error}") from error
    finally:
        claim.release()
    parts_written = sum(len(frame.parts) for frame in manifest.frames)
    return {"frames": len(manifest.frames), "files": parts_written, "particles": count}
