"""Pictures on their way to viewers: the newest one only, encoded once for all of them."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._io import png

__all__ = ["Encoded", "Picture", "jpeg", "lossless"]

_HEADER = struct.Struct("<4sIIII")  # magic, number, frame, orders, kind
MAGIC = b"mote"
JPEG, PNG = 0, 1


@dataclass(frozen=True)
class Picture:
    """A picture as the image generator made it."""

    number: int
    """From 1 on: each picture of a run has its own."""
    frame: int
    orders: int
    """How many orders were given before it was made."""
    pixels: NDArray[np.uint8]


@dataclass(frozen=True)
class Encoded:
    """The message that viewers get: 20 bytes, then a file that browsers read.

    The bytes are four 32-bit numbers, little-endian, behind the letters "mote": the picture's number, its
    frame, the orders given before it, and 0 for JPEG, 1 for PNG.
    """

    number: int
    exact: bool
    message: bytes


def jpeg(picture: Picture, quality: int) -> Encoded:
    """Encode as JPEG: two milliseconds, 100 KiB for 1280x720."""
    simplejpeg: Any = _extras.simplejpeg()
    # Halved colours: a viewer who looks closely pauses, and gets the picture without loss.
    data = simplejpeg.encode_jpeg(
        np.ascontiguousarray(picture.pixels), quality=quality, colorspace="RGB", colorsubsampling="420"
    )
    return Encoded(picture.number, False, _head(picture, JPEG) + data)


def lossless(picture: Picture) -> Encoded:
    """Encode as PNG: ten times as long and as large."""
    return Encoded(picture.number, True, _head(picture, PNG) + png.encode(picture.pixels))


def _head(picture: Picture, kind: int) -> bytes:
    return _HEADER.pack(MAGIC, picture.number, picture.frame, picture.orders % 2**32, kind)
