"""Particles as .npz: NumPy's archive of arrays, one per column."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .format import Format

__all__ = ["FORMAT"]


def write(path: Path, columns: Mapping[str, NDArray[Any]], *, frame: int, time: float) -> None:
    """Write columns (n, 3) or (n,) into an existing file. Equal columns make equal files.

    Like `numpy.savez`, without its extra copy of each array.
    """
    del frame, time
    with open(path, "wb") as file, zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name, column in columns.items():
            array = np.ascontiguousarray(column)
            entry = zipfile.ZipInfo(f"{name}.npy")  # dated 1980, not now: equal columns make equal files
            with archive.open(entry, "w", force_zip64=True) as out:
                np.lib.format.write_array_header_1_0(out, np.lib.format.header_data_from_array_1_0(array))
                if array.size:
                    out.write(array.data.cast("B"))


def read(path: Path, names: Iterable[str] | None, *, frame: int) -> dict[str, NDArray[Any]]:
    """Read the named columns, or all if `names` is None. Raises OSError, ValueError or KeyError."""
    del frame
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as archive:
            return {name: archive[name] for name in (archive.files if names is None else names)}
    except zipfile.BadZipFile as error:
        raise ValueError(str(error)) from error


FORMAT = Format("npz", "", write, read, alone=True, mistaken=(".npz",))
