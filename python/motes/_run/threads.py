"""How many threads each rank of a run has, where the script leaves it to the machine.

The ranks of a host share the processors that they may use: each takes its part of every processor that it
shares with others. Two ranks that are bound to a processor each have one thread each; two that may both use
eight have four each.
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
    """Where a rank computes."""

    host: str
    mask: bytes
    """The processors that its process may use: one bit each, `MASK_BYTES` bytes, the lowest first."""
    wish: int
    """The threads that its script or environment asks for; 0 leaves it to the machine."""
    most: int = MOST_THREADS
    """The threads that it may have unless it wishes for more."""


def processors(group: Path = Path("/sys/fs/cgroup/cpu.max")) -> bytes:
    """Return the mask of the processors that this process may use: see Place.

    A container that may use the time of two processors, on whichever they are, has the first two of them.
    """
    try:
        usable = sorted(os.sched_getaffinity(0))
    except AttributeError:  # a system without masks
        usable = list(range(os.cpu_count() or 1))
    usable = usable[: _most_at_once(group)]
    bits = sum(1 << number for number in usable if number < 8 * MASK_BYTES)
    return bits.to_bytes(MASK_BYTES, "little")


def most_threads() -> int:
    """Return the processors that Slurm gave each task.

    Where it binds tasks, masks say the same. Where it does not, a node's jobs share all its processors.
    """
    told = os.environ.get("SLURM_CPUS_PER_TASK", "")
    return min(max(1, int(told)), MOST_THREADS) if told.isdecimal() else MOST_THREADS


def threads_of(places: Sequence[Place]) -> list[int]:
    """Return the threads of each rank."""
    users: defaultdict[str, Counter[int]] = defaultdict(Counter)
    for place in places:
        users[place.host].update(_bits(place.mask))
    return [place.wish or _share(place, users[place.host]) for place in places]


def are_crowded(places: Sequence[Place]) -> bool:
    """Tell whether the ranks of a host have fewer processors than they are: then they take turns."""
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
    """Return how many processors the container's quota of processor time amounts to; None: it has none."""
    with contextlib.suppress(OSError, ValueError):
        quota, period = group.read_text().split()
        return max(1, math.ceil(int(quota) / int(period)))  # "max": no limit
    return None
