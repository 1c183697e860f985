"""Logs of earlier versions: their columns and phases are read under their present names."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from handmade import rows
from standing import on_ranks

import motes
from motes import LogError
from motes.analysis._tables.schema import EARLIER_PHASES, TABLES, Table
from motes.analysis._tables.tables import Follower

pandas = pytest.importorskip("pandas")

COLUMNS = {
    "meetings": "interactions",
    "copies": "ghosts",
    "copied_bytes": "interaction_bytes",
    "hops": "neighbour_ranks",
    "t_meet_s": "t_interact_s",
    "t_meet_wait_s": "t_interact_wait_s",
}
PHASES = {"word": "all_reduce", "copies": "replicas", "send leavers": "send migrants"}
PHASE_COLUMNS = {("waits", "phase"), ("spans", "phase"), ("spans", "message")}

SCENE = """
import sys
import motes
from motes.shapes import Box

world = motes.World(seed=3, space=(-1, 1), log=sys.argv[1], progress="off", spans=True)
s = world.system("dust")
s.configure(velocity=(1, 0, 0))
with world:
    for frame in world.frames(6):
        s.source(Box((-1, -1, -1), (1, 1, 1)), rate=12_000)
        s.gravitate(max_radius=0.1)
        s.move()
        world.step()
"""

Row = dict[str, Any]


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    """Let four ranks write a log; add a row about replicas, as a run that survives losses writes."""
    log: Path = tmp_path_factory.mktemp("names") / "log"
    assert on_ranks(4, SCENE, log).code == 0
    kept = {"frame": 5, "rank": 0, "waited_for": 1, "phase": "replicas", "seconds": 0.5}
    rows(log / "waits.jsonl", [kept], mode="a")
    return log


def renamed(row: Row, table: Table) -> Row:
    """Rename a row's fields to those of earlier versions."""
    names = {column.name: column.earlier or column.name for column in table.columns}
    row = {names.get(name, name): value for name, value in row.items()}
    for column in table.columns:
        values = {now: earlier for earlier, now in column.earlier_values.items()}
        if column.name in row and values:
            row[column.name] = values.get(row[column.name], row[column.name])
    return row


def rewritten(log: Path, target: Path, is_old: Callable[[int], bool] = lambda line: True) -> Path:
    """Copy a log, with the names of earlier versions in the lines for which `is_old` is true."""
    shutil.copytree(log, target)
    for table in TABLES.values():
        for path in target.glob(table.file):
            now = [json.loads(line) for line in path.read_text().splitlines()]
            rows(path, [renamed(row, table) if is_old(n) else row for n, row in enumerate(now)])
    return target


def tables(run: motes.Run) -> dict[str, Any]:
    return {name: run.waits() if name == "waits" else getattr(run, name) for name in TABLES}


def test_every_renamed_column_and_phase_is_known():
    columns = [column for table in TABLES.values() for column in table.columns]
    assert {column.earlier: column.name for column in columns if column.earlier} == COLUMNS
    assert EARLIER_PHASES == PHASES
    of_phases = {
        (name, one.name) for name, table in TABLES.items() for one in table.columns if one.earlier_values
    }
    assert of_phases == PHASE_COLUMNS


def test_the_engine_writes_the_present_names(log: Path):
    text = {path.name: path.read_text() for path in log.glob("*.jsonl")}
    for earlier, now in COLUMNS.items():
        assert f'"{now}"' in text["load.jsonl"] and f'"{earlier}"' not in text["load.jsonl"]
    written = "".join(text.values())
    for earlier, now in PHASES.items():
        assert f':"{now}"' in written.replace(": ", ":") and f':"{earlier}"' not in written


@pytest.mark.parametrize(
    "is_old",
    [lambda line: True, lambda line: line < 7, lambda line: line >= 7],
    ids=["all", "before", "after"],
)
def test_logs_read_alike_under_both_names(log: Path, tmp_path: Path, is_old: Callable[[int], bool]):
    """A run continued by a later version has rows of both."""
    old = rewritten(log, tmp_path / "old", is_old)
    assert '"meetings"' in (old / "load.jsonl").read_text()
    there, here = tables(motes.open_run(old)), tables(motes.open_run(log))
    for name in TABLES:
        pandas.testing.assert_frame_equal(there[name], here[name])
    assert (here["load"][list(COLUMNS.values())].notna()).all(axis=None)


def test_each_earlier_name_is_read_alone(log: Path, tmp_path: Path):
    now = [json.loads(line) for line in (log / "load.jsonl").read_text().splitlines()]
    for number, (earlier, present) in enumerate(COLUMNS.items()):
        folder = tmp_path / str(number)
        shutil.copytree(log, folder)
        rows(
            folder / "load.jsonl",
            [{earlier if k == present else k: v for k, v in row.items()} for row in now],
        )
        pandas.testing.assert_frame_equal(motes.open_run(folder).load, motes.open_run(log).load)


def test_a_log_that_grows_is_read_under_the_present_names(log: Path, tmp_path: Path):
    old = rewritten(log, tmp_path / "old")
    for name in ("load", "waits"):
        table = TABLES[name]
        there, here = (Follower(folder / table.file, table.columns).new_rows() for folder in (old, log))
        assert there == here and len(there) > 10


def test_reports_and_traces_of_both_are_the_same(log: Path, tmp_path: Path):
    old = rewritten(log, tmp_path / "old")
    runs = motes.open_run(old), motes.open_run(log)
    assert runs[0].explain().losses == runs[1].explain().losses
    traces = []
    for number, run in enumerate(runs):
        run.to_perfetto(tmp_path / f"{number}.json")
        traces.append((tmp_path / f"{number}.json").read_text())
    assert traces[0].replace(runs[0].name, runs[1].name) == traces[1]
    assert "all_reduce" in traces[1]


@pytest.mark.parametrize(("earlier", "present"), COLUMNS.items())
def test_what_an_earlier_column_cannot_hold_is_refused(log: Path, tmp_path: Path, earlier: str, present: str):
    shutil.copytree(log, tmp_path / "log")
    path = tmp_path / "log" / "load.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    lines[3] = {name: value for name, value in lines[3].items() if name != present} | {earlier: "many"}
    rows(path, lines)
    with pytest.raises(LogError, match=rf"line 4: {present} must be .*'many'"):
        motes.open_run(tmp_path / "log").load  # noqa: B018
