"""Write the finished file of a film: with an index, as a loop, or with at most so many bytes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, partial
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from ..errors import MotesError
from .containers import LOOPS, copy_whole, pixels_of
from .segment import Encoding, picture

__all__ = ["Finishing"]

Pixels = NDArray[np.uint8]
_SCALES = (1.0, 0.75, 0.5, 0.35, 0.25)
_MOST_CRF = 40
_LEAST_QUALITY = 20
_COLORS = (256, 128, 64, 32)
_MOST_KEPT = 256 << 20  # bytes of decoded pictures
_SAMPLES = 16  # pictures from which a GIF's palette is made


class Finishing:
    """Turns the growing film into the finished one."""

    def __init__(self, target: Path, encoding: Encoding, kilobytes: float | None) -> None:
        """Store how the growing film is encoded, and the most bytes of the finished one."""
        self._target = target
        self._suffix = target.suffix.lower()
        self._encoding = encoding
        self._most = None if kilobytes is None else int(kilobytes * 1000)

    def __call__(self, source: IO[bytes], draft: Path) -> int:
        """Write the draft of the finished film; return its number of frames.

        Raises MotesError if the film cannot be as small as requested.
        """
        encoding, most = self._encoding, self._most
        if self._suffix not in LOOPS:
            count = copy_whole(source, draft, encoding.kind, encoding.rate)
            if most is None or draft.stat().st_size <= most:
                return count
        frames = _Frames(source, encoding.kind)
        write, levels = self._ways(frames, draft)
        if most is None:
            write(1.0, levels[0])
        else:
            self._fit(write, levels, draft, most)
        return frames.count

    def _ways(self, frames: _Frames, draft: Path) -> tuple[Callable[[float, float], None], Sequence[float]]:
        """Return a function of scale and quality that writes the draft, and its qualities, the best first."""
        encoding = self._encoding
        if self._suffix == ".gif":
            return partial(_write_gif, frames, draft, encoding.rate), _COLORS
        if self._suffix == ".webp":
            best = max(_LEAST_QUALITY, 95 - round(encoding.crf))
            return partial(_write_webp, frames, draft, encoding.rate), range(best, _LEAST_QUALITY - 1, -5)
        crfs = [encoding.crf + step for step in range(1, max(2, int(_MOST_CRF - encoding.crf) + 1))]
        return partial(_write_video, frames, draft, encoding), crfs

    def _fit(
        self, write: Callable[[float, float], None], levels: Sequence[float], draft: Path, most: int
    ) -> None:
        """Choose the largest scale at which the film is small enough, and the best quality there."""
        written = (0.0, 0.0)  # what the draft is

        def size(scale: float, level: float) -> int:
            nonlocal written
            written = scale, level
            write(scale, level)
            return draft.stat().st_size

        for scale in _SCALES:
            if (least := size(scale, levels[-1])) <= most:
                break
        else:
            least_kb = math.ceil(least / 1000)
            raise MotesError(
                f"{self._target} cannot be as small as {most / 1000:g} kilobytes: the least is {least_kb}, "
                "at a quarter of its width; it stays beside it as a partial film"
            )
        good, bad = len(levels) - 1, -1
        while good - bad > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if size(scale, levels[middle]) <= most else (good, middle)
        if written != (scale, levels[good]):
            write(scale, levels[good])


class _Frames:
    """The pictures of a film, which can be read several times; those of a short one are decoded once."""

    def __init__(self, source: IO[bytes], kind: str) -> None:
        self._source = source
        self._kind = kind
        self._kept: list[Pixels] | None = None

    @cached_property
    def count(self) -> int:
        """The number of pictures."""
        self._source.seek(0)
        with _extras.av("Movie").open(self._source, "r", format=self._kind) as film:
            return sum(1 for packet in film.demux(video=0) if packet.size)

    def __iter__(self) -> Iterator[Pixels]:
        if self._kept is not None:
            yield from self._kept
            return
        self._source.seek(0)
        kept: list[Pixels] | None = []
        with _extras.av("Movie").open(self._source, "r", format=self._kind) as film:
            for frame in film.decode(video=0):
                pixels = pixels_of(frame)
                if kept is not None:
                    kept.append(pixels)
                    kept = kept if len(kept) * pixels.nbytes <= _MOST_KEPT else None
                yield pixels
        self._kept = kept

    def images(self, scale: float) -> Iterator[Any]:
        """Yield the pictures as Pillow's images, scaled."""
        image = _extras.pillow(need="a film as .gif or .webp")
        for pixels in self:
            whole = image.fromarray(pixels)
            size = [max(1, round(side * scale)) for side in whole.size]
            yield whole if scale == 1 else whole.resize(size, image.Resampling.LANCZOS)


def _write_gif(frames: _Frames, draft: Path, rate: Fraction, scale: float, colors: float) -> None:
    """Write all frames with one palette, so that colours do not flicker."""
    image = _extras.pillow(need="a film as .gif")
    count = frames.count
    chosen = {round(i * (count - 1) / max(1, _SAMPLES - 1)) for i in range(_SAMPLES)}
    samples = [np.asarray(one)[::2, ::2] for i, one in enumerate(frames.images(scale)) if i in chosen]
    palette = image.fromarray(np.concatenate(samples)).quantize(int(colors))

    def shown() -> Iterator[Any]:
        for one in frames.images(scale):
            yield one.quantize(palette=palette, dither=image.Dither.FLOYDSTEINBERG)

    _save(shown(), draft, "GIF", _durations(count, rate, 10), loop=0, optimize=False)


def _write_webp(frames: _Frames, draft: Path, rate: Fraction, scale: float, quality: float) -> None:
    _save(
        frames.images(scale),
        draft,
        "WEBP",
        _durations(frames.count, rate, 1),
        loop=0,
        quality=int(quality),
        method=4,
    )


def _save(images: Iterator[Any], draft: Path, kind: str, durations: list[int], **options: Any) -> None:
    first = next(images)
    with open(draft, "wb") as file:
        first.save(file, kind, save_all=True, append_images=images, duration=durations, **options)


def _durations(count: int, rate: Fraction, step: int) -> list[int]:
    """Return how long each frame is shown, ms, in multiples of `step`, such that the sum is exact."""
    ends = [round(i * 1000 / rate / step) * step for i in range(count + 1)]
    return [end - start for start, end in zip(ends, ends[1:], strict=False)]


def _write_video(frames: _Frames, draft: Path, encoding: Encoding, scale: float, crf: float) -> None:
    av = _extras.av("Movie")
    height, width = (max(2, round(side * scale / 2) * 2) for side in (encoding.height, encoding.width))
    options = {} if encoding.kind in ("matroska", "webm") else {"movflags": "+faststart"}
    with av.open(str(draft), "w", format=encoding.kind, container_options=options) as container:
        stream = replace(encoding, crf=crf, height=height, width=width).add_stream(container)
        for number, pixels in enumerate(frames):
            shown = picture(pixels)
            if scale != 1:
                shown = shown.reformat(width=width, height=height, interpolation="AREA")
            shown.pts, shown.time_base = number, 1 / encoding.rate
            container.mux(stream.encode(shown))
        container.mux(stream.encode(None))
