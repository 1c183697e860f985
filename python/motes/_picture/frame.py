"""Frame: one finished picture, a NumPy array on the image generator and empty elsewhere."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from .. import _core, _extras
from .._io import files, png
from .._values import arguments
from ..errors import ArgumentError, MotesError, NotHereError

__all__ = ["Frame", "add_layer", "arrive", "keep_all", "tell_saves"]

Late = Callable[[], ArrayLike] | NDArray[np.float32]
"""A float32 array, or a function that computes it on first use."""

NONE: Mapping[str, Callable[[], ArrayLike]] = MappingProxyType({})


class Frame:
    """A picture of the animation.

    On the image generator it holds the pixels. On every other rank it is falsy, `save` does nothing, and
    reading pixels raises `NotHereError`; a script need not test its rank.
    """

    __slots__ = (
        *("__weakref__", "_elsewhere", "_exposure", "_home", "_layers", "_linear", "_missing", "_pixels"),
        *("_rank", "index", "left_out", "time"),
    )

    def __init__(
        self,
        index: int,
        time: float,
        pixels: NDArray[np.uint8] | None,
        *,
        linear: Callable[[], ArrayLike] | None = None,
        exposure: float = 1,
        layers: Mapping[str, Callable[[], ArrayLike]] = NONE,
        home: int | None = 0,
        rank: int = 0,
        missing: str = "it was stepped, not rendered",
        left_out: bool = False,
    ) -> None:
        """Wrap pixels without copying; `World.render` creates frames.

        Args:
            index: the frame's number.
            time: the animation time, s.
            pixels: uint8 (height, width, 3); None: the picture is on another rank.
            linear: returns the linear float32 picture.
            exposure: the factor from the linear picture to `pixels`.
            layers: a function for each layer's name that returns the layer; on ranks other than the image
                generator only the names are used.
            home: the image generator's rank, for messages; None: no picture was made.
            rank: this rank, for messages.
            missing: why there is no picture, for messages.
            left_out: whether the whole run has this picture, but this job draws only others.
        """
        self.index = index
        self.time = time
        self._pixels = None if pixels is None else _view(pixels)
        self._linear: Late | None = linear
        self._exposure = exposure
        self._layers: dict[str, Late] = dict(layers)
        self._home = home
        self._rank = rank
        self._missing = missing
        self.left_out = left_out
        self._elsewhere: Callable[[int, Path, Literal[8, 16]], None] | None = None
        """Called when the script saves a picture of another rank, which may be lost before it writes it."""

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """The picture as sRGB, uint8 (height, width, 3), row 0 on top; a read-only view, not a copy."""
        if self._pixels is None and self._home is None:
            raise NotHereError(f"frame {self.index} has no picture: {self._missing}")
        if self._pixels is None:
            raise NotHereError(
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
        """The picture before exposure, linear RGB, float32 (height, width, 3), computed on first use."""
        shape = self.pixels.shape
        if self._linear is None:
            raise self._no_light()
        self._linear = _fetched("linear picture", self.index, self._linear, shape)
        return self._linear

    def _no_light(self) -> MotesError:
        return MotesError(
            f"frame {self.index} has no linear picture: only the 8-bit one was kept; "
            "request it with Renderer(linear=True)"
        )

    def layer(self, name: Literal["depth", "alpha", "velocity", "particles"]) -> NDArray[np.float32]:
        """Return one of the renderer's `layers`.

        Args:
            name: "depth": metres from the camera's plane to the nearest opaque surface, infinite where there
                is none. "alpha": the fraction of light from behind that is blocked, 0..1. "velocity": the
                velocity of the nearest opaque particle, m/s, 0 where there is none. "particles": the linear
                light of the particles alone, and the fraction of light from behind that they block: to be
                put over another picture (its light times 1 - alpha, plus this one's). Solids hide particles
                but are not in it.

        Returns:
            float32 (height, width), (height, width, 3) for "velocity", (height, width, 4) for "particles".

        Raises:
            NotHereError: if the picture is on another rank.
        """
        return self._layer(name)

    def _layer(self, name: str) -> NDArray[np.float32]:
        if not isinstance(name, str) or name not in self._layers:
            raise ArgumentError("name", name, self._allowed_layers(), known=self._layers)
        height, width, _ = self.pixels.shape
        channels = {"velocity": (3,), "particles": (4,)}.get(name, ())
        shape = (height, width, *channels)
        layer = _fetched(f"layer {name!r}", self.index, self._layers[name], shape)
        self._layers[name] = layer
        return layer

    def _allowed_layers(self) -> str:
        if not self._layers:
            return "one of the renderer's layers, but it has none: request them with Renderer(layers=...)"
        return "one of the renderer's layers: " + ", ".join(map(repr, self._layers))

    def save(self, path: str | os.PathLike[str], *, bits: Literal[8, 16] = 8) -> None:
        """Write the picture whole or not at all; do nothing on ranks without the picture.

        Args:
            path: its suffix selects the format. .png: sRGB; .jpg, with little loss, and .webp, without any:
                sRGB, both need the extra [image]; .npy: `pixels`; .exr: the linear picture as half floats,
                as A the layer "alpha", and all layers (`depth.Z`, `alpha.A`, `velocity.X`, `particles.R` and
                so on), losslessly compressed; needs the extra [exr].
            bits: bits per channel of a PNG: 8, the same as `pixels`, or 16, from the linear picture.

        Raises:
            ArgumentError: if the suffix is none of these; on all ranks.
            MotesError: if the renderer kept no linear picture, which EXR and 16 bits need.
            MissingExtraError: if the format's extra is not installed.
        """
        from .formats import format_of, write_by_pillow

        suffix = format_of("path", path)
        if arguments.integer("bits", bits) not in ((8, 16) if suffix == ".png" else (8,)):
            raise ArgumentError("bits", bits, "8 or 16, and 16 only for a name ending in .png")
        if self.made and self._linear is None and (suffix == ".exr" or bits == 16):
            raise self._no_light()
        if self._pixels is None:
            if self._elsewhere is not None and self.made:
                self._elsewhere(self.index, Path(path).absolute(), bits)
            return
        pixels = self._pixels
        files.sweep_directory(Path(path).parent)  # remove temporary files that a killed run left behind
        if suffix == ".png":
            files.write_whole(path, png.encode(self._pixels_16() if bits == 16 else pixels))
        elif suffix == ".npy":
            files.write_whole(path, lambda file: np.save(file, pixels))
        elif suffix != ".exr":
            write_by_pillow(path, suffix, pixels)
        else:
            from .._io import exr

            linear, layers = self.linear, {name: self._layer(name) for name in self._layers}
            with files.whole_path(path) as draft:
                exr.write(_extras.openexr(), draft, linear, layers)

    def _pixels_16(self) -> NDArray[np.uint16]:
        return _core.tone_16_bits(self.linear, self._exposure)

    def digest(self) -> str:
        """Hash the picture.

        Returns:
            Hexadecimal SHA-256 of the text "<height>x<width>x3", a line feed, and the pixels row by row.

        Raises:
            NotHereError: if the picture is on another rank.
        """
        import hashlib

        pixels = self.pixels
        height, width, _ = pixels.shape
        total = hashlib.sha256(f"{height}x{width}x3\n".encode())
        total.update(np.ascontiguousarray(pixels).data)
        return total.hexdigest()

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Return the pixels for NumPy: a view, unless another dtype or a copy is requested."""
        pixels = self.pixels
        if dtype is not None and np.dtype(dtype) != pixels.dtype:
            if copy is False:
                raise ValueError(f"pixels are uint8: as {np.dtype(dtype)} they must be copied")
            return pixels.astype(dtype)
        return pixels.copy() if copy else pixels

    def __bool__(self) -> bool:
        """Return whether the pixels are on this rank."""
        return self._pixels is not None

    def __repr__(self) -> str:
        """Show the frame's number and size, or the rank that has the picture."""
        if self._pixels is None:
            return f"<Frame {self.index} {'without picture' if not self.made else f'on rank {self._home}'}>"
        height, width, _ = self._pixels.shape
        return f"<Frame {self.index} {width}x{height}>"

    def _repr_png_(self) -> bytes | None:
        return None if self._pixels is None else png.encode(self._pixels)


def _view(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    try:
        array: NDArray[Any] = np.asarray(pixels)
    except Exception:  # of any kind: this runs methods of users' classes
        raise ArgumentError("pixels", pixels, "uint8 (height, width, 3)") from None
    if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] != 3 or 0 in array.shape:
        raise ArgumentError("pixels", f"{array.dtype} {array.shape}", "uint8 (height, width, 3)")
    view = array.view()
    view.flags.writeable = False
    return view


def _fetched(what: str, index: int, late: Late, shape: tuple[int, ...]) -> NDArray[np.float32]:
    if not callable(late):
        return late
    array = np.asarray(late(), np.float32)
    if array.shape != shape:
        raise MotesError(f"the {what} of frame {index} is {array.shape}, not {shape}")
    return array


def arrive(frame: Frame, picture: Frame) -> None:
    """Give `frame` a picture that was on a lost rank and has been drawn again on this one."""
    frame._pixels, frame._home = picture._pixels, frame._rank
    frame._linear, frame._exposure, frame._layers = picture._linear, picture._exposure, picture._layers


def add_layer(frame: Frame, name: str, layer: NDArray[np.float32]) -> None:
    """Add a layer that was drawn after the picture."""
    frame._layers[name] = layer


def keep_all(frame: Frame) -> None:
    """Fetch the linear picture and the layers while the engine still has them."""
    if frame._pixels is None:
        return
    if frame._linear is not None:
        frame.linear  # noqa: B018
    for name in frame._layers:
        frame._layer(name)


def tell_saves(frame: Frame, notify: Callable[[int, Path, Literal[8, 16]], None]) -> None:
    """Let a frame drawn on another rank call `notify` with index, path and bits when the script saves it."""
    frame._elsewhere = notify
