"""Other tools: load data for LBAF, OTF2 archives, and readers of the log's own files."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from handmade import load_row, moving_spot, rows, time_row, write_log
from standing import on_ranks

import motes
from motes.analysis._tables.schema import TABLES
from motes.analysis.report import write_report

pandas = pytest.importorskip("pandas")

ENTITY = {"home": int, "id": int, "migratable": bool, "type": str}
TASK = {"entity": dict, "node": int, "resource": str, "time": float, "user_defined": dict}
MESSAGE = {"type": str, "from": dict, "to": dict, "messages": int, "bytes": float}


def fits(value: dict, fields: dict) -> bool:
    """Return whether an object has exactly these fields, with these types."""
    return {name: type(one) for name, one in value.items()} == fields


@pytest.fixture
def run(tmp_path):
    load = [
        load_row(frame, "s", rank, n_end=n, t_compute_s=n / 1e4, bytes_sent=360 * rank)
        for frame in range(3)
        for rank, n in ((2, 9000), (3, 1000))
    ]
    log = write_log(tmp_path / "run", load)
    spent = {
        0: {"picture": 0.2, "wait": 0.8},
        1: {"wait": 1.0},
        2: {"act": 0.9, "wait": 0.1},
        3: {"act": 0.1, "wait": 0.9},
    }
    rows(
        log / "times.jsonl",
        [time_row(f, rank, chain_s=0.9 * (f + 1), **own) for f in range(3) for rank, own in spent.items()],
    )
    return motes.open_run(log)


def test_lbaf_gets_a_file_per_rank_with_all_seconds_and_bytes(run, tmp_path):
    paths = run.to_lbaf(tmp_path / "lbaf")
    assert [path.name for path in paths] == [f"motes.{rank}.json" for rank in range(4)]
    known: set[int] = set()
    for rank, (path, work) in enumerate(zip(paths, (0.2, 0.0, 0.9, 0.1), strict=True)):
        data = json.loads(path.read_text())
        assert data["type"] == data["metadata"]["type"] == "LBDatafile"
        assert [phase["id"] for phase in data["phases"]] == [0, 1, 2]
        for phase in data["phases"]:
            tasks = phase["tasks"]
            assert all(fits(task, TASK) and fits(task["entity"], ENTITY) for task in tasks)
            assert sum(task["time"] for task in tasks) == pytest.approx(work)
            assert len(tasks) == (17 if rank > 1 else 1), "no rank is without a task"
            assert all(fits(message, MESSAGE) for message in phase["communications"])
            sent = sum(message["bytes"] for message in phase["communications"])
            assert sent == (360 * rank if rank > 1 else 0)
        ids = {task["entity"]["id"] for task in data["phases"][0]["tasks"]}
        assert not ids & known, "numbers are of one task only"
        known |= ids
    ends = {message[end]["id"] for message in phase["communications"] for end in ("from", "to")}
    assert ends <= known


def test_otf2_reads_back_every_phase_and_arrow(tmp_path):
    otf2 = pytest.importorskip("otf2")
    log = moving_spot(tmp_path / "run", frames=3)
    wait = {"frame": 1, "phase": "wait", "system": "", "waited_for": 5, "message": "report"}
    first = json.loads((log / "spans.r0002.jsonl").read_text().splitlines()[8])
    wait |= {"start_s": first["start_s"], "end_s": first["end_s"]}
    rows(log / "spans.r0002.jsonl", [wait], mode="a")
    run = motes.open_run(log)
    anchor = run.to_otf2(tmp_path / "otf2")
    with otf2.reader.open(str(anchor)) as trace:
        assert [place.name for place in trace.definitions.locations] == [f"rank {r}" for r in range(6)]
        kinds = Counter((place.name, type(event).__name__) for place, event in trace.events)
    for rank in range(6):
        slices = (run.spans["rank"] == rank).sum()
        assert kinds[f"rank {rank}", "Enter"] == kinds[f"rank {rank}", "Leave"] == slices
    assert kinds["rank 2", "MpiRecv"] == kinds["rank 5", "MpiSend"] == 1
    with pytest.raises(motes.LogError, match="a directory of its own"):
        run.to_otf2(tmp_path / "otf2")


LOADER = """
import json, logging, sys
from lbaf.IO.lbsVTDataReader import LoadReader

class Accepts:  # the package's own validator downloads its schema from the internet
    def __init__(self, **_): pass
    def is_valid(self, **_): return True

LoadReader.SCHEMA_VALIDATOR_CLASS = Accepts
reader = LoadReader(sys.argv[1], logging.getLogger(), check_schema=False)
phases = [reader.populate_phase(number) for number in range(3)]
print(json.dumps([[[r.get_id(), len(r.get_objects()), r.get_load()] for r in ranks] for ranks in phases]))
"""


def old_python() -> str | None:
    """Return a Python of a version that LBAF supports, if there is one."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"), "versions")
    places = [*map(shutil.which, ("python3.9", "python3.8")), *sorted(pyenv.glob("3.[89].*/bin/python"))]
    works = (
        place for place in places if place and not subprocess.run([place, "-c", "import venv"]).returncode
    )
    return next(map(str, works), None)


@pytest.mark.slow
def test_lbaf_itself_loads_all_tasks(run, tmp_path):
    if (python := old_python()) is None:
        pytest.skip("LBAF 1.0.1 needs Python 3.8 or 3.9")
    subprocess.run([python, "-m", "venv", tmp_path / "venv"], check=True)
    its = tmp_path / "venv" / "bin" / "python"
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "LD_"))}
    subprocess.run([its, "-m", "pip", "install", "-q", "lbaf==1.0.1"], check=True, env=clean)
    run.to_lbaf(tmp_path / "lbaf")
    words = [its, "-c", LOADER, tmp_path / "lbaf" / "motes"]
    told = json.loads(subprocess.run(words, check=True, env=clean, stdout=subprocess.PIPE, text=True).stdout)
    for phase in told:
        assert phase == [
            [rank, 17 if rank > 1 else 1, pytest.approx(work)]
            for rank, work in enumerate((0.2, 0.0, 0.9, 0.1))
        ]


# --- the log's own files, read without motes

SCENE = """
import sys
import motes
from motes.shapes import Box

world = motes.World(seed=6, space=(-4, 4), log=sys.argv[1], progress="off", balancer=motes.balance.Pairwise())
rain = world.system("rain")
rain.configure(velocity=(0, -1, 0))
with world:
    for frame in world.frames(70):
        if frame == 0:
            rain.burst(Box((-4, 0, -1), (4, 1, 1)), count=6000)  # both halves are equal
        if frame > 58:
            rain.source(Box((-4, 0, -1), (-2, 1, 1)), rate=150_000)  # the cut begins to move
        rain.move()
        world.step()
"""
FILES = ("frames", "load", "times", "waits", "balance", "density")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    folder = tmp_path_factory.mktemp("read") / "log"
    done = on_ranks(4, SCENE, folder)
    assert done.code == 0, done.text
    cuts = motes.open_run(folder).load["domain_hi"].dropna()
    assert (cuts.iloc[:100] == cuts.iloc[0]).any() and cuts.nunique() > 1
    return folder


def read_with_pandas(path):
    return pandas.read_json(path, lines=True, precise_float=True)


def read_with_polars(path):
    return pytest.importorskip("polars").read_ndjson(path).to_pandas()


def read_with_duckdb(path):
    return pytest.importorskip("duckdb").read_json(str(path)).df()


def read_with_pyarrow(path):
    pytest.importorskip("pyarrow")
    from pyarrow import json as reader

    return reader.read_json(path).to_pandas()


@pytest.mark.parametrize(
    "read",
    [read_with_pandas, read_with_polars, read_with_duckdb, read_with_pyarrow],
    ids=lambda read: read.__name__,
)
def test_other_readers_see_the_same_numbers(log, read):
    names = [name for name in FILES if (log / f"{name}.jsonl").exists()]
    assert set(FILES) - set(names) <= {"balance"}
    for name in names:
        expected, seen = motes.open_run(log).table(name), read(log / f"{name}.jsonl")
        for column in TABLES[name].columns:
            if column.name not in seen:
                assert expected[column.name].isna().all(), (name, column.name)
            elif column.kind is str:
                texts, wanted = (
                    [None if pandas.isna(text) else text for text in table[column.name]]
                    for table in (seen, expected)
                )
                assert texts == wanted, (name, column.name)
            else:
                values = seen[column.name].to_numpy("float64", na_value=float("nan"))
                assert np.array_equal(values, expected[column.name], equal_nan=True), (name, column.name)
                known = column.kind is float and not expected[column.name].isna().all()
                if known and read is not read_with_pandas:  # which makes integers of whole floats itself
                    assert seen[column.name].dtype == "float64", (name, column.name)


def test_a_table_without_rows_is_no_file(tmp_path):
    done = on_ranks(1, SCENE, tmp_path / "log")
    assert done.code == 0, done.text
    files = sorted(path.name for path in (tmp_path / "log").glob("*.jsonl"))
    assert files == ["density.jsonl", "events.jsonl", "frames.jsonl", "load.jsonl", "times.jsonl"]
    run = motes.open_run(tmp_path / "log")
    assert run.balance.empty and run.waits().empty and run.explain().sentences


WITHOUT = """
import sys
import motes

world = motes.World(seed=1, progress="off", log=sys.argv[1])
with world:
    for frame in world.frames(int(sys.argv[2])):
        world.step()
"""


@pytest.mark.parametrize(
    ("frames", "says"),
    [(5, "the run has no systems"), (0, "no frames in the log: it ended before the first")],
)
def test_a_run_with_nothing_to_show_says_why(frames, says, tmp_path):
    assert on_ranks(1, WITHOUT, tmp_path / "log", frames).code == 0
    run = motes.open_run(tmp_path / "log")
    assert run.finished and len(run.frames) == frames
    for show in (run.plot.phases, run.plot.imbalance, lambda: run.to_lbaf(tmp_path / "lbaf")):
        with pytest.raises(motes.LogError, match=says):
            show()
    with pytest.raises(motes.LogError, match=says):
        write_report(run, tmp_path / "report.html")
