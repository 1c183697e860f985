"""PNG pictures with only the standard library: one pass, no filter, fastest compression."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["encode"]

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_RGB = struct.pack(">4B", 2, 0, 0, 0)  # RGB, deflate, the filters of PNG, not interlaced
_PERCEPTUAL = b"\x00"  # rendering intent of the sRGB chunk


def encode(pixels: NDArray[np.uint8] | NDArray[np.uint16], *, level: int = 1) -> bytes:
    """Encode sRGB pixels, uint8 or uint16 (height, width, 3), as a PNG file of 8 or 16 bits.

    No filter: pictures of small particles are noise, which filters make larger and slower to encode.
    """
    array: NDArray[Any] = np.asarray(pixels)
    if array.dtype not in (np.uint8, np.uint16) or array.ndim != 3 or array.shape[2] != 3 or 0 in array.shape:
        raise ValueError(
            f"pixels must be uint8 or uint16 (height, width, 3), got {array.dtype} {array.shape}"
        )
    height, width, _ = array.shape
    wide = array.astype(array.dtype.newbyteorder(">"), copy=False)
    rows = np.empty((height, 1 + 3 * width * array.itemsize), np.uint8)
    rows[:, 0] = 0  # filter type "none" of each row
    rows[:, 1:] = np.ascontiguousarray(wide).reshape(height, 3 * width).view(np.uint8)
    header = struct.pack(">2IB", width, height, 8 * array.itemsize) + _RGB
    return b"".join(
        (
            _SIGNATURE,
            _chunk(b"IHDR", header),
            _chunk(b"sRGB", _PERCEPTUAL),
            _chunk(b"IDAT", zlib.compress(rows.data, level)),
            _chunk(b"IEND", b""),
        )
    )


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(data, zlib.crc32(name)))
