"""The manager or the calculators create births, depending on their number; the particles are the same."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from standing import on_ranks

import motes
from motes._run.threads import MASK_BYTES, Place, are_crowded, processors

SCENE = """
import json, sys
import motes

counts, options = json.loads(sys.argv[2]), json.loads(sys.argv[3])
options |= {"progress": "off", "roles": "shared", "space": (-1, 1), "threads": 1}
world = motes.World(seed=3, log=sys.argv[1], **options)
first, second = world.system("first"), world.system("second")
with world:
    for frame in world.frames(len(counts)):
        for system in (first, second):
            if counts[frame]:
                system.burst(motes.shapes.Box((-1, -1, -1), (1, 1, 1)), counts[frame] // 2)
        world.step()
    text = world.digest()
    world.say(text)
"""
COUNTS = [0, 10, 30_000, 500, 20_000]


def rows_and_digest(ranks: int, log: Path, **options: Any) -> tuple[list[str | None], str]:
    result = on_ranks(ranks, SCENE, log, json.dumps(COUNTS), json.dumps(options))
    assert result.code == 0, result.text
    rows = [json.loads(line) for line in (log / "frames.jsonl").read_text().splitlines()]
    return [row.get("births_by") for row in rows], result.lines[-1]


@pytest.mark.parametrize("combine", ["together", "one_by_one", "overlapped"])
def test_the_log_says_who_created_births_and_all_are_the_same(tmp_path, combine):
    by: dict[str, list[str | None]] = {}
    digests = set()
    for births in ("manager", "calculators", "auto"):
        by[births], digest = rows_and_digest(2, tmp_path / births, births=births, combine=combine)
        digests.add(digest)
    assert len(digests) == 1
    assert by["manager"] == [None, *["manager"] * 4]
    assert by["calculators"] == [None, *["calculators"] * 4]
    many = "manager" if crowded(2) else "calculators"
    assert by["auto"] == [None, "manager", many, "manager", many]
    assert json.loads((tmp_path / "auto" / "run.json").read_text())["births"] == "auto"


def crowded(ranks: int) -> bool:
    """Return whether there are more ranks than available processors."""
    return int.from_bytes(processors(), "little").bit_count() < ranks


def test_one_calculator_creates_in_place(tmp_path):
    by, _ = rows_and_digest(1, tmp_path / "one")
    assert by == [None, *["manager"] * 4]


@pytest.mark.parametrize(
    ("processors_of", "expected"),
    [
        ([("a", 0b11), ("a", 0b11)], False),
        ([("a", 0b11), ("a", 0b11), ("a", 0b11)], True),
        ([("a", 0b01), ("a", 0b01)], True),
        ([("a", 0b01), ("a", 0b10), ("b", 0b01)], False),
        ([("a", 0b11), ("b", 0b01), ("b", 0b01)], True),
    ],
)
def test_ranks_that_take_turns_are_known(processors_of, expected):
    places = [Place(host, bits.to_bytes(MASK_BYTES, "little"), 0) for host, bits in processors_of]
    assert are_crowded(places) is expected


def test_logs_of_earlier_versions_are_read(tmp_path):
    log = tmp_path / "log"
    rows_and_digest(2, log)
    rows = [json.loads(line) for line in (log / "frames.jsonl").read_text().splitlines()]
    for row in rows:
        row.pop("births_by", None)
    (log / "frames.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    frames = motes.open_run(log).frames
    assert len(frames) == len(COUNTS) and frames["births_by"].isna().all()
    assert motes.open_run(log).summary()["frames"] == len(COUNTS)
