"""The manifest of an export: which frames are whole, and which files hold them.

The manager replaces it, whole, in each frame that is written. It names the frames that are complete on all
ranks, and announces those that are being written: their files appear when they are whole. So it tells what
can be read, whenever and however the run ended.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from .._io import files
from ..errors import MotesError

__all__ = [
    *("FORMAT", "NAME", "UNKNOWN", "VERSION", "Column", "FrameParts", "Manifest", "Part"),
    *("SystemColumns", "stems"),
]

FORMAT = "motes particles"
VERSION = 1
NAME = "manifest.json"
UNKNOWN = -1
"""Rows or bytes of a file of which the manifest knows only the name."""


@dataclass
class Column:
    """An attribute of a system."""

    name: str
    width: int
    """Numbers per particle, 1 or 3."""
    initial: tuple[float, ...]
    """What every particle has in frames whose files do not hold it."""
    since: int | None = None
    """The first frame whose files hold it; None: none does."""

    def written(self, frame: int) -> bool:
        """Whether the files of this frame hold it."""
        return self.since is not None and frame >= self.since


@dataclass
class SystemColumns:
    """A system, and the columns of its particles, all but the ids, which every file holds."""

    name: str
    stem: str
    """How the names of its files begin."""
    columns: list[Column]

    def written(self, frame: int) -> list[Column]:
        """List the columns that files of this frame hold."""
        return [column for column in self.columns if column.written(frame)]


@dataclass(frozen=True)
class Part:
    """A file: the particles of one system on one rank in one frame."""

    system: int
    """Its place among the manifest's systems."""
    rank: int | None
    """None: all ranks' particles, joined."""
    file: str
    rows: int
    bytes: int


@dataclass(frozen=True)
class FrameParts:
    """A frame that is whole."""

    frame: int
    time: float
    parts: tuple[Part, ...]

    @cached_property
    def text(self) -> str:
        """As JSON, made once: the manifest is written again with each frame."""
        parts = [[part.system, part.rank, part.file, part.rows, part.bytes] for part in self.parts]
        return json.dumps({"frame": self.frame, "time": self.time, "parts": parts})


@dataclass
class Manifest:
    """What an export holds."""

    kind: str
    """The name of a format: "npz", "vtp", "usdc"."""
    seed: int | None
    dt: float
    every: int
    systems: list[SystemColumns] = field(default_factory=list)
    frames: list[FrameParts] = field(default_factory=list)
    announced: list[FrameParts] = field(default_factory=list)
    """Frames that were being written, in order."""
    finished: bool = False

    def write(self, folder: Path) -> None:
        """Replace the folder's manifest."""
        systems = [
            {
                "name": system.name,
                "stem": system.stem,
                "columns": [
                    {**vars(column), "initial": list(map(_as_json, column.initial))}
                    for column in system.columns
                ],
            }
            for system in self.systems
        ]
        head = {
            "format": FORMAT,
            "version": VERSION,
            "kind": self.kind,
            "seed": self.seed,
            "dt": self.dt,
            "every": self.every,
            "finished": self.finished,
            "part": ["system", "rank", "file", "rows", "bytes"],
            "systems": systems,
        }
        lines = "".join(f"{json.dumps(name)}: {json.dumps(value)},\n" for name, value in head.items())
        for name, frames in (("frames", self.frames), ("announced", self.announced)):
            listed = ",\n".join(frame.text for frame in frames)
            lines += f'"{name}": [\n{listed}\n]' + (",\n" if name == "frames" else "\n")
        text = f"{{\n{lines}}}\n"
        files.write_whole(folder / NAME, text.encode())

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read a folder's manifest. Raises MotesError if it is damaged or of a later version."""
        path = folder / NAME
        try:
            said = json.loads(path.read_bytes())
        except (OSError, ValueError, RecursionError, MemoryError) as error:
            raise MotesError(f"{path} cannot be read: {error or type(error).__name__}") from error
        if not isinstance(said, dict) or said.get("format") != FORMAT:
            raise MotesError(f"{path} is no manifest of particles")
        if said.get("version") != VERSION:
            raise MotesError(f"{path} is of version {said.get('version')}; this motes reads {VERSION}")
        try:
            manifest = cls._of(said)
            manifest._take_whole(folder)
            return manifest
        except Exception as error:  # any: it may hold anything
            raise MotesError(f"{path} is damaged: {error!r}") from error

    @classmethod
    def _of(cls, said: Mapping[str, Any]) -> Self:
        systems = [
            SystemColumns(
                str(one["name"]), _stem(one["stem"]), [_column(column) for column in one["columns"]]
            )
            for one in said["systems"]
        ]
        frames, announced = ([_frame(one) for one in said[name]] for name in ("frames", "announced"))
        for frame in (*frames, *announced):
            for part in frame.parts:
                if not 0 <= part.system < len(systems):
                    raise ValueError(f"system {part.system} of {len(systems)}")
        seed = None if said["seed"] is None else int(said["seed"])
        numbers = float(said["dt"]), int(said["every"])
        return cls(str(said["kind"]), seed, *numbers, systems, frames, announced, bool(said["finished"]))

    def _take_whole(self, folder: Path) -> None:
        """Count as whole what was announced and is all there; files have their names only when whole."""
        while self.announced and all((folder / part.file).is_file() for part in self.announced[0].parts):
            self.frames.append(self.announced.pop(0))


def stems(names: Iterable[str]) -> list[str]:
    """Return for each system how the names of its files begin: no two alike, usable as names everywhere."""
    made: list[str] = []
    for name in names:
        stem = re.sub(r"[^A-Za-z0-9_]", "_", name)[:60]
        if not re.match(r"[A-Za-z]", stem):
            stem = f"system_{stem}"
        taken = {other.lower() for other in made}  # some file systems do not tell case
        number = 1
        unique = stem
        while unique.lower() in taken:
            number += 1
            unique = f"{stem}_{number}"
        made.append(unique)
    return made


def _as_json(value: float) -> float | str:
    return value if math.isfinite(value) else repr(value)


def _stem(said: Any) -> str:
    """Return how names of files begin, if these are in the folder: `pack` writes some that begin so."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", said):
        raise ValueError(f"stem {said!r}")
    return str(said)


def _column(said: Mapping[str, Any]) -> Column:
    since = None if said["since"] is None else int(said["since"])
    column = Column(str(said["name"]), int(said["width"]), tuple(map(float, said["initial"])), since)
    if column.width not in (1, 3, 4) or len(column.initial) != column.width:
        raise ValueError(f"column {column.name!r} is {column.width} wide")
    return column


def _frame(said: Mapping[str, Any]) -> FrameParts:
    return FrameParts(int(said["frame"]), float(said["time"]), tuple(_part(part) for part in said["parts"]))


def _part(said: Sequence[Any]) -> Part:
    system, rank, file, rows, size = said
    if not isinstance(file, str) or Path(file).name != file:
        raise ValueError(f"file {file!r}")
    return Part(int(system), None if rank is None else int(rank), file, int(rows), int(size))
