"""The number of threads of each rank, unless the script sets it.

The ranks of a host divide each processor that they may use among the ranks that share it. Two ranks bound to
one processor each have one thread each; two ranks that may both use the same eight processors have four each.
"""

from __future__ import annotations

import contextlib
import math
import os
from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from .._values.environment import MOST_THREADS

__all__ = ["MASK_BYTES", "Place", "are_crowded", "most_threads", "processors", "threads_of"]

MASK_BYTES = 128


class Place(NamedTuple):
    """The host and processors of a rank."""

    host: str
    mask: bytes
    """A bit mask of the processors that its process may use: `MASK_BYTES` bytes, little-endian."""
    wish: int
    """The threads requested by its script or environment; 0: not set."""
    most: int = MOST_THREADS
    """The most threads that it gets unless more are requested."""


def processors(group: Path = Path("/sys/fs/cgroup/cpu.max")) -> bytes:
    """Return the mask of the processors that this process may use: see `Place.mask`.

    If a container's quota is the time of two processors, the mask holds the first two.
    """
    try:
        usable = sorted(os.sched_getaffinity(0))
    except AttributeError:  # a system without masks
        usable = list(range(os.cpu_count() or 1))
    usable = usable[: _most_at_once(group)]
    bits = sum(1 << number for number in usable if number < 8 * MASK_BYTES)
    return bits.to_bytes(MASK_BYTES, "little")


def most_threads() -> int:
    """Return the number of processors that Slurm allocated to each task, or MOST_THREADS without Slurm.

    If Slurm binds tasks, their masks agree. Otherwise masks hold all processors of a node, which jobs share.
    """
    cpus = os.environ.get("SLURM_CPUS_PER_TASK", "")
    return min(max(1, int(cpus)), MOST_THREADS) if cpus.isdecimal() else MOST_THREADS


def threads_of(places: Sequence[Place]) -> list[int]:
    """Return the threads of each rank."""
    users: defaultdict[str, Counter[int]] = defaultdict(Counter)
    for place in places:
        users[place.host].update(_bits(place.mask))
    return [place.wish or _share(place, users[place.host]) for place in places]


def are_crowded(places: Sequence[Place]) -> bool:
    """Return whether some host has fewer processors than ranks, so that ranks take turns."""
    usable: defaultdict[str, set[int]] = defaultdict(set)
    for place in places:
        usable[place.host].update(_bits(place.mask))
    ranks = Counter(place.host for place in places)
    return any(ranks[host] > len(found) for host, found in usable.items())


def _share(place: Place, users: Counter[int]) -> int:
    share = sum(1 / users[number] for number in _bits(place.mask))
    return min(max(1, math.floor(share + 1e-9)), place.most)


def _bits(mask: bytes) -> list[int]:
    value = int.from_bytes(mask, "little")
    return [number for number in range(value.bit_length()) if value >> number & 1]


def _most_at_once(group: Path) -> int | None:
    """Return the container's quota of CPU time as a number of processors, rounded up; None: no quota."""
    with contextlib.suppress(OSError, ValueError):
        quota, period = group.read_text().split()
        return max(1, math.ceil(int(quota) / int(period)))  # "max": no limit
    return None
