"""Contact sheets: several pictures of a film in one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._picture.formats import format_of
from .._picture.frame import Frame
from ..errors import MotesError
from .containers import pixels_of

__all__ = ["make_sheet", "pictures_of_film"]

_NEED = "a contact sheet"
_GAP = 4
_MOST_WIDE = 1920
_PAPER = 16
Pixels = NDArray[np.uint8]


def pictures_of_film(path: Path, choose: Callable[[int], Sequence[int]]) -> dict[int, Pixels]:
    """Return the frames of a film that `choose` selects, given their number. Raises MotesError."""
    av = _extras.av(_NEED)
    try:
        with av.open(str(path)) as film:
            count = sum(1 for _ in film.decode(video=0))
        wanted = set(choose(count))
        with av.open(str(path)) as film:
            decoded = enumerate(film.decode(video=0))
            return {i: pixels_of(frame) for i, frame in decoded if i in wanted}
    except (av.error.FFmpegError, IndexError) as error:
        raise MotesError(f"{path} cannot be read as a film: {error}") from None


def make_sheet(pictures: Mapping[int, Pixels], columns: int, target: Path) -> dict[str, Any]:
    """Save pictures of one size, each with its number, row by row; return the sheet's figures.

    The sheet is at most 1920 pixels wide: larger pictures are scaled down.
    """
    if format_of("--output", target) == ".exr":
        raise MotesError(f"{target}: a contact sheet is a .png, .jpg, .webp or .npy")
    if not pictures:
        raise MotesError("there are no pictures for a contact sheet")
    image, draw_on = _extras.pillow(need=_NEED), _extras.pillow("PIL.ImageDraw", _NEED)
    columns = min(columns, len(pictures))
    height, width, _ = next(iter(pictures.values())).shape
    wide = max(1, min(width, (_MOST_WIDE - _GAP) // columns - _GAP))
    high = max(1, round(height * wide / width))
    rows = -(-len(pictures) // columns)
    size = _GAP + columns * (wide + _GAP), _GAP + rows * (high + _GAP)
    sheet = image.new("RGB", size, (_PAPER, _PAPER, _PAPER))
    for place, (number, pixels) in enumerate(sorted(pictures.items())):
        small = image.fromarray(pixels).resize((wide, high), image.Resampling.LANCZOS)
        pen = draw_on.Draw(small)
        pen.text((6, 4), str(number), fill="white", stroke_width=2, stroke_fill="black")
        row, column = divmod(place, columns)
        sheet.paste(small, (_GAP + column * (wide + _GAP), _GAP + row * (high + _GAP)))
    Frame(0, 0, np.asarray(sheet)).save(target)
    return {"sheet": str(target), "pictures": len(pictures), "width": size[0], "height": size[1]}
