"""The manifest of an export: which frames are complete, and which files hold them.

The manager replaces it atomically with each frame that is written. It lists the frames that are complete on
all ranks, and announces those being written, whose files appear only when complete. So it always tells what
can be read, even after the run was killed.
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
from .._shot.facts import Scene, changes, files_of, with_changes
from ..errors import MotesError

__all__ = [
    *("FORMAT", "NAME", "UNKNOWN", "VERSION", "Column", "FrameParts", "Manifest", "Part"),
    *("SystemColumns", "stems"),
]

FORMAT = "motes particles"
VERSION = 1
NAME = "manifest.json"
UNKNOWN = -1
"""Rows or bytes of an announced file, of which only the name is known."""


@dataclass
class Column:
    """An attribute of a system."""

    name: str
    width: int
    """Numbers per particle, 1, 3 or 4."""
    initial: tuple[float, ...]
    """The value of every particle in frames whose files omit the column."""
    since: int | None = None
    """The first frame whose files hold the column; None: no file does."""

    def written(self, frame: int) -> bool:
        """Whether the files of this frame hold the column."""
        return self.since is not None and frame >= self.since


@dataclass
class SystemColumns:
    """A system, and the columns of its particles except the ids, which every file holds."""

    name: str
    stem: str
    """The prefix of its files' names."""
    columns: list[Column]
    drawn: bool = False
    """Whether files also hold what the system's sprite draws."""

    @property
    def used(self) -> list[Column]:
        """The columns that any file holds."""
        return [column for column in self.columns if column.since is not None]

    def outline(self) -> list[Any]:
        """Return what stays the same over an export's frames, for comparisons."""
        return [self.name, self.stem, [[one.name, one.width, repr(one.initial)] for one in self.columns]]

    def written(self, frame: int) -> list[Column]:
        """List the columns that files of this frame hold."""
        return [column for column in self.columns if column.written(frame)]


@dataclass(frozen=True)
class Part:
    """A file: the particles of one system on one rank in one frame."""

    system: int
    """Index of the system in the manifest."""
    rank: int | None
    """The rank that wrote it; None: it joins the particles of all ranks."""
    file: str
    rows: int
    bytes: int


@dataclass(frozen=True)
class FrameParts:
    """A frame and its files."""

    frame: int
    time: float
    parts: tuple[Part, ...]
    scene: Scene | None = None
    """What its picture shows besides particles, for `Export(scene=True)`."""
    changed: Scene | None = None
    """How the scene differs from that of the frame before."""

    @cached_property
    def text(self) -> str:
        """The frame as JSON; cached, since the manifest is rewritten with each frame."""
        parts = [[part.system, part.rank, part.file, part.rows, part.bytes] for part in self.parts]
        scene = {} if self.changed is None else {"scene": self.changed}
        return json.dumps({"frame": self.frame, "time": self.time, "parts": parts} | scene)


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
    """Frames being written, in order."""
    finished: bool = False
    origin: dict[str, Any] | None = None
    """Which script made it: see `origin.py`. None: unknown."""

    def continue_after(self, earlier: Self, first: int) -> None:
        """Take over an earlier start's frames before `first`, and its systems."""
        self.frames = [frame for frame in earlier.frames if frame.frame < first]
        self.systems = earlier.systems
        for system in self.systems:
            for column in system.columns:
                if not self.frames or (column.since or 0) > self.frames[-1].frame:
                    column.since = None

    def announce(self, frame: int, time: float, parts: tuple[Part, ...], scene: Scene | None) -> None:
        """Announce the next frame; `scene`: what its picture shows, if that is written."""
        changed = None if scene is None else changes(scene, self.last_scene)
        self.announced.append(FrameParts(frame, time, parts, scene, changed))

    @property
    def last_scene(self) -> Scene | None:
        """The scene of the last frame of all."""
        frames = self.announced or self.frames
        return frames[-1].scene if frames else None

    def scene_files(self) -> set[str]:
        """Return the names of the files that scenes need."""
        frames = (*self.frames, *self.announced)
        return set().union(*(files_of(frame.scene) for frame in frames if frame.scene is not None))

    def write(self, folder: Path) -> None:
        """Replace the folder's manifest."""
        systems = [
            {
                "name": system.name,
                "stem": system.stem,
                **({"drawn": True} if system.drawn else {}),
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
            "origin": self.origin,
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
            content = json.loads(path.read_bytes())
        except (OSError, ValueError, RecursionError, MemoryError) as error:
            raise MotesError(f"{path} cannot be read: {error or type(error).__name__}") from error
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise MotesError(f"{path} is not a manifest of particles")
        if content.get("version") != VERSION:
            raise MotesError(f"{path} has version {content.get('version')}; this motes reads {VERSION}")
        try:
            manifest = cls._of(content)
            manifest._take_whole(folder)
            return manifest
        except Exception as error:  # any: it may hold anything
            raise MotesError(f"{path} is damaged: {error!r}") from error

    @classmethod
    def _of(cls, content: Mapping[str, Any]) -> Self:
        systems = [
            SystemColumns(
                str(one["name"]),
                _stem(one["stem"]),
                [_column(column) for column in one["columns"]],
                bool(one.get("drawn", False)),
            )
            for one in content["systems"]
        ]
        before: Scene | None = None
        lists: tuple[list[FrameParts], list[FrameParts]] = [], []
        for name, known in zip(("frames", "announced"), lists, strict=True):
            for one in content[name]:
                known.append(_frame(one, before))
                before = known[-1].scene
        frames, announced = lists
        for frame in (*frames, *announced):
            for part in frame.parts:
                if not 0 <= part.system < len(systems):
                    raise ValueError(f"system {part.system} of {len(systems)}")
        seed = None if content["seed"] is None else int(content["seed"])
        numbers = float(content["dt"]), int(content["every"])
        origin = content.get("origin")
        if not isinstance(origin, dict | None):
            raise TypeError(f"origin {origin!r}")
        finished = bool(content["finished"])
        return cls(str(content["kind"]), seed, *numbers, systems, frames, announced, finished, origin)

    def _take_whole(self, folder: Path) -> None:
        """Move announced frames whose files all exist to `frames`: only complete files have their names."""
        while self.announced and all((folder / part.file).is_file() for part in self.announced[0].parts):
            self.frames.append(self.announced.pop(0))


def stems(names: Iterable[str]) -> list[str]:
    """Return a prefix of file names for each system: unique, and valid in file systems and in USD."""
    prefixes: list[str] = []
    for name in names:
        stem = re.sub(r"[^A-Za-z0-9_]", "_", name)[:60]
        if not re.match(r"[A-Za-z]", stem):
            stem = f"system_{stem}"
        taken = {other.lower() for other in prefixes}  # some file systems ignore case
        number = 1
        unique = stem
        while unique.lower() in taken:
            number += 1
            unique = f"{stem}_{number}"
        prefixes.append(unique)
    return prefixes


def _as_json(value: float) -> float | str:
    return value if math.isfinite(value) else repr(value)


def _stem(stem: Any) -> str:
    """Return a stem, checked so that the files that `pack` names after it stay in their folder."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", stem):
        raise ValueError(f"stem {stem!r}")
    return str(stem)


def _column(entry: Mapping[str, Any]) -> Column:
    since = None if entry["since"] is None else int(entry["since"])
    column = Column(str(entry["name"]), int(entry["width"]), tuple(map(float, entry["initial"])), since)
    if column.width not in (1, 3, 4) or len(column.initial) != column.width:
        raise ValueError(f"column {column.name!r} is {column.width} wide")
    return column


def _frame(entry: Mapping[str, Any], before: Scene | None) -> FrameParts:
    parts, changed = tuple(_part(part) for part in entry["parts"]), entry.get("scene")
    scene = None if changed is None else with_changes(before, changed)
    return FrameParts(int(entry["frame"]), float(entry["time"]), parts, scene, changed)


def _part(entry: Sequence[Any]) -> Part:
    system, rank, file, rows, size = entry
    if not isinstance(file, str) or Path(file).name != file:
        raise ValueError(f"file {file!r}")
    return Part(int(system), None if rank is None else int(rank), file, int(rows), int(size))
