"""Each rank's time: no gaps, which rank waited for which, POP's factors, why a run takes so long."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from handmade import load_row, rows, time_row, write_log
from standing import on_ranks

import motes
from motes.analysis._tables.schema import ACTIVITIES
from motes.analysis.explaining import told_s

pandas = pytest.importorskip("pandas")

SCENE = """
import sys
import time
import motes
from motes.shapes import Box

world = motes.World(
    seed=3, space=(-1, 1), log=sys.argv[1], progress="off", roles=sys.argv[2], spans=True,
    renderer=motes.Renderer(64, 48, camera=motes.Camera((0, 1, 8), (0, 1, 0))),
)
s = world.system("snow")
with world:
    for frame in world.frames(6):
        s.source(Box((-1, -1, -1), (1, 1, 1)), rate=24_000)
        s.move()
        if world.rank == 1:
            time.sleep(0.01)
        world.render() if frame % 2 else world.step()
        world.digest()
"""


@pytest.fixture(scope="module", params=[(4, "auto"), (3, "shared"), (1, "shared")])
def run(request, tmp_path_factory):
    """Return a run's log and the number of its ranks."""
    size, roles = request.param
    log = tmp_path_factory.mktemp("times") / "log"
    on_ranks(size, SCENE, log, roles)
    return motes.open_run(log), size


def test_every_second_of_each_rank_has_one_name(run):
    run, ranks = run
    times = run.times
    assert len(times) == 6 * ranks
    named = times[[f"{name}_s" for name in ACTIVITIES]].sum(axis=1)
    assert np.allclose(named, times["wall_s"], rtol=0.01)
    ends = times.pivot(index="frame", columns="rank", values="wall_s").cumsum().max(axis=1)
    assert np.allclose(ends, run.frames.set_index("frame")["t_frame_s"].cumsum(), rtol=1e-6)
    assert (times[[f"{name}_s" for name in ACTIVITIES]] >= 0).all(axis=None)
    if ranks > 1:
        assert times[times["rank"] == 1]["script_s"].min() >= 0.01


def test_waits_say_for_whom_and_in_which_phase(run):
    run, ranks = run
    waits = run.waits()
    assert list(waits.columns) == ["frame", "rank", "waited_for", "phase", "seconds"]
    summed = waits.groupby(["frame", "rank"])["seconds"].sum()
    told = run.times.set_index(["frame", "rank"])["wait_s"]
    assert np.allclose(summed.reindex(told.index).fillna(0.0), told, atol=1e-6)
    if ranks == 1:
        assert waits.empty
        return
    assert (waits["rank"] != waits["waited_for"]).all()
    manager = run.facts["manager"]
    for_manager = waits[(waits["waited_for"] == manager) & (waits["phase"] == "begin")]
    assert set(for_manager["rank"]) == set(range(ranks)) - {manager}


def test_trace_has_an_arrow_to_the_end_of_each_wait(run, tmp_path):
    run, ranks = run
    run.to_perfetto(tmp_path / "trace.json")
    events = json.loads((tmp_path / "trace.json").read_text())["traceEvents"]
    waits = run.spans.dropna(subset=["waited_for"])
    starts = {event["id"]: event for event in events if event["ph"] == "s"}
    ends = {event["id"]: event for event in events if event["ph"] == "f"}
    assert starts.keys() == ends.keys() and len(starts) == (waits["waited_for"] >= 0).sum()
    assert all(starts[id]["pid"] != ends[id]["pid"] for id in starts)
    assert (len(starts) > 0) == (ranks > 1)


def test_factors_multiply_to_the_efficiency(run):
    found = run[0].efficiencies()
    assert list(found.index) == [0, 1, 2, 3, 4, 5, "all"]
    assert np.allclose(found["parallel"], found["load_balance"] * found["communication"], rtol=1e-9)
    assert np.allclose(found["communication"], found["serialisation"] * found["transfer"], rtol=1e-9)
    assert ((found > 0) & (found <= 1)).all(axis=None)


# --- made by hand: the answers are known

Times = dict[int, dict[str, float]]


def made(
    folder: Path, spent: Times, *, chain: float, held: dict[int, int] | None = None
) -> motes.analysis.Run:
    """Write four equal frames, calculated by ranks 2 and 3; `chain`: critical path of each, in seconds."""
    held = held or {2: 1000, 3: 1000}
    load, times = [], []
    for frame in range(4):
        for rank, n in held.items():
            load.append(load_row(frame, "s", rank, n_start=n, n_end=n, t_compute_s=spent[rank]["act"]))
        times += [time_row(frame, rank, chain_s=chain * (frame + 1), **own) for rank, own in spent.items()]
    wall = sum(next(iter(spent.values())).values())
    log = write_log(folder, load, t_frame_s=wall)
    rows(log / "times.jsonl", times)
    return motes.open_run(log)


def test_factors_of_a_run_whose_answer_is_known(tmp_path):
    spent = {
        0: {"picture": 0.2, "wait": 0.8},
        1: {"births": 0.1, "wait": 0.9},
        2: {"act": 0.4, "wait": 0.6},
        3: {"act": 0.5, "wait": 0.5},
    }
    found = made(tmp_path / "log", spent, chain=0.8).efficiencies()
    assert found.loc["all"].tolist() == pytest.approx([0.3, 0.6, 0.5, 0.625, 0.8])
    assert found.loc[2].tolist() == pytest.approx([0.3, 0.6, 0.5, 0.625, 0.8])


IDLE = {"script": 0.01, "wait": 0.99}
CAUSES: dict[str, tuple[Times, float, dict[int, int], str]] = {
    "imbalance": (
        {0: IDLE, 1: IDLE, 2: {"act": 0.1, "wait": 0.9}, 3: {"act": 0.9, "wait": 0.1}},
        0.98,
        {2: 1000, 3: 9000},
        "Imbalance: rank 3 holds",
    ),
    "slow rank": (
        {0: IDLE, 1: IDLE, 2: {"act": 0.1, "wait": 0.9}, 3: {"act": 0.9, "wait": 0.1}},
        0.98,
        {2: 1000, 3: 1000},
        "Slow rank 3: it takes 9 times",
    ),
    "network": (
        {0: IDLE, 1: IDLE, 2: {"act": 0.2, "wait": 0.8}, 3: {"act": 0.2, "wait": 0.8}},
        0.25,
        {2: 1000, 3: 1000},
        "Network: messages in flight cost 750 ms",
    ),
    "manager": (
        {
            0: IDLE,
            1: {"births": 0.7, "wait": 0.3},
            2: {"act": 0.2, "wait": 0.8},
            3: {"act": 0.2, "wait": 0.8},
        },
        0.95,
        {2: 1000, 3: 1000},
        "Manager (rank 1): others wait",
    ),
    "script": (
        {rank: {"script": 0.7, "act": 0.1, "wait": 0.2} for rank in range(4)},
        0.85,
        {2: 1000, 3: 1000},
        "Script: its own Python takes 700 ms",
    ),
}


@pytest.mark.parametrize("cause", CAUSES)
def test_the_largest_cause_is_named_first(cause, tmp_path):
    spent, chain, held, begins = CAUSES[cause]
    told = made(tmp_path / "log", spent, chain=chain, held=held).explain()
    assert told.losses[0].cause == cause
    assert str(told).startswith(begins)
    assert 1 <= len(told.sentences) <= 6
    seconds = [loss.seconds for loss in told.losses]
    assert seconds == sorted(seconds, reverse=True)


def test_perfect_balance_saves_no_more_than_others_leave(tmp_path):
    spent, chain, held, _ = CAUSES["imbalance"]
    assert made(tmp_path / "one", spent, chain=chain, held=held).explain().saving == pytest.approx(0.4)
    busy = {**spent, 0: {"picture": 0.85, "wait": 0.15}}
    run = made(tmp_path / "two", busy, chain=chain, held=held)
    assert run.explain().saving == pytest.approx(0.15)
    assert run.summary()["balance_would_save"] == pytest.approx(0.15)
    assert any("at most 150 ms of a frame's 1 s" in text for text in run.warnings())


BUSY = {"picture": 0.85, "wait": 0.15}
SLEEPER = {0: IDLE, 1: IDLE, 2: {"act": 0.1, "wait": 0.9}, 3: {"act": 0.1, "other": 0.8, "wait": 0.1}}


@pytest.mark.parametrize(
    ("spent", "held", "saved"),
    [
        (CAUSES["imbalance"][0], {2: 1000, 3: 9000}, 0.4),
        (CAUSES["slow rank"][0], {2: 1000, 3: 1000}, 0.9 - 2000 / (1000 / 0.1 + 1000 / 0.9)),
        (CAUSES["slow rank"][0], {2: 1000, 3: 2000}, 0.9 - 3000 / (1000 / 0.1 + 2000 / 0.9)),  # and imbalance
        ({**CAUSES["imbalance"][0], 0: BUSY}, {2: 1000, 3: 9000}, 0.15),
        ({**CAUSES["slow rank"][0], 0: BUSY}, {2: 1000, 3: 1000}, 0.15),
        (SLEEPER, {2: 1000, 3: 1000}, 0.9 - 2000 / (1000 / 0.1 + 1000 / 0.9)),
        (CAUSES["network"][0], {2: 1000, 3: 1000}, 0.0),
    ],
)
def test_all_that_tell_what_balance_would_save_agree(spent, held, saved, tmp_path):
    log = made(tmp_path / "log", spent, chain=0.98, held=held).path
    for name, column in (("load", "t_compute_s"), ("times", "wall_s")):  # files are opened in the first frame
        first, rest = (log / f"{name}.jsonl").read_text().split('"frame": 1', 1)
        slower = re.sub(rf'("{column}": )[\d.]+', r"\g<1>9.5", first)
        (log / f"{name}.jsonl").write_text(slower + '"frame": 1' + rest)
    run = motes.open_run(log)
    told = run.explain()
    named = [loss.seconds for loss in told.losses if loss.cause in ("imbalance", "slow rank")]
    assert told.frame_s == pytest.approx(1.0)
    assert sum(named) == pytest.approx(saved)
    assert told.saving * told.frame_s == pytest.approx(saved)
    assert run.summary()["balance_would_save"] == told.saving
    warned = [text for text in run.warnings() if "perfect balance" in text]
    assert all(f"at most {told_s(saved)} of a frame's 1 s" in text for text in warned)


def test_a_rank_that_sleeps_is_warned_of(tmp_path):
    run = made(tmp_path / "log", SLEEPER, chain=0.98)
    assert any(
        text.startswith("Rank 3 was kept from working for 800 ms of a frame's 1 s") for text in run.warnings()
    )
    assert "slept" in run.explain().sentences[0]


SLOW = """
import sys
import time
import motes
from motes.shapes import Box

class Slow(motes.balance.Balancer):
    def decide(self, load):
        time.sleep(float(sys.argv[2]))
        return motes.balance.Orders(())

world = motes.World(space=(-1, 1), log=sys.argv[1], progress="off", balancer=Slow())
s = world.system("snow")
with world:
    for frame in world.frames(24):
        s.burst(Box((-1, -1, -1), (1, 1, 1)), count=100)
        s.move()
        world.step()
        if world.rank == 1:
            time.sleep(0.001 if float(sys.argv[2]) else 0.02)
"""


@pytest.mark.parametrize("seconds", [0, 0.03])
def test_a_balancer_that_decides_slowly_is_named(seconds: float, tmp_path: Path):
    told = on_ranks(4, SLOW, tmp_path / "log", seconds)
    assert told.code == 0, told.text
    run = motes.open_run(tmp_path / "log")
    events = list(run.events["text"][run.events["kind"] == "slow_balancer"])
    assert len(events) == bool(seconds), run.events
    if seconds:
        assert events[0].startswith("balancer Slow(): its decide takes ")
        assert events[0] in run.warnings() and events[0] in run.explain().sentences[0]
        assert run.explain().sentences[0].startswith("Manager (rank 1): others wait")


def test_logs_of_earlier_versions_have_no_times(tmp_path):
    load = [
        load_row(f, "s", r, n_start=n, n_end=n, t_compute_s=n / 1e4)
        for f in range(4)
        for r, n in ((2, 900), (3, 100))
    ]
    run = motes.open_run(write_log(tmp_path / "log", load))
    assert run.times.empty and run.waits().empty and run.efficiencies().empty
    assert run.explain().sentences[0].startswith("Imbalance")
    assert np.isnan(run.summary()["parallel_efficiency"])


def test_all_policies_say_what_they_moved(tmp_path):
    load = [load_row(0, "s", rank, n_start=1600, n_end=1600, t_compute_s=0.1) for rank in (2, 3)]
    log = write_log(tmp_path / "log", load)
    density = []
    for rank, low in ((2, 0.0), (3, 16.0)):
        places = {f"x_q{i:02d}": low + i for i in range(17)}
        density.append({"frame": 0, "system": "s", "rank": rank, "n": 1600, **places})
    rows(log / "density.jsonl", density, pad=512)
    cut = {"frame": 0, "system": "s", "left_rank": 2, "right_rank": 3, "ordered": None, "given": None}
    rows(log / "balance.jsonl", [{**cut, "cut_before": 16.0, "cut_after": 13.0, "policy": "PrefixCuts()"}])
    assert motes.open_run(log).summary()["moved_to_balance"] == 300
