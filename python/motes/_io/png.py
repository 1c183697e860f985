"""PNG pictures with only the standard library: one pass, no filter, fastest compression."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["encode"]

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_KINDS = {3: 2, 4: 6}  # RGB, RGBA
_PLAIN = bytes(3)  # deflate, the filters of PNG, not interlaced
_PERCEPTUAL = b"\x00"  # rendering intent of the sRGB chunk


def encode(pixels: NDArray[np.uint8] | NDArray[np.uint16], *, level: int = 1) -> bytes:
    """Encode sRGB pixels, uint8 or uint16 (height, width, 3 or 4), as a PNG file of 8 or 16 bits.

    No filter: pictures of small particles are noise, which filters make larger and slower to encode.
    """
    array: NDArray[Any] = np.asarray(pixels)
    if (
        array.dtype not in (np.uint8, np.uint16)
        or array.ndim != 3
        or array.shape[2] not in _KINDS
        or 0 in array.shape
    ):
        allowed = "uint8 or uint16 (height, width, 3 or 4)"
        raise ValueError(f"pixels must be {allowed}, got {array.dtype} {array.shape}")
    height, width, channels = array.shape
    wide = array.astype(array.dtype.newbyteorder(">"), copy=False)
    rows = np.empty((height, 1 + channels * width * array.itemsize), np.uint8)
    rows[:, 0] = 0  # filter type "none" of each row
    rows[:, 1:] = np.ascontiguousarray(wide).reshape(height, channels * width).view(np.uint8)
    header = struct.pack(">2IB", width, height, 8 * array.itemsize) + bytes([_KINDS[channels]]) + _PLAIN
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
