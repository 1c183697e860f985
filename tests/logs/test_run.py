"""Logs as tables: `open_run` and `open_runs` on logs written by hand: complete, torn and damaged."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from docs_scripts import script_of_docs
from handmade import load_row, rows, write_log
from standing import on_ranks

import motes
from motes import ArgumentError, LogError

pandas = pytest.importorskip("pandas")


@pytest.fixture
def log(tmp_path):
    """Write a log of two systems on ranks 2 and 3; rank 3 takes 3, 2 and 1 times as long."""
    load = [
        load_row(frame, system, rank, n_end=n, t_compute_s=seconds, t_wait_s=0.25, speed=n / seconds)
        for frame, slow in enumerate((0.75, 0.5, 0.25))
        for system in ("a", "b")
        for rank, seconds, n in ((2, 0.25, 100), (3, slow, 300))
    ]
    return write_log(tmp_path / "run", load, facts={"systems": ["a", "b"]})


# --- reading


def test_tables_have_all_columns_in_order(log):
    run = motes.open_run(log)
    assert list(run.load.columns)[:6] == ["frame", "system", "rank", "host", "n_start", "n_end"]
    columns = list(run.load.columns)
    assert columns[columns.index("domain_lo") :][:2] == ["domain_lo", "domain_hi"]
    assert columns.index("domain_hi") < columns.index("speed") < columns.index("interactions")
    assert columns[-1] == "t_interact_wait_s"
    assert run.load["interactions"].isna().all(), "there were none"
    assert run.load["n_end"].dtype == "int64"
    assert run.load["t_compute_s"].dtype == "float64"
    assert len(run.load) == 12
    assert np.isnan(run.load["domain_lo"]).all(), "null is NaN"
    assert list(run.frames["frame"]) == [0, 1, 2]
    assert list(run.events["kind"]) == ["start", "end"]


def test_facts(log):
    run = motes.open_run(str(log))
    assert run.finished
    assert (run.ranks, run.calculators, run.systems) == (4, [2, 3], ["a", "b"])
    assert run.space == (-1.0, 1.0)
    assert run.balancer == "Static()"
    assert run.path == log
    assert run.name == "run"
    assert run.torn == []


def test_an_older_log_lacks_columns_and_files(tmp_path):
    log = write_log(
        tmp_path / "old", [{"frame": 0, "system": "a", "rank": 0, "n_end": 5, "t_compute_s": 0.5}]
    )
    run = motes.open_run(log)
    assert run.load["n_end"].tolist() == [5]
    assert np.isnan(run.load["speed"]).all()
    assert "t_image_s" in run.load.columns
    assert run.balance.empty
    assert {"ordered", "given", "cut_after"} <= set(run.balance.columns)
    assert run.density.empty
    assert run.spans.empty
    assert run.imbalance().tolist() == [1.0]


def test_columns_that_are_not_known_are_kept(tmp_path):
    run = motes.open_run(write_log(tmp_path / "run", [{**load_row(0, "a", 0), "rss_bytes": 7}]))
    assert run.load["rss_bytes"].tolist() == [7]


def test_orders_that_are_none_are_nan(tmp_path):
    log = write_log(tmp_path / "run", [load_row(0, "a", 0)])
    balance = [
        {"frame": 0, "system": "a", "left_rank": rank, "right_rank": rank + 1, "ordered": order, "given": 4}
        for rank, order in enumerate((-3, None))
    ]
    rows(log / "balance.jsonl", balance)
    run = motes.open_run(log)
    assert run.balance["ordered"].tolist()[0] == -3
    assert np.isnan(run.balance["ordered"][1])
    assert run.balance["given"].tolist() == [4, 4]
    assert run.summary()["moved_to_balance"] == 8


def test_spans_of_all_ranks(tmp_path):
    log = write_log(tmp_path / "run", [load_row(0, "a", 0)])
    for rank in (0, 11):
        span = {"frame": 0, "phase": "act", "system": "a", "start_s": 1.5, "end_s": 2.0}
        rows(log / f"spans.r{rank:04d}.jsonl", [span])
    spans = motes.open_run(log).spans
    assert spans["rank"].tolist() == [0, 11]
    assert spans["end_s"].tolist() == [2.0, 2.0]


@pytest.mark.parametrize(
    "tail", [b'{"frame": 2, "part', b'{"frame": 2, "part    \n', b"\0" * 300, b"{", b"[1]"]
)
def test_a_torn_last_row_is_left_out(log, tail):
    whole = motes.open_run(log).frames
    with (log / "frames.jsonl").open("ab") as file:
        file.write(tail)
    run = motes.open_run(log)
    assert run.frames.equals(whole)
    assert run.torn == ([] if tail.startswith(b"\0") else [log / "frames.jsonl"])


def test_a_last_row_without_its_newline_is_whole(log):
    text = (log / "frames.jsonl").read_bytes()
    (log / "frames.jsonl").write_bytes(text.rstrip())
    assert len(motes.open_run(log).frames) == 3


def test_a_run_that_was_killed(log):
    events = (log / "events.jsonl").read_text().splitlines(keepends=True)
    (log / "events.jsonl").write_text(events[0])
    run = motes.open_run(log)
    assert not run.finished
    assert len(run.frames) == 3


@pytest.mark.parametrize("damage", ['{"frame": 1, "particles":', "12", "[]", "{} {}", '{"a": 1}, {"b": 2}'])
def test_a_damaged_middle_names_file_and_line(log, damage):
    lines = (log / "frames.jsonl").read_text().splitlines()
    lines[1] = damage
    (log / "frames.jsonl").write_text("\n".join(lines) + "\n")
    run = motes.open_run(log)
    with pytest.raises(LogError, match=r"frames\.jsonl, line 2: "):
        _ = run.frames
    assert len(run.load) == 12, "other tables are read"


@pytest.mark.parametrize("file", ["load.jsonl", "frames.jsonl", "events.jsonl"])
def test_a_missing_table(log, file):
    (log / file).unlink()
    with pytest.raises(LogError, match=file):
        getattr(motes.open_run(log), file.partition(".")[0])


def test_what_is_no_log(tmp_path, log):
    with pytest.raises(LogError, match="nowhere: no such directory"):
        motes.open_run(tmp_path / "nowhere")
    with pytest.raises(LogError, match=r"run\.json: no such file"):
        motes.open_run(tmp_path)
    (log / "run.json").write_text('{"seed": ')
    with pytest.raises(LogError, match=r"run\.json"):
        motes.open_run(log)


def test_empty_tables(tmp_path):
    run = motes.open_run(write_log(tmp_path / "run", []))
    assert run.load.empty
    assert run.frames.empty
    assert run.imbalance().empty
    assert run.summary()["frames"] == 0


def test_a_run_from_tables(log):
    run = motes.open_run(log)
    copy = motes.Run(run.facts, {"load": run.load, "frames": run.frames})
    assert copy.path is None
    assert copy.finished
    assert copy.balance.empty
    assert copy.imbalance().equals(run.imbalance())


def test_a_run_that_goes_on_is_read_anew(log):
    run = motes.open_run(log)
    assert len(run.frames) == 3
    rows(log / "frames.jsonl", [{"frame": 3, "particles": 1}], mode="a")
    assert len(run.frames) == 3
    assert len(run.reload().frames) == 4


def test_importing_motes_imports_no_pandas():
    code = (
        "import sys, motes; motes.open_run; print([m for m in ('pandas', 'matplotlib') if m in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert said.stdout.strip() == "[]", said.stderr


def test_without_pandas_the_error_names_the_extra(log, monkeypatch):
    run = motes.open_run(log)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match='needs pandas, .* -m pip install "pandas'):
        _ = run.load


# --- measures


def test_imbalance_and_efficiency(log):
    run = motes.open_run(log)
    # Seconds over both systems: (0.5, 1.5), (0.5, 1.0), (0.5, 0.5).
    assert run.imbalance().tolist() == pytest.approx([1.5, 4 / 3, 1.0])
    assert run.efficiency().tolist() == pytest.approx([2 / 3, 0.75, 1.0])
    assert run.imbalance("n_end").tolist() == pytest.approx([1.5] * 3)
    assert run.imbalance(system="a").tolist() == pytest.approx([1.5, 4 / 3, 1.0])
    assert run.imbalance().index.tolist() == [0, 1, 2]


def test_by_rank_sums_systems_but_not_what_a_rank_has_once(log):
    run = motes.open_run(log)
    assert run.by_rank("n_end").loc[0].to_dict() == {2: 200, 3: 600}
    assert run.by_rank("n_end", "b").loc[0].to_dict() == {2: 100, 3: 300}
    assert run.by_rank("t_wait_s").loc[1].to_dict() == {2: 0.25, 3: 0.25}
    # Particles per second over both systems: 200 / 0.5, 600 / 1.5.
    assert run.by_rank("speed").loc[0].to_dict() == pytest.approx({2: 400.0, 3: 400.0})


@pytest.mark.parametrize(("column", "system"), [("host", None), ("weight", None), ("n_end", "c")])
def test_what_is_not_there_is_refused(log, column, system):
    with pytest.raises(ArgumentError, match="must be"):
        motes.open_run(log).by_rank(column, system)


def test_idle_calculators_are_balanced(tmp_path):
    run = motes.open_run(write_log(tmp_path / "run", [load_row(0, "a", rank) for rank in (0, 1)]))
    assert run.imbalance().tolist() == [1.0]
    assert run.by_rank("speed").isna().all(axis=None)


def test_summary(log):
    told = motes.open_run(log).summary()
    assert told["frames"] == 3
    assert told["wall_s"] == pytest.approx(3.0)
    assert told["frames_per_s"] == pytest.approx(1.0)
    assert told["mean_imbalance"] == pytest.approx((1.5 + 4 / 3 + 1) / 3)
    assert told["particles"] == 800
    assert told["calculators"] == 2


# --- many runs


def timed(folder, name, seconds, calculators, *, space, balancer="Static()", frames=4):
    load = [load_row(frame, "a", rank) for frame in range(frames) for rank in calculators]
    facts = {"space": space, "balancer": balancer, "calculators": calculators}
    facts["ranks"] = [{"rank": rank, "host": "h"} for rank in range(max(calculators) + 1)]
    return write_log(folder / name, load, facts=facts, t_frame_s=seconds)


@pytest.fixture
def runs(tmp_path):
    timed(tmp_path, "one", 8.0, [0], space=None)
    for ranks, finite, infinite in ((4, 4.0, 8.0), (5, 2.0, 10.0)):
        calculators = list(range(2, ranks + 2))
        timed(tmp_path, f"{ranks}-is-slb", infinite, calculators, space=None)
        timed(tmp_path, f"{ranks}-fs-slb", finite, calculators, space=[-1, 1])
        timed(tmp_path, f"{ranks}-fs-dlb", finite / 2, calculators, space=[-1, 1], balancer="Pairwise(0.1)")
    (tmp_path / "notes").mkdir()
    return tmp_path


def test_speedup_in_the_papers_layout(runs):
    table = motes.open_runs(f"{runs}/*").speedup()
    assert list(table["speedup"].columns) == ["IS-SLB", "FS-SLB", "FS-DLB"]
    assert table.index.names == ["ranks", "calculators"]
    assert table["speedup"].loc[(6, 4)].tolist() == pytest.approx([1.0, 2.0, 4.0])
    assert table["speedup"].loc[(7, 5)].tolist() == pytest.approx([0.8, 4.0, 8.0])
    assert table["efficiency"].loc[(7, 5)].tolist() == pytest.approx([0.16, 0.8, 1.6])
    assert table["speedup"].loc[(1, 1), "IS-SLB"] == 1.0
    assert np.isnan(table["speedup"].loc[(1, 1), "FS-SLB"])


def test_speedup_over_a_named_baseline(runs):
    opened = motes.open_runs(runs)
    assert len(opened) == 7
    cell = ((7, 5), ("speedup", "FS-SLB"))
    assert opened.speedup({"ranks": 6, "space": None}).loc[cell] == pytest.approx(4.0)
    assert opened.speedup(baseline=1.0).loc[cell] == pytest.approx(0.5)
    assert opened.speedup(runs / "4-fs-slb").loc[cell] == pytest.approx(2.0)
    with pytest.raises(ArgumentError, match="baseline"):
        opened.speedup({"ranks": 99})
    with pytest.raises(ArgumentError, match="baseline"):
        opened.speedup(-1)
    with pytest.raises(ArgumentError, match="layout"):
        opened.speedup(layout="wide")


def test_speedup_says_over_what(runs):
    opened = motes.open_runs(runs)
    assert opened.speedup().attrs["baseline"] == "one"
    assert set(opened.speedup(layout="long")["baseline"]) == {"one"}
    assert opened.speedup(2).attrs["baseline"] == "2 s"
    several = motes.Runs(run for run in opened if run.ranks > 1)
    with pytest.warns(motes.errors.MotesWarning, match="relative to 4-is-slb, on 6 ranks, 4 of them") as said:
        assert several.speedup().attrs["baseline"] == "4-is-slb"
    assert {warning.filename for warning in said} == {__file__}


def test_only_frames_that_both_have_are_compared(tmp_path):
    timed(tmp_path, "short", 2.0, [0], space=None, frames=2)
    log = timed(tmp_path, "long", 1.0, [0, 1], space=None, frames=4)
    lines = (log / "frames.jsonl").read_text().replace('"t_frame_s": 1.0', '"t_frame_s": 9.0').splitlines()
    first = (log / "frames.jsonl").read_text().splitlines()[:2]
    (log / "frames.jsonl").write_text("\n".join(first + lines[2:]) + "\n")
    table = motes.open_runs(tmp_path).speedup(layout="long")
    assert table.loc["long", "speedup"] == pytest.approx(2.0)


def test_several_dynamic_balancers_have_columns_of_their_own(runs):
    timed(runs, "4-fs-cuts", 1.0, [2, 3, 4, 5], space=[-1, 1], balancer="PrefixCuts(threshold=0.05)")
    table = motes.open_runs(runs).speedup()
    assert list(table["speedup"].columns) == ["IS-SLB", "FS-SLB", "FS-DLB Pairwise", "FS-DLB PrefixCuts"]


def test_runs_are_a_sequence(runs):
    opened = motes.open_runs(f"{runs}/4-*")
    assert [run.name for run in opened] == ["4-fs-dlb", "4-fs-slb", "4-is-slb"]
    assert opened.table.loc["4-is-slb", "configuration"] == "IS-SLB"
    assert [run.name for run in opened.where(configuration="FS-DLB")] == ["4-fs-dlb"]
    assert [run.name for run in opened.where(space=(-1, 1), balancer="Static()")] == ["4-fs-slb"]
    assert opened[-1].name == opened[1:][1].name


def test_no_runs(tmp_path):
    with pytest.raises(LogError, match="no run's log"):
        motes.open_runs(f"{tmp_path}/*")
    with pytest.raises(LogError, match="nothing is not a run's log"):
        motes.open_runs([tmp_path / "nothing"])


# --- the page


def test_the_page_says_what_the_schema_says():
    module = script_of_docs("make_analysis")
    assert module.page() == module.PAGE.read_text(), "run python docs/scripts/make_analysis.py"
    assert module.columns() == module.COLUMNS.read_text(), "run python docs/scripts/make_analysis.py"


def test_the_pages_example_runs(tmp_path):
    page = Path(__file__).resolve().parents[2] / "docs" / "analysis.md"
    if not page.is_file():
        pytest.skip("the page needs the source tree")
    (block,) = re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)
    (tmp_path / "script.py").write_text(f"import os; os.chdir({str(tmp_path)!r})\n{block}")
    for result in (on_ranks(1, tmp_path / "script.py"), on_ranks(3, tmp_path / "script.py")):
        assert result.code == 0, result.text
    assert (tmp_path / "out" / "rain.trace.json").stat().st_size > 10_000
