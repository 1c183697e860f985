"""Reads text dumps of LAMMPS: styles `atom` and `custom`, several steps per file, also compressed (.gz)."""

from __future__ import annotations

import weakref
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from gzip import GzipFile
from io import BufferedReader
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MotesError

__all__ = ["Dump", "is_dump"]

ITEM = b"ITEM: "
PLACES = {"x": False, "xu": False, "xs": True, "xsu": True}
"""Names of the first coordinate -> whether it is a fraction of the box; the first that a dump has is read."""
VECTORS = {
    "velocity": ("vx", "vy", "vz"),
    "force": ("fx", "fy", "fz"),
    "omega": ("omegax", "omegay", "omegaz"),
    "spin": ("spx", "spy", "spz"),
}
COLUMNS = b"ITEM: ATOMS"
LINES = {b"TIMESTEP": 1, b"TIME": 1, b"UNITS": 1, b"NUMBER OF ATOMS": 1, b"BOX BOUNDS": 3}
"""Items of a header -> their lines."""


def is_dump(path: Path) -> bool:
    """Return whether a file begins like a text dump."""
    try:
        with _opened(path) as file:
            return file.read(len(ITEM)) == ITEM
    except (OSError, EOFError):
        return False


def _opened(path: Path) -> GzipFile | BufferedReader:
    with path.open("rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
    return GzipFile(path) if packed else path.open("rb")


@dataclass(frozen=True)
class _Step:
    """Where a step's atoms are in the file, and its box."""

    number: int
    time: float
    count: int
    offset: int
    """Of the first atom's line, in bytes of the text."""
    names: tuple[str, ...]
    axes: NDArray[np.float64]
    """The box: its three edges, and its lowest corner in the last row."""


class Dump:
    """The complete steps of a dump. Steps that a continued run wrote again replace the first ones."""

    def __init__(self, path: Path) -> None:
        """Find the steps. Raises MotesError if the file is damaged before its last step."""
        self.path = path
        self._file = _opened(path)
        weakref.finalize(self, self._file.close)
        self.finished = True
        """Whether the last step is complete."""
        self.texts: set[str] = set()
        """The columns that were left out so far, because they hold texts."""
        self._steps = {step.number: step for step in self._scan()}
        if not self._steps:
            raise MotesError(f"{path} cannot be read: it has no complete step")

    @property
    def steps(self) -> list[tuple[int, float, int]]:
        """Number, time and count of atoms of each step, by number."""
        return [(one.number, one.time, one.count) for _, one in sorted(self._steps.items())]

    def columns(self) -> dict[str, int]:
        """Return name and width of the columns of all steps; texts, such as elements, are left out."""
        columns = self.read(min(self._steps))
        return {
            name: array.shape[1] if array.ndim == 2 else 1 for name, array in columns.items() if name != "id"
        }

    def read(self, number: int) -> dict[str, NDArray[Any]]:
        """Return a step's columns, sorted by id."""
        step = self._steps[number]
        self._file.seek(step.offset)
        words = b"".join(islice(self._file, step.count)).split()
        width = len(step.names)
        if len(words) != step.count * width:
            raise MotesError(f"{self.path} is damaged: step {number} has atoms without {width} values")
        table = np.array(words).reshape(step.count, width)
        given = {name: table[:, at] for at, name in enumerate(step.names)}
        ids = given.pop("id").astype(np.uint64) if "id" in given else np.arange(step.count, dtype=np.uint64)
        numbers: dict[str, NDArray[np.float64]] = {}
        for name, column in given.items():
            try:
                numbers[name] = column.astype(np.float64)
            except ValueError:
                self.texts.add(name)
        joined = _named(numbers, step.axes)
        if joined is None:
            raise MotesError(f"{self.path} cannot be read: its atoms have no coordinates x, xu, xs or xsu")
        order = np.argsort(ids, kind="stable")
        with np.errstate(over="ignore"):  # values beyond float32 become infinite
            floats = {name: column.astype(np.float32)[order] for name, column in joined.items()}
        return {**floats, "id": ids[order]}

    # --- the file's structure

    def _scan(self) -> Iterator[_Step]:
        while True:
            try:
                step = self._header()
            except (EOFError, OSError):  # cut off, in the text or in its compression
                self.finished = False
                return
            except (ValueError, IndexError, StopIteration):
                raise MotesError(
                    f"{self.path} is damaged near byte {self._file.tell()} of its text"
                ) from None
            if step is None:
                return
            yield step

    def _header(self) -> _Step | None:
        """Read a step's header and skip its atoms; None at the end. Raises EOFError in an incomplete step."""
        parts: dict[bytes, list[bytes]] = {}
        line = self._file.readline()
        if not line.strip():
            return None
        while not line.startswith(COLUMNS):
            if not line.startswith(ITEM):
                raise ValueError(line)
            head = line[len(ITEM) :].strip()
            kind = next((kind for kind in LINES if head.startswith(kind)), None)
            if kind is None:
                raise MotesError(f"{self.path} cannot be read: it has no atoms, but {head.decode()!r}")
            parts[kind] = [head[len(kind) :], *(self._whole_line() for _ in range(LINES[kind]))]
            line = self._whole_line()
        number, count = (int(parts[kind][1]) for kind in (b"TIMESTEP", b"NUMBER OF ATOMS"))
        time = float(parts[b"TIME"][1]) if b"TIME" in parts else float(number)
        names = tuple(name.decode() for name in line[len(COLUMNS) :].split())
        offset = self._file.tell()
        last = b"\n"
        seen = 0
        for seen, last in enumerate(islice(self._file, count), 1):  # noqa: B007
            pass
        if seen < count or not last.endswith(b"\n"):
            raise EOFError
        return _Step(number, time, count, offset, names, _box(parts[b"BOX BOUNDS"]))

    def _whole_line(self) -> bytes:
        line = self._file.readline()
        if not line.endswith(b"\n"):
            raise EOFError
        return line


def _box(lines: Sequence[bytes]) -> NDArray[np.float64]:
    """Return the three edges of a box and its lowest corner, from the item's four lines."""
    head = lines[0].split()
    rows = [[float(word) for word in line.split()] for line in lines[1:]]
    if b"abc" in head:  # edges and origin as they are
        table = np.array(rows)
        return np.vstack([table[:, :3], table[:, 3]])
    low, high = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
    xy, xz, yz = (row[2] for row in rows) if b"xy" in head else (0.0, 0.0, 0.0)
    low -= (min(0, xy, xz, xy + xz), min(0, yz), 0)  # the bounds are those of the tilted box
    high -= (max(0, xy, xz, xy + xz), max(0, yz), 0)
    x, y, z = high - low
    return np.array([[x, 0, 0], [xy, y, 0], [xz, yz, z], low])


def _named(
    given: Mapping[str, NDArray[np.float64]], axes: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]] | None:
    """Return columns under our names, with coordinates in the dump's unit of length; None: it has none."""
    left = dict(given)
    first = next((name for name in PLACES if name in left and "y" + name[1:] in left), None)
    if first is None:
        return None
    flat = np.zeros(len(left[first]))
    place = np.stack([left.pop(axis + first[1:], flat) for axis in "xyz"], axis=1)
    own = {"position": place @ axes[:3] + axes[3] if PLACES[first] else place}
    for name, three in VECTORS.items():
        if all(one in left for one in three):
            own[name] = np.stack([left.pop(one) for one in three], axis=1)
    if "diameter" in left or "radius" in left:
        diameter = left.pop("diameter") if "diameter" in left else 2 * left.pop("radius")
        own["size"] = np.repeat(diameter[:, None], 3, axis=1)
    for name, column in left.items():
        plain = "".join(letter if letter.isalnum() else "_" for letter in name).strip("_")
        own[plain if plain not in own else f"{plain}_"] = column
    return own
