"""Parts of a film that several jobs draw, and joining them without a seam.

A film is encoded second by second. Where a part begins or ends within a second, it also keeps these pictures
without loss, in a file beside it: `film.000250-000500.mp4.seam`. Joining encodes such a second as a whole, so
the joined film has the bits of the one that a single job would have made.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import zipfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._io import files, png
from .._run import continuing
from ..errors import MotesError
from . import containers
from .growing import GrowingFilm
from .segment import Encoding, Segment

__all__ = ["Part", "films_in", "join", "parts_of", "whole_of"]

_PART = re.compile(r"(?P<stem>.+)\.(?P<first>\d{6,})-(?P<end>\d{6,}|end)(?P<suffix>\.\w+)")
_FACTS = "film.json"
_SUFFIX = ".seam"
Pixels = NDArray[np.uint8]


@dataclass
class Part:
    """The frames of a film that one job writes, while it writes them."""

    of: str
    """The place of the whole film."""
    left_out: int = 0
    """How many of the film's frames this job has computed without a picture."""
    before: int = 0
    """How many frames the film has before this part's."""
    head: list[Pixels] = field(default_factory=list)
    """The pictures of the first segment, if the film's segment began before this part."""
    tail: list[Pixels] = field(default_factory=list)
    """The pictures of the last segment so far."""
    open_start: bool = True
    whole: bool = True
    """Whether the pictures of the seams are all here: not after another rank has taken the film over."""
    _cut: int = -1

    def note_cut(self) -> None:
        """Note, before the first frame, that the whole film has a cut here."""
        self._cut = self.left_out

    def begin(self, frame: int | None, per_segment: int) -> None:
        """Note the first frame: its number in the world, and the frames between two cuts of the film."""
        earlier = continuing.continued
        left_out = self.left_out
        if left_out == 0 and frame is not None:  # the script writes only pictures: one for each frame, then
            left_out = frame - earlier.frame
        self.before = earlier.movies.get(self.of, 0) + left_out
        self.open_start = self.before % per_segment != 0 and self._cut != self.left_out

    def add(self, pixels: Pixels) -> None:
        """Keep a picture of the current segment."""
        self.tail.append(pixels)

    def end_segment(self, frames: int) -> None:
        """Forget the pictures of a segment that a cut ends; `frames`: the part's frames up to its end."""
        if frames == len(self.tail) and self.open_start:
            self.head = self.tail
        self.tail = []

    def write(self, path: Path, encoding: Encoding, frames: int) -> None:
        """Write the seams beside the part, whole or not at all."""
        if not self.whole:
            return
        only = bool(self.tail) and self.open_start and len(self.tail) == frames
        head = self.tail if only else self.head
        facts = {"first": self.before, "frames": frames, "head": len(head), "tail": len(self.tail)}
        facts |= asdict(encoding) | {"rate": str(encoding.rate)}
        kept = dict(enumerate(head)) | {frames - len(self.tail) + i: one for i, one in enumerate(self.tail)}
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as seam:
            seam.writestr(_FACTS, json.dumps(facts))
            for index, pixels in kept.items():
                seam.writestr(f"{index:06}.png", png.encode(pixels))
        files.write_whole(seam_of(path), packed.getvalue())


def seam_of(path: Path) -> Path:
    """Return the path of the file with a part's seams."""
    return path.with_name(path.name + _SUFFIX)


def parts_of(film: Path) -> list[Path]:
    """List the parts of a film beside it, in order."""
    found = []
    for path in film.parent.iterdir() if film.parent.is_dir() else ():
        match = _PART.fullmatch(path.name)
        if match and match["stem"] == film.stem and match["suffix"] == film.suffix and path.is_file():
            found.append((int(match["first"]), path))
    return [path for _, path in sorted(found)]


def whole_of(part: Path) -> Path:
    """Return the path of the film to which a part belongs."""
    match = _PART.fullmatch(part.name)
    assert match is not None
    return part.with_name(match["stem"] + match["suffix"])


def films_in(folder: Path) -> list[Path]:
    """List the films of which a folder has parts."""
    parts = [path for path in folder.iterdir() if _PART.fullmatch(path.name)]
    return sorted({whole_of(path) for path in parts if path.suffix.lower() in containers.FORMATS})


@dataclass
class _Seam:
    """The seams of a finished part."""

    path: Path
    facts: dict[str, Any]
    packed: bytes

    @classmethod
    def read(cls, path: Path) -> _Seam:
        """Read a part's file of seams. Raises MotesError if it is missing or damaged."""
        seam = seam_of(path)
        try:
            packed = seam.read_bytes()
            with zipfile.ZipFile(io.BytesIO(packed)) as archive:
                facts = json.loads(archive.read(_FACTS))
            if not {"first", "frames", "head", "tail", *Encoding.__dataclass_fields__} <= set(facts):
                raise ValueError(f"it lacks facts in {_FACTS}")
        except FileNotFoundError:
            raise MotesError(
                f"{path} cannot be joined: {seam.name}, which its job wrote, is missing"
            ) from None
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
            raise MotesError(f"{seam} cannot be read: {error}") from None
        return cls(path, facts, packed)

    @property
    def encoding(self) -> Encoding:
        """How the part is encoded."""
        facts = {name: self.facts[name] for name in Encoding.__dataclass_fields__}
        return Encoding(**facts | {"rate": Fraction(facts["rate"])})

    def picture(self, index: int) -> Pixels:
        """Return a picture that was kept without loss."""
        with zipfile.ZipFile(io.BytesIO(self.packed)) as archive:
            data = archive.read(f"{index:06}.png")
        with _extras.av("motes movie").open(io.BytesIO(data), format="png_pipe") as file:
            pixels: Pixels = next(file.decode(video=0)).to_ndarray(format="rgb24")
        return pixels


def join(paths: Sequence[Path], target: Path) -> dict[str, Any]:
    """Join the parts of a film, given in order; return the film's figures.

    Raises MotesError, before a file is written, if frames are missing between them or if they are encoded
    differently.
    """
    if paths[0].suffix.lower() not in containers.FORMATS:
        raise MotesError(f"{paths[0]} cannot be joined: draw ranges as films, such as .mp4")
    seams = [_Seam.read(path) for path in paths]
    encoding = seams[0].encoding
    if containers.FORMATS.get(target.suffix.lower()) != encoding.kind:
        raise MotesError(f"{target} must end in {paths[0].suffix}, like the parts of the film")
    for one, following in zip(seams, seams[1:], strict=False):
        end, first = one.facts["first"] + one.facts["frames"], following.facts["first"]
        if end != first:
            what = f"frames {end} to {first - 1} are missing" if end < first else "both have the same frames"
            raise MotesError(f"{following.path.name} does not follow {one.path.name}: {what}")
        if following.encoding != encoding:
            raise MotesError(
                f"{one.path.name} and {following.path.name} differ in size, rate, quality or preset"
            )
    film = GrowingFilm(target, encoding.rate, hidden=True)
    with contextlib.closing(film):
        film.open()
        joined = _Joined(film, encoding)
        for seam in seams:
            joined.add(seam)
        joined.flush()
        if film.frames != (frames := sum(seam.facts["frames"] for seam in seams)):
            raise MotesError(
                f"only {film.frames} of {frames} frames could be read from the parts of {target}"
            )
        film.finish()
    facts = {"film": str(target), "parts": len(paths), "pictures": film.frames}
    facts |= {"width": encoding.width, "height": encoding.height, "fps": float(encoding.rate)}
    return facts | {"seconds": film.frames / float(encoding.rate)}


class _Joined:
    """A film that grows part by part."""

    def __init__(self, film: GrowingFilm, encoding: Encoding) -> None:
        self._film = film
        self._encoding = encoding
        self._pending: list[Pixels] = []

    def add(self, seam: _Seam) -> None:
        """Append a part."""
        frames, head, tail = (int(seam.facts[name]) for name in ("frames", "head", "tail"))
        self._encode(seam, range(head))
        if head == 0 or head < frames or tail == 0:
            self.flush()
        if head < frames:
            with _extras.av("motes movie").open(str(seam.path), "r", format=self._encoding.kind) as source:
                self._film.take_groups(source, head, frames - tail)
            self._encode(seam, range(frames - tail, frames))

    def _encode(self, seam: _Seam, indices: range) -> None:
        self._pending += [seam.picture(index) for index in indices]

    def flush(self) -> None:
        """Encode the pictures of a segment that parts share."""
        if not self._pending:
            return
        segment = Segment(self._encoding, first=self._film.frames, number=self._film.segments + 1)
        for pixels in self._pending:
            segment.add(pixels)
        self._film.append(*segment.finish(), segment.frames)
        self._pending = []
