"""OpenEXR pictures: linear light as half floats, with further layers, compressed without loss."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["read", "write"]

_MOST = 65504
"""The largest half float."""

_CHANNELS = {
    "depth": ("depth.Z",),
    "alpha": ("alpha.A",),
    "velocity": ("velocity.X", "velocity.Y", "velocity.Z"),
    "particles": ("particles.R", "particles.G", "particles.B", "particles.A"),
}
"""Channels of each layer, `layer.channel` as compositing programs expect them."""

_WHOLE = ("depth",)
"""Layers that stay float32: half floats have steps of 8 mm at 10 m, and end at 65 km."""


def write(
    library: Any, path: Path, linear: NDArray[np.float32], layers: Mapping[str, NDArray[np.float32]]
) -> None:
    """Write one part of scan lines with the module OpenEXR: R, G, B, perhaps A, and layers.

    Compression is ZIP: lossless, known to every reader, and the smallest such method for particles.
    """
    channels: dict[str, NDArray[Any]] = {"RGB": _half(linear)}
    if "alpha" in layers:
        channels = {"RGBA": _half(np.dstack([linear, layers["alpha"]]))}
    for name, layer in layers.items():
        planes = np.atleast_3d(layer)
        for i, channel in enumerate(_CHANNELS[name]):
            plane = planes[:, :, i]
            channels[channel] = np.ascontiguousarray(plane) if name in _WHOLE else _half(plane)
    header = {"compression": library.ZIP_COMPRESSION, "type": library.scanlineimage}
    with library.File(header, channels) as file:
        file.write(str(path))


def read(library: Any, path: Path, most: int) -> NDArray[np.float32]:
    """Return the colours in the display window of a file's first part, float32 (height, width, 3).

    Pixels outside the data window are black; what it has beyond the display window (overscan) is cut off.

    Args:
        library: the module OpenEXR.
        path: the file.
        most: the most pixels each way.

    Raises:
        ValueError: with the reason, if the file has no such picture; or errors of OpenEXR's own.
    """
    with library.File(str(path)) as file:
        if not file.parts:
            raise ValueError("it is damaged")
        part = file.parts[0]
        return _displayed(_colors(part.channels), file.header(), most)


def _colors(channels: Mapping[str, Any]) -> NDArray[np.float32]:
    for name in ("RGB", "RGBA"):
        if name in channels:
            return np.array(channels[name].pixels[:, :, :3], np.float32)
    if not all(name in channels for name in "RGB"):
        raise ValueError(f"its channels are {', '.join(channels)}")
    return np.stack([channels[name].pixels for name in "RGB"], axis=2).astype(np.float32)


def _displayed(pixels: NDArray[np.float32], header: Mapping[str, Any], most: int) -> NDArray[np.float32]:
    """Place the pixels of the data window in the display window."""
    data, display = (np.array(header[name], int) for name in ("dataWindow", "displayWindow"))
    if (data == display).all():
        return pixels
    width, height = display[1] - display[0] + 1
    if not (1 <= width <= most and 1 <= height <= most):
        raise ValueError(
            f"its display window has {width}x{height} pixels, at most {most} each way are allowed"
        )
    whole = np.zeros((height, width, 3), np.float32)
    low, high = np.maximum(data[0], display[0]), np.minimum(data[1], display[1]) + 1
    if (low < high).all():
        (left, top), (right, bottom) = low - display[0], high - display[0]
        (first, row), (last, end) = low - data[0], high - data[0]
        whole[top:bottom, left:right] = pixels[row:end, first:last]
    return whole


def _half(values: NDArray[np.float32]) -> NDArray[np.float16]:
    return np.clip(values, -_MOST, _MOST).astype(np.float16, order="C")
