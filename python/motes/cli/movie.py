"""Join numbered PNG pictures, or films of ranges of frames, into one film.

  python -m motes movie out/frames
  python -m motes movie out/frames -o film.mp4 --fps 30
  python -m motes movie out --series snow. --gaps hold
  python -m motes movie out/film.mp4
  python -m motes movie out/frames --sheet 4x3 -o sheet.png

Pictures have names such as frame.0000.png or snow12.png; the text before the number is their series. They are
ordered by number and must have the same size. A missing number is an error, unless --gaps says what to show
instead: `hold` the picture before it, `skip` nothing. A film has no alpha channel: transparent pixels show
the colour of --background.

Films of ranges, which `run --frames` makes, have names such as film.000400-000500.mp4. They are joined,
without encoding them again, into film.mp4: give that name, or their directory. The file
film.000400-000500.mp4.seam, which holds the pictures of seconds that two ranges share, must be there, too.

--sheet 4x3 makes one picture of twelve, four in a row, from pictures or a film, at equal intervals.
"""

from __future__ import annotations

import argparse
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._io.text import printable
from ..errors import MotesError, near
from .parser import add_json, print_figures

__all__ = ["configure", "join", "run"]

_NUMBERED = re.compile(r"(.*?)(\d+)\.png", re.IGNORECASE | re.DOTALL)
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_MOST_NAMED = 5


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `movie`."""
    parser.add_argument("directory", metavar="DIR", help="where the pictures are; or a film")
    parser.add_argument("-o", "--output", metavar="FILE", help="the film (DIR.mp4), or the sheet")
    parser.add_argument("--fps", type=float, help="pictures per second (24)")
    parser.add_argument("--sheet", type=_grid, metavar="4x3", help="a contact sheet instead of a film")
    parser.add_argument("--series", metavar="NAME", help="only pictures with this name before the number")
    parser.add_argument(
        "--gaps",
        choices=("refuse", "hold", "skip"),
        default="refuse",
        help="what to do about missing numbers (refuse)",
    )
    parser.add_argument(
        "--background",
        type=_color,
        metavar="RRGGBB",
        help="the colour behind transparent pixels, such as 000000; required if there are any",
    )
    add_json(parser)


def _color(text: str) -> tuple[int, int, int]:
    match = re.fullmatch(r"#?([0-9a-fA-F]{2})([0-9a-fA-F]{2})([0-9a-fA-F]{2})", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"must be six hexadecimal digits, such as 202020, got {text!r}")
    return int(match[1], 16), int(match[2], 16), int(match[3], 16)


def run(args: argparse.Namespace) -> int:
    """Write the film and print its figures."""
    folder = Path(args.directory)
    if args.sheet is not None:
        return _make_sheet(args, folder)
    if films := _ranges(folder, args.series):
        return _join_ranges(args, films)
    named = folder if folder.name not in ("", "..") else folder.resolve()
    target = Path(args.output) if args.output else named.with_name(f"{named.name}.mp4")
    figures = join(
        folder, target, fps=args.fps or 24, series=args.series, gaps=args.gaps, background=args.background
    )
    print_figures(
        args, figures, "{film}: {pictures} pictures of {width}x{height}, {seconds:.2f} s".format(**figures)
    )
    return 0


def _grid(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"([1-9]\d?)x([1-9]\d?)", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"must be columns x rows, such as 4x3, 1..99 each, got {text!r}")
    return int(match[1]), int(match[2])


def _make_sheet(args: argparse.Namespace, source: Path) -> int:
    from .._film.sheet import make_sheet, pictures_of_film

    columns, rows = args.sheet
    if args.output is None:
        raise MotesError("movie --sheet: no file given for the sheet: add `-o sheet.png`")
    if source.is_dir():
        numbered = _numbered(source, args.series)
        _one_size([numbered[number] for number in sorted(numbered)])
        chosen = [sorted(numbered)[i] for i in _spread(len(numbered), columns * rows)]
        pictures = {number: _pixels(numbered[number], args.background) for number in chosen}
    else:
        pictures = pictures_of_film(source, lambda frames: _spread(frames, columns * rows))
    figures = make_sheet(pictures, columns, Path(args.output))
    print_figures(args, figures, "{sheet}: {pictures} pictures, {width}x{height}".format(**figures))
    return 0


def _spread(count: int, most: int) -> list[int]:
    """Return up to `most` of the numbers below `count`, at equal intervals, with the first and the last."""
    if count <= most:
        return list(range(count))
    return [round(i * (count - 1) / (most - 1)) for i in range(most)] if most > 1 else [count // 2]


def _ranges(source: Path, series: str | None) -> list[Path]:
    """List the films of ranges at a path: of one film, or the only film in a directory without pictures."""
    from .._film.parts import films_in, parts_of

    if not source.is_dir():
        return parts_of(source)
    films = films_in(source)
    if series is not None:
        films = [film for film in films if film.stem == series]
    elif any(_NUMBERED.fullmatch(path.name) for path in source.iterdir()):
        return []
    if len(films) > 1:
        named = ", ".join(repr(film.stem) for film in films)
        raise MotesError(f"{source} has ranges of several films: {named}; choose one with --series")
    return parts_of(films[0]) if films else []


def _join_ranges(args: argparse.Namespace, films: list[Path]) -> int:
    from .._film.parts import join as join_parts
    from .._film.parts import whole_of

    if args.fps is not None:
        raise MotesError("movie --fps: the films of ranges have their own rate")
    figures = join_parts(films, Path(args.output) if args.output else whole_of(films[0]))
    text = "{film}: {parts} parts, {pictures} pictures of {width}x{height}, {seconds:.2f} s"
    print_figures(args, figures, text.format(**figures))
    return 0


def join(
    folder: Path,
    target: Path,
    *,
    fps: float = 24,
    series: str | None = None,
    gaps: str = "refuse",
    background: tuple[int, int, int] | None = None,
) -> dict[str, Any]:
    """Write a film of a directory's pictures; return its figures.

    `background` is the sRGB colour behind transparent pixels. Raises MotesError, before a file is written, if
    pictures are missing or their sizes differ, or if one has transparent pixels and there is no background.
    """
    from .._film.movie import Movie

    numbered = _numbered(folder, series)
    width, height = _one_size([numbered[number] for number in sorted(numbered)])
    order = list(_in_order(numbered, gaps))
    with Movie(target, fps=fps) as movie:
        for path in order:
            movie.write(_pixels(path, background))
    facts = {"film": str(target), "pictures": len(order), "width": width, "height": height, "fps": fps}
    return {**facts, "seconds": len(order) / fps}


def _numbered(folder: Path, series: str | None) -> dict[int, Path]:
    """Find the pictures of a series, or of the only series, by number."""
    if not folder.is_dir():
        if folder.suffix and not folder.exists():
            part = f"{folder.stem}.000400-000500{folder.suffix}"
            raise MotesError(f"{folder.parent} has no films of ranges of {folder.name}, such as {part}")
        raise MotesError(f"{folder} is not a directory")
    by_name: dict[str, dict[int, Path]] = {}
    for path in sorted(folder.iterdir()):
        match = _NUMBERED.fullmatch(path.name)
        if match is None or not path.is_file():
            continue
        pictures = by_name.setdefault(match[1], {})
        other = pictures.setdefault(int(match[2]), path)
        if other is not path:
            raise MotesError(f"{_name(other)} and {_name(path)} have the same number")
    if series is not None and series not in by_name:
        raise MotesError(
            f"no picture in {folder} is named {series!r} followed by a number{near(series, list(by_name))}"
        )
    if not by_name:
        raise MotesError(f"{folder} has no numbered pictures, such as frame.0000.png")
    if series is None and len(by_name) > 1:
        named = ", ".join(f"{name!r} ({len(pictures)})" for name, pictures in sorted(by_name.items()))
        raise MotesError(f"{folder} has several series of pictures: {named}; choose one with --series")
    return by_name[next(iter(by_name)) if series is None else series]


def _in_order(numbered: dict[int, Path], gaps: str) -> Iterator[Path]:
    """Yield the picture for each number from the first to the last."""
    numbers = sorted(numbered)
    missing = [(a + 1, b - 1) for a, b in zip(numbers, numbers[1:], strict=False) if b > a + 1]
    if missing and gaps == "refuse":
        named = [str(a) if a == b else f"{a} to {b}" for a, b in missing]
        text = ", ".join(named[:_MOST_NAMED])
        if len(named) > _MOST_NAMED:
            text += f" and {len(named) - _MOST_NAMED} more gaps"
        raise MotesError(
            f"pictures are missing between {numbers[0]} and {numbers[-1]}: {text}; "
            "--gaps hold repeats the picture before each gap, --gaps skip leaves the gaps out"
        )
    for k, number in enumerate(numbers):
        shown = numbers[k + 1] - number if gaps == "hold" and k + 1 < len(numbers) else 1
        yield from [numbered[number]] * shown


def _one_size(paths: list[Path]) -> tuple[int, int]:
    """Return the common size of all pictures, from their headers."""
    first = paths[0]
    size = _size(first)
    for path in paths[1:]:
        if (other := _size(path)) != size:
            raise MotesError(
                f"the pictures differ in size: {_name(first)} has {size[0]}x{size[1]} pixels, "
                f"{_name(path)} {other[0]}x{other[1]}"
            )
    return size


def _size(path: Path) -> tuple[int, int]:
    with path.open("rb") as file:
        head = file.read(24)
    if len(head) < 24 or head[:8] != _SIGNATURE or head[12:16] != b"IHDR":
        raise MotesError(f"{_name(path)} is not a PNG picture")
    width, height = struct.unpack(">II", head[16:24])
    return width, height


def _pixels(path: Path, background: tuple[int, int, int] | None) -> NDArray[np.uint8]:
    from .. import _extras

    av = _extras.av("motes movie")
    try:
        with av.open(str(path)) as picture:
            pixels: NDArray[np.uint8] = next(picture.decode(video=0)).to_ndarray(format="rgba")
    except (av.error.FFmpegError, StopIteration) as error:
        raise MotesError(f"{_name(path)} cannot be read: {error or 'it contains no picture'}") from None
    colors, alpha = pixels[:, :, :3], pixels[:, :, 3:]
    if (alpha == 255).all():
        return np.ascontiguousarray(colors)
    if background is None:
        hint = "--background 000000 puts black behind them"
        raise MotesError(f"{_name(path)} has transparent pixels, which a film cannot have: {hint}")
    part = alpha.astype(np.float32) / 255
    return np.rint(colors * part + np.array(background, np.float32) * (1 - part)).astype(np.uint8)


def _name(path: Path) -> str:
    return printable(str(path))
