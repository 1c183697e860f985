"""steer.jsonl: the steering of a run, written to its log and read by a run that repeats it.

The first line is a header: schema, ranks, seed, script_sha256, controls. Each further line is a frame before
which something changed, {"frame": 198, "set": {"wind": 0.7}} or {"frame": 198, "camera": {...}}; also
"balancer": a call, and "speeds": of ranks that behave like slower machines, neither of which changes a
particle; and "resize": the number of ranks with which the run went on, which no run repeats. The last line
may be {"frame": 345, "stop": true}, where a viewer or a signal ended the run. Pauses and single steps change
no frame, so they are omitted. Numbers are the shortest decimals that read back to the same bits.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from .._io import files
from .._values.environment import LEAST_SPEED
from ..errors import ArgumentError, LogError
from .pose import Pose

__all__ = ["CHANGES", "NAME", "Header", "SteerFile", "is_speed", "read"]

NAME = "steer.jsonl"
SCHEMA = 1
CHANGES = ("set", "camera", "balancer", "speeds")
"""What a row may change."""
Header = dict[str, Any]
Rows = dict[int, dict[str, Any]]


class SteerFile:
    """The file that a run writes, on the manager."""

    def __init__(
        self, directory: str | os.PathLike[str], header: Header, *, ranks: int, continued_from: int
    ) -> None:
        """Create the file; a continued run keeps the rows of frames before `continued_from`.

        `ranks`: with how many the run goes on.

        Raises LogError if it cannot be written, or if the existing file is damaged.
        """
        self.path = Path(directory) / NAME
        self.resized: int | None = None
        """The number of ranks if it was another before; to be written in the first row."""
        self._file: IO[str] | None = None
        lines = []
        try:
            if continued_from > 0 and self.path.exists():
                before, rows = _read(self.path)
                kept = {frame: row for frame, row in rows.items() if frame < continued_from}
                lines = [_line({"frame": frame, **row}) for frame, row in kept.items()]
                first = before.get("ranks", ranks)
                last = [first, *(row["resize"] for row in kept.values() if "resize" in row)][-1]
                self.resized, header = None if last == ranks else ranks, {**header, "ranks": first}
            lines.insert(0, _line({"schema": SCHEMA, "ranks": ranks, **header}))
            files.write_whole(self.path, "".join(lines).encode())
            self._file = files.append_to(self.path)
        except ValueError as error:
            raise LogError(f"{self.path}: cannot be continued: {error}") from None
        except OSError as error:
            raise self._failed(error) from error

    def add(self, frame: int, row: Mapping[str, Any]) -> None:
        """Write a row. Raises LogError if it cannot."""
        try:
            if self._file is not None:
                self._file.write(_line({"frame": frame, **row}))
                self._file.flush()
        except OSError as error:
            raise self._failed(error) from error

    def secure(self) -> None:
        """Flush the file to disk, before a checkpoint is written. Raises LogError."""
        try:
            if self._file is not None:
                os.fsync(self._file.fileno())
        except OSError as error:
            raise self._failed(error) from error

    def close(self) -> None:
        """Close the file; further rows are ignored."""
        file, self._file = self._file, None
        if file is not None:
            file.close()

    def _failed(self, error: OSError) -> LogError:
        return LogError(f"{self.path}: cannot be written: {error.strerror or error}")


def read(path: str) -> tuple[Header, Rows]:
    """Return the header, and the rows by frame. Raises ArgumentError, naming the line, for a damaged file."""
    try:
        return _read(Path(path))
    except OSError as error:
        raise ArgumentError("steering", path, f"a {NAME} of a run: {error.strerror or error}") from None
    except ValueError as error:
        raise ArgumentError("steering", path, f"a {NAME} of a run: {error}") from None


def _read(path: Path) -> tuple[Header, Rows]:
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    if lines and not text.endswith("\n"):
        lines.pop()  # cut off when the run was killed
    if not lines:
        raise ValueError("it is empty")
    header = _parsed(lines[0], 1)
    if header.get("schema") != SCHEMA:
        raise ValueError(f"its schema is {header.get('schema')!r}, not {SCHEMA}")
    seed = header.get("seed")
    if type(seed) is not int or not 0 <= seed < 2**64 or not isinstance(header.get("script_sha256"), str):
        raise ValueError("its first line lacks a seed, 0..2^64-1, and script_sha256")
    rows: Rows = {}
    for number, line in enumerate(lines[1:], start=2):
        frame, row = _row(_parsed(line, number), number)
        if frame in rows or (rows and frame < max(rows)):
            raise ValueError(f"line {number}: frame {frame} comes after a later one")
        rows[frame] = row
    return header, rows


def is_speed(pair: tuple[Any, Any]) -> bool:
    """Return whether a pair is a rank as digits and the speed at which it may run."""
    rank, speed = pair
    is_rank = isinstance(rank, str) and rank.isascii() and rank.isdigit() and len(rank) < 10
    return is_rank and type(speed) in (int, float) and LEAST_SPEED <= speed <= 1


def _parsed(line: str, number: int) -> dict[str, Any]:
    try:
        parsed = json.loads(line)
    except (ValueError, RecursionError):
        parsed = None
    if not isinstance(parsed, dict):
        raise ValueError(f"line {number} is not a JSON object")
    return parsed


def _row(row: dict[str, Any], number: int) -> tuple[int, dict[str, Any]]:
    frame = row.pop("frame", None)
    if type(frame) is not int or not 0 <= frame < 2**63 or set(row) - {*CHANGES, "resize", "stop"}:
        raise ValueError(f"line {number} must have a frame, and {', '.join(CHANGES)}, resize or stop")
    if type(row.get("resize", 1)) is not int or row.get("resize", 1) < 1:
        raise ValueError(f"line {number} has no number of ranks")
    speeds = row.get("speeds", {})
    slow = isinstance(speeds, dict) and all(map(is_speed, speeds.items()))
    if not slow or not isinstance(row.get("balancer", ""), str):
        raise ValueError(f"line {number} has no speeds 0.001..1 of ranks, or no balancer")
    if not isinstance(row.get("set", {}), dict) or row.get("stop", True) is not True:
        raise ValueError(f"line {number} sets or stops nothing")
    if row.get("camera") is not None:
        try:
            Pose.read(row["camera"])
        except (ValueError, ArithmeticError) as error:
            raise ValueError(f"line {number}: {error}") from None
    return frame, row


def _line(content: Mapping[str, Any]) -> str:
    return json.dumps(content) + "\n"
