"""Encodes small pictures for notebooks, which are saved with them, by whichever package is installed."""

from __future__ import annotations

import contextlib
import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._io import png
from ..errors import MissingExtraError

__all__ = ["still"]

MOST_WIDTH = 960  # pixels; wider pictures are divided by 2, 3, ...
MOST_WIDTH_PNG = 480  # without a JPEG encoder
MOST_BYTES = 120_000
QUALITIES = (85, 65, 40, 20)  # tried in turn until the file is small enough


def still(pixels: NDArray[np.uint8]) -> tuple[int, str, bytes]:
    """Shrink a picture; return its width, its MIME type and its file, of about 0.1 MB as JPEG."""
    encode = _encoder()
    if encode is None:
        small = _smaller(pixels, MOST_WIDTH_PNG)
        return small.shape[1], "image/png", png.encode(small, level=6)
    small = _smaller(pixels, MOST_WIDTH)
    for quality in QUALITIES:
        data = encode(small, quality)
        if len(data) <= MOST_BYTES:
            break
    return small.shape[1], "image/jpeg", data


def _smaller(pixels: NDArray[np.uint8], most: int) -> NDArray[np.uint8]:
    """Shrink a picture to at most `most` pixels of width by averaging squares of pixels."""
    height, width, _ = pixels.shape
    n = min(-(-width // most), height)
    if n <= 1:
        return np.ascontiguousarray(pixels)
    whole = pixels[: height // n * n, : width // n * n]
    squares = whole.reshape(height // n, n, width // n, n, 3)
    mean: NDArray[np.uint8] = (squares.sum(axis=(1, 3), dtype=np.uint32) // (n * n)).astype(np.uint8)
    return mean


def _encoder() -> Any:
    """Return a function of pixels and quality that makes a JPEG file; None if no encoder is installed."""
    for package, encode in ((_extras.simplejpeg, _by_simplejpeg), (_extras.pillow, _by_pillow)):
        with contextlib.suppress(MissingExtraError):
            package()
            return encode
    return None


def _by_simplejpeg(pixels: NDArray[np.uint8], quality: int) -> bytes:
    data: bytes = _extras.simplejpeg().encode_jpeg(
        pixels, quality=quality, colorspace="RGB", colorsubsampling="420"
    )
    return data


def _by_pillow(pixels: NDArray[np.uint8], quality: int) -> bytes:
    file = io.BytesIO()
    _extras.pillow().fromarray(pixels).save(file, "JPEG", quality=quality)
    return file.getvalue()
