"""A run that continues another one appends to its log without a seam."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket

import pytest
from handmade import load_row, moving_spot, rows, write_log
from launching import mpirun, said
from standing import on_ranks

import motes
from motes._run import run_file
from motes._run.log_directory import LogDirectory
from motes.analysis._tables.tables import Follower
from motes.analysis.view import View
from motes.errors import ArgumentError, LogError

pandas = pytest.importorskip("pandas")

TABLES = ("frames", "load", "density", "balance")


def rows_of(path):
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


# --- the directory


def earlier_log(folder):
    folder.mkdir()
    files = {
        ".lock": "process 7 on host\n",
        "run.json": json.dumps({"schema": 1, "argv": ["x.py"]}),
        "load.jsonl": "rows",
        "frames.jsonl": "rows",
        "events.jsonl": "rows",
        "spans.r0007.jsonl": "of the earlier start",
        ".load.jsonl.tmp": "half",
        ".run.json.0011223344556677.tmp": "half",
        "film.mp4": "mine",
    }
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


def test_a_continued_log_stays_where_it_is(tmp_path):
    log = earlier_log(tmp_path / "today")
    claimed = LogDirectory.claim(log, continued=True)
    assert claimed.moved is None
    kept = {".lock", "run.json", "load.jsonl", "frames.jsonl", "events.jsonl", "film.mp4"}
    assert set(os.listdir(log)) == kept
    assert (log / "load.jsonl").read_text() == "rows"
    assert os.listdir(tmp_path) == ["today"]
    with pytest.raises(ArgumentError, match="is writing to this one"):
        LogDirectory.claim(log, continued=True)
    claimed.release()
    LogDirectory.claim(log, continued=True).release()
    LogDirectory.claim(log).release()  # a run that starts from its first frame moves it aside, as always
    assert set(os.listdir(tmp_path)) == {"today", "today.1"}


@pytest.mark.parametrize("text", ["", "{", "[]", '{"continued": 3}'])
def test_a_damaged_run_file_is_told_before_anything_is_changed(tmp_path, text):
    log = earlier_log(tmp_path / "today")
    (log / "run.json").write_text(text)
    before = set(os.listdir(log))
    with pytest.raises(LogError, match=r"run.json: cannot be continued"):
        LogDirectory.claim(log, continued=True)
    assert set(os.listdir(log)) == before
    (log / "run.json").write_text(json.dumps({"schema": 1, "argv": []}))
    LogDirectory.claim(log, continued=True).release()  # the refused claim released the lock


# --- run.json


def test_run_json_keeps_the_first_start_and_lists_the_others(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.argv", ["first.py"])
    facts = {"seed": 3, "calculators": [0, 1], "manager": 0}
    run_file.write_run(tmp_path, facts, ["a", "b"], [1, 1])
    first = json.loads((tmp_path / "run.json").read_text())
    assert "continued" not in first
    monkeypatch.setattr("sys.argv", ["again.py"])
    run_file.write_run(tmp_path, {**facts, "calculators": [0]}, ["c"], [2], continued_from=96)
    run_file.write_run(tmp_path, facts, ["c", "d"], [1, 1], continued_from=144)
    run = json.loads((tmp_path / "run.json").read_text())
    second, third = run.pop("continued")
    assert run == first
    assert (second["frame"], second["argv"], second["calculators"]) == (96, ["again.py"], [0])
    assert second["ranks"] == [{"rank": 0, "host": "c", "threads": 2}]
    assert second["started_unix_s"] >= first["started_unix_s"]
    assert "seed" not in second, "what is as it was is not said again"
    assert (third["frame"], [rank["host"] for rank in third["ranks"]]) == (144, ["c", "d"])


def test_a_log_that_begins_at_a_checkpoint_has_a_run_json(tmp_path):
    run_file.write_run(tmp_path, {"seed": 3}, ["a"], [1], continued_from=96)
    run = json.loads((tmp_path / "run.json").read_text())
    assert run["seed"] == 3
    assert [part["frame"] for part in run["continued"]] == [96]


# --- the engine's tables, in real runs

SCENE = """
import json, os, pathlib, sys
import motes
from motes import shapes
from motes._world.world import session_of

log, secure, ending, begin = sys.argv[1], int(sys.argv[2]), sys.argv[3], int(sys.argv[4])
world = motes.World(
    seed=3, space=(-1, 1), log=log, digest=True, spans=True, progress="off", roles=sys.argv[5],
    renderer=motes.Renderer(32, 24, camera=motes.Camera((0, 0, 5), (0, 0, 0))),
    balancer=motes.balance.Pairwise(min_particles=1, smoothing=1),
)
session = session_of(world)
session.settings = session.settings._replace(continued_from=begin)
systems = [world.system(name) for name in "ab"]
with world:
    for frame in world.frames(0 if begin else 9):
        for s in systems:
            s.configure(velocity=motes.Normal((1, 0, 0), (1, 0, 0)), lifetime=0.2)
            s.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=24 * (50 + 50 * frame))
            s.kill_expired()
            s.move()
        if frame % 2:
            world.render()
        else:
            world.step()
        if frame + 1 == secure:
            with open(f"{log}/frames.jsonl") as file:
                world.say(len(file.readlines()))
            session_of(world).engine.secure()
            counts = {}
            for name in ("frames", "load", "density", "balance"):
                table = pathlib.Path(log, f"{name}.jsonl")  # none if there are no rows
                lines = table.read_text().splitlines() if table.exists() else []
                counts[name] = [json.loads(line)["frame"] for line in lines]
            world.say(json.dumps(counts))
            if ending == "killed":
                world.say("kill me")
                world.step()
                sys.stdin.read()
"""


def check_whole(log, frames, ranks):
    """Check that every table has each frame once per calculator and system, and each cut at most once."""
    expected = {"frames": 1, "load": 2 * ranks, "density": 2 * ranks}
    for name, count in expected.items():
        told = [row["frame"] for row in rows_of(log / f"{name}.jsonl")]
        assert told == [frame for frame in range(frames) for _ in range(count)], name
    cuts = [(row["frame"], row["system"], row["left_rank"]) for row in rows_of(log / "balance.jsonl")]
    assert len(set(cuts)) == len(cuts), "Pairwise looks at every other pair in each frame"
    assert {frame for frame, _, _ in cuts} == (set(range(frames)) if ranks > 1 else set())
    for row in rows_of(log / "load.jsonl"):
        assert row["n_end"] == (
            row["n_start"] + row["created"] - row["killed"] - row["sent"] + row["received"]
        )
    for row in rows_of(log / "frames.jsonl"):
        assert row["t_frame_s"] > 0, "what ranks tell late is there, too"
        assert ("image_sha256" in row) == bool(row["frame"] % 2)


@pytest.mark.parametrize(
    ("size", "roles", "ranks"),
    [(1, "auto", 1), (2, "shared", 2), (3, "auto", 1), (5, "auto", 3), (5, "shared", 5)],
)
def test_a_secured_log_has_all_frames_and_goes_on_behind_them(tmp_path, size, roles, ranks):
    log = tmp_path / "log"
    result = on_ranks(size, SCENE, log, 6, "end", 0, roles)
    assert result.code == 0, result.text
    before, told = result.out.splitlines()[:2]
    assert int(before) == 4, "without it the log lags two frames behind"
    counts = json.loads(told)
    for name, per_frame in (("frames", 1), ("load", 2 * ranks), ("density", 2 * ranks)):
        assert counts[name] == [frame for frame in range(6) for _ in range(per_frame)], name
    assert set(counts["balance"]) == (set(range(6)) if ranks > 1 else set())
    check_whole(log, 9, ranks)


FULL = """
import resource, sys
import motes
from motes._world.world import session_of

world = motes.World(seed=3, log=sys.argv[1], progress="off", roles="shared")
system = world.system("a")
with world:
    for frame in world.frames(9):
        system.burst(motes.shapes.Point((0, 0, 0)), count=3)
        world.step()
        if frame == 5:
            if "manager" in world.role:
                resource.setrlimit(resource.RLIMIT_FSIZE, (4 * 1024, resource.RLIM_INFINITY))
            session_of(world).engine.secure()
            print("secured")
"""


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_disk_that_is_full_at_a_checkpoint_ends_the_job(tmp_path, ranks):
    result = mpirun(ranks, FULL, tmp_path / "log", timeout=40)
    assert result.code == 1, result.text
    assert "secured" not in result.out
    assert "jsonl: File too large" in result.err, result.text
    if ranks > 1:
        assert len(said(result.err, "*** motes: ")) == 1, result.text
    told = [row["frame"] for row in rows_of(tmp_path / "log" / "frames.jsonl")]
    assert told == list(range(len(told))), "what is there is whole"


class Killer:
    """Kills the run's manager once the log is synced to disk."""

    def __init__(self, log):
        self.log = log

    def __call__(self, _):
        frames = self.log / "frames.jsonl"
        if frames.exists() and len(frames.read_bytes()) >= 6 * 1024:
            with contextlib.suppress(ProcessLookupError):
                os.kill(json.loads((self.log / "run.json").read_text())["pid"], signal.SIGKILL)


@pytest.mark.parametrize(("before", "after"), [(3, 2), (2, 3), (1, 1)])
def test_a_killed_run_is_continued_in_its_log(tmp_path, before, after):
    """Checks only the start of the continued run: it keeps the rows before its first frame."""
    log = tmp_path / "log"
    result = mpirun(before, SCENE, log, 6, "killed", 0, "shared", watch=Killer(log))
    assert result.code != 0
    assert [row["frame"] for row in rows_of(log / "frames.jsonl")][:6] == list(range(6))
    result = on_ranks(after, SCENE, log, 0, "end", 5, "shared")
    assert result.code == 0, result.text
    assert os.listdir(tmp_path) == ["log"]
    check_whole(log, 5, before)
    run = motes.open_run(log)
    ranks = "1 rank" if after == 1 else f"{after} ranks"
    assert f"The run was continued from the checkpoint of frame 5 on {ranks}." in run.warnings()
    assert [(part["frame"], len(part["ranks"])) for part in run.stretches] == [(0, before), (5, after)]
    assert run.ranks == max(before, after)
    assert run.calculators == list(range(max(before, after)))
    assert run.torn == []
    assert not list(log.glob(".*.tmp"))
    kinds = [(row["kind"], row["frame"]) for row in rows_of(log / "events.jsonl")]
    assert kinds[:2] == [("start", 0), ("continued", 5)]


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_damaged_row_ends_the_start_on_every_rank(tmp_path, ranks):
    log = tmp_path / "log"
    assert on_ranks(1, SCENE, log, 0, "end", 0, "shared").code == 0
    damaged = (log / "load.jsonl").read_bytes()
    damaged = damaged[:512] + b"[" + damaged[513:]
    (log / "load.jsonl").write_bytes(damaged)
    result = on_ranks(ranks, SCENE, log, 0, "end", 5, "shared")
    assert result.code == 1
    assert f"{log}/load.jsonl, line 2: damaged row" in result.err, result.text
    assert (log / "load.jsonl").read_bytes() == damaged
    if ranks == 1:
        assert "LogError" in result.err, result.text


# --- reading it


@pytest.fixture
def on_fewer_ranks(tmp_path):
    """Make a run of four calculators, ranks 2 to 5, continued from frame 20 on with three, ranks 1 to 3."""
    first, second = (moving_spot(tmp_path / name, calculators=n) for name, n in (("a", 4), ("b", 3)))
    for name in (*TABLES, "events"):
        kept = [row for row in rows_of(first / f"{name}.jsonl") if row["frame"] < 20]
        if name == "events":
            kept.append(
                {"frame": 20, "kind": "continued", "text": "from the checkpoint of frame 20 on 4 ranks"}
            )
        new = [row for row in rows_of(second / f"{name}.jsonl") if row["frame"] >= 20]
        for row in [*kept, *new] if name == "frames" else []:
            row["t_create_s"] = 1e-4
        for row in new:
            for column in {"rank", "left_rank", "right_rank", "slowest_rank"} & set(row):
                row[column] -= 1
        rows(first / f"{name}.jsonl", [*kept, *new], pad=1024)
    facts = json.loads((first / "run.json").read_text())
    part = {"frame": 20, "calculators": [1, 2, 3], "manager": 0, "speeds": {"3": 0.5}}
    part["ranks"] = [{"rank": rank, "host": "other"} for rank in range(4)]
    (first / "run.json").write_text(json.dumps({**facts, "continued": [part]}))
    for file in first.glob("spans.*"):
        file.unlink()
    return first


def test_a_run_that_was_continued_on_fewer_ranks_is_read(on_fewer_ranks, tmp_path):
    run = motes.open_run(on_fewer_ranks)
    assert run.finished
    assert run.calculators == [2, 3, 4, 5, 1]
    assert (run.ranks, run.summary()["ranks"]) == (6, 6)
    assert run.hosts == {0: "other", 1: "other", 2: "other", 3: "other", 4: "h", 5: "h"}
    assert list(run.frames["frame"]) == list(range(40))
    table = run.by_rank("n_end")
    assert table.loc[:19, 1].isna().all()
    assert table.loc[20:, [4, 5]].isna().all(axis=None)
    assert (table.sum(axis=1) == 40_000).all()
    assert (run.imbalance() >= 1).all()
    assert len(run.imbalance()) == 40
    assert any("continued from the checkpoint of frame 20 on 4 ranks" in text for text in run.warnings())
    trace = json.loads(run.to_perfetto(tmp_path / "trace.json").read_text())["traceEvents"]
    acting = [event for event in trace if event["name"].startswith("act")]
    assert {event["pid"] for event in acting if event["args"]["frame"] < 20} == {3, 4, 5, 6}
    assert {event["pid"] for event in acting if event["args"]["frame"] >= 20} == {2, 3, 4}, (
        "rank 0 is process 1"
    )
    creates = [event for event in trace if event["name"] == "create" and event["ph"] == "X"]
    assert {event["pid"] for event in creates if event["args"]["frame"] < 20} == {2}
    assert {event["pid"] for event in creates if event["args"]["frame"] >= 20} == {1}


def test_the_live_view_follows_the_last_start(on_fewer_ranks):
    facts = json.loads((on_fewer_ranks / "run.json").read_text())
    facts["continued"][0] |= {"pid": 2**22 + 1, "host": socket.gethostname()}
    view = View(on_fewer_ranks, facts | {"pid": os.getpid(), "host": socket.gethostname()})
    assert view.process_is_gone()
    view.read()
    assert view.ended
    assert "continued from the checkpoint of frame 20" in "\n".join(view.lines(100))


def test_a_table_that_was_continued_is_followed_from_its_start(tmp_path):
    path = tmp_path / "load.jsonl"
    rows(path, [{"frame": frame} for frame in range(4)])
    table = Follower(path)
    assert [row["frame"] for row in table.new_rows()] == [0, 1, 2, 3]
    rows(tmp_path / "draft", [{"frame": frame} for frame in range(3)])
    (tmp_path / "draft").rename(path)
    rows(path, [{"frame": frame} for frame in range(3, 7)], mode="a")  # between reads, it outgrew the old one
    assert [row["frame"] for row in table.new_rows()] == list(range(7))
    assert table.restarted
    rows(path, [{"frame": 7}], mode="a")
    assert [row["frame"] for row in table.new_rows()] == [7]
    assert not table.restarted


def test_every_plot_and_the_report_show_it(on_fewer_ranks, tmp_path):
    run = motes.open_run(on_fewer_ranks)
    names = [name for name in dir(run.plot) if not name.startswith("_")]
    assert len(names) > 8
    for name in names:
        getattr(run.plot, name)() if name != "heatmap" else run.plot.heatmap("n_end")
    import matplotlib.pyplot as plt

    plt.close("all")
    from motes.analysis.report import write_report

    text = write_report(run, tmp_path / "report.html").read_text()
    assert "continued" in text


def test_a_domain_of_a_rank_that_is_gone_ends_where_the_rank_does(on_fewer_ranks):
    run = motes.open_run(on_fewer_ranks)
    ax = run.plot.domains()
    bands = [band.get_paths()[0].vertices for band in ax.collections[::2]]
    spans = [(points[:, 0].min(), points[:, 0].max()) for points in bands]
    assert spans == [(0, 40), (0, 40), (0, 19), (0, 19), (20, 40)]


@pytest.mark.parametrize(
    "part",
    [3, {}, {"frame": 0}, {"frame": -1}, {"frame": "x"}, {"frame": 3, "ranks": "x"}, {"frame": 3, "argv": 1}],
)
def test_a_damaged_list_of_continuations_is_told(tmp_path, part):
    log = write_log(tmp_path / "run", [load_row(0, "a", 0)], facts={"continued": [part]})
    with pytest.raises(
        LogError, match=r"run.json: continued must be a list of objects, each with a frame > 0 and facts"
    ):
        motes.open_run(log)


def test_a_continuation_from_an_earlier_frame_replaces_the_later_one(tmp_path):
    parts = [{"frame": frame, "calculators": [frame]} for frame in (10, 30, 20)]
    log = write_log(tmp_path / "run", [load_row(0, "a", 0)], facts={"continued": parts})
    assert [part["frame"] for part in motes.open_run(log).stretches] == [0, 10, 20]
