"""Reader of the log's tables (JSON lines); skips the incomplete last row of a killed or running run."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ... import _extras
from ...errors import LogError
from .checks import check_facts, check_rows, check_unique
from .schema import Column, Table

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["Follower", "frame_of", "read_facts", "read_rows", "read_table", "with_columns"]

Row = dict[str, Any]


def read_facts(directory: Path) -> Row:
    """Read run.json. Raises LogError if it is missing or damaged."""
    path = directory / "run.json"
    if not directory.is_dir():
        raise LogError(f"{directory}: no such directory; World(log=...) writes a run's log")
    try:
        facts = _decode(path.read_bytes())
    except FileNotFoundError:
        raise LogError(f"{path}: no such file; {directory} is not a run's log") from None
    except OSError as error:
        raise LogError(f"{path}: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise LogError(f"{path}: damaged: {error}") from error
    if not isinstance(facts, dict):
        raise LogError(f"{path}: a JSON object is expected")
    check_facts(facts, path)
    return facts


def read_rows(path: Path, columns: Sequence[Column] = ()) -> tuple[list[Row], bool]:
    """Return the rows of a table, and whether an incomplete last line was skipped.

    A killed writer can leave an incomplete row at the end, which is skipped. Raises LogError, naming the
    line, for any other damaged row, and for values that `columns` do not allow.
    """
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        raise LogError(f"{path}: no such file") from None
    except OSError as error:
        raise LogError(f"{path}: {error.strerror}") from error
    return _parse(text, path, columns)


class Follower:
    """Reads a table while it is being written: each call returns the rows completed since the last call."""

    def __init__(self, path: Path, columns: Sequence[Column] = ()) -> None:
        """Set the file, which need not exist yet, and its columns."""
        self.path = path
        self.restarted = False
        """Whether the last call found the file rewritten by another run or by a continuation of this one."""
        self._columns = columns
        self._offset = 0
        self._line = 0
        self._file: int | None = None

    def new_rows(self) -> list[Row]:
        """Return the new rows, none while the file does not exist. Raises LogError for damaged rows."""
        try:
            with self.path.open("rb") as file:
                known, self._file = self._file, os.fstat(file.fileno()).st_ino
                self.restarted = file.seek(0, 2) < self._offset or known not in (None, self._file)
                if self.restarted:
                    self._offset = self._line = 0
                file.seek(self._offset)
                text = file.read()
        except FileNotFoundError:
            return []
        except OSError as error:
            raise LogError(f"{self.path}: {error.strerror}") from error
        text = text[: text.rfind(b"\n") + 1]
        first = self._line + 1
        rows, _ = _parse(text, self.path, self._columns, first_line=first, last_may_be_torn=False)
        self._offset += len(text)
        self._line += text.count(b"\n")
        return rows


def _parse(
    text: bytes,
    path: Path,
    columns: Sequence[Column],
    *,
    first_line: int = 1,
    last_may_be_torn: bool = True,
) -> tuple[list[Row], bool]:
    # After a crash of the machine, blocks that the file system had not written can contain zeros.
    text = text.rstrip(b"\0 \n\r\t")
    lines = text.split(b"\n") if text else []
    try:
        # Fast path: one call decodes all rows; complete rows give one object per line.
        rows = _decode(b"[" + b",".join(lines) + b"]")
        if len(rows) == len(lines) and all(isinstance(row, dict) for row in rows):
            rename_earlier(rows, columns)
            check_rows(rows, columns, path, range(first_line, first_line + len(rows)))
            return rows, False
    except (ValueError, RecursionError):
        pass
    rows, numbers, torn = [], [], False
    for number, line in enumerate(lines, first_line):
        if not line.strip():
            continue
        try:
            row = _decode(line)
            if not isinstance(row, dict):
                raise ValueError("a JSON object is expected")
        except (ValueError, RecursionError) as error:
            if last_may_be_torn and number == first_line + len(lines) - 1:
                torn = True
                break
            raise LogError(f"{path}, line {number}: damaged row: {error}") from error
        rows.append(row)
        numbers.append(number)
    rename_earlier(rows, columns)
    check_rows(rows, columns, path, numbers)
    return rows, torn


def rename_earlier(rows: Sequence[Row], columns: Sequence[Column]) -> None:
    """Rename columns and values from logs of earlier versions to their present names, in place.

    Works row by row, because a run continued by a later version has rows of both.
    """
    names = {column.earlier: column.name for column in columns if column.earlier}
    for row in rows if names else ():
        for earlier in names.keys() & row.keys():
            row.setdefault(names[earlier], row.pop(earlier))
    for column in columns:
        for row in rows if column.earlier_values else ():
            value = row.get(column.name)
            if isinstance(value, str):
                row[column.name] = column.earlier_values.get(value, value)


def _decode(text: bytes) -> Any:
    """Decode UTF-8 JSON. Raises ValueError (also for NaN and Infinity) or RecursionError."""
    return json.loads(text.decode(), parse_constant=_no_constant)


def _no_constant(name: str) -> Any:
    raise ValueError(f"{name} is not a number")


def read_table(directory: Path, table: Table) -> tuple[DataFrame, list[Path]]:
    """Return a table as a DataFrame, and the files whose last line was incomplete.

    An optional table is empty if its file is missing; a required one raises LogError.
    """
    if "*" in table.file:
        return _read_per_rank(directory, table)
    path = directory / table.file
    if not table.required and not path.exists():
        return frame_of([], table.columns), []
    rows, torn = read_rows(path, table.columns)
    if table.unique:
        check_unique(rows, table.unique, path)
    return frame_of(rows, table.columns), [path] if torn else []


def _read_per_rank(directory: Path, table: Table) -> tuple[DataFrame, list[Path]]:
    rows: list[Row] = []
    torn_files = []
    columns = [column for column in table.columns if column.name != "rank"]
    for path in sorted(directory.glob(table.file)):
        rank = re.search(r"\.r(\d+)\.", path.name)
        if rank is None:
            continue
        new, torn = read_rows(path, columns)
        rows += [{**row, "rank": int(rank[1])} for row in new]
        torn_files += [path] if torn else []
    return frame_of(rows, table.columns), torn_files


def frame_of(rows: Sequence[Row], columns: Iterable[Column]) -> DataFrame:
    """Make a DataFrame: all known columns in order, even if no row has them, then all other columns."""
    pd = _extras.pandas()
    columns = tuple(columns)
    known = {column.name for column in columns}
    others = list(dict.fromkeys(name for row in rows for name in row if name not in known))
    data = {column.name: _series([row.get(column.name) for row in rows], column.kind) for column in columns}
    data.update({name: pd.Series([row.get(name) for row in rows]) for name in others})
    table: DataFrame = pd.DataFrame(data)
    return table


def with_columns(table: DataFrame, columns: Iterable[Column]) -> DataFrame:
    """Return a table with all known columns, those that it lacks empty; the same table if it lacks none."""
    missing = [column for column in columns if column.name not in table.columns]
    nothing = {column.name: None if column.kind is str else float("nan") for column in missing}
    return table.assign(**nothing) if missing else table


def _series(values: list[Any], kind: type) -> Any:
    """Return a column; missing numbers become NaN (and integers floats), missing strings None."""
    pd = _extras.pandas()
    if kind is str:
        return pd.Series(values, dtype=object if None in values else "str")
    if kind is int and None not in values and all(type(value) is int for value in values):
        return pd.Series(values, dtype="int64")
    try:
        return pd.Series(values, dtype="float64")
    except (TypeError, ValueError):
        return pd.Series(values, dtype=object)
