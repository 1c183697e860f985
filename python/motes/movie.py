"""Movie: frames into an H.264 file, encoded by a background thread while the next frame is computed."""

from __future__ import annotations

import atexit
import contextlib
import os
import queue
import sys
import threading
import weakref
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from . import _extras, arguments
from ._io import files
from ._run.busy import Busy
from ._run.process import process
from .errors import ArgumentError, MotesError
from .frame import Frame

__all__ = ["Movie"]

_FORMATS = {".mp4": "mp4", ".mkv": "matroska", ".mov": "mov"}
_PRESETS = ("ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow")
_QUEUE_FRAMES = 4  # enough to smooth over a slow frame; more would only hold memory
_LOOK_S = 0.1
_ABANDON_S = 1.0  # how long leaving by an exception waits for the frame being encoded


class Movie:
    """A movie file that is complete or does not exist.

    Construct it on every rank: where frames are falsy it touches no file, so a script need not test its rank.
    Without a frame no file appears. Leaving the `with` block by an exception removes what was written.
    """

    def __init__(
        self, path: str | os.PathLike[str], *, fps: float = 24, crf: float = 18, preset: str = "superfast"
    ) -> None:
        """Name the file (.mp4, .mkv, .mov); smaller `crf`, slower `preset` look better and take longer."""
        self.path = arguments.file_path("path", path)
        if self.path.suffix.lower() not in _FORMATS:
            raise ArgumentError("path", os.fspath(path), "a name ending in .mp4, .mkv or .mov")
        self.fps = arguments.number("fps", fps, low=1e-3, high=1e4)
        self.crf = arguments.number("crf", crf, low=0, high=51)
        self.preset = arguments.choice("preset", preset, _PRESETS)
        # Checked here, not when frames arrive, so that every rank gets the same error at the same line.
        _extras.require_av("Movie")
        self.frames = 0
        self._shape: tuple[int, ...] | None = None
        self._thread: threading.Thread | None = None
        self._queue: queue.Queue[NDArray[np.uint8] | None] = queue.Queue(_QUEUE_FRAMES)
        self._error: BaseException | None = None
        self._closed = False
        self._abandoned = False

    def write(self, frame: Frame | NDArray[np.uint8]) -> None:
        """Append a frame; waits while four are queued. Does nothing for a frame that lives on another rank.

        An error of the encoder is raised here, at the next call, or by `close`.
        """
        if self._closed:
            raise MotesError(f"the movie {self.path} is closed")
        if isinstance(frame, Frame) and not frame:
            return
        self._raise_error()
        try:
            pixels: NDArray[np.uint8] = np.asarray(frame.pixels if isinstance(frame, Frame) else frame)
        except Exception:  # any: this runs methods of users' classes
            raise ArgumentError("frame", frame, "a Frame or uint8 (height, width, 3)") from None
        if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
            allowed = "a Frame or uint8 (height, width, 3)"
            raise ArgumentError("frame", f"{pixels.dtype} {pixels.shape}", allowed)
        if self._shape is None:
            self._start(pixels.shape)
        elif pixels.shape != self._shape:
            raise ArgumentError("frame", pixels.shape, f"of the size of the first frame, {self._shape}")
        # A caller's own array may change while it waits in the queue; a frame's pixels cannot.
        self._put(pixels if isinstance(frame, Frame) else pixels.copy())
        self.frames += 1

    def close(self) -> None:
        """Encode what is queued and give the file its name. Calling it again does nothing."""
        if self._closed:
            return
        self._closed = True
        _open_movies.discard(self)
        if self._thread is None:
            return
        try:
            self._put(None)
            with Busy(f"closing {self.path.name}") as busy:
                while self._thread.is_alive():
                    self._thread.join(_LOOK_S)
                    busy.look()
        except BaseException:
            self._abandon()
            raise
        self._raise_error()

    def __enter__(self) -> Self:
        """Return the movie itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the movie, or remove it when the block failed."""
        if kind is None:
            self.close()
        else:
            self._abandon()

    def __repr__(self) -> str:
        """Name the file and what is in it."""
        return f"<Movie {str(self.path)!r} {self.frames} frames at {self.fps:g} per second>"

    def _start(self, shape: tuple[int, ...]) -> None:
        self._shape = shape
        # A daemon: a thread the interpreter waits for would keep a failed rank alive, and with it the whole
        # job.
        self._thread = threading.Thread(target=self._encode, name=f"movie {self.path.name}", daemon=True)
        self._thread.start()
        _open_movies.add(self)

    def _put(self, item: NDArray[np.uint8] | None) -> None:
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
            self._closed = True
            _open_movies.discard(self)
            raise MotesError(f"the movie {self.path} could not be written: {error}") from error

    def _abandon(self) -> None:
        self._closed = self._abandoned = True
        _open_movies.discard(self)
        if self._thread is None:
            return
        while True:  # room for the end mark, so that the thread wakes even if it waits for a frame
            try:
                self._queue.put_nowait(None)
                break
            except queue.Full:
                try:
                    self._queue.get_nowait()
                except queue.Empty:
                    continue
        self._thread.join(_ABANDON_S)

    def _encode(self) -> None:
        """Work of the background thread, from the first frame to the rename."""
        try:
            with files.whole_path(self.path, remove_abandoned=True) as draft:
                self._encode_into(draft)
        except _Abandoned:
            pass
        except BaseException as error:
            self._error = error

    def _encode_into(self, draft: Path) -> None:
        import av

        assert self._shape is not None
        kind = _FORMATS[self.path.suffix.lower()]
        options = {} if kind == "matroska" else {"movflags": "+faststart"}  # plays before it is loaded whole
        with av.open(str(draft), "w", format=kind, container_options=options) as container:
            stream = self._stream(container)
            count = 0
            while (pixels := self._queue.get()) is not None and not self._abandoned:
                picture = _picture(pixels)
                picture.pts = count
                count += 1
                container.mux(stream.encode(picture))
            if self._abandoned:
                raise _Abandoned
            container.mux(stream.encode(None))

    def _stream(self, container: Any) -> Any:
        assert self._shape is not None
        height, width, _ = self._shape
        rate = Fraction(self.fps).limit_denominator(60000)
        options = {"crf": str(self.crf), "preset": self.preset}
        stream = container.add_stream("libx264", rate=rate, options=options)
        stream.width, stream.height = width + width % 2, height + height % 2
        stream.pix_fmt = "yuv420p"
        context = stream.codec_context
        context.time_base = 1 / rate
        # Declare the colour space (BT.709, limited range); otherwise players guess it from the size of the
        # picture.
        context.colorspace = context.color_primaries = context.color_trc = context.color_range = 1
        return stream


class _Abandoned(Exception):
    pass


def _picture(pixels: NDArray[np.uint8]) -> Any:
    """Convert to 4:2:0, where both sides must be even: an odd one repeats its last row or column."""
    import av

    height, width, _ = pixels.shape
    if height % 2 or width % 2:
        pixels = np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")
    # Names, not members of PyAV's enumerations: PyAV 14 takes only names, and all others take both.
    return picture.reformat(format="yuv420p", dst_colorspace="ITU709", dst_color_range="MPEG")


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
