"""Containers of films: head and body of a fragmented file, and reading and writing its packets.

A fragmented file is a head, which describes the encoding, followed by segments. A segment is first written in
memory as a small file, whose body is then appended to the film.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["FORMATS", "LOOPS", "SegmentFile", "copy_whole", "extradata", "groups", "numbered", "pixels_of"]

FORMATS = {".mp4": "mp4", ".mkv": "matroska", ".mov": "mov", ".webm": "webm"}
"""Suffixes of films -> FFmpeg's names of their formats."""

LOOPS = (".gif", ".webp")
"""Suffixes of loops, which are written at the end, from a film without loss."""

_DELAY = 2
"""Frames by which decoding precedes display, as H.264 with a pyramid of B-frames needs."""

_EBML = ("matroska", "webm")
_CLUSTER = 0x1F43B675
_SEGMENT = 0x18538067


class SegmentFile:
    """A file in memory that turns the packets of one segment into bytes."""

    def __init__(self, kind: str, number: int) -> None:
        """Open the file; `kind`: a value of FORMATS; `number`: the segment's number in the film, from 1."""
        import av

        self._kind = kind
        self._buffer = io.BytesIO()
        options = {"live": "1"}
        if kind not in _EBML:
            # A head with an edit list, which needs the first packet; continuous time over segments; no index.
            flags = "frag_custom+empty_moov+delay_moov+default_base_moof+frag_discont+skip_trailer"
            options = {"movflags": flags, "fragment_index": str(number)}
        self.container: Any = av.open(self._buffer, "w", format=kind, container_options=options)

    def finish(self) -> tuple[bytes, bytes]:
        """Return the head of a film that begins with this segment, and the segment."""
        self.container.close()
        data = self._buffer.getvalue()
        at = _body_of_matroska(data) if self._kind in _EBML else _body_of_mp4(data)
        return data[:at], data[at:]


def _body_of_mp4(data: bytes) -> int:
    """Return the offset of the first fragment: a box "moof", after "ftyp" and "moov"."""
    at = 0
    while at + 8 <= len(data) and data[at + 4 : at + 8] != b"moof":
        size = int.from_bytes(data[at : at + 4], "big")
        at += size if size >= 8 else len(data)
    return min(at, len(data))


def _body_of_matroska(data: bytes) -> int:
    """Return the offset of the first cluster."""
    at = 0
    while at < len(data):
        name, start = _number(data, at, marker=True)
        size, start = _number(data, start, marker=False)
        if name == _CLUSTER:
            return at
        at = start if name == _SEGMENT else start + size
    return len(data)


def _number(data: bytes, at: int, *, marker: bool) -> tuple[int, int]:
    """Read an EBML number; return it, with its length marker (its highest bit) or without, and its end."""
    length = 9 - data[at].bit_length()
    value = int.from_bytes(data[at : at + length], "big")
    return value if marker else value & ((1 << 7 * length) - 1), at + length


def numbered(packets: Iterable[Any], shown: Iterable[int], *, first: int, rate: Fraction) -> Iterator[Any]:
    """Set the times of packets given in decoding order; `shown`: the film's frame of each packet.

    `first`: the number of the first packet within the film.
    """
    for count, (packet, frame) in enumerate(zip(packets, shown, strict=True), first):
        packet.time_base = 1 / rate
        packet.pts, packet.dts, packet.duration = frame, count - _DELAY, 1
        yield packet


def groups(container: Any) -> Iterator[tuple[list[Any], list[int]]]:
    """Yield a film's independently decodable groups: packets, and each packet's frame in the group.

    Ends where the film was cut off or becomes unreadable.
    """
    packets: list[Any] = []
    for packet in _readable(container):
        if packet.is_keyframe and packets:
            yield packets, _order(packets)
            packets = []
        if packet.is_keyframe or packets:
            packets.append(packet)
    if packets and _is_whole(packets, container.streams.video[0].average_rate):
        yield packets, _order(packets)


def _readable(container: Any) -> Iterator[Any]:
    import av

    with contextlib.suppress(av.FFmpegError):
        for packet in container.demux(container.streams.video[0]):
            if packet.size == 0:  # PyAV's mark of the end
                continue
            if packet.is_corrupt or packet.pts is None:
                return
            yield packet


def _order(packets: list[Any]) -> list[int]:
    """Return each packet's frame in the group, from the order of times only: some clocks are coarse."""
    by_time = sorted(range(len(packets)), key=lambda number: packets[number].pts)
    order = [0] * len(packets)
    for frame, number in enumerate(by_time):
        order[number] = frame
    return order


def _is_whole(packets: list[Any], rate: Fraction | None) -> bool:
    """Return whether no frame is missing in the group."""
    if len(packets) == 1 or rate is None:
        return True
    tick: Fraction = packets[0].time_base
    times = [packet.pts * tick for packet in packets]
    missing: Fraction = (max(times) - min(times)) * rate - (len(packets) - 1)
    return abs(missing) < Fraction(1, 2) + rate * tick


def copy_stream(container: Any, source: Any, rate: Fraction) -> Any:
    """Add a stream for packets of `source` to an output, with a time base of one frame."""
    stream = container.add_stream_from_template(source)
    stream.time_base, stream.codec_context.framerate = 1 / rate, rate
    return stream


def copy_whole(source: IO[bytes], draft: Path, kind: str, rate: Fraction) -> int:
    """Write the packets of a fragmented film into a regular file, with an index; return their number."""
    import av

    options = {} if kind in _EBML else {"movflags": "+faststart"}  # plays before it is fully loaded
    count = 0
    with (
        av.open(source, "r", format=kind) as film,
        av.open(str(draft), "w", format=kind, container_options=options) as container,
    ):
        stream = copy_stream(container, film.streams.video[0], rate)
        for packets, order in groups(film):
            for packet in numbered(packets, (count + frame for frame in order), first=count, rate=rate):
                packet.stream = stream
                container.mux(packet)
            count += len(packets)
    return count


def pixels_of(frame: Any) -> NDArray[np.uint8]:
    """Return a decoded frame as sRGB, uint8 (height, width, 3)."""
    if frame.format.is_rgb:
        pixels: NDArray[np.uint8] = frame.to_ndarray(format="rgb24")
        return pixels
    shown = frame.reformat(format="rgb24", src_colorspace="ITU709", src_color_range="MPEG")
    pixels = shown.to_ndarray()
    return pixels


def extradata(data: IO[bytes], kind: str) -> bytes:
    """Return the codec's extradata in a film's head, which is the same for all segments."""
    import av

    with av.open(data, "r", format=kind) as film:
        return bytes(film.streams.video[0].codec_context.extradata or b"")
