"""A run killed with -9 at a random moment leaves a log that can be read up to its last complete row."""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import time

import pytest
from launching import mpirun

import motes

pandas = pytest.importorskip("pandas")

SCENE = """
import sys
import motes
from motes import shapes

options = {"log": sys.argv[1], "spans": True, "digest": True, "progress": "off"}
world = motes.World(seed=3, space=(-1, 1), roles="shared", **options)
systems = [world.system(f"s{i}") for i in range(4)]
with world:
    for frame in world.frames(20_000):
        for s in systems:
            s.configure(velocity=motes.Normal((0, 0, 0), (3, 3, 3)), lifetime=motes.Uniform(0.1, 0.4))
            s.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=240)
            s.kill_expired()
            s.move()
        world.step()
"""


class Killer:
    """Kills the process that writes the log, some time after the first row of a table."""

    def __init__(self, log, table, delay_s):
        self.log, self.rows, self.delay_s, self.at = log, log / table, delay_s, None

    def __call__(self, _):
        if self.at is None and self.rows.exists() and self.rows.stat().st_size:
            self.at = time.monotonic() + self.delay_s
        if self.at is not None and time.monotonic() >= self.at:
            with contextlib.suppress(ProcessLookupError):
                os.kill(json.loads((self.log / "run.json").read_text())["pid"], signal.SIGKILL)


def kill_and_read(log, table, delay_s):
    """Kill a run; return the number of frames in its log, all of them complete."""
    result = mpirun(2, SCENE, log, timeout=40, watch=Killer(log, table, delay_s))
    assert result.code != 0, "the run was killed"
    tables = sorted(log.glob("*.jsonl"))
    run = motes.open_run(log)
    assert not run.finished
    assert list(run.frames["frame"]) == list(range(len(run.frames)))
    load = run.load.groupby("frame").size()
    assert len(load) in (len(run.frames), len(run.frames) + 1)
    assert (load[load.index.isin(run.frames["frame"])][:-1] == 2 * 4).all()
    _ = run.balance, run.density, run.events, run.spans
    assert run.torn == []
    for table in tables:
        text = table.read_bytes()
        plain = pandas.read_json(table, lines=True) if text else []
        assert len(plain) == text.count(b"\n"), table.name
        assert not text or text.endswith(b"\n"), table.name
    assert "did not finish" in run.warnings()[0]
    return len(run.frames)


@pytest.mark.parametrize(
    "number", [*range(2), *(pytest.param(n, marks=pytest.mark.slow) for n in range(2, 50))]
)
def test_every_row_of_a_killed_run_is_read(tmp_path, number):
    delay_s = random.Random(number).uniform(0, 0.6)
    table = ("load.jsonl", "frames.jsonl")[number % 2]  # load.jsonl is written first
    assert kill_and_read(tmp_path / "log", table, delay_s) > 0 or table == "load.jsonl"
