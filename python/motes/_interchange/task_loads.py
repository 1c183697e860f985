"""Loads that another code measured: vt's load files, which LBAF reads and `Run.to_lbaf` writes, one per rank.

NAME.RANK.json is a JSON object of the type "LBDatafile" (docs/md/node-lb-data.md in vt), plain or compressed
with Brotli. Its phases are frames; its migratable tasks can be given to any rank.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _extras
from ..errors import LogError

__all__ = ["TaskLoads", "load_files", "read_task_loads"]

Floats = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]
_FILE = re.compile(r"(?P<stem>.+)\.(?P<rank>\d+)\.json(\.br)?")
_MOST_TASKS = 2**23  # their places in the row are exact in float32
_FINE = 1e-4
"""Seconds of a particle, in units of the power of ten below a task's mean: rounding matters little."""
_MOST_PHASES = 10**7


@dataclass(frozen=True)
class TaskLoads:
    """Seconds of tasks. They form a row, those of each rank side by side as when they were first seen.

    Attributes:
        name: the files' name without rank and suffix.
        phases: the phases' numbers, ascending.
        task_s: seconds of each migratable task, (phases, tasks); 0 where it is not there.
        rank_of: the rank that had it, (phases, tasks); -1 where it is not there.
        fixed_s: seconds of the tasks that cannot migrate, (phases, ranks).
        first: the rank that had each task first, ascending, (tasks,).
    """

    name: str
    phases: list[int]
    task_s: Floats
    rank_of: Counts
    fixed_s: Floats
    first: Counts
    system: ClassVar[str] = "tasks"
    """Name of the system that they are in tables."""

    @property
    def ranks(self) -> int:
        """Number of ranks, one per file."""
        return int(self.fixed_s.shape[1])

    @cached_property
    def particle_s(self) -> float:
        """Seconds of a particle: a power of ten, such that tasks have 10,000 to 100,000 on average."""
        some = self.task_s[self.task_s > 0]
        return float(10 ** math.floor(math.log10(some.mean()))) * _FINE if len(some) else 1.0

    @cached_property
    def cuts(self) -> npt.NDArray[np.float32]:
        """Where the row is cut at first, (ranks - 1,): task number i is at i + 1/2."""
        return np.searchsorted(self.first, np.arange(1, self.ranks)).astype(np.float32)

    def on_machines(self, powers: Floats) -> TaskLoads:
        """Return the loads as a machine of power 1 would have measured them.

        Args:
            powers: each rank's power, (ranks,).
        """
        scale = np.append(powers, 1.0)[self.rank_of]  # -1 is the last
        return replace(self, task_s=self.task_s * scale, fixed_s=self.fixed_s * powers)

    def lasting(self, frames: int) -> TaskLoads:
        """Return the loads of so many phases: the first ones, and then the last one again and again.

        Args:
            frames: number of phases.
        """
        rows = np.minimum(np.arange(frames), len(self.phases) - 1)
        more = range(self.phases[-1] + 1, self.phases[-1] + 1 + max(0, frames - len(self.phases)))
        known = {name: getattr(self, name)[rows] for name in ("task_s", "rank_of", "fixed_s")}
        return replace(self, phases=[*self.phases[:frames], *more], **known)

    def by_rank(self, k: int) -> Floats:
        """Return the seconds of each rank's migratable tasks in a phase, (ranks,).

        Args:
            k: index of the phase.
        """
        there = self.rank_of[k] >= 0
        seconds = np.bincount(self.rank_of[k][there], self.task_s[k][there], self.ranks)
        return seconds.astype(np.float64)  # without any task, they are integers


def load_files(path: Path) -> list[Path]:
    """Return the load files that a path names, by rank; none if it names none.

    Args:
        path: their directory, or "DIRECTORY/NAME", or one of them.

    Raises:
        LogError: if a directory has files of several names, or a rank's file is missing.
    """
    folder = path if path.is_dir() else path.parent
    if folder.joinpath("run.json").exists() or not folder.is_dir():
        return []
    families: dict[str, dict[int, Path]] = {}
    for one in sorted(folder.iterdir()):
        if found := _FILE.fullmatch(one.name):
            families.setdefault(found["stem"], {})[int(found["rank"])] = one
    if folder is not path:
        named = _FILE.fullmatch(path.name)
        stem = named["stem"] if named and path.exists() else path.name
        families = {stem: families[stem]} if stem in families else {}
    if len(families) > 1:
        names = ", ".join(repr(str(folder / stem)) for stem in families)
        raise LogError(f"{folder}: load files of several names; give one of {names}")
    for stem, files in families.items():
        for rank in range(max(files) + 1):
            if rank not in files:
                raise LogError(
                    f"{folder}/{stem}.{rank}.json: no such file; each rank up to {max(files)} has one"
                )
    return [files[rank] for files in families.values() for rank in sorted(files)]


def read_task_loads(files: Iterable[Path]) -> TaskLoads:
    """Read load files.

    Args:
        files: one per rank, as `load_files` returns them.

    Returns:
        The tasks of all ranks.

    Raises:
        LogError: if one cannot be read or is damaged, naming file and field.
        MissingExtraError: if one is compressed, and Brotli is not installed.
    """
    files = list(files)
    ranks = [dict(_phases(path, rank)) for rank, path in enumerate(files)]
    phases = sorted(ranks[0])
    for path, own in zip(files, ranks, strict=True):
        if sorted(own) != phases:
            other = min(set(phases) ^ set(own))
            which, lacks = (path, files[0]) if other in own else (files[0], path)
            raise LogError(f"{lacks}: phases: there is no phase {other}, which {which.name} has")
    if not phases:
        raise LogError(f"{files[0]}: phases: the list is empty")
    places: dict[Any, tuple[int, Any]] = {}  # of each task: its first rank, and its order there
    for phase in phases:
        for rank, own in enumerate(ranks):
            for key, task in own[phase].tasks.items():
                places.setdefault(key, (rank, task.order))
    row = sorted(places, key=lambda key: places[key])
    if len(row) > _MOST_TASKS:
        raise LogError(f"{files[0]}: phases: more than {_MOST_TASKS} tasks that can migrate")
    column = {key: i for i, key in enumerate(row)}
    task_s, fixed_s = np.zeros((len(phases), len(row))), np.zeros((len(phases), len(ranks)))
    rank_of = np.full(task_s.shape, -1, np.int64)
    for k, phase in enumerate(phases):
        for rank, own in enumerate(ranks):
            fixed_s[k, rank] = own[phase].fixed_s
            for key, task in own[phase].tasks.items():
                if rank_of[k, column[key]] >= 0:
                    other = files[rank_of[k, column[key]]].name
                    raise LogError(f"{files[rank]}: {task.at}.entity: {other} has this task, too")
                task_s[k, column[key]], rank_of[k, column[key]] = task.seconds, rank
    found = _FILE.fullmatch(files[0].name)
    first = np.array([places[key][0] for key in row], np.int64)
    return TaskLoads(found["stem"] if found else "", phases, task_s, rank_of, fixed_s, first)


class _Task(NamedTuple):
    at: str  # where in the file
    order: tuple[int, list[int], int]  # among the tasks of its rank
    seconds: float


class _Phase(NamedTuple):
    tasks: dict[Any, _Task]  # those that can migrate
    fixed_s: float


def _phases(path: Path, rank: int) -> Iterator[tuple[int, _Phase]]:
    """Yield the phases of a file by number, also those that only repeat the one before."""
    data = _content(path)
    about = data.get("metadata", {})
    if not isinstance(about, dict):
        raise _wrong(path, "metadata", about, "an object")
    kind = about.get("type", data.get("type"))
    if kind != "LBDatafile":
        raise _wrong(path, "metadata.type", kind, '"LBDatafile"')
    if (named := about.get("rank", rank)) != rank:
        raise _wrong(path, "metadata.rank", named, f"{rank}, as in the file's name,")
    repeated = _numbers(path, about)
    known: dict[int, _Phase] = {}
    for i, phase in enumerate(_field(path, "", data, "phases", list, "a list")):
        number = _field(path, f"phases[{i}]", phase, "id", int, "a whole number >= 0")
        if number < 0 or number in known:
            raise _wrong(path, f"phases[{i}].id", number, "another whole number >= 0 for each phase")
        known[number] = _phase(path, f"phases[{i}]", phase)
    for number in sorted(repeated - set(known)):
        if number - 1 not in known:
            where = "metadata.phases.identical_to_previous"
            raise _wrong(path, where, number, "the number of a phase behind one that is known")
        known[number] = known[number - 1]
    yield from known.items()


def _content(path: Path) -> Mapping[str, Any]:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: {error.strerror or error}") from error
    if content.lstrip()[:1] != b"{":  # vt compresses files by default, whatever their suffix
        brotli = _extras.brotli()
        try:
            content = brotli.decompress(content)
        except brotli.error:
            raise LogError(f"{path}: neither JSON nor compressed with Brotli") from None
    try:
        data = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise LogError(f"{path}: damaged: {error}") from None
    if not isinstance(data, dict):
        raise LogError(f"{path}: a JSON object is expected")
    return data


def _numbers(path: Path, about: Mapping[str, Any]) -> set[int]:
    """Return the numbers of the phases that are not written because they equal the one before."""
    where = "metadata.phases.identical_to_previous"
    phases = about.get("phases", {})
    same = phases.get("identical_to_previous", {}) if isinstance(phases, dict) else phases
    parts = [same.get(name, []) for name in ("list", "range")] if isinstance(same, dict) else [same]
    if not all(isinstance(part, list) for part in parts):
        raise _wrong(path, where, same, 'an object with the lists "list" and "range"')
    single, ranges = parts
    found: set[int] = set()
    for one in [*([number, number] for number in single), *ranges]:
        if not (isinstance(one, list) and len(one) == 2 and all(type(end) is int for end in one)):
            raise _wrong(path, where, one, "phase numbers, and [first, last] in ranges,")
        if not 0 < one[0] <= one[1] < _MOST_PHASES:
            raise _wrong(path, where, one, f"ascending phase numbers from 1 to {_MOST_PHASES}")
        found.update(range(one[0], one[1] + 1))
    return found


def _phase(path: Path, at: str, phase: Any) -> _Phase:
    tasks: dict[Any, _Task] = {}
    fixed_s = 0.0
    for i, one in enumerate(_field(path, at, phase, "tasks", list, "a list")):
        here = f"{at}.tasks[{i}]"
        seconds = _field(path, here, one, "time", (int, float), "seconds >= 0")
        if not 0 <= seconds < math.inf:
            raise _wrong(path, f"{here}.time", seconds, "seconds >= 0")
        entity = _field(path, here, one, "entity", dict, "an object")
        if not _field(path, f"{here}.entity", entity, "migratable", bool, "true or false"):
            fixed_s += seconds
            continue
        key, order = _key(path, f"{here}.entity", entity)
        if key in tasks:
            raise LogError(f"{path}: {here}.entity: {tasks[key].at} is the same task")
        tasks[key] = _Task(here, order, float(seconds))
    return _Phase(tasks, fixed_s)


def _key(path: Path, at: str, entity: Mapping[str, Any]) -> tuple[Any, tuple[int, list[int], int]]:
    """Return what identifies a task, and its order among those of its rank."""
    collection = entity.get("collection_id", -1)
    if type(collection) is not int:
        raise _wrong(path, f"{at}.collection_id", collection, "a whole number")
    name = "id" if "id" in entity or "seq_id" not in entity else "seq_id"
    number = _field(path, at, entity, name, int, "a whole number")
    index = entity.get("index", [])
    if not isinstance(index, list) or not all(type(one) is int for one in index):
        raise _wrong(path, f"{at}.index", index, "a list of whole numbers")
    return (name, collection, number), (collection, index, number)


def _field(path: Path, at: str, one: Any, name: str, kinds: Any, what: str) -> Any:
    """Return a field of an object."""
    if not isinstance(one, dict):
        raise _wrong(path, at, one, "an object")
    kinds = kinds if isinstance(kinds, tuple) else (kinds,)
    where = f"{at}.{name}" if at else name
    if name not in one:
        raise LogError(f"{path}: {where}: the field is missing; {what} is expected")
    if type(value := one[name]) not in kinds:
        raise _wrong(path, where, value, what)
    return value


def _wrong(path: Path, where: str, value: Any, what: str) -> LogError:
    text = json.dumps(value)
    return LogError(
        f"{path}: {where}: {what} is expected, not {text if len(text) < 60 else text[:57] + '...'}"
    )
