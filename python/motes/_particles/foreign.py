"""Names that other programs, mainly Houdini, give to columns of particles."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ArgumentError, MotesWarning

__all__ = ["NAMES", "WIDTHS", "leave_out", "no_column", "renamed"]

NAMES = {
    **{
        "P": "position",
        "v": "velocity",
        "Cd": "color",
        "Alpha": "alpha",
        "pscale": "size",
        "life": "lifetime",
    },
    **{"widths": "size", "displayColor": "color", "displayOpacity": "alpha"},
}
"""Other programs' names -> ours."""
WIDTHS = (1, 3, 4)
"""How many numbers per particle a column can have."""


def leave_out(path: Path, name: str, reason: str, *, level: int = 5) -> None:
    """Warn, `level` calls up the stack, at the caller of `open_particles`, that a column is not read."""
    text = (
        f"{path}: column {name!r} is left out: it has {reason}; columns have 1, 3 or 4 numbers per particle"
    )
    warnings.warn(text, MotesWarning, stacklevel=level)


def renamed(columns: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return columns under our names, unless the file already has a column of that name.

    `pscale` is a radius, so it is doubled to get `size`. A scalar size applies to all axes.
    """
    own: dict[str, NDArray[Any]] = {}
    for name, column in columns.items():
        ours = NAMES.get(name, name)
        if ours in own or (ours != name and ours in columns):
            ours = name
        if ours == "size" and column.ndim == 1:
            column = np.repeat(column[:, None], 3, axis=1) * (2 if name == "pscale" else 1)
        own[ours] = column
    return own


def no_column(system: str, name: str, values: Any, known: Iterable[str]) -> ArgumentError:
    """Return the error for a column that a system lacks; it says how to declare it or leave it out."""
    ours = NAMES.get(name)
    if ours is not None:
        return ArgumentError("column", name, f"named as in motes: emit({ours}=...)")
    initial = "(0, 0, 0)" if np.ndim(values) == 2 else "0.0"
    declared = f"world.system({system!r}, attributes={{{name!r}: {initial}}})"
    left_out = "s.emit(**particles.columns('position'))"
    allowed = f"an attribute of {system!r}: declare it, {declared}, or leave it out, {left_out}"
    return ArgumentError("column", name, allowed, known=known)
