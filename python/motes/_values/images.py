"""Read pictures from files: upright, sRGB with straight alpha, 8 bits per channel."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._values import arguments
from ..errors import ArgumentError
from .colors import LINEAR

__all__ = ["BRIGHTEST", "FORMATS", "MOST_SIDE", "interpolated", "linear_light", "picture_in", "read_picture"]

FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF", "TGA", "PPM")
"""Formats that may be opened; others, such as EPS, would start programs or hold no pixels."""
MOST_SIDE = 8192
"""Largest width and height of a picture of light, pixels."""
BRIGHTEST = 1e6
"""The most light in it, in units of white."""
_OF_16_BITS = ("PNG", "PPM")
"""Formats with at most 16 bits per channel, which Pillow may store as 32-bit integers."""


def read_picture(argument: str, path: Any, *, most: int) -> NDArray[np.uint8]:
    """Read a picture of at most `most` pixels each way by Pillow, as uint8 of shape (height, width, 4).

    A single channel of 16 bits is scaled from 0..65535, one of floats from 0..1. Of an animation, the first
    picture is read. Raises ArgumentError, MissingExtraError.
    """
    _extras.pillow()
    path = arguments.existing_file(argument, path)
    return picture_in(argument, path, most=most)


def linear_light(argument: str, given: Any, allowed: str) -> NDArray[np.float32]:
    """Return an array, uint8 sRGB or linear floats, as light: float32 (height, width, 3), read-only.

    Raises ArgumentError, which says what is `allowed`.
    """
    try:
        array: NDArray[Any] = np.asarray(given)
    except Exception:  # of any kind: this runs methods of users' classes
        raise ArgumentError(argument, given, allowed) from None
    fits = array.ndim == 3 and array.shape[2] in (3, 4) and min(array.shape) > 0
    if not fits or max(array.shape) > MOST_SIDE or not (array.dtype.kind == "f" or array.dtype == np.uint8):
        raise ArgumentError(argument, f"{array.dtype} {array.shape}", allowed)
    if array.dtype == np.uint8:
        array = np.array(LINEAR)[array[:, :, :3]]
    light = np.array(array[:, :, :3], np.float32, order="C")
    if not ((light >= 0) & (light <= BRIGHTEST)).all():
        raise ArgumentError(argument, f"{array.dtype} {array.shape}", f"{allowed}, finite and not negative")
    light.flags.writeable = False
    return light


def picture_in(argument: str, path: Any, *, most: int) -> NDArray[np.uint8]:
    """Read a picture as `read_picture` does, from a path or an open file."""
    library = _extras.pillow()
    name = os.fspath(path) if isinstance(path, os.PathLike) else "a picture"
    sides = f"1..{most} pixels each way"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", library.DecompressionBombWarning)  # our own limit is lower
            with library.open(path, formats=FORMATS) as picture:
                width, height = picture.size
                if max(width, height) > most:  # refused before it takes memory
                    allowed = f"a picture of {sides} (this one has {width}x{height})"
                    raise ArgumentError(argument, name, allowed)
                return _bytes(picture)
    except ArgumentError:
        raise
    except library.DecompressionBombError as error:  # Pillow does not report the size
        raise ArgumentError(argument, name, f"a picture of {sides} ({error})") from None
    except library.UnidentifiedImageError:
        allowed = f"a picture that can be read: {', '.join(FORMATS)}"
        raise ArgumentError(argument, name, allowed) from None
    except Exception as error:  # of any kind: each format raises different ones
        raise ArgumentError(argument, name, f"a picture that can be read ({error})") from None


def interpolated(
    picture: NDArray[Any],
    uv: NDArray[Any],
    value: Callable[[NDArray[Any]], NDArray[np.float64]],
) -> NDArray[np.float32]:
    """Interpolate the values of the four nearest pixels at each texture coordinate."""
    height, width, _ = picture.shape
    x = (uv[:, 0].astype(np.float64) % 1) * width - 0.5
    y = (1 - uv[:, 1].astype(np.float64) % 1) * height - 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    right, down = (x - column)[:, None], (y - row)[:, None]

    def pixel(i: NDArray[Any], j: NDArray[Any]) -> NDArray[np.float64]:
        return value(picture[j % height, i % width, :3])

    above = pixel(column, row) * (1 - right) + pixel(column + 1, row) * right
    below = pixel(column, row + 1) * (1 - right) + pixel(column + 1, row + 1) * right
    mixed: NDArray[np.float32] = (above * (1 - down) + below * down).astype(np.float32)
    return mixed


def _bytes(picture: Any) -> NDArray[np.uint8]:
    """Return the pixels of an opened picture."""
    turned = _extras.pillow("PIL.ImageOps").exif_transpose(picture)
    mode, kind = turned.mode, picture.format
    if not mode.startswith(("I", "F")):
        return np.asarray(turned.convert("RGBA"))
    grey = np.asarray(turned)
    if mode.startswith("I;16") or (mode == "I" and kind in _OF_16_BITS):
        part = grey / 65535
    elif mode == "F":
        part = grey.astype(np.float64)
    else:
        raise ValueError(f"32-bit values of mode {mode} have no known range: save it with 8 or 16 bits")
    if not ((part >= 0) & (part <= 1)).all():
        raise ValueError("its values must be within 0..1")
    whole = np.full((*grey.shape, 4), 255, np.uint8)
    whole[:, :, :3] = np.rint(part * 255)[:, :, None]
    clear = picture.info.get("transparency")
    if isinstance(clear, int):
        whole[grey == clear, 3] = 0
    return whole
