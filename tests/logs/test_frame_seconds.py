"""A frame's seconds add up to the run's, and every figure that is made of them."""

from __future__ import annotations

import json
import sys
from itertools import pairwise

import pytest
from handmade import load_row, rows, time_row, write_log
from launching import command
from standing import on_ranks

import motes
import motes.analysis.runs
from motes._launch import starting
from motes.analysis._plots import timeline
from motes.analysis.view import View

pandas = pytest.importorskip("pandas")

SCENE = """
import sys
import time
import motes
import motes.analysis.runs
from motes.shapes import Box

frames, log = int(open(sys.argv[1]).read()), sys.argv[3]
ranks = [int(rank) for rank in sys.argv[2].split(",")]
world = motes.World(
    seed=1, space=(-1, 1), log=log, progress="off", roles="shared", threads=1,
    checkpoint=motes.Checkpoint(log + ".saved", every=7) if len(sys.argv) > 4 else None,
)
s = world.system("p")
with world:
    start = 0.0
    for frame in world.frames(frames):
        if frame == 0:
            s.burst(Box((-1, -1, -1), (1, 1, 1)), count=1000)
        s.move()
        if world.rank == ranks[frame % len(ranks)]:
            time.sleep(0.02)
        world.step()
        end = time.time()
        if frame == 0:
            start = end
        if frame % 3 == 0 and world.rank == ranks[0]:
            time.sleep(0.01)
print(world.rank, start, end)
"""


def check(run: motes.analysis.Run, took_s: float) -> None:
    """Check all figures that are made of frames' seconds; `took_s`: from the end of frame 0."""
    seconds = run.frames["t_frame_s"]
    assert (seconds > 0).all()
    assert seconds.iloc[1:].sum() == pytest.approx(took_s, rel=0.02)
    walls = run.times.pivot(index="frame", columns="rank", values="wall_s")
    assert seconds.sum() == pytest.approx(walls.sum().max(), rel=0.01)
    told = run.summary()
    assert told["wall_s"] == pytest.approx(seconds.sum())
    assert told["frames_per_s"] == pytest.approx(len(run.frames) / seconds.sum())
    table = motes.analysis.Runs([run]).table
    assert table["wall_s"].iloc[0] == pytest.approx(seconds.sum())
    assert run.explain().frame_s == pytest.approx(seconds.iloc[1:].mean())
    view = View(run.path, run.facts)
    view.read()
    assert view.fps == pytest.approx(len(run.frames) / seconds.sum(), rel=0.1)
    starts = timeline.frame_starts(run)
    assert max(end for _, end in starts.values()) == pytest.approx(seconds.sum())


@pytest.mark.parametrize(("size", "ranks"), [(1, "0"), (2, "0,1"), (3, "0,2"), (5, "4,0,2")])
def test_seconds_of_frames_add_up_to_the_run(size, ranks, tmp_path):
    (tmp_path / "frames").write_text("24")
    done = on_ranks(size, SCENE, tmp_path / "frames", ranks, tmp_path / "log")
    assert done.code == 0, done.text
    clocks = [list(map(float, line.split())) for line in done.out.splitlines()]
    took = max(end for _, _, end in clocks) - max(start for _, start, _ in clocks)
    check(motes.open_run(tmp_path / "log"), took)


def test_each_part_of_a_continued_run_adds_up(tmp_path):
    log = tmp_path / "log"
    for size, frames in ((2, 9), (3, 20)):
        (tmp_path / "frames").write_text(str(frames))  # not an argument: the same command continues
        done = on_ranks(size, SCENE, tmp_path / "frames", "0,1", log, "saves")
        assert done.code == 0, done.text
    run = motes.open_run(log)
    assert list(run.frames["frame"]) == list(range(20))
    assert [part["frame"] for part in run.stretches] == [0, 9]
    for part in run.parts():
        walls = part.times.pivot(index="frame", columns="rank", values="wall_s")
        assert part.frames["t_frame_s"].sum() == pytest.approx(walls.sum().max(), rel=0.01)
    saving = run.times.groupby("frame")["checkpoint_s"].max()
    assert saving[[7, 14]].min() > 10 * saving[[3, 4, 5, 11]].max(), (
        "time on checkpoints has a name of its own"
    )
    assert (run.times.set_index("frame").loc[4, "script_idle_s"] >= 0.0).all()
    replayed = run.replay(motes.balance.PrefixCuts())
    assert list(replayed.frames["frame"]) == list(range(9)), "a replay ends where other ranks go on"
    assert replayed.calculators == run.parts()[0].calculators
    if len(run.explain().losses):
        assert "(frames " in run.explain().sentences[0]


LOSING = """
import os, sys, time
import motes
import motes.analysis.runs

world = motes.World(seed=1, space=(-1, 1), progress="off", log=sys.argv[1], on_loss="recover", roles="shared")
s = world.system("s")
with world:
    for frame in world.frames(30):
        s.source(motes.shapes.Box((-1, 0, 0), (1, 1, 1)), 24_000)
        s.kill_old(0.4)
        s.move()
        time.sleep(0.01)
        if frame == 19 and world.rank == int(sys.argv[2]) and world.size == 4:
            os.kill(os.getpid(), 9)
        world.step()
        if frame == 0:
            start = time.time()
    if "manager" in world.role:
        print(time.time() - start)
"""


@pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))
@pytest.mark.parametrize("lost", [1, 0])
def test_a_loss_of_ranks_is_counted_once_and_named(lost, tmp_path):
    (tmp_path / "scene.py").write_text(LOSING)
    words = [sys.executable, "-m", "motes", "run", "-n", 4, "--survive", tmp_path / "scene.py"]
    done = command([*words, tmp_path / "log", lost], timeout=90)
    assert done.code == 0, done.text
    run = motes.open_run(tmp_path / "log")
    assert list(run.frames["frame"]) == list(range(30))
    seconds = run.frames.set_index("frame")["t_frame_s"]
    assert seconds.iloc[1:].sum() == pytest.approx(float(done.out.split()[-1]), rel=0.05)
    lost_s = run.times.groupby("frame")["recovery_s"].max()
    assert lost_s[12] > 7 * 0.01, "the time of frames 12 to 18, which ran again"
    assert lost_s.drop(12).max() == 0
    walls = run.times.pivot(index="frame", columns="rank", values="wall_s").max(axis=1)
    chain = run.times.groupby("frame")["chain_s"].max()
    assert chain.is_monotonic_increasing
    assert chain.diff()[12] <= walls[12] - lost_s[12] + 0.01, "without the chains of the lost frames"
    assert chain.iloc[-1] <= seconds.sum() - lost_s[12] + 0.01
    table = run.efficiencies()
    assert table.loc["all", "transfer"] <= table["transfer"].drop("all").max()
    (told,) = [loss for loss in run.explain().losses if loss.cause == "recovery"]
    assert told.seconds == pytest.approx(lost_s[12] / 30)
    assert told.sentence.startswith("Recovery: a loss of ranks cost ")


# --- made by hand


def on_fewer_ranks(folder, *, chain_goes_on=False, imbalance=1.0, flight=0.0):
    """Write a run of 20 frames on four ranks and 20 on one; rank 3 has `imbalance` times the others' work."""
    load, times = [], []
    for frame in range(40):
        ranks, each = (range(4), 0.1) if frame < 20 else (range(1), 0.4)
        for rank in ranks:
            work = each * (imbalance if rank == 3 else 1)
            wait = each * imbalance - work if frame < 20 else flight
            n = round(1000 * work / each) if frame < 20 else 4000
            load.append(load_row(frame, "s", rank, n_start=n, n_end=n, t_compute_s=work))
            length = each * imbalance * (frame + 1) if frame < 20 else each * (frame - 19)
            if chain_goes_on and frame >= 20:
                length += 2 * imbalance + 7.0  # with the chains of frames that were lost
            times.append(time_row(frame, rank, chain_s=length, act=work, wait=wait))
    facts = {"calculators": [0, 1, 2, 3], "manager": 0, "image_generator": 0}
    part = {"frame": 20, "calculators": [0], "manager": 0, "ranks": [{"rank": 0, "host": "h"}]}
    log = write_log(folder, load, facts={**facts, "continued": [part]})
    frames = [json.loads(line) for line in (log / "frames.jsonl").read_text().splitlines()]
    rows(
        log / "frames.jsonl",
        [row | {"t_frame_s": 0.1 * imbalance if i < 20 else 0.4 + flight} for i, row in enumerate(frames)],
    )
    rows(log / "times.jsonl", times, pad=512)
    return motes.open_run(log)


@pytest.mark.parametrize("chain_goes_on", [False, True])
def test_ranks_that_were_not_there_were_not_idle(chain_goes_on, tmp_path):
    run = on_fewer_ranks(tmp_path / "log", chain_goes_on=chain_goes_on)
    table = run.efficiencies()
    assert table.min(axis=None) == pytest.approx(1.0), "both parts are balanced and nobody waits"
    assert run.explain().saving == 0 and run.explain().losses == ()
    assert run.summary()["balance_would_save"] == 0
    assert set(run.imbalance()) == {1.0}


@pytest.mark.parametrize("chain_goes_on", [False, True])
def test_chains_of_lost_frames_are_not_the_runs(chain_goes_on, tmp_path):
    run = on_fewer_ranks(tmp_path / "log", chain_goes_on=chain_goes_on, flight=0.1)
    # Four ranks for 2 s without messages, one rank for 10 s, of which messages take 2 s.
    assert run.efficiencies().loc["all", "transfer"] == pytest.approx((4 * 2 + 8) / (4 * 2 + 10), abs=0.01)


def test_the_whole_run_combines_its_parts(tmp_path):
    run = on_fewer_ranks(tmp_path / "log", imbalance=2.0)
    table = run.efficiencies()
    assert table.loc[3].tolist() == pytest.approx([0.625, 0.625, 1, 1, 1])
    # Four ranks for 4 s worked 5/8 of them, one rank for 8 s all of them.
    assert table.loc["all", "parallel"] == pytest.approx((16 * 0.625 + 8) / 24)
    told = run.explain()
    assert told.frame_s == pytest.approx(0.3)
    assert told.saving == pytest.approx(20 * 0.075 / 12)
    (only,) = told.losses
    assert only.seconds == pytest.approx(20 * 0.075 / 40) and only.rank == 3
    assert only.sentence.startswith("Imbalance: rank 3 holds 1.6 times")
    assert only.sentence.endswith("(frames 0 to 19).")
    assert [len(part.frames) for part in run.parts()] == [20, 20]
    assert all(a <= b for a, b in pairwise(table["parallel"].drop("all")))
