"""A segment: about a second of film, encoded independently of the rest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import containers

__all__ = ["Encoding", "Segment", "picture"]

# The bits depend on the number of threads, so it must not depend on the machine.
_THREADS = 4
_SPEEDS = {"ultrafast": 8, "superfast": 6, "veryfast": 5, "faster": 4, "fast": 3}
# Above this rate, Matroska's times, in ms, do not separate frames; packets must then be in display order.
_COARSE_FPS = 400


@dataclass(frozen=True)
class Encoding:
    """How a film is encoded."""

    kind: str
    """A value of `containers.FORMATS`."""
    height: int
    width: int
    rate: Fraction
    """Frames per second."""
    crf: float
    preset: str
    codec: str = "libx264"
    """"libx264"; "libvpx-vp9" for .webm; "libx264rgb", without loss, for what becomes a loop."""

    @property
    def frames(self) -> int:
        """The most frames of a segment."""
        return max(1, round(self.rate))

    def add_stream(self, container: Any) -> Any:
        """Add a stream with its own encoder to an output."""
        options = {"crf": str(self.crf), "preset": self.preset}
        if self.codec == "libvpx-vp9":  # whose scale of quality reaches 63
            speed = _SPEEDS.get(self.preset, 2)
            options = {"crf": str(min(63, round(self.crf * 63 / 51))), "b": "0", "cpu-used": str(speed)}
            options |= {"deadline": "good", "auto-alt-ref": "0"}
        if self.kind == "matroska" and self.rate > _COARSE_FPS:
            options["bf"] = "0"
        lossless = self.codec == "libx264rgb"
        if lossless:
            options["crf"] = "0"
        stream = container.add_stream(self.codec, rate=self.rate, options=options)
        odd = 0 if lossless else 1
        stream.width = self.width + odd * (self.width % 2)
        stream.height = self.height + odd * (self.height % 2)
        stream.pix_fmt = "rgb24" if lossless else "yuv420p"
        context = stream.codec_context
        context.thread_type, context.thread_count = "FRAME", _THREADS
        context.time_base = 1 / self.rate
        if lossless:
            return stream
        # Declare the colour space (BT.709, limited range); otherwise players guess it from the size of the
        # picture.
        context.colorspace = context.color_primaries = context.color_trc = context.color_range = 1
        return stream


class Segment:
    """Encodes frames into one segment. The bits depend only on these frames and the encoding."""

    def __init__(self, encoding: Encoding, *, first: int, number: int) -> None:
        """Start a segment; `first`: its first frame in the film; `number`: the segment's number, from 1."""
        self._encoding = encoding
        self._first = first
        self._file = containers.SegmentFile(encoding.kind, number)
        self._stream = encoding.add_stream(self._file.container)
        self.frames = 0
        self._packets: list[Any] = []

    def add(self, pixels: NDArray[np.uint8]) -> None:
        """Encode a frame."""
        lossless = self._encoding.codec == "libx264rgb"
        shown = unchanged(pixels) if lossless else picture(pixels)
        shown.pts = self.frames  # counts from 0 in each segment, so the bits do not depend on its position
        self.frames += 1
        self._packets += self._stream.encode(shown)

    def finish(self) -> tuple[bytes, bytes]:
        """Return the head of a film that begins with this segment, and the segment's bytes."""
        self._packets += self._stream.encode(None)
        for packet in containers.numbered(
            self._packets, list(self._shown()), first=self._first, rate=self._encoding.rate
        ):
            self._file.container.mux(packet)
        self._packets = []
        return self._file.finish()

    def _shown(self) -> Iterator[int]:
        for packet in self._packets:
            yield self._first + packet.pts


def unchanged(pixels: NDArray[np.uint8]) -> Any:
    """Wrap a picture for an encoder without loss."""
    import av

    return av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")


def picture(pixels: NDArray[np.uint8]) -> Any:
    """Convert to 4:2:0, which needs even sides: repeat the last row or column of an odd side."""
    import av

    height, width, _ = pixels.shape
    if height % 2 or width % 2:
        pixels = np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")
    # Names instead of members of PyAV's enumerations: PyAV 14 accepts only names; other versions accept both.
    return frame.reformat(format="yuv420p", dst_colorspace="ITU709", dst_color_range="MPEG")
