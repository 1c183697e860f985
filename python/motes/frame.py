"""Frame: one finished picture, a NumPy array on the image generator and empty elsewhere."""

from __future__ import annotations

import hashlib
import os
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import arguments
from ._io import files, png
from .errors import ArgumentError, MotesError, NotHere

__all__ = ["Frame"]


class Frame:
    """A picture of the animation.

    On the image generator it holds the pixels. On every other rank it is falsy, `save` does nothing, and
    asking for pixels raises `NotHere`; so a script need not test its rank.
    """

    __slots__ = ("__weakref__", "_home", "_linear", "_missing", "_pixels", "_rank", "index", "time")

    def __init__(
        self,
        index: int,
        time: float,
        pixels: NDArray[np.uint8] | None,
        *,
        linear: Callable[[], ArrayLike] | None = None,
        home: int | None = 0,
        rank: int = 0,
        missing: str = "it was stepped, not rendered",
    ) -> None:
        """Wrap `pixels`, uint8 (height, width, 3), without copying; None if the picture lives elsewhere.

        `linear` makes the float32 picture when it is asked for. `home` is the image generator's rank, None if
        no picture was made at all; `missing` says why not; `rank` is this rank. These three are used in
        messages only.
        """
        self.index = index
        self.time = time
        self._pixels = None if pixels is None else _view(pixels)
        self._linear: Callable[[], ArrayLike] | NDArray[np.float32] | None = linear
        self._home = home
        self._rank = rank
        self._missing = missing

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """The picture as sRGB, uint8 (height, width, 3), row 0 on top; read-only and not a copy."""
        if self._pixels is None and self._home is None:
            raise NotHere(f"frame {self.index} has no picture: {self._missing}")
        if self._pixels is None:
            raise NotHere(
                f"the pixels of frame {self.index} live on rank {self._home}, the image generator; "
                f"this is rank {self._rank}"
            )
        return self._pixels

    @property
    def made(self) -> bool:
        """Whether there is a picture, here or on another rank."""
        return self._home is not None

    @property
    def linear(self) -> NDArray[np.float32]:
        """The picture before exposure to 8 bits: linear RGB, float32 (height, width, 3), made on request."""
        shape = self.pixels.shape
        if self._linear is None:
            raise MotesError(f"frame {self.index} has no linear picture: only the 8-bit one was kept")
        if callable(self._linear):
            made = np.asarray(self._linear(), np.float32)
            if made.shape != shape:
                raise MotesError(f"the linear picture of frame {self.index} is {made.shape}, not {shape}")
            self._linear = made
        return self._linear

    def _keep_linear(self) -> None:
        """Fetch the linear picture while the engine still has it."""
        if callable(self._linear):
            self.linear  # noqa: B018

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the picture whole or not at all: `.png` and `.npy` hold `pixels`, `.exr` holds `linear`.

        Does nothing off the image generator, except to refuse a suffix it does not know.
        """
        suffix = arguments.file_path("path", path).suffix.lower()
        if suffix not in (".png", ".npy", ".exr"):
            raise ArgumentError("path", os.fspath(path), "a name ending in .png, .npy or .exr")
        if self._pixels is None:
            return
        pixels = self._pixels
        if suffix == ".png":
            files.write_whole(path, png.encode(pixels))
        elif suffix == ".npy":
            files.write_whole(path, lambda file: np.save(file, pixels))
        else:
            files.write_whole(path, _exr(self.linear))

    def digest(self) -> str:
        """SHA-256 in hexadecimal of the text "<height>x<width>x3", a line feed, and the pixels by rows."""
        pixels = self.pixels
        height, width, _ = pixels.shape
        total = hashlib.sha256(f"{height}x{width}x3\n".encode())
        total.update(np.ascontiguousarray(pixels).data)
        return total.hexdigest()

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Give the pixels to NumPy: a view, unless another dtype or a copy is asked for."""
        pixels = self.pixels
        if dtype is not None and np.dtype(dtype) != pixels.dtype:
            if copy is False:
                raise ValueError(f"pixels are uint8: as {np.dtype(dtype)} they must be copied")
            return pixels.astype(dtype)
        return pixels.copy() if copy else pixels

    def __bool__(self) -> bool:
        """Whether the pixels are on this rank."""
        return self._pixels is not None

    def __repr__(self) -> str:
        """Name the frame and its size, or where it lives."""
        if self._pixels is None:
            return f"<Frame {self.index} {'without picture' if not self.made else f'on rank {self._home}'}>"
        height, width, _ = self._pixels.shape
        return f"<Frame {self.index} {width}x{height}>"

    def _repr_png_(self) -> bytes | None:
        return None if self._pixels is None else png.encode(self._pixels)


def _view(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    try:
        array: NDArray[Any] = np.asarray(pixels)
    except Exception:  # any: this runs methods of users' classes
        raise ArgumentError("pixels", pixels, "uint8 (height, width, 3)") from None
    if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] != 3 or 0 in array.shape:
        raise ArgumentError("pixels", f"{array.dtype} {array.shape}", "uint8 (height, width, 3)")
    view = array.view()
    view.flags.writeable = False
    return view


def _exr(linear: NDArray[np.float32]) -> bytes:
    """Encode as OpenEXR: float32, one part, scan lines, not compressed, by the format's specification."""
    height, width, _ = linear.shape
    float32, uncompressed, top_down = 2, 0, 0
    # A channel: name, pixel type, 4 bytes "linear" and reserved, sampling in x and y; in the order of the
    # alphabet.
    channels = b"".join(name + b"\0" + struct.pack("<4i", float32, 0, 1, 1) for name in (b"B", b"G", b"R"))
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = (
        (b"channels", b"chlist", channels + b"\0"),
        (b"compression", b"compression", bytes([uncompressed])),
        (b"dataWindow", b"box2i", window),
        (b"displayWindow", b"box2i", window),
        (b"lineOrder", b"lineOrder", bytes([top_down])),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        (b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1)),
    )
    magic, version = 20000630, 2
    header = struct.pack("<2i", magic, version)
    for name, kind, value in attributes:
        header += name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value
    header += b"\0"
    lines = np.empty(height, [("y", "<i4"), ("bytes", "<i4"), ("channels", "<f4", (3, width))])
    lines["y"] = np.arange(height)
    lines["bytes"] = 3 * 4 * width
    lines["channels"] = linear[:, :, ::-1].transpose(0, 2, 1)  # each line holds all blue, all green, all red
    first = len(header) + 8 * height
    offsets = first + lines.itemsize * np.arange(height, dtype="<u8")
    return b"".join((header, offsets.tobytes(), lines.tobytes()))
