"""The grid of a sweep: its values from text, and the cases that they make."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import quote

from ..errors import ArgumentError

__all__ = ["Case", "cases", "whole_numbers"]

MOST = 100_000
"""Most runs of a sweep."""
ALLOWED = "NAME=a:b:n (n numbers from a to b), NAME=a..b (whole numbers) or NAME=a,b,c (a list)"
_LONGEST = 180  # letters of a folder's name


@dataclass(frozen=True)
class Case:
    """One run of a sweep."""

    controls: tuple[tuple[str, str], ...]
    """Names and values of controls, as text."""
    seed: int | None
    ranks: int
    balancer: str | None

    @property
    def values(self) -> dict[str, str]:
        """Everything that a sweep may vary, as text, in the order in which it is shown."""
        given = dict(self.controls)
        if self.seed is not None:
            given["seed"] = str(self.seed)
        given["ranks"] = str(self.ranks)
        if self.balancer is not None:
            given["balancer"] = self.balancer
        return given

    @property
    def name(self) -> str:
        """The run in words: "gravity=1, seed=0, ranks=2"."""
        return ", ".join(f"{name}={value}" for name, value in self.values.items())

    @property
    def folder(self) -> str:
        """The name of the run's folder."""
        name = ",".join(f"{quote(n, safe=' ')}={quote(v, safe=' +')}" for n, v in self.values.items())
        if len(name) <= _LONGEST:
            return name
        return f"{name[:_LONGEST]}~{hashlib.sha256(self.name.encode()).hexdigest()[:12]}"


def cases(
    given: Sequence[str], ranks: Sequence[int], balancers: Sequence[str | None] = (None,)
) -> list[Case]:
    """Return all combinations; `given`: the texts of `--set`. Raises ArgumentError."""
    axes: dict[str, list[str]] = {}
    for text in given:
        name, values = _axis(text)
        if name in axes or name in ("ranks", "balancer"):
            hint = f"use --{name}" if name in ("ranks", "balancer") else f"{name!r} is given twice"
            raise ArgumentError("--set", text, ALLOWED, hint=hint)
        axes[name] = values
    seeds: list[int | None] = [_seed(text) for text in axes.pop("seed", [])] or [None]
    parts = [[(name, value) for value in values] for name, values in axes.items()]
    count = math.prod(len(part) for part in parts) * len(seeds) * len(ranks) * len(balancers)
    if count > MOST:
        allowed = f"values for at most {MOST} runs"
        raise ArgumentError("--set", " ".join(given), allowed, hint=f"these are {count}")
    return [
        Case(controls, seed, n, balancer)
        for controls in itertools.product(*parts)
        for seed in seeds
        for n in ranks
        for balancer in balancers
    ]


def whole_numbers(argument: str, text: str) -> list[int]:
    """Return the numbers of ranks in "1,2,4" or "1..4". Raises ArgumentError."""
    allowed = "whole numbers above 0, such as 1,2,4 or 1..4"
    try:
        numbers = [int(value) for value in _values(text)]
    except ValueError:
        raise ArgumentError(argument, text, allowed) from None
    if min(numbers) < 1 or len(set(numbers)) < len(numbers):
        raise ArgumentError(argument, text, allowed)
    return numbers


def _axis(text: str) -> tuple[str, list[str]]:
    name, equals, rest = text.partition("=")
    try:
        values = _values(rest)
    except ValueError:
        raise ArgumentError("--set", text, ALLOWED) from None
    if not equals or not name or len(set(values)) < len(values):
        raise ArgumentError("--set", text, ALLOWED)
    return name, values


def _values(text: str) -> list[str]:
    """Return the values of a text. Raises ValueError."""
    if match := re.fullmatch(r"(-?\d+)\.\.(-?\d+)", text):
        low, high = map(int, match.groups())
        if high < low or high - low >= MOST:
            raise ValueError(text)
        return [str(number) for number in range(low, high + 1)]
    if text.count(":") == 2 and "," not in text:
        low_text, high_text, count_text = text.split(":")
        return _spaced(float(low_text), float(high_text), int(count_text))
    values = text.split(",")
    if not all(values):
        raise ValueError(text)
    return values


def _spaced(low: float, high: float, count: int) -> list[str]:
    if (
        not (math.isfinite(low) and math.isfinite(high))
        or not 1 <= count <= MOST
        or (count == 1) != (low == high)
    ):
        raise ValueError(low, high, count)
    numbers = [low + (high - low) * step / max(count - 1, 1) for step in range(count)]
    return [f"{float(f'{number:.12g}'):.12g}" for number in numbers]  # 0.3, not 0.30000000000000004


def _seed(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) >= 2**64:
        raise ArgumentError("seed", text, "whole numbers in 0..2^64-1")
    return int(text)


def wishes_of(case: Case | None, folder: str, result: str) -> bytes:
    """Return the content of MOTES_SWEEP's file for a run in a folder; None: it only tells its controls."""
    content = {
        "controls": {} if case is None else dict(case.controls),
        "seed": None if case is None else case.seed,
        "balancer": None if case is None else case.balancer,
        "log": f"{folder}/log",
        "result": result,
        "probe": case is None,
    }
    return json.dumps(content).encode()
