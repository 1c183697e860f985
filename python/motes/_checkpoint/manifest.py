"""manifest.json: what a checkpoint says about itself. It is written last, when all parts are on disk."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self

from .._io import files
from ..errors import CheckpointError
from .folder import MANIFEST
from .kept import data_of, value_of

__all__ = ["FORMAT", "VERSION", "Manifest", "PartEntry"]

FORMAT = "motes checkpoint"
VERSION = 6


@dataclass
class PartEntry:
    """One calculator's file."""

    file: str
    bytes: int
    rows: list[int]
    """Particles of each system."""


@dataclass
class Manifest:
    """A checkpoint between two frames."""

    frame: int
    """The first one that is still to do."""
    time_s: float
    seed: int
    dt_s: float
    substeps: int
    motes: str
    """Version of the package."""
    script: dict[str, Any]
    """Its path, its text, its arguments: see same_script."""
    systems: list[str]
    parts: list[PartEntry]
    world: dict[str, Any]
    """Of the file that says what all ranks know: file, bytes, crc32c."""
    periodic: dict[str, list[float]] = field(default_factory=dict)
    """The ends of each periodic axis."""
    movies: dict[str, int] = field(default_factory=dict)
    """How many frames each open movie had."""
    kept: Any = None
    """What Python keeps, as data: see kept."""

    @property
    def particles(self) -> list[int]:
        """How many there are of each system."""
        return [sum(part.rows[i] for part in self.parts) for i in range(len(self.systems))]

    def with_kept(self, kept: Any) -> Self:
        """Keep a value of Python's."""
        self.kept = data_of(kept)
        return self

    def unpacked(self, path: Path) -> Any:
        """Return what `with_kept` kept. Raises CheckpointError, naming the file, for what it never keeps."""
        try:
            return {} if self.kept is None else value_of(self.kept)
        except Exception as error:  # any: the data may be anything
            raise CheckpointError(f"{path} is damaged: {type(error).__name__}: {error}") from error

    def write(self, folder: Path) -> None:
        """Write it whole, with a checksum of itself."""
        files.write_whole(folder / MANIFEST, self.to_bytes())

    def to_bytes(self) -> bytes:
        """Return the file's content."""
        content = {"format": FORMAT, "version": VERSION, **asdict(self)}
        return (json.dumps({**content, "sha256": _checksum(content)}, indent=1) + "\n").encode()

    @classmethod
    def from_bytes(cls, text: bytes, path: Path) -> Self:
        """Read it. Raises CheckpointError, naming the file, where it is damaged or of another version."""
        try:
            content = json.loads(text)
            expected = content.pop("sha256")
            if content.pop("format") != FORMAT:
                raise CheckpointError(f"{path} is no manifest of a checkpoint")
            version = content.pop("version")
            if version != VERSION:
                raise CheckpointError(
                    f"{path} is of version {version}, made by motes {content.get('motes')}; this one reads "
                    f"version {VERSION}"
                )
            if _checksum({"format": FORMAT, "version": version, **content}) != expected:
                raise CheckpointError(f"{path} has changed since it was written")
            content["parts"] = [PartEntry(**part) for part in content["parts"]]
            return cls(**content)
        except CheckpointError:
            raise
        except Exception as error:  # any: the bytes may be anything
            raise CheckpointError(f"{path} is damaged: {type(error).__name__}: {error}") from error


def _checksum(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
