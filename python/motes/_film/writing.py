"""FilmWriter: encodes frames into an H.264 file in a background thread; every rank counts them."""

from __future__ import annotations

import atexit
import contextlib
import queue
import sys
import threading
import weakref
from array import array
from collections import deque
from fractions import Fraction
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._picture.frame import Frame
from .._run import continuing
from .._run.busy import Busy, busy_with
from .._run.process import process
from ..errors import ArgumentError, MotesError
from .containers import FORMATS
from .finishing import Finishing
from .growing import GrowingFilm, partial_path
from .parts import Part
from .segment import Encoding, Segment

__all__ = ["FilmWriter"]

_QUEUE_FRAMES = 4  # enough to smooth over a slow frame; more would only hold memory
_LOOK_S = 0.1
_NO_FRAME = -1  # stands for a picture that is the script's array, not a frame of the world
_ABANDON_S = 1.0  # how long leaving by an exception waits for queued frames


class FilmWriter:
    """Writes a film on the rank that has its frames, and counts them on all others."""

    def __init__(
        self, path: Path, place: str, rate: Fraction, crf: float, preset: str, *,
        kilobytes: float | None = None, part_of: str | None = None,
    ) -> None:  # fmt: skip
        """Store the arguments that `Movie` has checked; `rate`: frames per second.

        `kilobytes`: the most that the finished film may have. `part_of`: the place of the whole film, of
        which this job writes only a part.
        """
        self.path = path
        self.place = place
        """The film's absolute path, the same for every run and rank that writes it."""
        self.frames = 0
        """The number of frames in the film that this process writes."""
        self.closed = False
        self.abandoned = False
        self._rate, self._crf, self._preset = rate, crf, preset
        self._kilobytes = kilobytes
        self._part = None if part_of is None else Part(part_of)
        self._written: int | None = None  # None before the first frame
        self._unsecured = array("q")  # the world's number of each frame since `note_secured`, or _NO_FRAME
        self._again: deque[int] = deque()  # frames that a lost rank may not have written
        self._film: GrowingFilm | None = None
        self._shape: tuple[int, ...] | None = None
        self._thread: threading.Thread | None = None
        self._queue: queue.Queue[NDArray[np.uint8] | _Mark | None] = queue.Queue(_QUEUE_FRAMES)
        self._error: BaseException | None = None
        continuing.note_movie(self)

    @property
    def written(self) -> int:
        """The number of frames so far, equal on every rank."""
        if self._written is not None:
            return self._written
        return continuing.continued.movies.get(self.place, 0)

    def write(self, frame: Frame | NDArray[np.uint8]) -> None:
        """Append a frame: `Movie.write`."""
        if self.closed:
            raise MotesError(f"the movie {self.path} is closed")
        if isinstance(frame, Frame) and not frame:
            if frame.left_out and self._part is not None:
                self._part.left_out += 1
            if frame.made:
                self._count(frame.index)
            return
        self._add(frame)
        self._count(frame.index if isinstance(frame, Frame) else None)

    def _add(self, frame: Frame | NDArray[np.uint8]) -> None:
        self._raise_error()
        pixels = _pixels(frame)
        if self._shape is None:
            self._start(pixels.shape, frame.index if isinstance(frame, Frame) else None)
        elif pixels.shape != self._shape:
            raise ArgumentError("frame", pixels.shape, f"of the size of the first frame, {self._shape}")
        # A caller's array may change while it is queued; a frame's pixels cannot.
        self._put(pixels if isinstance(frame, Frame) else pixels.copy())
        self.frames += 1

    def _count(self, index: int | None) -> None:
        if self._written is None:
            self._written = self.written
        continuing.hold_movie(self)
        self._written += 1
        self._unsecured.append(_NO_FRAME if index is None else index)

    def close(self) -> None:
        """Encode queued frames and give the file its name: `Movie.close`."""
        if self.closed:
            return
        self._end()
        try:
            if self._thread is None:
                self._find_earlier()
            self._finish()
        except BaseException:
            self.abandon()
            raise

    def _find_earlier(self) -> None:
        """Open a film that needs no more frames: an earlier process was killed after the last one."""
        count = self.written
        earlier = continuing.continued.draws and self._written is None and count > 0
        if self._film is None and earlier and partial_path(Path(self.place)).exists():
            self.continue_at(count)

    def _finish(self) -> None:
        """Encode queued frames and give the film its name."""
        what = f"closing {self.path.name}"
        if self._thread is not None:
            self._put(None)
            busy_with(what, self._thread.join)
        elif self._film is not None:
            try:
                with contextlib.closing(self._film):
                    busy_with(what, self._film.finish)
            except Exception as error:
                self._error = error
        self._raise_error()

    # --- for checkpoints, and runs that continue from them

    def secure(self) -> int:
        """Wait until all frames so far are on disk; return their number. Main thread only.

        A segment ends here, so the film can be continued from this point. Ranks that write no file only
        return their count. Once all ranks know that this succeeded, `note_secured` follows.
        """
        self._raise_error()
        if self._thread is None and self._part is not None:
            self._part.note_cut()
        if self._thread is not None and not self.closed:
            mark = _Mark()
            self._put(mark)
            with Busy(f"securing {self.path.name}") as busy:
                while not mark.wait(_LOOK_S) and self._thread.is_alive():
                    busy.look()
            self._raise_error()
        return self.written

    def note_secured(self) -> None:
        """Note that all frames so far are on disk, as all ranks know."""
        del self._unsecured[:]

    def continue_at(self, count: int) -> None:
        """Continue after the first `count` frames of an earlier process's film, before the first `write`.

        Raises CheckpointError, naming the file and its content, if it has fewer frames or no cut at `count`.
        """
        if self._thread is not None:
            raise MotesError(f"the movie {self.path} is already being written; it can no longer be continued")
        if self._film is not None:
            self._film.close()
            self._film = None
        if self._part is not None:
            self._part.whole = False
        if count > 0:
            _extras.av("Movie")
            where = Path(self.place)
            copy = partial(GrowingFilm.continued, where, self._rate, count)
            self._film = busy_with(f"reading {self.path.name}", copy)
        self.frames = self._written = count
        del self._unsecured[:]
        if not self.closed:
            continuing.hold_movie(self)

    def first_unsaved(self) -> int | None:
        """Return the first frame of the world that is not in the file yet; None if all are."""
        behind = self.written - len(self._unsecured)
        waiting = self._unsecured[max(0, (self._film.frames if self._film else 0) - behind) :]
        return min((index for index in waiting if index != _NO_FRAME), default=None)

    def take_over(self) -> list[int]:
        """Write the film from here on, in place of a lost rank.

        Returns the frames of the world that are missing in the file; pass each to `write_again`. Raises
        CheckpointError if frames that were on disk are missing, too.
        """
        count, unsecured = self.written, self._unsecured[:]
        if self._thread is not None or self.abandoned or count == 0:
            return []
        if self.closed and not partial_path(Path(self.place)).exists():
            return []  # the lost rank has closed it, too
        behind = count - len(unsecured)
        held = GrowingFilm.frames_in(Path(self.place), self._rate, most=count)
        self.continue_at(max(held, behind))
        self._unsecured, self._written = unsecured, count
        missing = unsecured[self.frames - behind :]
        if _NO_FRAME in missing:
            raise MotesError(f"the movie {self.path} lacks pictures that were not frames of the world")
        self._again = deque(missing)
        if self.closed and not missing:
            self._finish_taken_over()
        return list(self._again)

    def write_again(self, index: int, frame: Frame) -> None:
        """Write a frame that the lost rank did not write, as often as the script wrote it."""
        if not self._again:
            return
        while self._again and self._again[0] == index:
            self._again.popleft()
            self._add(frame)
        if self.closed and not self._again:
            self._finish_taken_over()

    def _finish_taken_over(self) -> None:
        """Close a film that the script has closed, but the lost rank has not."""
        try:
            self._finish()
        finally:
            self._end()

    def close_for_lost(self) -> None:
        """Give the film its name, in place of a lost rank, whose frames are on disk."""
        self._end()
        self.take_over()

    # --- the background thread

    def _start(self, shape: tuple[int, ...], index: int | None) -> None:
        if self._film is None and self._written is None and self.written > 0:
            self.continue_at(self.written)
        _extras.av("Movie")  # here, not in the thread: a library may not begin in two threads at once
        height, width, _ = shape
        suffix = self.path.suffix.lower()
        kind, codec = FORMATS.get(suffix, "matroska"), "libx264"
        if suffix not in FORMATS or suffix == ".webm":
            codec = "libvpx-vp9" if suffix == ".webm" else "libx264rgb"
        encoding = Encoding(kind, height, width, self._rate, self._crf, self._preset, codec)
        self._shape = shape
        if self._part is not None:
            self._part.begin(index, encoding.frames)
        film = self._film = self._film or GrowingFilm(Path(self.place), self._rate)
        if suffix not in FORMATS or self._kilobytes is not None:
            film.write_whole = Finishing(self.path, encoding, self._kilobytes)
        # A daemon: a thread that the interpreter waits for would keep a failed rank, and the job, alive.
        self._thread = threading.Thread(
            target=self._encode, args=(encoding, film), name=f"movie {self.path.name}", daemon=True
        )
        self._thread.start()
        _open_films.add(self)

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
        self.closed = True
        _open_films.discard(self)
        continuing.forget_movie(self)

    def abandon(self) -> None:
        """Keep the partial film, including queued frames as far as they are encoded within a second."""
        self.abandoned = True
        self._end()
        if self._thread is None:
            if self._film is not None:
                self._film.close()
            return
        with contextlib.suppress(queue.Full):  # if the queue is full, the thread is not waiting for it
            self._queue.put_nowait(None)
        self._thread.join(_ABANDON_S)

    def _next(self) -> NDArray[np.uint8] | _Mark | None:
        """Return the next item of the queue; None at the film's end."""
        if not self.abandoned:
            return self._queue.get()
        try:
            return self._queue.get_nowait()
        except queue.Empty:
            return None

    def _encode(self, encoding: Encoding, film: GrowingFilm) -> None:
        """Run the background thread: encode all frames, then give the film its name."""
        try:
            with contextlib.closing(film):
                film.open()
                self._encode_into(film, encoding)
                if self._part is not None and not self.abandoned:
                    self._part.write(film.target, encoding, film.frames)
                if not self.abandoned:
                    film.finish()
        except BaseException as error:
            self._error = error

    def _encode_into(self, film: GrowingFilm, encoding: Encoding) -> None:
        part, before = self._part, 0 if self._part is None else self._part.before
        segment: Segment | None = None

        def end_segment() -> None:
            nonlocal segment
            if segment is None:
                return
            film.append(*segment.finish(), segment.frames)
            segment = None

        while (item := self._next()) is not None:
            cuts = isinstance(item, _Mark)
            if isinstance(item, _Mark):
                end_segment()
                film.sync()
                item.set()
            else:
                if segment is None:
                    segment = Segment(encoding, first=film.frames, number=film.segments + 1)
                segment.add(item)
                if part is not None:
                    part.add(item)
                if cuts := (before + film.frames + segment.frames) % encoding.frames == 0:
                    end_segment()
            if part is not None and cuts:
                part.end_segment(film.frames)
        end_segment()


class _Mark(threading.Event):
    """An item of the queue that is set once all frames before it are on disk."""


def _pixels(frame: Frame | NDArray[np.uint8]) -> NDArray[np.uint8]:
    allowed = "a Frame or uint8 (height, width, 3)"
    try:
        pixels: NDArray[np.uint8] = np.asarray(frame.pixels if isinstance(frame, Frame) else frame)
    except Exception:  # of any kind: this runs methods of users' classes
        raise ArgumentError("frame", frame, allowed) from None
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
        raise ArgumentError("frame", f"{pixels.dtype} {pixels.shape}", allowed)
    return pixels


_open_films: weakref.WeakSet[FilmWriter] = weakref.WeakSet()


@atexit.register
def _close_open_films() -> None:
    """Close films that the script left open; keep them partial if it left in the middle of a run."""
    for film in list(_open_films):
        if process.running:
            film.abandon()
            continue
        try:
            film.close()
        except Exception as error:
            print(f"motes: {error}", file=sys.stderr)
