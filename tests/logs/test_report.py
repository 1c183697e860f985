"""What motes shows of a run: summaries, reports, traces, the live view."""

from __future__ import annotations

import io
import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import threading
import time

import pytest
from handmade import load_row, moving_spot, rows, write_log

import motes
from motes import LogError
from motes.analysis import report
from motes.analysis.view import View
from motes.cli import main
from motes.cli.watch import watch

pytest.importorskip("pandas")
pytest.importorskip("matplotlib").use("Agg")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return moving_spot(tmp_path_factory.mktemp("logs") / "spot", frames=8)


def unfinished(folder, **columns):
    log = write_log(folder, [load_row(0, "a", rank, n_end=5, t_compute_s=0.25, **columns) for rank in (2, 3)])
    rows(log / "events.jsonl", [{"frame": 0, "kind": "start", "text": ""}])
    return log


# --- summary


def test_a_run_shows_itself_in_a_notebook(log):
    html = motes.open_run(log)._repr_html_()
    assert "6 (4 calculators)" in html
    assert "Pairwise(threshold=0.1)" in html
    assert html.count("data:image/png;base64,") == 1
    assert len(html) < 150_000
    assert "rank 5: 0.5" in html


def test_text_in_a_summary_is_escaped(tmp_path):
    log = write_log(tmp_path / "<b>", [load_row(0, "<i>", 0)], facts={"balancer": "<script>"})
    html = motes.open_run(log)._repr_html_()
    assert "<script>" not in html
    assert "<i>" not in html


def test_a_healthy_run_has_no_warnings(tmp_path):
    load = [load_row(0, "a", rank, n_end=5, t_compute_s=1.0) for rank in (2, 3)]
    assert motes.open_run(write_log(tmp_path / "run", load, facts={"cores": 8})).warnings() == []


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"facts": {"cores": 2}}, "4 ranks shared 2 cores"),
        ({"facts": {"speeds": {"3": 0.5}}}, "rank 3: 0.5"),
        ({"idle": True}, "No particles in any frame: rank 3"),
        ({"slow": 4.0}, "took 1.60 times the mean"),
        ({"killed": True}, "did not finish"),
        ({"torn": True}, "The last line of frames.jsonl was incomplete"),
        ({"event": "rank_lost"}, "1 event of kind rank_lost"),
    ],
)
def test_warnings(tmp_path, change, says):
    load = [load_row(0, "a", rank, n_end=5, t_compute_s=1.0) for rank in (2, 3)]
    load[1] |= {"n_end": 0 if "idle" in change else 5, "t_compute_s": change.get("slow", 1.0)}
    log = write_log(tmp_path / "run", load, facts=change.get("facts"))
    if "killed" in change:
        rows(log / "events.jsonl", [{"frame": 0, "kind": "start", "text": ""}])
    if "event" in change:
        rows(log / "events.jsonl", [{"frame": 0, "kind": change["event"], "text": "x"}], mode="a")
    if "torn" in change:
        with (log / "frames.jsonl").open("a") as file:
            file.write('{"frame": ')
    run = motes.open_run(log)
    _ = run.frames
    assert len(run.warnings()) == 1
    assert says in run.warnings()[0]


def test_runs_show_themselves(log):
    html = motes.open_runs([log, log])._repr_html_()
    assert html.count("Pairwise(threshold=0.1)") == 2


# --- report


def test_report_is_one_file_that_needs_nothing(log, tmp_path, capsys):
    target = tmp_path / "sub" / "page.html"
    assert main(["report", str(log), "-o", str(target)]) == 0
    assert capsys.readouterr().out.strip() == str(target)
    page = target.read_text()
    assert page.count("data:image/png;base64,") >= 9
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", page)
    for word in ("Domains of cloud", "Moved by balancing", "Where the time goes", "Facts (run.json)"):
        assert word in page
    assert page.rstrip().endswith("</html>")
    assert [path.name for path in target.parent.iterdir()] == ["page.html"], "no draft is left"


def test_report_of_a_log_without_optional_files(tmp_path, capsys):
    log = unfinished(tmp_path / "run")
    assert main(["report", str(log), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["report"] == str(log / "report.html")
    assert told["finished"] is False
    assert told["calculators"] == 2
    assert "did not finish" in (log / "report.html").read_text()


def test_report_fails_whole(log, tmp_path, monkeypatch):
    def broken(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(report.summary, "image", broken)
    with pytest.raises(motes.LogError, match="disk full"):
        report.write_report(motes.open_run(log), tmp_path / "page.html")
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_log_is_said_in_a_line(tmp_path, capsys):
    for command in (["report", str(tmp_path / "no")], ["watch", str(tmp_path / "no"), "--wait", "0"]):
        assert main(command) == 2
        said = capsys.readouterr().err
        assert "no such directory" in said
        assert said.count("\n") == 1
    assert main(["report", str(write_log(tmp_path / "empty", []))]) == 2
    assert "no frames" in capsys.readouterr().err


def test_report_without_matplotlib_names_the_extra(log, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["report", str(log), "-o", str(tmp_path / "x.html")]) == 2
    assert 'pip install "pandas>=2" "matplotlib>=3.8"' in capsys.readouterr().err
    assert motes.open_run(log)._repr_html_().count("matplotlib&gt;=3.8") == 1, "figures in words remain"
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(motes.MissingExtraError, match="needs matplotlib") as caught:
        motes.open_run(log).plot.imbalance()
    assert isinstance(caught.value, ImportError)


# --- trace


def trace_of(run, path):
    assert run.to_perfetto(path) == path
    events = json.loads(path.read_text())["traceEvents"]
    assert all({"ph", "pid", "tid", "name"} <= set(event) for event in events)
    return events


def assert_nested(events):
    threads = {}
    for event in events:
        if event["ph"] == "X":
            threads.setdefault((event["pid"], event["tid"]), []).append((event["ts"], event["dur"]))
    assert threads
    for mine in threads.values():
        open_ends = []
        for start, length in sorted(mine, key=lambda one: (one[0], -one[1])):
            while open_ends and open_ends[-1] <= start + 1e-6:
                open_ends.pop()
            assert not open_ends or start + length <= open_ends[-1] + 1e-6
            open_ends.append(start + length)
    return threads


def test_trace_of_spans(log, tmp_path):
    run = motes.open_run(log)
    events = trace_of(run, tmp_path / "trace.json")
    threads = assert_nested(events)
    assert {pid for pid, _ in threads} == {1, 2, 3, 4, 5, 6, 1_000_000}, (
        "process 0 is the idle one to Perfetto"
    )
    acts = [e for e in events if e["ph"] == "X" and e["cat"] == "act" and e["pid"] == 6]
    spans = run.spans[(run.spans["rank"] == 5) & (run.spans["phase"] == "act")]
    assert [e["dur"] for e in acts] == pytest.approx(
        ((spans["end_s"] - spans["start_s"]) * 1e6).tolist(), abs=1e-3
    )
    assert acts[0]["args"] == {"frame": 0, "system": "cloud"}
    names = {e["pid"]: e["args"]["name"] for e in events if e["name"] == "process_name"}
    assert names[1] == "rank 0 (image generator) on h"
    assert names[6] == "rank 5 (calculator 3) on h"
    counts = [e["args"]["cloud"] for e in events if e["name"] == "particles" and e["pid"] == 3]
    assert counts == run.load[run.load["rank"] == 2]["n_end"].tolist()
    worth = [e["args"]["largest / mean"] for e in events if e["name"] == "imbalance"]
    assert worth == pytest.approx(run.frames["imbalance"].tolist())


def test_trace_without_spans(tmp_path):
    run = motes.open_run(unfinished(tmp_path / "run", t_exchange_s=0.1, t_image_s=0.5))
    events = trace_of(run, tmp_path / "trace.json")
    assert_nested(events)
    acts = [e for e in events if e["ph"] == "X" and e["cat"] == "act"]
    assert [(e["pid"], e["dur"]) for e in acts] == [(3, 250_000), (4, 250_000)]


def test_slices_that_overlap_without_nesting_get_threads_of_their_own(tmp_path):
    log = write_log(tmp_path / "run", [load_row(0, "a", 0)])
    times = [
        ("whole", 0.0, 9.0),
        ("act", 1.0, 4.0),
        ("exchange", 3.0, 6.0),
        ("inner", 1.5, 2.0),
        ("act", 6.0, 7.0),
    ]
    rows(
        log / "spans.r0000.jsonl",
        [{"frame": 0, "phase": p, "system": "", "start_s": a, "end_s": b} for p, a, b in times],
    )
    events = trace_of(motes.open_run(log), tmp_path / "trace.json")
    assert_nested(events)
    lanes = {e["name"]: e["tid"] for e in events if e["ph"] == "X" and e["pid"] == 1}
    assert lanes == {"whole": 0, "act": 0, "inner": 0, "exchange": 1}


def test_messages_under_way_have_a_track_of_their_own(tmp_path):
    log = write_log(tmp_path / "run", [load_row(0, "a", 0)])
    times = [
        ("act", "a", 0.0, 1.0),
        ("messages", "a", 1.0, 3.0),
        ("act", "b", 1.0, 2.0),
        ("messages", "b", 2.0, 4.0),
    ]
    rows(
        log / "spans.r0000.jsonl",
        [{"frame": 0, "phase": p, "system": s, "start_s": a, "end_s": b} for p, s, a, b in times],
    )
    run = motes.open_run(log)
    events = trace_of(run, tmp_path / "trace.json")
    assert_nested(events)
    lanes = {e["name"]: e["tid"] for e in events if e["ph"] == "X" and e["pid"] == 1}
    assert lanes == {"act a": 0, "act b": 0, "messages a": 100, "messages b": 101}
    bars = {box.get_label(): [bar.get_height() for bar in box] for box in run.plot.phases().containers}
    assert bars == {"act": [2000.0]}, "what is under way takes no time of the rank"
    assert "messages in flight" in {box.get_label() for box in run.plot.gantt().containers}


def test_trace_is_whole_or_not_there(log, tmp_path, monkeypatch):
    def broken(*_):
        raise RuntimeError("stop")

    monkeypatch.setattr("motes.analysis.trace._counters", broken)
    with pytest.raises(RuntimeError, match="stop"):
        motes.open_run(log).to_perfetto(tmp_path / "trace.json")
    assert list(tmp_path.iterdir()) == []
    monkeypatch.undo()
    with pytest.raises(LogError, match="no frame"):
        motes.open_run(write_log(tmp_path / "empty", [])).to_perfetto(tmp_path / "trace.json")


# --- the live view


def test_view_of_a_frame(log):
    view = View(log, json.loads((log / "run.json").read_text()))
    view.read()
    lines = view.lines(79)
    assert all(len(line) <= 79 for line in lines)
    run = motes.open_run(log)
    last = run.load[run.load["frame"] == 7].set_index("rank")
    bars = {int(line.split()[1]): line for line in lines if line.startswith("rank ")}
    assert sorted(bars) == [2, 3, 4, 5]
    longest = last["t_compute_s"].idxmax()
    assert bars[longest].count("█") == 39
    assert bars[longest].count("░") == 0
    for rank, line in bars.items():
        assert line.count("█") == round(39 * last["t_compute_s"][rank] / last["t_compute_s"].max())
        assert line.endswith(f"{last['n_end'][rank]:,}".replace(",", " "))
    strip = next(line for line in lines if line.count("│") == 3)
    assert strip.index("2") < strip.index("3") < strip.index("4") < strip.index("5")
    assert view.ended
    assert view.fps == pytest.approx(1 / run.frames["t_frame_s"].iloc[0])
    assert f"{run.frames['imbalance'].iloc[-1]:.2f}" in next(
        line for line in lines if line.startswith("imbalance")
    )
    assert all(line.isascii() for line in view.lines(79, plain=True))


def test_not_a_terminal_gets_lines(log):
    out = io.StringIO()
    assert watch(log, out=out) == 0
    assert out.getvalue().startswith("frame 8  ")
    assert out.getvalue().count("\n") == 1
    assert "\x1b" not in out.getvalue()


def test_once_prints_the_whole_view_anywhere(log, tmp_path):
    out = io.StringIO()
    assert watch(log, once=True, out=out) == 0
    assert len(re.findall("^rank ", out.getvalue(), re.MULTILINE)) == 4
    assert re.search("^parallel efficiency .* = load balance .* x tra", out.getvalue(), re.MULTILINE)
    assert re.search("^longest wait: rank . for rank .,", out.getvalue(), re.MULTILINE)
    assert "\x1b" not in out.getvalue()
    assert watch(unfinished(tmp_path / "run"), once=True, out=out) == 0, "it does not wait for an end"


def test_the_view_as_json(log, capsys):
    assert main(["watch", str(log), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    last = motes.open_run(log).load.query("frame == 7")
    assert (told["frame"], told["particles"], told["ended"]) == (7, 40_000, True)
    assert [row["particles"] for row in told["ranks"]] == last["n_end"].tolist()
    factors = motes.open_run(log).efficiencies().loc[6]  # a live view cannot know whether frame 7 is complete
    assert told["efficiency"] == pytest.approx(factors.to_dict())
    assert [row["t_compute_s"] for row in told["ranks"]] == pytest.approx(last["t_compute_s"].tolist())


def test_following_a_run_that_is_written(tmp_path):
    log = unfinished(tmp_path / "run")
    view = View(log, {})
    assert view.read()
    assert not view.read()
    with (log / "frames.jsonl").open("a") as file:
        file.write('{"frame": 1, "part')
        file.flush()
        assert not view.read(), "half a row is no news"
        file.write('icles": 12, "imbalance": 1.5, "t_frame_s": 0.5}\n')
    assert view.read()
    assert view.frame["particles"] == 12
    assert list(view.imbalances) == [1.0, 1.5]
    assert not view.ended
    rows(log / "frames.jsonl", [{"frame": 0, "particles": 3}])
    assert view.read(), "another run began in the same directory"
    assert view.frame["particles"] == 3
    assert len(view.imbalances) == 1


def test_watch_waits_for_the_log_and_ends_with_the_run(tmp_path):
    out, log = io.StringIO(), tmp_path / "run"
    codes = []
    watcher = threading.Thread(target=lambda: codes.append(watch(log, out=out)))
    watcher.start()
    time.sleep(0.3)
    unfinished(log)
    time.sleep(0.8)
    assert not codes
    rows(log / "events.jsonl", [{"frame": 0, "kind": "end", "text": ""}], mode="a")
    watcher.join(10)
    assert codes == [0]
    assert out.getvalue().startswith("frame 1 ")


def test_watch_of_a_killed_run_ends(tmp_path, capsys):
    done = subprocess.run(
        [sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, text=True
    )
    log = unfinished(tmp_path / "run")
    facts = json.loads((log / "run.json").read_text()) | {
        "pid": int(done.stdout),
        "host": os.uname().nodename,
    }
    (log / "run.json").write_text(json.dumps(facts))
    assert watch(log, out=io.StringIO()) == 1
    assert "its process is gone" in capsys.readouterr().err


def on_a_terminal(argv, *, interrupt_at=None, timeout=60):
    """Run a command on a pseudo-terminal; send Ctrl-C when output matches. Return exit code and output."""
    master, slave = pty.openpty()
    env = {**os.environ, "TERM": "xterm", "COLUMNS": "90", "LINES": "30"}
    process = subprocess.Popen(argv, stdin=slave, stdout=slave, stderr=slave, env=env, start_new_session=True)
    os.close(slave)
    said, limit = "", time.monotonic() + timeout
    try:
        while time.monotonic() < limit:
            ready, _, _ = select.select([master], [], [], limit - time.monotonic())
            try:
                news = os.read(master, 65536).decode(errors="replace") if ready else ""
            except OSError:  # the other end is closed
                break
            said += news
            if interrupt_at and re.search(interrupt_at, news):
                os.kill(process.pid, signal.SIGINT)
        return process.wait(max(limit - time.monotonic(), 1)), said
    finally:
        process.kill()
        process.wait()
        os.close(master)


def test_a_terminal_is_redrawn_in_place_until_interrupted(tmp_path):
    log = unfinished(tmp_path / "run")
    argv = [sys.executable, "-m", "motes", "watch", str(log)]
    code, said = on_a_terminal(argv, interrupt_at=r"\x1b\[\d+F")
    assert code == 0, said
    assert "rank 3" in said
    assert "█" in said
    assert "Traceback" not in said
