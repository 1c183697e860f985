"""Radiance pictures (.hdr, .pic): linear light with a shared exponent per pixel, the usual files of skies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["encode", "read"]

_MAGIC = (b"#?RADIANCE", b"#?RGBE")


def read(path: Path, most: int) -> NDArray[np.float32]:
    """Return a picture as linear light, float32 (height, width, 3).

    A pixel is mantissa / 256 * 2**(exponent - 128), divided by the exposures that the header names.
    OpenImageIO 3.2 and OpenCV 5.0 have the same bits, but ignore exposures; Radiance's own programs add half
    a step.

    Args:
        path: the file.
        most: the most pixels each way.

    Raises:
        ValueError: with the reason, if the file is not such a picture.
    """
    content = path.read_bytes()
    exposure, at = _header(content)
    height, width, upwards, mirrored, at = _size(content, at)
    if not (1 <= height <= most and 1 <= width <= most):
        raise ValueError(f"{width}x{height} pixels, and at most {most} each way are allowed")
    rgbe = np.empty((height, width, 4), np.uint8)
    for row in rgbe:
        at = _row(content, at, row)
    scale = np.ldexp(np.float32(1), rgbe[:, :, 3].astype(np.int32) - 136)
    light = rgbe[:, :, :3] * np.where(rgbe[:, :, 3] > 0, scale, 0)[:, :, None] / np.float32(exposure)
    light = light[::-1] if upwards else light
    return np.ascontiguousarray(light[:, ::-1] if mirrored else light, np.float32)


def encode(light: NDArray[np.float32]) -> bytes:
    """Encode linear light, (height, width, 3), each pixel rounded to 8 bits of its brightest channel."""
    height, width, _ = light.shape
    _, exponent = np.frexp(np.maximum(light.max(axis=2), 1e-38) * np.float32(256 / 255.5))
    mantissa = np.rint(np.ldexp(light, 8 - exponent[:, :, None]))
    rgbe = np.dstack([mantissa, exponent + 128]).astype(np.uint8)
    rgbe[light.max(axis=2) < 1e-37] = 0
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
    if not 8 <= width < 32768:  # where rows are never compressed
        return head + rgbe.tobytes()
    mark = bytes((2, 2, width >> 8, width & 255))
    starts = range(0, width, 128)
    rows = [head]
    for row in rgbe:
        rows.append(mark)
        for channel in np.ascontiguousarray(row.T):
            parts = (channel[at : at + 128] for at in starts)
            rows += [bytes([len(part)]) + part.tobytes() for part in parts]
    return b"".join(rows)


def _header(content: bytes) -> tuple[float, int]:
    """Return the product of the exposures, and where the header ends."""
    end = content.find(b"\n\n")
    lines = content[: max(end, 0)].split(b"\n")
    if not lines[0].startswith(_MAGIC):
        raise ValueError("it does not begin like a Radiance picture")
    exposure = 1.0
    for name, _, text in (line.partition(b"=") for line in lines[1:]):
        if name.strip() == b"FORMAT" and text.strip() != b"32-bit_rle_rgbe":
            raise ValueError(f"its format is {text.strip().decode(errors='replace')}, not 32-bit_rle_rgbe")
        if name.strip() == b"EXPOSURE":
            exposure *= float(text)
    if not 0 < exposure < np.inf:
        raise ValueError(f"its exposure is {exposure}")
    return exposure, end + 2


def _size(content: bytes, at: int) -> tuple[int, int, bool, bool, int]:
    """Return height and width, whether rows go upwards and from right to left, and where pixels begin."""
    end = content.find(b"\n", at)
    words = content[at : max(end, at)].split()
    if len(words) != 4 or words[0] not in (b"-Y", b"+Y") or words[2] not in (b"+X", b"-X"):
        line = content[at : max(end, at)][:40].decode(errors="replace")
        raise ValueError(f"its size is given as {line!r}, not as rows like '-Y 512 +X 1024'")
    return int(words[1]), int(words[3]), words[0] == b"+Y", words[2] == b"-X", end + 1


def _row(content: bytes, at: int, row: NDArray[np.uint8]) -> int:
    """Read a row of pixels into `row`, (width, 4); return where it ends."""
    width = len(row)
    head = content[at : at + 4]
    if head[:2] == b"\2\2" and len(head) == 4 and head[2] << 8 | head[3] == width and 8 <= width < 32768:
        at += 4
        for channel in range(4):
            values, at = _runs(content, at, width)
            row[:, channel] = np.frombuffer(values, np.uint8)
        return at
    return _flat_row(content, at, row)


def _runs(content: bytes, at: int, width: int) -> tuple[bytearray, int]:
    """Return one channel of a row: runs of equal bytes, and bytes as they are."""
    values = bytearray()
    while len(values) < width:
        if at + 1 >= len(content):
            raise ValueError("it ends in the middle of a row")
        count = content[at]
        if count > 128:
            values += content[at + 1 : at + 2] * (count - 128)
            at += 2
        else:
            values += content[at + 1 : at + 1 + count]
            at += 1 + count
        if count == 0 or (at > len(content)):
            raise ValueError("a row of it is damaged")
    if len(values) != width:
        raise ValueError("a row of it is damaged")
    return values, at


def _flat_row(content: bytes, at: int, row: NDArray[np.uint8]) -> int:
    """Read a row of whole pixels, in which (1, 1, 1, n) repeats the last one: the older of the two forms."""
    pixel, shift = 0, 0
    pixels = np.frombuffer(content, np.uint8, offset=at)
    pixels = pixels[: len(pixels) // 4 * 4].reshape(-1, 4)
    repeats = (pixels[: len(row), :3] == 1).all(axis=1)
    if not repeats.any():
        if len(pixels) < len(row):
            raise ValueError("it ends in the middle of a row")
        row[:] = pixels[: len(row)]
        return at + 4 * len(row)
    used = 0
    while pixel < len(row):
        if used >= len(pixels):
            raise ValueError("it ends in the middle of a row")
        value = pixels[used]
        used += 1
        if (value[:3] == 1).all() and pixel > 0:
            count = int(value[3]) << shift
            row[pixel : pixel + count] = row[pixel - 1]
            pixel += count
            shift += 8
        else:
            row[pixel] = value
            pixel += 1
            shift = 0
    if pixel > len(row):
        raise ValueError("a row of it is damaged")
    return at + 4 * used
