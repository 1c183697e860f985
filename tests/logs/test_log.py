"""The run's log: its columns, its sums, and what remains of it when a run is killed."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path
from typing import Any

import pytest
from launching import mpirun
from standing import on_ranks

pandas = pytest.importorskip("pandas")

SCENE = """
import sys
import motes
from motes import shapes

world = motes.World(
    seed=3, space=(-1, 1), log=sys.argv[1], digest=True, progress="off", roles=sys.argv[2],
    renderer=motes.Renderer(64, 48, camera=motes.Camera((0, 1, 8), (0, 1, 0))),
)
systems = [world.system("snow"), world.system("rain", axis="y", capacity=300)]
endless = len(sys.argv) > 3
with world:
    for frame in world.frames(10**9 if endless else 12):
        for s in systems:
            s.configure(velocity=motes.Normal((0, 0, 0), (3, 3, 3)), lifetime=motes.Uniform(0.1, 0.4))
            s.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=2400)
            s.move()
            s.kill_expired()
        if frame == 5:
            world.digest()
            with systems[0].local() as p:
                p.position[:, 0] += 0.5
        if frame % 4 == 3:
            world.step()
        else:
            world.render()
        digest = world.digest()
        if not endless:
            count = systems[0].count + systems[1].count
            world.say(f"{frame} {digest} {count} {sum(s.dropped for s in systems)}")
"""

LOAD = {
    *(
        "frame",
        "system",
        "rank",
        "host",
        "n_start",
        "n_end",
        "created",
        "killed",
        "sent",
        "received",
        "bytes_sent",
    ),
    *(
        "t_compute_s",
        "t_rescaled_s",
        "t_exchange_s",
        "t_wait_s",
        "t_image_s",
        "domain_lo",
        "domain_hi",
        "speed",
    ),
}
FRAMES = {
    *("frame", "time", "particles", "exchanged", "exchanged_bytes", "imbalance", "t_frame_s", "image_sha256"),
    *("particles_digest", "t_create_s", "t_act_s", "t_report_s", "t_exchange_s", "t_balance_s", "t_render_s"),
    *("t_project_s", "t_draw_s", "t_assemble_s", "render_path", "records", "render_bytes"),
}


def rows_of(path: Path) -> list[dict[str, Any]]:
    """Read a table; check that every line is complete, padded, and within a page."""
    data = path.read_bytes()
    at = 0
    rows = []
    for line in data.splitlines(keepends=True):
        assert line.endswith(b"\n")
        assert len(line) % 256 == 0
        assert len(line) > 4096 or at // 4096 == (at + len(line) - 1) // 4096, "a line in one page"
        at += len(line)
        rows.append(json.loads(line))
    return rows


@pytest.fixture(scope="module", params=[(4, "auto"), (3, "shared")], ids=["auto", "shared"])
def run(request, tmp_path_factory):
    """Return the log of a run, the lines that the script printed, and the number of calculators."""
    size, roles = request.param
    log = tmp_path_factory.mktemp("run") / "log"
    said = [line.split() for line in on_ranks(size, SCENE, log, roles).lines]
    return log, said, 2 if roles == "auto" else 3


OF_PICTURES = {"image_sha256", "render_path", "records", "render_bytes"}
OF_PICTURES |= {"t_project_s", "t_draw_s", "t_assemble_s"}


def test_columns(run):
    log, _, _ = run
    for name, wanted in (("load", LOAD), ("frames", FRAMES)):
        for row in rows_of(log / f"{name}.jsonl"):
            missing = wanted - set(row) - OF_PICTURES
            assert not missing, f"{name}: {missing}"
            assert all(isinstance(value, (int, float, str, type(None))) for value in row.values()), (
                "flat scalars"
            )
    kinds = [row["kind"] for row in rows_of(log / "events.jsonl")]
    assert kinds[0] == "start"
    assert kinds[-1] == "end"


def test_sums(run):
    log, said, calculators = run
    load, frames = rows_of(log / "load.jsonl"), rows_of(log / "frames.jsonl")
    assert [row["frame"] for row in frames] == list(range(12))
    assert len(load) == 12 * 2 * calculators
    held: dict[tuple[str, int], int] = {}
    for row in load:
        assert (
            row["n_end"] == row["n_start"] + row["created"] - row["killed"] - row["sent"] + row["received"]
        ), row
        place = row["system"], row["rank"]
        assert row["n_start"] == held.get(place, 0), row
        held[place] = row["n_end"]
        assert (row["bytes_sent"] > 0) == (row["sent"] > 0), row
        assert row["t_compute_s"] >= 0
        assert row["host"]
    exchanged = 0
    for row, (frame, digest, count, dropped) in zip(frames, said, strict=True):
        mine = [one for one in load if one["frame"] == row["frame"]]
        assert row["frame"] == int(frame)
        assert row["particles"] == sum(one["n_end"] for one in mine) == int(count)
        assert row["exchanged"] == sum(one["sent"] for one in mine) == sum(one["received"] for one in mine)
        assert row["exchanged_bytes"] == sum(one["bytes_sent"] for one in mine)
        assert row["particles_digest"] == digest
        assert row["dropped"] == int(dropped)
        assert row["imbalance"] >= 1
        assert row["time"] == pytest.approx((row["frame"] + 1) / 24)
        assert ("image_sha256" in row) == (row["frame"] % 4 != 3), "pictures where frames were rendered"
        exchanged += row["exchanged"]
    assert exchanged > 100
    assert int(said[-1][3]) > 0, "the capacity was reached"


def test_domains(run):
    log, _, calculators = run
    first = [row for row in rows_of(log / "load.jsonl") if row["frame"] == 0 and row["system"] == "snow"]
    assert first[0]["domain_lo"] is None
    assert first[-1]["domain_hi"] is None
    cuts = [row["domain_hi"] for row in first[:-1]]
    assert cuts == pytest.approx([-1 + 2 * (i + 1) / calculators for i in range(calculators - 1)])
    assert [row["domain_lo"] for row in first[1:]] == cuts


def test_pandas_reads_it(run):
    log, _, calculators = run
    load = pandas.read_json(log / "load.jsonl", lines=True)
    assert len(load) == 24 * calculators
    assert set(load.columns) >= LOAD
    assert load.n_end.dtype.kind == "i"
    frames = pandas.read_json(log / "frames.jsonl", lines=True)
    assert (load.groupby("frame").n_end.sum().to_numpy() == frames.particles.to_numpy()).all()


def test_the_run_itself(run):
    log, _, calculators = run
    facts = json.loads((log / "run.json").read_text())
    assert facts["seed"] == 3
    assert facts["systems"] == ["snow", "rain"]
    assert facts["axes"] == ["x", "y"]
    assert len(facts["calculators"]) == calculators
    assert len(facts["ranks"]) == (4 if calculators == 2 else 3)
    assert "world.frames" in facts["script"], "the script is kept"
    assert {"mpi", "simd", "python", "dt_s", "argv", "motes", "started_unix_s"} <= set(facts)


def test_a_killed_run_leaves_whole_rows(tmp_path):
    log = tmp_path / "log"

    def kill(launcher: int) -> None:
        table = log / "frames.jsonl"
        if not killed and table.exists() and table.stat().st_size > 20_000:
            killed.append(launcher)
            os.kill(launcher, signal.SIGKILL)

    killed: list[int] = []
    result = mpirun(3, SCENE, log, "auto", "endless", timeout=30, watch=kill)
    assert killed, result.text
    frames = rows_of(log / "frames.jsonl")
    assert len(frames) >= 20
    assert [row["frame"] for row in frames] == list(range(len(frames)))
    assert len(rows_of(log / "load.jsonl")) >= 2 * (len(frames) - 1)
    assert json.loads((log / "run.json").read_text())["seed"] == 3
