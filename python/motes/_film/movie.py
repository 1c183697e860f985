"""Movie: a film of frames, for scripts."""

from __future__ import annotations

import os
from fractions import Fraction
from types import TracebackType
from typing import Literal, Self, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._picture.frame import Frame
from .._run import continuing
from .._run.excerpt import Excerpt
from .._values import arguments
from ..errors import ArgumentError, Stopped
from .containers import FORMATS, LOOPS
from .page import video
from .writing import FilmWriter

__all__ = ["Movie", "writer_of"]

Preset: TypeAlias = Literal[
    "ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow"
]


class Movie:
    """A movie file that is complete, or a partial one beside it.

    While `film.mp4` is written, it grows as `film.partial.mp4`, second by second. Players can open the
    partial film, even after the process was killed. It is kept if the `with` block is left by an exception;
    the next movie with this path replaces it.

    Construct it on every rank: where frames are falsy it touches no file, so a script need not test its rank.
    Without a frame no file appears.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        fps: float = 24,
        crf: float = 18,
        preset: Preset = "superfast",
        kilobytes: float | None = None,
    ) -> None:
        """Set the file and its encoding; nothing is written yet.

        Args:
            path: a name ending in .mp4, .mkv or .mov (H.264), .webm (VP9), .gif or .webp. The last two repeat
                for ever and need the extra [image], too; they are written when the film is closed.
            fps: frames per second; at most 50 for .gif.
            crf: quality, 0..51; lower looks better and makes larger files. A .gif always has 256 colours.
            preset: "ultrafast" to "veryslow"; slower presets make smaller files.
            kilobytes: the most that the file may have, 1000 bytes each: if it has more when it is closed, it
                is encoded again, with less quality or in smaller pictures. `close` raises MotesError, and
                says what is possible, if even a quarter of the width does not suffice. A part of a film
                (`motes run --frames`) has no limit. None: no limit.

        Raises:
            MissingExtraError: if the package av is not installed.
        """
        self.path = arguments.file_path("path", path)
        suffix = self.path.suffix.lower()
        if suffix not in (*FORMATS, *LOOPS):
            allowed = "a name ending in .mp4, .mkv, .mov, .webm, .gif or .webp"
            raise ArgumentError("path", os.fspath(path), allowed)
        self.fps = arguments.number("fps", fps, low=1e-3, high=50 if suffix == ".gif" else 1e4)
        self.kilobytes = (
            None if kilobytes is None else arguments.number("kilobytes", kilobytes, low=1, high=1e12)
        )
        self.crf = arguments.number("crf", crf, low=0, high=51)
        self.preset = arguments.choice("preset", preset, get_args(Preset))
        # Checked here rather than at the first frame: every rank gets the same error at the same line.
        _extras.require_av("Movie")
        if suffix in LOOPS:
            _extras.require_pillow(f"a film as {suffix}")
        self._process = os.getpid()
        self._excerpt, part_of = Excerpt.current(), None
        if self._excerpt is not None:
            part_of = continuing.place_of(self.path)
            self.path = self._excerpt.beside(self.path)
        place = continuing.place_of(self.path)
        rate = Fraction(self.fps).limit_denominator(60000)
        most = self.kilobytes if part_of is None else None
        self._writer = FilmWriter(
            self.path, place, rate, self.crf, self.preset, kilobytes=most, part_of=part_of
        )

    @property
    def frames(self) -> int:
        """The number of frames in the film that this process writes; 0 on other ranks."""
        return self._writer.frames

    @property
    def written(self) -> int:
        """The number of frames so far, equal on every rank."""
        return self._writer.written

    def write(self, frame: Frame | NDArray[np.uint8]) -> None:
        """Append a frame; wait while four are queued.

        Args:
            frame: a frame, or uint8 (height, width, 3); a frame that is on another rank is only counted.

        Raises:
            MotesError: if the movie is closed, or if an earlier frame could not be written, for example on a
                full disk; `close` raises this, too.
        """
        if self._excerpt is None or self._excerpt.still is None:
            self._writer.write(frame)

    def close(self) -> None:
        """Encode queued frames and give the file its name; do nothing if that is done.

        If this fails, the partial film stays.
        """
        self._writer.close()

    def __enter__(self) -> Self:
        """Return the movie itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the movie, or keep the partial film if the block failed."""
        if os.getpid() != self._process:  # in a fork: the film belongs to the parent
            return
        if kind is None or issubclass(kind, Stopped):
            self.close()
        else:
            self._writer.abandon()

    def __repr__(self) -> str:
        """Show the path, the number of frames and their rate."""
        return f"<Movie {str(self.path)!r} {self.frames} frames at {self.fps:g} per second>"

    def _repr_html_(self) -> str | None:
        """Return HTML that shows the film in a notebook, once it is closed."""
        return video(self.path) if self._writer.closed and not self._writer.abandoned else None


def writer_of(movie: Movie) -> FilmWriter:
    """Return a movie's `FilmWriter`, for the rest of the package."""
    return movie._writer
