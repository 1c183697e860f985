"""Reads particles back from files, frame by frame, as `System.gather` returned them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._particles.foreign import NAMES, leave_out, renamed
from .._particles.particles import Particles
from .._values import arguments
from ..errors import ArgumentError, MotesError
from . import lammps
from .format import Format
from .formats import FORMATS, Place, place_of
from .manifest import NAME, UNKNOWN, Column, FrameParts, Manifest, Part, SystemColumns

__all__ = ["ParticleFiles", "facts_of", "filled", "manifest_of", "open_particles"]

ALLOWED = (
    "an export (a .usd or .pvd file, or a directory with manifest.json), a single .npz or .vtp file, "
    "or a text dump of LAMMPS"
)


def open_particles(path: str | os.PathLike[str], *, system: str | None = None) -> ParticleFiles:
    """Open particles that `Export` or `python -m motes pack` wrote, a single .npz or .vtp file, or a dump.

    `open_particles(path)[frame]` reads one frame as `Particles`, sorted by id and bit-identical to what
    `gather` returned. A single file may come from another program: its `P`, `v`, `Cd`, `Alpha`, `pscale` and
    `life` get our names. After a killed run, all frames up to the last complete one can be read. Needs no
    MPI; .usd needs the extra [usd].

    Text dumps of LAMMPS (`dump atom`, `dump custom`, also compressed, with any suffix) hold several steps:
    the numbers of their frames are the time steps. Scaled coordinates (xs) become lengths, in the dump's
    units; vx, fx, omegax and radius become velocity, force, omega and size; other columns keep their names.

    Args:
        path: of the export, or of the file.
        system: the system to read, if there are several.

    Returns:
        A mapping from frame number to particles; each frame is read on access.

    Raises:
        ArgumentError: if `path` is neither an export nor such a file, or has no such system.
        MotesError: if files are damaged or missing.
    """
    where = arguments.file_path("path", path)
    if system is not None and not isinstance(system, str):
        raise ArgumentError("system", system, "a system's name")
    if _alone(where) is not None and not where.is_dir():
        return _single(where, system)
    if where.is_file() and lammps.is_dump(where):
        return _dump(where, system)
    place = _place(where)
    return ParticleFiles(place.path, place.folder, Manifest.read(place.folder), _reader(place), system)


class ParticleFiles(Mapping[int, Particles]):
    """The frames of an export: a mapping from a frame's number to its particles, read on access.

    `files[96]` is frame 96, `files[-1]` the last one; `for frame, particles in files.items()` reads all in
    order. Frames keep their numbers in the run: with `every=4` they are 0, 4, 8, ...
    """

    def __init__(
        self,
        path: Path,
        folder: Path,
        manifest: Manifest,
        read: Callable[[Part, int, Sequence[str]], dict[str, NDArray[Any]]],
        system: str | None,
    ) -> None:
        """Call `open_particles` instead."""
        self.path = path
        self.folder = folder
        self._manifest = manifest
        self._read = read
        names = self.systems
        if system is not None and system not in names:
            raise ArgumentError("system", system, _one_of(names), known=names)
        self._system = names.index(system) if system is not None else 0 if len(names) == 1 else None
        self._frames = {
            frame.frame: frame
            for frame in manifest.frames
            if self._system is None or any(part.system == self._system for part in frame.parts)
        }

    @property
    def systems(self) -> tuple[str, ...]:
        """The names of all systems in the files."""
        return tuple(system.name for system in self._manifest.systems)

    @property
    def system(self) -> str | None:
        """The name of the system that is read; None if there are several and none was chosen."""
        return None if self._system is None else self.systems[self._system]

    @property
    def frames(self) -> tuple[int, ...]:
        """The numbers of the frames, ascending."""
        return tuple(self._frames)

    @property
    def times(self) -> tuple[float, ...]:
        """Seconds of the animation at the end of each frame."""
        return tuple(frame.time for frame in self._frames.values())

    @property
    def seed(self) -> int | None:
        """The seed of the run."""
        return self._manifest.seed

    @property
    def dt(self) -> float:
        """Seconds per frame of the run."""
        return self._manifest.dt

    @property
    def finished(self) -> bool:
        """Whether the run closed its export."""
        return self._manifest.finished

    def count(self, frame: int) -> int:
        """Return how many particles a frame has; reads at most their ids."""
        number = self._found(frame).frame
        return sum(
            len(self._read_part(part, number, ["id"])["id"]) if part.rows == UNKNOWN else part.rows
            for part in self._parts(frame)
        )

    def __getitem__(self, frame: int) -> Particles:
        """Read a frame; -1 is the last one. Raises KeyError for a frame that is not there."""
        parts = self._parts(frame)
        number = self._found(frame).frame
        columns = self._facts.columns
        names = ["id", *(column.name for column in self._facts.written(number))]
        read = [self._read_part(part, number, names) for part in parts]
        joined = {name: _joined([one[name] for one in read], _empty(name, columns)) for name in names}
        count = len(joined["id"])
        ordered = {
            column.name: joined[column.name] if column.name in joined else filled(column, count)
            for column in columns
        }
        return Particles({**ordered, "id": joined["id"]})

    def __contains__(self, frame: object) -> bool:
        """Whether there is a frame of this number."""
        return frame in self._frames

    __eq__ = object.__eq__  # Mapping's comparison would read all frames
    __hash__ = object.__hash__

    def __iter__(self) -> Iterator[int]:
        """Iterate over the numbers of the frames."""
        return iter(self._frames)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._frames)

    def __repr__(self) -> str:
        """Name the files, their systems and frames."""
        frames = f"frames {self.frames[0]}..{self.frames[-1]}" if self._frames else "no frame"
        named = ", ".join(map(repr, self.systems if self.system is None else (self.system,)))
        return f"<particles of {named} in {str(self.path)!r}, {frames} ({len(self)})>"

    @property
    def _facts(self) -> SystemColumns:
        """The system that is read; there must be one."""
        assert self._system is not None
        return self._manifest.systems[self._system]

    def _found(self, frame: int) -> FrameParts:
        number = arguments.integer("frame", frame, low=-(2**62))
        if number < 0 and -number <= len(self._frames):
            number = self.frames[number]
        if number not in self._frames:
            raise KeyError(f"no frame {frame}; there are {_ranges(self.frames)}")
        return self._frames[number]

    def _parts(self, frame: int) -> list[Part]:
        if self._system is None:
            hint = (
                f"as in open_particles({str(self.path)!r}, system={self.systems[0]!r})"
                if self.systems
                else ""
            )
            raise ArgumentError("system", None, _one_of(self.systems), hint=hint)
        return [part for part in self._found(frame).parts if part.system == self._system]

    def _read_part(self, part: Part, frame: int, names: Sequence[str]) -> dict[str, NDArray[Any]]:
        columns = self._read(part, frame, names)
        system = self._manifest.systems[part.system]
        widths = {"id": 1, **{column.name: column.width for column in system.columns}}
        rows = len(columns["id"]) if part.rows == UNKNOWN else part.rows
        for name in names:
            array = columns[name]
            shape = (rows,) if widths[name] == 1 else (rows, widths[name])
            kind = np.uint64 if name == "id" else np.float32
            if array.shape != shape or array.dtype != kind:
                actual = f"{array.dtype} {array.shape}, not {np.dtype(kind)} {shape}"
                raise MotesError(f"{part.file} of {self.path} is damaged: {name} is {actual}")
        return columns


def manifest_of(files: ParticleFiles) -> Manifest:
    """Return the files' manifest."""
    return files._manifest


def facts_of(files: ParticleFiles) -> SystemColumns:
    """Return the manifest's entry of the system that is read."""
    return files._facts


def _reader(place: Place) -> Callable[[Part, int, Sequence[str]], dict[str, NDArray[Any]]]:
    def read(part: Part, frame: int, names: Sequence[str]) -> dict[str, NDArray[Any]]:
        path = place.folder / part.file
        try:
            return place.format.read(path, names, frame=frame)
        except Exception as error:  # any: a damaged file can fail anywhere
            raise _unreadable(path, error) from error

    return read


def _place(path: Path) -> Place:
    if not path.exists():
        raise ArgumentError("path", str(path), ALLOWED, hint="it does not exist")
    if path.is_dir():
        place = _folder(path)
    else:
        place = place_of("path", path)
        if not place.format.index:
            raise ArgumentError("path", str(path), ALLOWED)
    if not (place.folder / NAME).is_file():
        raise ArgumentError("path", str(path), ALLOWED, hint=f"there is no {place.folder / NAME}")
    return place


def _folder(path: Path) -> Place:
    """Return the export in a folder: .npz files, or the parts of an index beside the folder."""
    for format in FORMATS.values():
        if format.index and path.name.endswith(f"{format.index}.parts"):
            return Place(path.with_name(path.name.removesuffix(".parts")), format)
    return Place(path, FORMATS["npz"])


def _alone(path: Path) -> Format | None:
    """Return the format of a file that can be opened without a manifest, by its suffix; else None."""
    format = FORMATS.get(path.suffix.lower()[1:])
    return format if format is not None and format.alone else None


def _single(path: Path, system: str | None) -> ParticleFiles:
    """Open one file as an export of one frame."""
    format = _alone(path)
    assert format is not None
    try:
        columns = format.read(path, None, frame=0)
    except FileNotFoundError:
        raise ArgumentError("path", str(path), ALLOWED, hint="it does not exist") from None
    except Exception as error:  # any: a damaged file can fail anywhere
        raise _unreadable(path, error) from error
    columns = _checked(path, columns)
    count = len(next(iter(columns.values())))
    columns = renamed(columns)
    ids = columns.pop("id", np.arange(count)).astype(np.uint64)
    with np.errstate(over="ignore"):  # values beyond float32 become infinite
        floats = {name: array.astype(np.float32, copy=False) for name, array in columns.items()}
    read_columns: dict[str, NDArray[Any]] = {"id": ids, **floats}
    widths = {name: array.shape[1] if array.ndim == 2 else 1 for name, array in columns.items()}
    known = [Column(name, width, (0.0,) * width, 0) for name, width in widths.items()]
    name = system or path.stem.partition(".")[0] or "particles"
    frame = FrameParts(0, 0.0, (Part(0, None, path.name, count, 0),))
    manifest = Manifest(
        path.suffix[1:], None, 1.0, 1, [SystemColumns(name, name, known)], [frame], finished=True
    )
    return ParticleFiles(path, path.parent, manifest, lambda *_: read_columns, name)


def _dump(path: Path, system: str | None) -> ParticleFiles:
    """Open a dump of LAMMPS."""
    try:
        dump = lammps.Dump(path)
        widths = dump.columns()
    except Exception as error:  # any: a damaged file can fail anywhere
        raise _unreadable(path, error) from error
    for text in sorted(dump.texts):
        leave_out(path, text, "texts", level=4)
    name = system or path.name.partition(".")[0] or "particles"
    steps = dump.steps
    known = [Column(column, width, (0.0,) * width, steps[0][0]) for column, width in widths.items()]
    frames = [
        FrameParts(number, time, (Part(0, None, path.name, count, 0),)) for number, time, count in steps
    ]
    kind = "lammpstrj"
    manifest = Manifest(
        kind, None, 1.0, 1, [SystemColumns(name, name, known)], frames, finished=dump.finished
    )

    def read(part: Part, frame: int, names: Sequence[str]) -> dict[str, NDArray[Any]]:
        try:
            columns = dump.read(frame)
        except Exception as error:  # any: a damaged file can fail anywhere
            raise _unreadable(path, error) from error
        empty = {one.name: filled(one, part.rows) for one in known if one.name not in columns}
        return {**columns, **empty}

    return ParticleFiles(path, path.parent, manifest, read, name)


def _checked(path: Path, given: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return a file's columns without those that particles cannot have, of which it warns.

    Raises MotesError if the position or the ids are among these, or if the columns have no common length.
    """
    columns = {}
    for name, array in given.items():
        if not isinstance(array, np.ndarray):  # NumPy returns bytes for an entry that is not .npy
            raise MotesError(f"{path} cannot be read: {name!r} is not an array")
        if array.ndim in (1, 2) and array.shape[1:] in ((), (3,), (4,)) and array.dtype.kind in "fiu":
            columns[name] = array
            continue
        actual = f"{array.dtype} {array.shape}"
        if NAMES.get(name, name) in ("position", "id"):
            raise MotesError(
                f"{path} cannot be read: {name!r} is {actual}; columns are numbers, (n,), (n, 3) or (n, 4)"
            )
        leave_out(path, name, f"values {actual}")
    lengths = {len(array) for array in columns.values()}
    if len(lengths) != 1:
        raise MotesError(
            f"{path} cannot be read: its columns have {sorted(lengths) or 'no'} rows, not equally many"
        )
    ids = columns.get("id", np.empty(0, np.uint64))
    if ids.ndim != 1 or ids.dtype.kind not in "iu" or (ids < 0).any():
        raise MotesError(
            f"{path} cannot be read: 'id' is {ids.dtype} {ids.shape}; ids are whole numbers >= 0, (n,)"
        )
    return columns


def _unreadable(path: Path, error: Exception) -> MotesError:
    return (
        error
        if isinstance(error, MotesError)
        else MotesError(f"{path} cannot be read: {error or type(error).__name__}")
    )


def _joined(arrays: list[NDArray[Any]], empty: NDArray[Any]) -> NDArray[Any]:
    if not arrays:
        return empty
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


def _empty(name: str, columns: Sequence[Column]) -> NDArray[Any]:
    if name == "id":
        return np.empty(0, np.uint64)
    width = next((column.width for column in columns if column.name == name), 1)
    return np.empty((0, width) if width > 1 else 0, np.float32)


def filled(column: Column, count: int) -> NDArray[Any]:
    """Return a column that the files omit: the initial value for each particle."""
    row = np.array(column.initial, np.float32)
    return np.tile(row, (count, 1)) if column.width > 1 else np.full(count, row[0])


def _one_of(names: Sequence[str]) -> str:
    return "one of " + ", ".join(map(repr, names)) if names else "None: there is no system"


def _ranges(frames: Sequence[int]) -> str:
    if len(frames) <= 8:
        return ", ".join(map(str, frames)) or "none"
    return f"{', '.join(map(str, frames[:3]))}, ..., {frames[-1]}"
