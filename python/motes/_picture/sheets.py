"""Images of sprites: one picture, several of the same size, or a sheet, and how particles pick one."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._values import arguments
from ..errors import ArgumentError

if TYPE_CHECKING:
    from .. import _core
    from ..expressions import Expression
    from ..expressions._conditions import Columns, Program

__all__ = ["Sheet", "pick_of", "pictures_of", "program_of_pick", "sheet_of", "text_of_pictures", "tiles_of"]

MOST_IMAGE_PIXELS = 8192
"""The longest side of an image."""
MOST_TILES = 256
"""The most columns or rows of a sheet."""
SIDES = f"1..{MOST_IMAGE_PIXELS} pixels each way"
IMAGE = f"a path, or uint8 or floats 0..1 (height, width, 4) or (height, width, 3), {SIDES}; or a list"
PICKS = ("random", "age")
PICK = "'random', 'age' or an expression of one number per particle"

Pixels = NDArray[np.uint8]
"""Shape (height, width, 4): sRGB and straight alpha."""


class Sheet(NamedTuple):
    """Pictures of the same size combined into one: `number` cells, counted row by row from the top."""

    pixels: Pixels
    columns: int
    rows: int
    number: int


def pictures_of(kind: str, given: Any) -> NDArray[np.uint8] | None:
    """Return a sprite's picture, (height, width, 4), or pictures, (number, height, width, 4), checked."""
    if (kind == "image") != (given is not None):
        raise ArgumentError("image", given, "given for kind='image', and for no other kind")
    if given is None:
        return None
    if not _several(given):
        return _frozen(_picture(given))
    if not 1 <= len(given) <= MOST_TILES * MOST_TILES:
        raise ArgumentError("image", f"{len(given)} pictures", f"1..{MOST_TILES * MOST_TILES} pictures")
    pictures = [_picture(one) for one in given]
    sizes = [f"{one.shape[1]}x{one.shape[0]}" for one in pictures]
    if len(set(sizes)) > 1:
        odd = next(i for i, size in enumerate(sizes) if size != sizes[0])
        raise ArgumentError(
            "image", f"pictures of {sizes[0]} and, number {odd}, {sizes[odd]}", "pictures of one size"
        )
    return _frozen(np.stack(pictures))


def tiles_of(image: NDArray[np.uint8] | None, tiles: Any) -> tuple[int, int] | None:
    """Return the columns and rows into which pictures are cut, checked."""
    if tiles is None:
        return None
    allowed = f"two integers in 1..{MOST_TILES}: columns, rows"
    if image is None:
        raise ArgumentError("tiles", tiles, "given with `image`, which it divides")
    pair = arguments.listed("tiles", tiles, allowed)
    if len(pair) != 2:
        raise ArgumentError("tiles", tiles, allowed)
    columns, rows = (arguments.integer("tiles", number, low=1, high=MOST_TILES) for number in pair)
    height, width = image.shape[-3:-1]
    if width % columns or height % rows:
        raise ArgumentError("tiles", tiles, f"columns and rows that divide a picture of {width}x{height}")
    return columns, rows


def sheet_of(image: NDArray[np.uint8], tiles: tuple[int, int] | None) -> Sheet:
    """Cut pictures into tiles and combine all tiles into one sheet."""
    columns, rows = tiles or (1, 1)
    if image.ndim == 3:
        return Sheet(image, columns, rows, columns * rows)
    number, height, width, _ = image.shape
    high, wide = height // rows, width // columns
    cut = image.reshape(number, rows, high, columns, wide, 4).swapaxes(2, 3).reshape(-1, high, wide, 4)
    count = len(cut)
    down = min(MOST_IMAGE_PIXELS // high, MOST_TILES, count)
    across = -(-count // down)
    if across > MOST_TILES or across * wide > MOST_IMAGE_PIXELS:
        allowed = f"pictures that together fit into one of {MOST_IMAGE_PIXELS}x{MOST_IMAGE_PIXELS}"
        raise ArgumentError("image", f"{count} pictures of {wide}x{high}", allowed)
    whole = np.zeros((down * across, high, wide, 4), np.uint8)
    whole[:count] = cut
    pixels = whole.reshape(down, across, high, wide, 4).swapaxes(1, 2).reshape(down * high, across * wide, 4)
    return Sheet(pixels, across, down, count)


def pick_of(image: NDArray[np.uint8] | None, tiles: Any, pick: Any) -> Any:
    """Return how a particle picks its picture: 'random', 'age', an expression; None if there is only one."""
    several = tiles is not None or (image is not None and image.ndim == 4)
    if pick is None:
        return "random" if several else None
    if not several:
        raise ArgumentError("pick", pick, "given with `tiles` or a list of images, from which it picks")
    if isinstance(pick, str):
        if pick not in PICKS:
            raise ArgumentError("pick", pick, PICK, known=PICKS)
        return pick
    from ..expressions._expression import as_expression, node_of

    try:
        expression = as_expression("pick", pick)
    except ArgumentError:  # its message would allow vectors, too
        raise ArgumentError("pick", pick, PICK) from None
    operation, *operands = node_of(expression)
    if operation == "constant" and len(operands[0]) != 1:
        raise ArgumentError("pick", pick, PICK)
    return expression


def program_of_pick(
    pick: str | Expression, count: int, columns: Columns
) -> tuple[Program, list[_core.Shape]]:
    """Compile a pick, other than 'random', for a system's columns."""
    from ..expressions import column, minimum
    from ..expressions._compiling import compile_values
    from ..expressions._expression import node_of

    number = minimum(column("age") / column("lifetime"), 1) * (count - 1) if isinstance(pick, str) else pick
    _check_columns(node_of(number))
    shapes: list[_core.Shape] = []
    return compile_values("pick", number, 1, columns, shapes)[0], shapes


def text_of_pictures(image: NDArray[np.uint8]) -> str:
    """Describe the number of pictures and their size."""
    several = f"{len(image)} of " if image.ndim == 4 else ""
    return f"<{several}{image.shape[-2]}x{image.shape[-3]} pixels>"


def _check_columns(node: Any) -> None:
    """Refuse copies of birth values (`*_b`), which exist only if a recorded list uses them."""
    if isinstance(node, tuple):
        if len(node) == 2 and node[0] == "column" and isinstance(node[1], str) and node[1].endswith("_b"):
            raise ArgumentError("pick", f"column({node[1]!r})", "an expression without *_b attributes")
        for part in node:
            _check_columns(part)


def _several(given: Any) -> bool:
    """Return whether a value is a list of pictures, rather than nested lists of one picture's pixels."""
    if isinstance(given, np.ndarray):
        return given.ndim == 4
    if not isinstance(given, (list, tuple)):
        return False
    one = given[0] if given else ""
    return isinstance(one, (str, os.PathLike)) or getattr(one, "ndim", 0) == 3 or _depth(given) == 4


def _depth(given: Any) -> int:
    """Return how deep lists are nested, at most 4."""
    depth = 0
    while isinstance(given, (list, tuple)) and given and depth < 4:
        given, depth = given[0], depth + 1
    return depth


def _picture(given: Any) -> Pixels:
    if isinstance(given, (str, os.PathLike)):
        from .._values.images import read_picture

        given = read_picture("image", given, most=MOST_IMAGE_PIXELS)
    try:
        array: NDArray[Any] = np.asarray(given)
    except Exception:  # of any kind: this runs methods of users' classes
        raise ArgumentError("image", given, IMAGE) from None
    if array.dtype.kind == "f" and array.size and (array >= 0).all() and (array <= 1).all():
        array = np.rint(array * 255).astype(np.uint8)
    if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] not in (3, 4):
        raise ArgumentError("image", f"{array.dtype} {array.shape}", IMAGE)
    if not 0 < min(array.shape) <= max(array.shape) <= MOST_IMAGE_PIXELS:
        raise ArgumentError("image", f"{array.dtype} {array.shape}", IMAGE)
    whole = np.full((*array.shape[:2], 4), 255, np.uint8)
    whole[:, :, : array.shape[2]] = array
    return whole


def _frozen(array: Pixels) -> Pixels:
    array.flags.writeable = False
    return array
