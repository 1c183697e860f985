"""Load files of vt and LBAF: opened as runs, and replayed under our balancers."""

from __future__ import annotations

import itertools
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from handmade import load_row, rows, time_row, write_log

import motes
from motes.balance import BALANCERS, Pairwise, PrefixCuts, Proportional, Static

pytest.importorskip("pandas")
FIXED = 0.25
"""Seconds of the task of rank 1 that cannot migrate."""


def task(rank: int, number: int, seconds: float, *, migratable: bool = True, **more: Any) -> dict[str, Any]:
    """Return a task as vt writes it."""
    entity = {"home": rank, "id": number, "migratable": migratable, "type": "object", **more}
    subphases = [{"id": 0, "time": seconds}]
    return {"entity": entity, "node": rank, "resource": "cpu", "subphases": subphases, "time": seconds}


def content(rank: int, phases: dict[int, list[dict[str, Any]]], same: dict[str, Any] | None = None) -> Any:
    """Return the content of a file as vt writes it."""
    nothing: dict[str, Any] = {"list": [], "range": []}
    metadata = {
        "type": "LBDatafile",
        "rank": rank,
        "phases": {"count": len(phases), "skipped": nothing, "identical_to_previous": same or nothing},
        "shared_node": {"id": 0, "num_nodes": 1, "rank": rank, "size": 3},
    }
    own = [{"id": number, "tasks": tasks} for number, tasks in phases.items()]
    return {"metadata": metadata, "phases": own}


def write(folder: Path, contents: list[Any], name: str = "data") -> Path:
    """Write the files of all ranks; return their directory."""
    folder.mkdir(exist_ok=True)
    for rank, one in enumerate(contents):
        (folder / f"{name}.{rank}.json").write_text(json.dumps(one))
    return folder


@pytest.fixture
def vt(tmp_path) -> Path:
    """Three ranks; in phase 2 tasks 10 and 30 have changed places; phases 3 and 4 repeat it."""
    phases = [
        {
            0: [
                task(0, 12, 0.1, index=[1, 0]),
                task(0, 10, 0.4, index=[0, 1]),
                task(0, 11, 0.0, index=[0, 2]),
            ],
            2: [task(0, 12, 0.1, index=[1, 0]), task(0, 30, 0.2)],
        },
        {
            0: [task(1, 20, 0.1), task(1, 1, FIXED, migratable=False)],
            2: [task(1, 20, 0.3), task(1, 1, 2 * FIXED, migratable=False)],
        },
        {0: [task(2, 30, 0.1), task(2, 31, 0.8)], 2: [task(2, 10, 0.4), task(2, 31, 0.8)]},
    ]
    same = {"list": [3], "range": [[4, 4]]}
    return write(tmp_path / "vt", [content(rank, own, same) for rank, own in enumerate(phases)])


def test_load_files_of_vt_are_a_run(vt):
    run = motes.open_run(vt)
    assert (run.name, run.ranks, run.calculators, run.systems) == ("data", 3, [0, 1, 2], ["tasks"])
    assert list(run.frames["frame"]) == [0, 2, 3, 4]
    seconds = run.by_rank().to_numpy()
    then, later = [0.5, 0.1 + FIXED, 0.9], [0.3, 0.3 + 2 * FIXED, 1.2]
    np.testing.assert_allclose(seconds, [then, later, later, later])
    np.testing.assert_allclose(run.frames["t_frame_s"], [0.9, 1.2, 1.2, 1.2])
    np.testing.assert_allclose(run.imbalance(), seconds.max(axis=1) / seconds.mean(axis=1))
    each = run.facts["particle_s"]
    held = run.by_rank("n_end").to_numpy() * each
    np.testing.assert_allclose(held[0], [0.5, 0.1, 0.9], atol=2 * each)
    sent = run.by_rank("sent").to_numpy() * each
    np.testing.assert_allclose(sent, [[0, 0, 0], [0.4, 0, 0.2], [0, 0, 0], [0, 0, 0]], atol=each)
    ends = run.load[run.load["frame"] == 0]["domain_hi"].tolist()
    assert ends[:2] == [3.0, 4.0] and np.isnan(ends[2]), "tasks 10, 11, 12, 20, 30, 31"
    assert run.load[run.load["frame"] == 2]["domain_hi"].isna().all(), "ranks are mixed in the row"
    assert run.finished and run.summary()["frames"] == 4 and run.explain().sentences and repr(run)


def test_a_run_of_tasks_is_found_by_directory_name_and_file(vt):
    write(vt, [content(0, {0: [task(0, 1, 1.0)]})], name="other")
    with pytest.raises(motes.LogError, match=r"load files of several names; give one of '.*data', '.*other'"):
        motes.open_run(vt)
    assert motes.open_run(vt / "data").ranks == motes.open_run(vt / "data.2.json").ranks == 3
    assert motes.open_run(vt / "other").ranks == 1
    for wrong in ("dat", "data.7.json", "nothing.0.json"):
        with pytest.raises(motes.LogError, match="no such directory"):
            motes.open_run(vt / wrong)


def test_tasks_stay_where_they_were_at_first_without_a_balancer(vt):
    replay = motes.open_run(vt).replay(Static())
    each = motes.open_run(vt).facts["particle_s"]
    expected = [[0.5, 0.1 + FIXED, 0.9], *[[0.1 + 0.4, 0.3 + 2 * FIXED, 0.8 + 0.2]] * 3]
    np.testing.assert_allclose(replay.by_rank().to_numpy(), expected, atol=4 * each)
    np.testing.assert_allclose(replay.frames["t_frame_s"], np.max(expected, axis=1), atol=4 * each)
    assert replay.frames["exchanged"].sum() == 0 and list(replay.frames["frame"]) == [0, 2, 3, 4]


def tasks_of(rank: int, seconds: list[float]) -> list[dict[str, Any]]:
    """Return tasks of a rank that take these seconds."""
    return [task(rank, 100 * rank + i, one) for i, one in enumerate(seconds)]


def many(tmp_path: Path, *, phases: int = 12, ranks: int = 4, each: int = 30) -> tuple[Path, np.ndarray]:
    """Write files in which the first rank has most to do; return the seconds of all tasks, (ranks, each)."""
    seconds = np.random.default_rng(5).uniform(1e-3, 3e-3, (ranks, each))
    seconds[0] *= 6
    contents = [
        content(
            rank, dict.fromkeys(range(phases), [task(rank, each * rank + i, s) for i, s in enumerate(own)])
        )
        for rank, own in enumerate(seconds.tolist())
    ]
    return write(tmp_path / "many", contents), seconds


@pytest.mark.parametrize("kind", BALANCERS)
def test_every_balancer_moves_whole_tasks(kind, tmp_path):
    folder, seconds = many(tmp_path)
    balancer = Proportional([1, 1, 1, 1]) if kind == "Proportional" else getattr(motes.balance, kind)()
    run = motes.open_run(folder)
    replay = run.replay(balancer)
    runs = np.concatenate([[0.0], np.cumsum(seconds)])
    for own in replay.by_rank().to_numpy():
        ends = np.cumsum(own)
        away = np.abs(runs[:, None] - ends).min(axis=0)
        assert (away < 120 * run.facts["particle_s"]).all(), "a cut is between two tasks"
        assert ends[-1] == pytest.approx(runs[-1], rel=1e-4), "no task is lost"
    if kind != "Static":
        assert replay.imbalance().iloc[-1] < 1.3 < 2 < run.imbalance().iloc[-1]
        assert replay.frames["t_frame_s"].sum() < run.frames["t_frame_s"].sum()
        assert replay.frames["exchanged"].sum() > 0


def test_cuts_follow_from_the_phase_before(tmp_path):
    loads = [[[1.0, 1.0], [1.0, 1.0]], [[3.0, 3.0], [1.0, 1.0]], [[3.0, 3.0], [1.0, 1.0]]]
    contents = [
        content(
            rank,
            {
                k: [task(rank, 2 * rank + i, s) for i, s in enumerate(one[rank])]
                for k, one in enumerate(loads)
            },
        )
        for rank in (0, 1)
    ]
    replay = motes.open_run(write(tmp_path / "two", contents)).replay(PrefixCuts(threshold=0.0))
    np.testing.assert_allclose(replay.frames["t_frame_s"], [2.0, 6.0, 5.0], rtol=1e-3)


def test_powers_tell_tasks_from_machines(tmp_path):
    contents = [content(rank, {k: [task(rank, 4 * rank + i, s) for i in range(4)] for k in range(3)})
                for rank, s in ((0, 1.0), (1, 3.0))]  # fmt: skip
    run = motes.open_run(write(tmp_path / "two", contents))
    same = run.replay(Static(), powers=[3, 1])
    np.testing.assert_allclose(same.by_rank().to_numpy(), [[4.0, 12.0]] * 3, rtol=1e-3)
    moved = run.replay(Proportional([3, 1]), powers=[3, 1])
    np.testing.assert_allclose(moved.by_rank().to_numpy()[-1], [6.0, 6.0], rtol=1e-3)
    for wrong in ([1.0], [1, -1], ["a", "b"]):
        with pytest.raises(motes.ArgumentError, match="powers"):
            run.replay(Static(), powers=wrong)
    with pytest.raises(motes.ArgumentError, match="balancer"):
        run.replay("Static()")
    with pytest.raises(motes.ArgumentError, match="migrant_s"):
        run.replay(Static(), migrant_s=1e-6)


def test_what_to_lbaf_writes_is_read_back(tmp_path):
    load = [
        load_row(frame, "s", rank, n_end=n, t_compute_s=n / 1e4, bytes_sent=360 * rank)
        for frame, (rank, n) in itertools.product(range(3), ((2, 9000), (3, 1000)))
    ]
    log = write_log(tmp_path / "run", load)
    spent = {0: {"picture": 0.2}, 1: {}, 2: {"act": 0.95}, 3: {"act": 0.1}}
    rows(
        log / "times.jsonl",
        [time_row(f, rank, chain_s=f + 1.0, **own) for f in range(3) for rank, own in spent.items()],
    )
    run = motes.open_run(log)
    run.to_lbaf(tmp_path / "lbaf")
    again = motes.open_run(tmp_path / "lbaf")
    np.testing.assert_allclose(again.by_rank().to_numpy(), [[0.2, 0.0, 0.95, 0.1]] * 3)
    assert (len(again.load), list(again.frames["frame"])) == (12, [0, 1, 2])
    replay = again.replay(PrefixCuts())
    np.testing.assert_allclose(replay.by_rank().sum(axis=1), 1.25, rtol=1e-3)
    assert replay.frames["t_frame_s"].iloc[-1] < 0.6, "a sixteenth of 0.9 s is a task"
    again.to_lbaf(tmp_path / "twice")
    np.testing.assert_allclose(motes.open_run(tmp_path / "twice").by_rank(), again.by_rank(), rtol=1e-3)


def test_compressed_files_are_read_whatever_their_suffix(vt, monkeypatch):
    brotli = pytest.importorskip("brotli")
    plain = motes.open_run(vt)
    for path, name in ((vt / "data.0.json", "data.0.json"), (vt / "data.1.json", "data.1.json.br")):
        packed = brotli.compress(path.read_bytes())
        path.unlink()
        (vt / name).write_bytes(packed)
    assert motes.open_run(vt).load.equals(plain.load)
    monkeypatch.setitem(sys.modules, "brotli", None)
    with pytest.raises(motes.MissingExtraError, match="a compressed load file needs brotli"):
        motes.open_run(vt)


def changed(at: str, value: Any) -> Any:
    """Return a function that changes one field of a file's content; `...` removes it."""

    def change(data: Any) -> None:
        *way, last = [int(part) if part.isdigit() else part for part in at.split("/")]
        for part in way:
            data = data[part]
        if value is ...:
            del data[last]
        else:
            data[last] = value

    return change


@pytest.mark.parametrize(
    ("at", "value", "says"),
    [
        ("metadata/type", "LBStatsfile", r'metadata.type: "LBDatafile" is expected, not "LBStatsfile"'),
        ("metadata", [], r"metadata: an object is expected, not \[\]"),
        ("metadata/rank", 2, r"metadata.rank: 1, as in the file's name, is expected, not 2"),
        ("metadata/phases/identical_to_previous", 7, r"identical_to_previous: an object with the lists"),
        (
            "metadata/phases/identical_to_previous/list",
            [1],
            r"identical_to_previous: the number of a phase behind .* not 4",
        ),
        ("metadata/phases/identical_to_previous/range", [[4]], r"identical_to_previous: .* not \[4\]"),
        ("metadata/phases/identical_to_previous/range", [[9, 8]], r"ascending .* not \[9, 8\]"),
        ("phases", ..., r"phases: the field is missing; a list is expected"),
        ("phases", {}, r"phases: a list is expected, not \{\}"),
        ("phases/0", 3, r"phases\[0\]: an object is expected, not 3"),
        ("phases/0/id", -1, r"phases\[0\].id: another whole number >= 0 for each phase is expected, not -1"),
        ("phases/1/id", 0, r"phases\[1\].id: another whole number"),
        ("phases/1/id", "2", r'phases\[1\].id: a whole number >= 0 is expected, not "2"'),
        ("phases/0/tasks", ..., r"phases\[0\].tasks: the field is missing"),
        ("phases/0/tasks/0/time", ..., r"phases\[0\].tasks\[0\].time: the field is missing"),
        ("phases/0/tasks/0/time", "1", r'phases\[0\].tasks\[0\].time: seconds >= 0 is expected, not "1"'),
        ("phases/0/tasks/1/time", -1.0, r"phases\[0\].tasks\[1\].time: seconds >= 0 is expected, not -1.0"),
        ("phases/0/tasks/1/time", float("nan"), r"tasks\[1\].time: seconds >= 0 is expected, not NaN"),
        ("phases/0/tasks/0/entity", None, r"tasks\[0\].entity: an object is expected, not null"),
        ("phases/0/tasks/0/entity/migratable", 1, r"entity.migratable: true or false is expected, not 1"),
        ("phases/0/tasks/0/entity/id", ..., r"entity.id: the field is missing; a whole number is expected"),
        ("phases/0/tasks/0/entity/id", 1.5, r"entity.id: a whole number is expected, not 1.5"),
        ("phases/0/tasks/0/entity/index", [1.5], r"entity.index: a list of whole numbers is expected"),
        ("phases/0/tasks/0/entity/id", 10, r"phases\[0\].tasks\[0\].entity: data.0.json has this task, too"),
        (
            "phases/0/tasks/1/entity",
            {"id": 20, "migratable": True},
            r"phases\[0\].tasks\[0\] is the same task",
        ),
    ],
)
def test_a_damaged_file_is_told_by_name_and_field(at, value, says, vt):
    path = vt / "data.1.json"
    data = json.loads(path.read_text())
    changed(at, value)(data)
    path.write_text(json.dumps(data))
    with pytest.raises(motes.LogError, match=says) as told:
        motes.open_run(vt)
    assert "data.1.json: " in str(told.value) and "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b'{"phases": [', "data.1.json: damaged: "),
        (b"[1]", "data.1.json: (neither JSON nor compressed|a JSON object)|needs brotli"),
        (b"", "data.1.json: neither JSON nor compressed|needs brotli"),
        (None, "data.1.json: no such file; each rank up to 2 has one"),
    ],
)
def test_what_is_no_load_file_is_told(content, says, vt):
    path = vt / "data.1.json"
    path.unlink() if content is None else path.write_bytes(content)
    with pytest.raises((motes.LogError, motes.MissingExtraError), match=says):
        motes.open_run(vt)


def test_all_files_have_the_same_phases(vt):
    path = vt / "data.1.json"
    data = json.loads(path.read_text())
    del data["phases"][0]
    data["metadata"]["phases"]["identical_to_previous"] = {"list": [3, 4], "range": []}
    path.write_text(json.dumps(data))
    with pytest.raises(
        motes.LogError, match=r"data.1.json: phases: there is no phase 0, which data.0.json has"
    ):
        motes.open_run(vt)


def test_a_log_beside_other_files_stays_a_log(tmp_path):
    log = write_log(tmp_path / "run", [load_row(0, "s", 0, n_end=1)])
    (log / "extra.0.json").write_text("{}")
    assert motes.open_run(log).systems == ["s"]


def test_a_replay_of_tasks_is_planned_by_seconds_of_other_work_too(tmp_path):
    contents = [
        content(
            rank,
            {k: [task(rank, 50 * rank + i, 0.01) for i in range(50)]
             + [task(rank, 999, 0.4, migratable=False)] * (rank == 0) for k in range(12)},
        )
        for rank in (0, 1)
    ]  # fmt: skip
    run = motes.open_run(write(tmp_path / "two", contents))
    for balancer in (PrefixCuts(), Pairwise()):
        replay = run.replay(balancer)
        assert replay.imbalance().iloc[-1] < 1.06 < run.imbalance().iloc[-1], balancer
