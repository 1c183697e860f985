"""Examines the hosts of a cluster: whether they can run one job, and how fast the ranks of each are."""

from __future__ import annotations

import importlib
import json
import platform
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

from .._launch import starting
from .._launch.hosts import answer_of, check_names
from .._mpi.loading import import_mpi, use_mpi
from ..errors import ArgumentError, MotesError
from . import speed

__all__ = ["Figures", "examine", "powers_of", "shown"]

_LIMIT_S = 90.0
_AT_ONCE = 64
_ROLES = ("auto", "shared")
_PYTHON, _NO_MOTES = "motes-python", "motes-none "
# Another Python may be unable to read a line of motes. As one line, since the remote shell may be csh.
_SCRIPT = f"""\
import sys
sys.stdout.write('{_PYTHON} %d.%d\\n' % sys.version_info[:2])
sys.stdout.flush()
try:
    from motes.cli import speed
except ImportError as error:
    sys.exit('{_NO_MOTES}%s' % error)
speed.main()
"""
_ASK = f"exec({_SCRIPT!r})"
Figures = dict[str, Any]


class Place(NamedTuple):
    """A host, and how many ranks it takes."""

    host: str
    ranks: int


def examine(hosts: str) -> tuple[Figures, list[str]]:
    """Measure the hosts of "h1:2,h2", all at the same time; return figures, and a sentence per problem.

    Raises ArgumentError for what is no such text.
    """
    places = [_place(text, hosts) for text in hosts.split(",")]
    check_names("--hosts", (place.host for place in places))
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        told = list(pool.map(_ask, places))
    rows = [row for row in told if isinstance(row, dict)]
    problems = [problem for problem in told if isinstance(problem, str)]
    if not problems:
        problems = _differences(rows)
    figures: Figures = {"hosts": rows}
    if not problems:
        # mpirun fills one host before the next.
        speeds = [row["particles_per_s"] for row in rows for _ in range(row["ranks"])]
        figures["powers"] = {roles: powers_of(speeds, _calculators(roles, len(speeds))) for roles in _ROLES}
    return figures, problems


def powers_of(speeds: Sequence[float], calculators: Sequence[int]) -> list[float]:
    """Return the powers of the ranks that calculate, from the speeds of all: 1 for the slowest."""
    slowest = min(speeds[rank] for rank in calculators)
    return [round(speeds[rank] / slowest, 2) for rank in calculators]


def shown(figures: Figures) -> list[str]:
    """Return the figures as lines of text."""
    heads = ("host", "ranks", "threads", "instructions", "particles/s of a rank", "processor")
    table = [heads, *(_cells(row) for row in figures["hosts"])]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in table]
    for roles, powers in figures.get("powers", {}).items():
        told = "" if roles == "auto" else f', roles="{roles}"'
        lines += ["", f"World(balancer=motes.balance.Pairwise(powers={powers}){told})"]
    return lines


def _cells(row: Figures) -> tuple[str, ...]:
    speed = f"{row['particles_per_s'] / 1e6:.1f} million"
    return row["host"], str(row["ranks"]), str(row["threads"]), row["simd"], speed, row["processor"]


def _place(text: str, hosts: str) -> Place:
    host, colon, ranks = text.partition(":")
    if colon and not (ranks.isascii() and ranks.isdigit() and 0 < int(ranks) <= starting.most_ranks()):
        raise ArgumentError("--hosts", hosts, "hosts, each with the number of ranks it takes: h1,h2:2")
    return Place(host, int(ranks or 1))


def _ask(place: Place) -> Figures | str:
    """Return a host's figures, or the sentence that says why there are none."""
    here = f"{sys.version_info[0]}.{sys.version_info[1]}"
    try:
        answer = answer_of(place.host, [sys.executable, "-c", _ASK, str(place.ranks)], _LIMIT_S)
    except subprocess.TimeoutExpired:
        return f"{place.host} did not answer within {_LIMIT_S:.0f} s"
    except OSError as error:
        return f"{place.host} cannot be asked: {error}"
    lines = [line for line in answer.stdout.splitlines() if line.startswith(("{", _PYTHON))]
    if not lines:
        if answer.returncode in (126, 127):
            same = "every host needs the same environment at the same path"
            return f"{place.host} has no {sys.executable}, or no shell: {same}"
        return f"{place.host} does not answer: {starting.reason(answer)}"
    there = lines[0].partition(" ")[2]
    if there != here:
        return (
            f"{place.host} runs Python {there}, this host {platform.python_version()}: one job needs the same"
        )
    if _NO_MOTES in answer.stderr:
        reason = answer.stderr.partition(_NO_MOTES)[2].strip()
        return f"{place.host} has no motes for {sys.executable}: {reason}"
    if answer.returncode or not lines[-1].startswith("{"):
        return f"{place.host} cannot be measured: {starting.reason(answer)}"
    return {"host": place.host, "ranks": place.ranks, **json.loads(lines[-1])}


def _differences(rows: Sequence[Figures]) -> list[str]:
    """Return what differs between this host and others that must be the same in one job."""
    here = {"motes": speed.version(), "mpi": str(starting.library())}
    return [
        f"{row['host']} has {_named(name, row[name])}, this host {_named(name, mine)}: one job needs the same"
        for row in rows
        for name, mine in here.items()
        if row[name] != mine
    ]


def _named(name: str, version: object) -> str:
    return f"motes {version}" if name == "motes" else str(version)


def _calculators(roles: str, ranks: int) -> list[int]:
    try:
        use_mpi(import_mpi())  # without starting MPI
        core = importlib.import_module("motes._core")
    except ImportError as error:
        raise MotesError(f"the compiled core does not load: {error}") from None
    return list(core.cast(roles, ranks)[2])
