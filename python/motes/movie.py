"""Movie: frames into an H.264 file, encoded by a background thread while the next frame is computed."""

from __future__ import annotations

import atexit
import contextlib
import os
import queue
import sys
import threading
import weakref
from array import array
from collections import deque
from fractions import Fraction
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Literal, Self, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from . import _extras, arguments
from ._film.containers import FORMATS
from ._film.growing import GrowingFilm, partial_path
from ._film.page import video
from ._film.segment import Encoding, Segment
from ._run import continuing
from ._run.busy import Busy, busy_with
from ._run.process import process
from .errors import ArgumentError, MotesError, Stopped
from .frame import Frame

__all__ = ["Movie"]

Preset: TypeAlias = Literal[
    "ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow"
]
_QUEUE_FRAMES = 4  # enough to smooth over a slow frame; more would only hold memory
_LOOK_S = 0.1
_NO_FRAME = -1  # what is written is an array of the script's, not a frame of the world
_ABANDON_S = 1.0  # how long leaving by an exception waits for the frames that are queued


class Movie:
    """A movie file that is complete, or a partial one beside it.

    While `film.mp4` is written it grows as `film.partial.mp4`, second by second; players open it, also after
    the process was killed. Leaving the `with` block by an exception keeps this partial film. The next movie
    of this path starts its own, in its place.

    Construct it on every rank: where frames are falsy it touches no file, so a script need not test its rank.
    Without a frame no file appears.
    """

    def __init__(
        self, path: str | os.PathLike[str], *, fps: float = 24, crf: float = 18, preset: Preset = "superfast"
    ) -> None:
        """Name the file.

        Args:
            path: a name ending in .mp4, .mkv or .mov.
            fps: frames per second.
            crf: 0..51; smaller looks better and makes larger files.
            preset: "ultrafast" to "veryslow"; slower ones make smaller files.

        Raises:
            MissingExtraError: if the package av is not installed.
        """
        self.path = arguments.file_path("path", path)
        if self.path.suffix.lower() not in FORMATS:
            raise ArgumentError("path", os.fspath(path), "a name ending in .mp4, .mkv or .mov")
        self.fps = arguments.number("fps", fps, low=1e-3, high=1e4)
        self.crf = arguments.number("crf", crf, low=0, high=51)
        self.preset = arguments.choice("preset", preset, get_args(Preset))
        # Checked here, not when frames arrive, so that every rank gets the same error at the same line.
        _extras.require_av("Movie")
        self._process = os.getpid()
        self.frames = 0
        """Those of the film that this process writes."""
        self._place = continuing.place_of(self.path)
        """The same for every run and rank that writes this film."""
        self._written: int | None = None  # before the first frame
        self._unsecured = array("q")  # the world's number of each frame since `_note_secured`, or _NO_FRAME
        self._again: deque[int] = deque()  # frames that a lost rank was to write
        self._film: GrowingFilm | None = None
        self._shape: tuple[int, ...] | None = None
        self._thread: threading.Thread | None = None
        self._queue: queue.Queue[NDArray[np.uint8] | _Mark | None] = queue.Queue(_QUEUE_FRAMES)
        self._error: BaseException | None = None
        self._closed = False
        self._abandoned = False
        continuing.note_movie(self)

    @property
    def written(self) -> int:
        """How many frames the film has so far, on whatever rank they are: the same on every rank."""
        if self._written is not None:
            return self._written
        return continuing.continued.movies.get(self._place, 0)

    def write(self, frame: Frame | NDArray[np.uint8]) -> None:
        """Append a frame; waits while four are queued.

        Args:
            frame: a frame, or uint8 (height, width, 3); nothing is done for a frame that is on another rank.

        Raises:
            MotesError: if the movie is closed.
            OSError: that of an earlier frame, such as a full disk; or `close` raises it.
        """
        if self._closed:
            raise MotesError(f"the movie {self.path} is closed")
        if isinstance(frame, Frame) and not frame:
            if frame.made:
                self._count(frame.index)
            return
        self._add(frame)
        self._count(frame.index if isinstance(frame, Frame) else None)

    def _add(self, frame: Frame | NDArray[np.uint8]) -> None:
        self._raise_error()
        pixels = _pixels(frame)
        if self._shape is None:
            self._start(pixels.shape)
        elif pixels.shape != self._shape:
            raise ArgumentError("frame", pixels.shape, f"of the size of the first frame, {self._shape}")
        # A caller's own array may change while it waits in the queue; a frame's pixels cannot.
        self._put(pixels if isinstance(frame, Frame) else pixels.copy())
        self.frames += 1

    def _count(self, index: int | None) -> None:
        if self._written is None:
            self._written = self.written
        continuing.hold_movie(self)
        self._written += 1
        self._unsecured.append(_NO_FRAME if index is None else index)

    def close(self) -> None:
        """Encode what is queued and give the file its name. Calling it again does nothing.

        Where this fails, the partial film stays.
        """
        if self._closed:
            return
        self._end()
        try:
            if self._thread is None:
                self._find_earlier()
            self._finish()
        except BaseException:
            self._abandon()
            raise

    def _find_earlier(self) -> None:
        """Find a film to which this process adds nothing: an earlier one was killed behind the last frame."""
        count = self.written
        earlier = continuing.continued.draws and self._written is None and count > 0
        if self._film is None and earlier and partial_path(Path(self._place)).exists():
            self._continue_at(count)

    def _finish(self) -> None:
        """Write what is queued, and give the film its name."""
        told = f"closing {self.path.name}"
        if self._thread is not None:
            self._put(None)
            busy_with(told, self._thread.join)
        elif self._film is not None:
            try:
                with contextlib.closing(self._film):
                    busy_with(told, self._film.finish)
            except Exception as error:
                self._error = error
        self._raise_error()

    def __enter__(self) -> Self:
        """Return the movie itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the movie, or keep the partial one when the block failed."""
        if os.getpid() != self._process:  # a fork: the film is its parent's
            return
        if kind is None or issubclass(kind, Stopped):
            self.close()
        else:
            self._abandon()

    def __repr__(self) -> str:
        """Name the file and what is in it."""
        return f"<Movie {str(self.path)!r} {self.frames} frames at {self.fps:g} per second>"

    def _repr_html_(self) -> str | None:
        """Show the film in a notebook, once it is closed."""
        return video(self.path) if self._closed and not self._abandoned else None

    # --- what a checkpoint, and a run that goes on after it, need

    def _secure(self) -> int:
        """Wait until all frames so far are on the disk; returns their number. The main thread calls it.

        The film can be continued behind them: a segment ends here. On ranks that write no file it returns
        what they have counted; `_note_secured` follows where all ranks know that it is so.
        """
        self._raise_error()
        if self._thread is not None and not self._closed:
            mark = _Mark()
            self._put(mark)
            with Busy(f"securing {self.path.name}") as busy:
                while not mark.wait(_LOOK_S) and self._thread.is_alive():
                    busy.look()
            self._raise_error()
        return self.written

    def _note_secured(self) -> None:
        """All frames so far are on the disk, as the rank that writes them has told all others."""
        del self._unsecured[:]

    def _continue_at(self, count: int) -> None:
        """Go on behind the first `count` frames that an earlier process left, before the first `write`.

        Raises CheckpointError, naming the file and what it holds, if there are fewer, or no cut at `count`.
        """
        if self._thread is not None:
            raise MotesError(f"the movie {self.path} is being written; it cannot be continued any more")
        if self._film is not None:
            self._film.close()
            self._film = None
        if count > 0:
            where = Path(self._place)
            copy = partial(GrowingFilm.continued, where, self._rate, count)
            self._film = busy_with(f"reading {self.path.name}", copy)
        self.frames = self._written = count
        del self._unsecured[:]
        if not self._closed:
            continuing.hold_movie(self)

    def _first_unsaved(self) -> int | None:
        """Return the first frame of the world that is in no segment of the file yet; None: there is none."""
        behind = self.written - len(self._unsecured)
        waiting = self._unsecured[max(0, (self._film.frames if self._film else 0) - behind) :]
        return min((index for index in waiting if index != _NO_FRAME), default=None)

    def _take_over(self) -> list[int]:
        """Write the film from here on: the rank that wrote it is gone.

        Returns the frames of the world that it may not have written, which `_write_again` expects. Raises
        CheckpointError where the file lacks more than those.
        """
        count, unsecured = self.written, self._unsecured[:]
        if self._thread is not None or self._abandoned or count == 0:
            return []
        if self._closed and not partial_path(Path(self._place)).exists():
            return []  # that rank has closed it, too
        behind = count - len(unsecured)
        held = GrowingFilm.frames_in(Path(self._place), self._rate, most=count)
        self._continue_at(max(held, behind))
        self._unsecured, self._written = unsecured, count
        missing = unsecured[self.frames - behind :]
        if _NO_FRAME in missing:
            raise MotesError(f"the movie {self.path} lacks pictures that were no frames of the world")
        self._again = deque(missing)
        if self._closed and not missing:
            self._finish_taken_over()
        return list(self._again)

    def _write_again(self, index: int, frame: Frame) -> None:
        """Write a frame that the lost rank was to write, as often as it stood in the film."""
        if not self._again:
            return
        while self._again and self._again[0] == index:
            self._again.popleft()
            self._add(frame)
        if self._closed and not self._again:
            self._finish_taken_over()

    def _finish_taken_over(self) -> None:
        """Close a film that the script has closed: the rank that was about to is gone."""
        try:
            self._finish()
        finally:
            self._end()

    def _close_for_lost(self) -> None:
        """Give the film its name: the rank that wrote it is gone, and its frames are on the disk."""
        self._end()
        self._take_over()

    # --- the background thread

    @property
    def _rate(self) -> Fraction:
        return Fraction(self.fps).limit_denominator(60000)

    def _start(self, shape: tuple[int, ...]) -> None:
        if self._film is None and self._written is None and self.written > 0:
            self._continue_at(self.written)
        height, width, _ = shape
        kind = FORMATS[self.path.suffix.lower()]
        encoding = Encoding(kind, height, width, self._rate, self.crf, self.preset)
        self._shape = shape
        film = self._film = self._film or GrowingFilm(Path(self._place), self._rate)
        # A daemon: a thread the interpreter waits for would keep a failed rank alive, and with it the whole
        # job.
        self._thread = threading.Thread(
            target=self._encode, args=(encoding, film), name=f"movie {self.path.name}", daemon=True
        )
        self._thread.start()
        _open_movies.add(self)

    def _put(self, item: NDArray[np.uint8] | _Mark | None) -> None:
        self._raise_error()
        with contextlib.suppress(queue.Full):
            return self._queue.put_nowait(item)
        with Busy(f"encoding {self.path.name}") as busy:
            while True:
                self._raise_error()
                try:
                    return self._queue.put(item, timeout=_LOOK_S)
                except queue.Full:
                    busy.look()

    def _raise_error(self) -> None:
        if self._error is not None:
            error, self._error = self._error, None
            self._end()
            if isinstance(error, MotesError):
                raise error
            raise MotesError(f"the movie {self.path} could not be written: {error}") from error

    def _end(self) -> None:
        self._closed = True
        _open_movies.discard(self)
        continuing.forget_movie(self)

    def _abandon(self) -> None:
        """Keep the partial film, with what is queued if that takes no longer than a second."""
        self._abandoned = True
        self._end()
        if self._thread is None:
            if self._film is not None:
                self._film.close()
            return
        with contextlib.suppress(queue.Full):  # then the thread is not waiting for a frame
            self._queue.put_nowait(None)
        self._thread.join(_ABANDON_S)

    def _next(self) -> NDArray[np.uint8] | _Mark | None:
        """Return what is next in the queue; None at the film's end."""
        if not self._abandoned:
            return self._queue.get()
        try:
            return self._queue.get_nowait()
        except queue.Empty:
            return None

    def _encode(self, encoding: Encoding, film: GrowingFilm) -> None:
        """Work of the background thread, from the first frame to the film's final name."""
        try:
            with contextlib.closing(film):
                film.open()
                self._encode_into(film, encoding)
                if not self._abandoned:
                    film.finish()
        except BaseException as error:
            self._error = error

    def _encode_into(self, film: GrowingFilm, encoding: Encoding) -> None:
        segment: Segment | None = None
        while (item := self._next()) is not None:
            if isinstance(item, _Mark):
                if segment is not None:
                    film.append(*segment.finish(), segment.frames)
                    segment = None
                film.sync()
                item.set()
                continue
            if segment is None:
                segment = Segment(encoding, first=film.frames, number=film.segments + 1)
            segment.add(item)
            if (film.frames + segment.frames) % encoding.frames == 0:
                film.append(*segment.finish(), segment.frames)
                segment = None
        if segment is not None:
            film.append(*segment.finish(), segment.frames)


class _Mark(threading.Event):
    """In the queue: secure what came before, then set this."""


def _pixels(frame: Frame | NDArray[np.uint8]) -> NDArray[np.uint8]:
    allowed = "a Frame or uint8 (height, width, 3)"
    try:
        pixels: NDArray[np.uint8] = np.asarray(frame.pixels if isinstance(frame, Frame) else frame)
    except Exception:  # any: this runs methods of users' classes
        raise ArgumentError("frame", frame, allowed) from None
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
        raise ArgumentError("frame", f"{pixels.dtype} {pixels.shape}", allowed)
    return pixels


_open_movies: weakref.WeakSet[Movie] = weakref.WeakSet()


@atexit.register
def _close_open_movies() -> None:
    """Finish what the script forgot to close; drop it if the script left in the middle of a run."""
    for movie in list(_open_movies):
        if process.running:
            movie._abandon()
            continue
        try:
            movie.close()
        except Exception as error:
            print(f"motes: {error}", file=sys.stderr)
