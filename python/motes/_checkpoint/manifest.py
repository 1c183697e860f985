"""manifest.json: the description of a checkpoint. It is written last, when all parts are on disk."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self

from .._io import files
from ..errors import CheckpointError
from .folder import MANIFEST
from .plain_data import data_of, value_of

__all__ = ["FORMAT", "VERSION", "Manifest", "PartEntry"]

FORMAT = "motes checkpoint"
VERSION = 9


@dataclass
class PartEntry:
    """The file with one calculator's particles."""

    file: str
    bytes: int
    rows: list[int]
    """The number of particles of each system."""


@dataclass
class Manifest:
    """The description of a checkpoint between two frames."""

    frame: int
    """The first frame that is still to do."""
    time_s: float
    seed: int
    dt_s: float
    substeps: int
    motes: str
    """The version of motes."""
    script: dict[str, Any]
    """The script's path, text, hash and arguments: see `same_script.facts`."""
    systems: list[str]
    parts: list[PartEntry]
    world: dict[str, Any]
    """The file with the state that all ranks share: its keys are file, bytes, crc32c."""
    periodic: dict[str, list[float]] = field(default_factory=dict)
    """The ends of each periodic axis, m."""
    movies: dict[str, int] = field(default_factory=dict)
    """The number of frames of each open movie."""
    stepped_s: float = 0
    """Seconds that computing the frames before has taken, without pictures; known with every="auto"."""
    script_state: Any = None
    """Python's state, encoded by `plain_data.data_of`."""

    @property
    def particles(self) -> list[int]:
        """The number of particles of each system."""
        return [sum(part.rows[i] for part in self.parts) for i in range(len(self.systems))]

    def with_script_state(self, script_state: Any) -> Self:
        """Store Python's state, encoded; return the manifest."""
        self.script_state = data_of(script_state)
        return self

    def unpacked(self, path: Path) -> Any:
        """Return the state of the script. Raises CheckpointError, naming `path`, if it is damaged."""
        try:
            return {} if self.script_state is None else value_of(self.script_state)
        except Exception as error:  # of any kind: the data may be anything
            raise CheckpointError(f"{path} is damaged: {type(error).__name__}: {error}") from error

    def write(self, folder: Path) -> None:
        """Write the file, whole or not at all, with its own checksum."""
        files.write_whole(folder / MANIFEST, self.to_bytes())

    def to_bytes(self) -> bytes:
        """Return the file's content."""
        content = {"format": FORMAT, "version": VERSION, **asdict(self)}
        return (json.dumps({**content, "sha256": _checksum(content)}, indent=1) + "\n").encode()

    @classmethod
    def from_bytes(cls, text: bytes, path: Path) -> Self:
        """Parse a manifest. Raises CheckpointError, naming `path`, if it is damaged or of another version."""
        try:
            content = json.loads(text)
            expected = content.pop("sha256")
            if content.pop("format") != FORMAT:
                raise CheckpointError(f"{path} is not the manifest of a checkpoint")
            version = content.pop("version")
            if version != VERSION:
                raise CheckpointError(
                    f"{path} has version {version}, made by motes {content.get('motes')}; this one reads "
                    f"version {VERSION}"
                )
            if _checksum({"format": FORMAT, "version": version, **content}) != expected:
                raise CheckpointError(f"{path} has changed since it was written")
            content["parts"] = [PartEntry(**part) for part in content["parts"]]
            return cls(**content)
        except CheckpointError:
            raise
        except Exception as error:  # of any kind: the bytes may be anything
            raise CheckpointError(f"{path} is damaged: {type(error).__name__}: {error}") from error


def _checksum(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
