"""The file formats of pictures."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._io import files
from .._values import arguments
from ..errors import ArgumentError

__all__ = ["format_of", "write_by_pillow"]

SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".exr", ".npy")
_ALLOWED = "a name ending in .png, .jpg, .webp, .exr or .npy"
_BY_PILLOW: dict[str, dict[str, Any]] = {
    "JPEG": {"quality": 95, "subsampling": 0},
    "WEBP": {"lossless": True},
}


def format_of(argument: str, path: Any) -> str:
    """Return the suffix, in lower case, that selects a picture's format.

    Raises ArgumentError if it is unknown, MissingExtraError if its package is not installed.
    """
    suffix = arguments.file_path(argument, path).suffix.lower()
    if suffix not in SUFFIXES:
        raise ArgumentError(argument, os.fspath(path), _ALLOWED)
    if suffix == ".exr":
        _extras.require_openexr()
    elif suffix not in (".png", ".npy"):
        _extras.require_pillow(f"saving a picture as {suffix}")
    return suffix


def write_by_pillow(path: str | os.PathLike[str], suffix: str, pixels: NDArray[np.uint8]) -> None:
    """Write a JPEG or a WebP, whole or not at all."""
    kind = "WEBP" if suffix == ".webp" else "JPEG"
    picture = _extras.pillow().fromarray(np.ascontiguousarray(pixels))
    files.write_whole(path, lambda file: picture.save(file, kind, **_BY_PILLOW[kind]))
