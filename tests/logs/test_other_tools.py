"""Exports for other tools: load data for LBAF, OTF2 archives."""

from __future__ import annotations

import json
from collections import Counter

import pytest
from handmade import load_row, moving_spot, rows, time_row, write_log

import motes

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
