"""What a sweep leaves behind: figures of each run, a table of all, and a sheet of their last pictures."""

from __future__ import annotations

import csv
import importlib
import io
import math
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .. import _extras
from .._io import files
from ..analysis._tables.schema import FRAMES
from ..analysis._tables.tables import read_rows
from ..errors import MissingExtraError
from .grid import Case
from .runs import Row

__all__ = ["figures", "write_sheet", "write_table"]

COLUMNS = ("seconds", "frames", "count", "frame_s", "imbalance", "efficiency", "particles", "picture")
"""Columns after the values: seconds of the run; frames; particles at the end; the median frame's seconds;
imbalance and efficiency as means over frames; digests of the particles and of the last picture."""
SHEET = 240  # width of a picture on the sheet, pixels
LABEL = 34  # height of its label
MOST_PICTURES = 400


def figures(log: Path) -> Row:
    """Return a run's figures from the rows of its log."""
    rows, _ = read_rows(log / FRAMES.file, FRAMES.columns)
    seconds = [float(row["t_frame_s"]) for row in rows if row.get("t_frame_s") is not None]
    uneven = [float(row["imbalance"]) for row in rows if row.get("imbalance")]
    return {
        "frame_s": statistics.median(seconds) if seconds else None,
        "imbalance": statistics.fmean(uneven) if uneven else None,
        "efficiency": statistics.fmean(1 / one for one in uneven) if uneven else None,
    }


def write_table(directory: Path, cases: Sequence[Case], rows: Sequence[Row]) -> list[Path]:
    """Write sweep.csv and, if pyarrow is installed, sweep.parquet; return their paths."""
    names = list(cases[0].values)
    header = [*names, *COLUMNS, "folder", "error"]
    typed = [{**row, **{name: _number(row[name]) for name in names}} for row in rows]
    text = io.StringIO()
    writer = csv.DictWriter(text, header, restval="", extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(typed)
    paths = [directory / "sweep.csv"]
    files.write_whole(paths[0], text.getvalue().encode())
    try:
        pyarrow: Any = importlib.import_module("pyarrow")
        parquet: Any = importlib.import_module("pyarrow.parquet")
    except ImportError:
        return paths
    columns = {name: _column([row.get(name) for row in typed]) for name in header}
    paths.append(directory / "sweep.parquet")
    files.write_whole(paths[1], lambda file: parquet.write_table(pyarrow.table(columns), file))
    return paths


def write_sheet(directory: Path, rows: Sequence[Row], still: str) -> Path | None:
    """Write sheet.png, all last pictures with their values; None: there are none, or Pillow is missing."""
    stills = [(row, directory / str(row.get("folder", "")) / still) for row in rows]
    found = [(row, path) for row, path in stills if row.get("folder") and path.is_file()][:MOST_PICTURES]
    try:
        image, draw, font = (_extras.pillow(f"PIL.{name}", "a sheet of pictures") for name in _PARTS)
    except MissingExtraError:
        return None
    if not found:
        return None
    with image.open(found[0][1]) as first:
        height = max(1, round(SHEET * first.height / first.width))
    across = math.ceil(math.sqrt(len(found)))
    down = math.ceil(len(found) / across)
    sheet = image.new("RGB", (across * SHEET, down * (height + LABEL)), (24, 24, 24))
    pen, letters = draw.Draw(sheet), font.load_default(13)
    varied = [name for name in found[0][0] if name not in (*COLUMNS, "folder", "error")]
    varied = [name for name in varied if len({row[name] for row, _ in found}) > 1] or varied[:1]
    for number, (row, path) in enumerate(found):
        x, y = number % across * SHEET, number // across * (height + LABEL)
        with image.open(path) as picture:
            sheet.paste(picture.convert("RGB").resize((SHEET, height)), (x, y))
        for line, label in enumerate(_lines([f"{name}={row[name]}" for name in varied])):
            pen.text((x + 4, y + height + 1 + 16 * line), label, fill=(230, 230, 230), font=letters)
    path = directory / "sheet.png"
    files.write_whole(path, lambda file: sheet.save(file, "PNG"))
    return path


_PARTS = ("Image", "ImageDraw", "ImageFont")
_LETTERS = 36  # of a label's line


def _lines(words: Sequence[str]) -> list[str]:
    """Return at most two lines of words; longer ones are cut off."""
    lines = [""]
    for word in words:
        longer = f"{lines[-1]} {word}".strip()
        if len(longer) > _LETTERS and lines[-1]:
            lines.append(word)
        else:
            lines[-1] = longer
    return [line[:_LETTERS] for line in lines[:2]]


def _number(text: Any) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _column(values: Sequence[Any]) -> list[Any]:
    """Return values of one type: whole numbers, numbers or texts."""
    known = [value for value in values if value is not None]
    if any(isinstance(value, str) for value in known):
        return [None if value is None else str(value) for value in values]
    if any(isinstance(value, float) for value in known) or any(abs(value) >= 2**63 for value in known):
        return [None if value is None else float(value) for value in values]
    return list(values)
