"""Runs a scene with all features on any ranks, and compares its frames with those on one rank."""

from __future__ import annotations

import json
import platform
from functools import cache
from pathlib import Path
from typing import Any

from standing import on_ranks

EVERYTHING = Path(__file__).parents[1] / "scenes" / "everything.py"


@cache
def alone(variants: str) -> dict[tuple[int, int], list[str]]:
    """Return the frames of the scene on one rank, by variant and frame."""
    return table(on_ranks(1, EVERYTHING, variants).lines)


def table(lines: list[str]) -> dict[tuple[int, int], list[str]]:
    """Read the scene's output."""
    rows = [line.split() for line in lines]
    found = {(int(row[0]), int(row[1])): row[2:] for row in rows}
    assert len(found) == len(rows), "one line per frame"
    return found


def expected() -> list[list[str]]:
    """Return the frames that every variant must show."""
    frames = alone(json.dumps([{"roles": "auto", "space": None}]))
    return [frames[0, frame] for frame in range(len(frames))]


def on_all_paths(scene: str) -> list[str]:
    """Run a scene, whose arguments are path and roles, on 1 to 5 ranks; return its lines, alike on all."""
    alone = on_ranks(1, scene, "gather", "auto").lines
    for path in ("gather", "tiles", "composite"):
        assert on_ranks(2, scene, path, "shared").lines == alone
    assert on_ranks(3, scene, "tiles", "auto").lines == alone
    assert on_ranks(5, scene, "composite", "auto").lines == alone
    return alone


def roles(size: int) -> list[Any]:
    """Return ordinary and unusual roles for a number of ranks: [manager, image generator, calculators]."""
    ranks = list(range(size))
    wishes: list[Any] = ["auto", "shared", [size - 1, size // 2, ranks[::-1]]]
    if size > 2:
        wishes.append([2, 1, [2, 0]])  # the manager calculates, and some ranks have no role
    return wishes


def assert_same(size: int, variants: list[dict[str, Any]], env: dict[str, str] | None = None) -> None:
    """Run variants on this many ranks, and compare."""
    lines = on_ranks(size, EVERYTHING, json.dumps(variants), timeout=200, env=env).lines
    assert_equal(table(lines), variants)


def assert_equal(frames: dict[tuple[int, int], list[str]], variants: list[dict[str, Any]]) -> None:
    """Compare every variant's frames with those of one rank."""
    wanted = expected()
    assert len(frames) == len(wanted) * len(variants)
    for (variant, frame), row in sorted(frames.items()):
        assert row == wanted[frame], f"{variants[variant]}, frame {frame}"


def widths() -> list[str]:
    """Return the names of the instruction sets that this processor has."""
    flags = Path("/proc/cpuinfo").read_text().split() if Path("/proc/cpuinfo").exists() else []
    if platform.machine() == "aarch64":
        return ["neon"]
    needs = {"sse2": [], "avx2": ["avx2"], "avx512": ["avx512f", "avx512dq", "avx512vl", "avx512bw"]}
    return [name for name, wanted in needs.items() if all(flag in flags for flag in wanted)]
