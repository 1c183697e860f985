"""The table of export formats, and the place of an export on disk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from .._io import files
from ..errors import ArgumentError
from . import npz, usd, vtp
from .format import Format
from .manifest import Manifest

__all__ = ["ALLOWED", "FORMATS", "Format", "Place", "place_of"]

FORMATS = {format.kind: format for format in (npz.FORMAT, vtp.FORMAT, usd.FORMAT)}

ALLOWED = (
    f"a name ending in {' or '.join(sorted((f.index for f in FORMATS.values() if f.index), reverse=True))}, "
    "or a directory's name without suffix, for .npz files"
)


@dataclass(frozen=True)
class Place:
    """The path and format of an export."""

    path: Path
    """The path that the user gave."""
    format: Format

    @property
    def folder(self) -> Path:
        """The folder of its parts and its manifest."""
        return self.path.with_name(f"{self.path.name}.parts") if self.format.index else self.path

    def file(self, stem: str, frame: int, rank: int | None) -> str:
        """Return the name of a part."""
        return f"{stem}.{frame:06d}{'' if rank is None else f'.r{rank:04d}'}.{self.format.kind}"

    def write_part(
        self, file: str, columns: Mapping[str, NDArray[Any]], *, frame: int, time: float, drawn: Any = None
    ) -> int:
        """Write a part, whole or not at all; return its size in bytes.

        `drawn`: makes what the system's sprite draws of the columns; None: nothing.
        """
        path = self.folder / file
        with files.whole_path(path) as draft:
            more = {} if drawn is None else {"drawn": drawn}
            self.format.write(draft, columns, frame=frame, time=time, **more)
            return draft.stat().st_size

    def beside(self, manifest: Manifest) -> set[str]:
        """Return the names of the files that are written once per system."""
        return {system.stem + suffix for system in manifest.systems for suffix in self.format.beside}

    def publish(self, manifest: Manifest, *, shows: bool = True) -> None:
        """Publish the complete frames: to other programs, if it `shows` them, then to `open_particles`."""
        for suffix, content in self.format.beside.items():
            for system in manifest.systems:
                _write_changed(self.folder / f"{system.stem}{suffix}", content(system))
        if shows and self.format.show is not None:
            # The first time, remove the drafts of killed runs, which lists the directory.
            with files.whole_path(self.path, remove_abandoned=not manifest.frames) as draft:
                draft.write_bytes(self.format.show(manifest, self.folder.name))
        manifest.write(self.folder)


def place_of(argument: str, path: Path) -> Place:
    """Return the place of an export from its path. Raises ArgumentError for an unknown suffix."""
    suffix = path.suffix.lower()
    for format in FORMATS.values():
        if suffix == format.index:
            if not path.name:
                raise ArgumentError(argument, str(path), "a directory's name")
            return Place(path, format)
    if suffix[1:].isdigit():  # today.1
        return Place(path, FORMATS["npz"])
    meant = [format.index or "a directory" for format in FORMATS.values() if suffix in format.mistaken]
    hint = f"did you mean {meant[0]}?" if meant else ""
    if suffix == ".vdb":
        hint = "no library for .vdb installs from PyPI: export to .usd, of which others make volumes"
    raise ArgumentError(argument, str(path), ALLOWED, hint=hint)


def _write_changed(path: Path, content: bytes) -> None:
    try:
        if path.read_bytes() == content:
            return
    except OSError:
        pass
    files.write_whole(path, content)
