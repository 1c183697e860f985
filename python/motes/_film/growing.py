"""A film while it is written: a file beside its target that is playable even if the process is killed.

`film.mp4` grows as `film.partial.mp4`. It consists of segments, each appended in one piece: a killed process
leaves all of them complete, except perhaps the last one, which players then ignore.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import IO, Any, Self

from .._io import files
from ..errors import CheckpointError
from . import containers

__all__ = ["GrowingFilm", "partial_path"]

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_PATIENCE_S = 10.0
_LOOK_S = 0.05
_READ = os.O_RDONLY | getattr(os, "O_CLOEXEC", 0)


def partial_path(target: Path) -> Path:
    """Return the path of a film while it is written; a loop grows as a film without loss."""
    suffix = ".mkv" if target.suffix.lower() in containers.LOOPS else target.suffix
    return target.with_name(f"{target.stem}.partial{suffix}")


class GrowingFilm:
    """The partial file of a film; it appears with its first segment and replaces an earlier run's."""

    def __init__(self, target: Path, rate: Fraction, *, hidden: bool = False) -> None:
        """Store the finished film's path and its frames per second; write nothing yet.

        `hidden`: there is no partial file, only the finished one.
        """
        self.target = target
        self.path = partial_path(target)
        self.frames = 0
        """The number of frames in the file."""
        self.segments = 0
        self._kind = containers.FORMATS[self.path.suffix.lower()]
        self.write_whole: Callable[[IO[bytes], Path], int] | None = None
        """Writes the draft of the finished film and returns its frames; None: it gets an index."""
        self._rate = rate
        self._hidden = hidden
        self._draft: Path | None = None
        self._file = -1
        self._bytes = 0
        self._extradata: bytes | None = None
        """The extradata of the film that is continued, which this process's must equal."""

    def open(self) -> None:
        """Create the file, with a hidden name until it has content. Raises OSError if that fails."""
        if self._file >= 0:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        for path in (self.target, self.path):
            files.sweep(path)
        self._draft, self._file = files.make_draft(self.path)

    def append(self, head: bytes, segment: bytes, frames: int) -> None:
        """Append a segment, which then survives a kill of the process. Raises OSError if writing fails."""
        if self._extradata is not None:
            self._check_encoding(head + segment)
        self._put(head, segment)
        if self._draft is not None and not self._hidden:
            self._show()
        self._count(frames)  # last, so that counted frames are always in the file

    def sync(self) -> None:
        """Wait until all segments so far are on disk."""
        if self._file >= 0:
            os.fsync(self._file)
            files.sync(self.path.parent)

    def finish(self) -> None:
        """Write the finished film, with an index, and remove the partial file.

        If this fails, the partial file stays.
        """
        if self.frames == 0:
            return self.close()
        with files.whole_path(self.target, remove_abandoned=True) as draft:
            with self._reader() as source:
                if self.write_whole is None:
                    frames = containers.copy_whole(source, draft, self._kind, self._rate)
                else:
                    frames = self.write_whole(source, draft)
            if frames != self.frames:
                raise OSError(
                    errno.EIO, f"{frames} of {self.frames} frames could be read back", str(self.path)
                )
        with contextlib.suppress(OSError):
            # Another run may have replaced the partial file by its own.
            if os.path.samestat(os.fstat(self._file), os.lstat(self.path)):
                self.path.unlink()
        self.close()

    def close(self) -> None:
        """Close the partial file and keep it; do nothing if it is closed."""
        file, self._file = self._file, -1
        if file >= 0:
            os.close(file)
        if self._draft is not None:  # still hidden: it has no complete segment
            with contextlib.suppress(OSError):
                self._draft.unlink()
            self._draft = None

    def _put(self, head: bytes, segment: bytes) -> None:
        self._write(head + segment if self.segments == 0 else segment)

    def _count(self, frames: int) -> None:
        self.frames += frames
        self.segments += 1

    def _write(self, data: bytes) -> None:
        left = memoryview(data)
        try:
            while left:
                left = left[os.write(self._file, left) :]
        except OSError:
            with contextlib.suppress(OSError):  # cut off the incomplete segment
                os.ftruncate(self._file, self._bytes)
            raise
        self._bytes += len(data)

    def _show(self) -> None:
        """Give the file its visible name."""
        assert self._draft is not None
        os.replace(self._draft, self.path)
        self._draft = None

    def _reader(self) -> IO[bytes]:
        """Open this file for reading, even if another file has its name by now."""
        reader = os.fdopen(os.dup(self._file), "rb")
        reader.seek(0)
        return reader

    # --- continuing an earlier process's film

    @classmethod
    def continued(cls, target: Path, rate: Fraction, frames: int) -> Self:
        """Continue an earlier process's film, partial or finished, after its first `frames` frames.

        Later frames are dropped. Raises CheckpointError, naming the file and its content, if that fails.
        """
        film = cls(target, rate)
        path = film.path if film.path.exists() or target.suffix.lower() in containers.LOOPS else target
        try:
            source = os.fdopen(os.open(path, _READ), "rb")
        except OSError as error:
            why = error.strerror or str(error)
            if isinstance(error, FileNotFoundError):
                why = f"neither {film.path} nor {target.name} exists"
            raise _lost(target, frames, why) from error
        with source:
            if not _lock(source.fileno()):
                raise _lost(target, frames, f"another process is writing {path}")
            try:
                film._take(source, path, frames)
            except BaseException:
                film.close()
                raise
        return film

    @classmethod
    def frames_in(cls, target: Path, rate: Fraction, *, most: int) -> int:
        """Return the number of frames of an earlier process's film up to its last cut at or before `most`."""
        import av

        film, count = cls(target, rate), 0
        path = film.path if film.path.exists() else target
        with (
            contextlib.suppress(FileNotFoundError, av.FFmpegError),
            av.open(str(path), "r", format=film._kind) as earlier,
        ):
            for packets, _ in containers.groups(earlier):
                if count + len(packets) > most:
                    break
                count += len(packets)
        return count

    def _take(self, source: IO[bytes], path: Path, frames: int) -> None:
        import av

        self.open()
        kind = self._kind
        try:
            with av.open(source, "r", format=kind) as earlier:
                self.take_groups(earlier, 0, frames)
            source.seek(0)
            self._extradata = containers.extradata(source, kind)
        except (av.FFmpegError, OSError, IndexError, ValueError) as error:
            if getattr(error, "errno", None) in _FULL:
                raise
            holds = f"{path} is damaged after frame {self.frames}: {error}"
            raise _lost(self.target, frames, holds) from error
        if self.frames != frames:
            raise _lost(self.target, frames, f"{path} {self._held(path, frames)}")
        os.fsync(self._file)
        self._show()
        files.sync(self.path.parent)

    def take_groups(self, earlier: Any, first: int, end: int) -> None:
        """Append the groups of packets of a film that have only frames `first` to `end` - 1."""
        position = 0
        for packets, order in containers.groups(earlier):
            start, position = position, position + len(packets)
            if position > end:
                break
            if start < first:
                continue
            segment = containers.SegmentFile(self._kind, self.segments + 1)
            stream = containers.copy_stream(segment.container, earlier.streams.video[0], self._rate)
            shown = (self.frames + frame for frame in order)
            for packet in containers.numbered(packets, shown, first=self.frames, rate=self._rate):
                packet.stream = stream
                segment.container.mux(packet)
            self._put(*segment.finish())
            self._count(len(packets))

    def _held(self, path: Path, frames: int) -> str:
        """Describe a film that has no cut after the requested number of frames."""
        import av

        count, cuts = 0, [0]
        with av.open(str(path), "r", format=self._kind) as film:
            for packets, _ in containers.groups(film):
                count += len(packets)
                cuts.append(count)
        before = max(cut for cut in cuts if cut <= frames)
        return f"holds {count} frames, and can be cut only after {before} of them"

    def _check_encoding(self, film: bytes) -> None:
        """Raise CheckpointError if this process encodes differently from the earlier one."""
        known, self._extradata = self._extradata, None
        if containers.extradata(io.BytesIO(film), self._kind) != known:
            raise CheckpointError(
                f"the movie {self.target} cannot be continued in {self.path}: its first {self.frames} frames "
                "have a different size, rate, quality or preset, or are from another version of the encoder"
            )


def _lock(file: int) -> bool:
    """Lock a film; wait a while for a killed process; return False if another process keeps it locked."""
    limit = time.monotonic() + _PATIENCE_S
    while files.is_locked_elsewhere(file):
        if time.monotonic() > limit:
            return False
        time.sleep(_LOOK_S)
    return True


def _lost(target: Path, frames: int, why: str) -> CheckpointError:
    return CheckpointError(f"the movie {target} cannot be continued after its first {frames} frames: {why}")
