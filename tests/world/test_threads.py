"""Threads of a rank: their number, the log's columns, their cost. For their bits see test_same_bits.py."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest
from launching import python
from standing import on_ranks

import motes
from motes._run.threads import MASK_BYTES, Place, processors, threads_of
from motes.errors import ArgumentError

SCENE = """
import sys
import motes
from motes import shapes

world = motes.World(seed=1, roles="shared", space=(-1, 1), log=sys.argv[1] or None, progress="off")
snow = world.system("snow")
with world:
    for frame in world.frames(2):
        snow.burst(shapes.Box((-1, -1, -1), (1, 1, 1)), count=1000)
        snow.move()
        world.step()
"""


def place(numbers: list[int], host: str = "a", wish: int = 0) -> Place:
    """Describe a rank that may use these processors."""
    return Place(host, sum(1 << n for n in numbers).to_bytes(MASK_BYTES, "little"), wish)


@pytest.mark.parametrize(
    ("places", "threads"),
    [
        ([place([0, 1, 2, 3])], [4]),
        ([place([0, 1, 2, 3])] * 2, [2, 2]),
        ([place([0, 1, 2, 3])] * 3, [1, 1, 1]),
        ([place([0, 1])] * 4, [1, 1, 1, 1]),
        ([place([0]), place([1])], [1, 1]),  # each bound to its own
        ([place([0, 1, 2, 3]), place([4, 5])], [4, 2]),
        ([place([0, 1, 2, 3]), place([2, 3])], [3, 1]),
        ([place([0, 1]), place([0, 1], host="b")], [2, 2]),
        ([place([0, 1], wish=7), place([0, 1, 2, 3])], [7, 3]),
        ([place([0, 1, 2, 3])._replace(most=2), place([0, 1, 2, 3])], [2, 2]),
        ([place([0, 1, 2, 3])._replace(most=3)] * 2, [2, 2]),
        ([place([0, 1, 2, 3], wish=4)._replace(most=2)], [4]),
        ([place([])], [1]),
        ([place(list(range(1000)))], [1000]),
    ],
)
def test_ranks_of_a_host_share_its_processors(places: list[Place], threads: list[int]):
    assert threads_of(places) == threads


def test_a_quota_counts_as_so_many_processors(tmp_path: Path):
    usable = len(os.sched_getaffinity(0))
    group = tmp_path / "cpu.max"
    assert threads_of([Place("a", processors(group), 0)]) == [usable], "no such file"
    for text, most in (
        ("max 100000", usable),
        ("100000 100000", 1),
        ("150000 100000", 2),
        ("1000 100000", 1),
    ):
        group.write_text(text + "\n")
        assert threads_of([Place("a", processors(group), 0)]) == [min(most, usable)]


@pytest.mark.parametrize(("told", "threads"), [("1", 1), ("", 2), ("1(x2)", 2), ("0", 1)])
def test_no_more_threads_than_slurm_gives_a_task(told: str, threads: int, tmp_path: Path):
    log = tmp_path / "log"
    ended = python(SCENE, log, env={"SLURM_CPUS_PER_TASK": told, "MOTES_THREADS": ""})
    assert ended.code == 0, ended.text
    (row,) = json.loads((log / "run.json").read_text())["ranks"]
    assert row["threads"] == min(threads, len(os.sched_getaffinity(0)))


@pytest.mark.parametrize("wrong", [0, -1, 1025, 1.5, "two", True])
def test_wrong_numbers_of_threads(wrong: object):
    with pytest.raises(ArgumentError, match="threads must be"):
        motes.World(threads=wrong)


@pytest.mark.parametrize("wrong", ["0", "1025", "2.5", "two"])
def test_wrong_environment(monkeypatch: pytest.MonkeyPatch, wrong: str):
    monkeypatch.setenv("MOTES_THREADS", wrong)
    with pytest.raises(ArgumentError, match="MOTES_THREADS must be an integer 1..1024"):
        motes.World()


def test_the_environment_takes_precedence(monkeypatch: pytest.MonkeyPatch):
    assert motes.World(threads=3).threads == 3
    assert motes.World().threads is None
    monkeypatch.setenv("MOTES_THREADS", "5")
    assert motes.World(threads=3).threads == 5


def test_the_log_says_the_threads_of_each_rank(tmp_path: Path):
    log = tmp_path / "log"
    assert on_ranks(2, SCENE, log, env={"MOTES_THREADS": "3"}).code == 0
    rows = json.loads((log / "run.json").read_text())["ranks"]
    assert [row["threads"] for row in rows] == [3, 3]


def test_more_ranks_than_processors_have_a_thread_each(tmp_path: Path):
    log = tmp_path / "log"
    size = len(os.sched_getaffinity(0)) + 1
    assert on_ranks(min(size, 5), SCENE, log, env={"MOTES_THREADS": ""}).code == 0
    rows = json.loads((log / "run.json").read_text())["ranks"]
    assert all(row["threads"] == 1 for row in rows) or size > 5


REFUSED = """
import os
import resource
import motes
from motes import shapes

def threads():
    return len(os.listdir("/proc/self/task"))

world = motes.World(seed=1, threads=1000, progress="off")
snow = world.system("snow")
try:
    with world:
        snow.burst(shapes.Box((-1, -1, -1), (1, 1, 1)), count=100_000)
        snow.move()
        before = threads()
        used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (used + (200 << 20), most))  # room for some 25 stacks of 8 MB
        world.step()
except motes.MotesError as error:
    print(threads() - before)
    print(error)
"""


def test_threads_that_the_system_refuses_are_told():
    left, text = python(REFUSED).lines
    found = re.search(r"only (\d+) of 1000 threads could be started \(.+\); (.+)", text)
    assert found and 1 < int(found[1]) < 1000, text
    assert found[2] == "set fewer with World(threads=) or MOTES_THREADS"
    assert left == "0", "no thread is left running"


IDLE = """
import time
import motes
from motes import shapes

world = motes.World(seed=1, threads=4, progress="off")
snow = world.system("snow")
with world:
    for frame in world.frames(3):
        snow.burst(shapes.Box((-1, -1, -1), (1, 1, 1)), count=200_000)
        snow.gravity((0, -9.8, 0))
        snow.move()
        world.step()
    time.sleep(0.1)
    before = time.process_time()
    time.sleep(1)
    print(time.process_time() - before)
"""


def test_an_idle_world_uses_no_processor_time():
    assert float(python(IDLE).lines[0]) < 0.05


FAILING = """
import motes
from motes import shapes

world = motes.World(seed=1, threads=3, roles="shared", space=(-1, 1), progress="off")
snow = world.system("snow")

def stop(p):
    raise ValueError("no more")

with world:
    for frame in world.frames(3):
        snow.burst(shapes.Box((-1, -1, -1), (1, 1, 1)), count=100_000)
        snow.move()
        if frame == 1:
            snow.callback(stop)
        world.step()
"""


@pytest.mark.parametrize("size", [1, 3])
def test_a_callback_that_raises_ends_the_job(size: int):
    ended = on_ranks(size, FAILING)
    assert ended.code != 0 and "no more" in ended.err, ended.text


def test_an_interrupt_reaches_the_script(tmp_path: Path):
    # Send the signal once, although each thread calls this: a second one would end the run at once.
    script = FAILING.replace(
        'raise ValueError("no more")',
        "import os, signal; stop.__dict__ or os.kill(os.getpid(), signal.SIGINT); stop.sent = 1",
    )
    ended = python(script)
    assert ended.code == 130, ended.text
    assert "stopped by SIGINT after frame 2 of 3" in ended.err, ended.text


UNEQUAL = """
import sys
from mpi4py import MPI
import motes
from motes import balance, shapes

threads = 1 + MPI.COMM_WORLD.rank
world = motes.World(
    seed=1, roles="shared", space=(-1, 1), threads=threads, balancer=balance.PrefixCuts(), log=sys.argv[1],
    progress="off",
)
snow = world.system("snow")
with world:
    for frame in world.frames(12):
        if frame == 0:
            snow.burst(shapes.Box((-1, -1, -1), (1, 1, 1)), count=400_000)
        for _ in range(8):
            snow.random_acceleration(shapes.Sphere((0, 0, 0), 1e-6))
        snow.move()
        world.step()
"""


@pytest.mark.slow
def test_ranks_with_other_numbers_of_threads_have_their_share(tmp_path: Path):
    log = tmp_path / "log"
    assert on_ranks(2, UNEQUAL, log).code == 0
    last = [json.loads(line) for line in (log / "load.jsonl").read_text().splitlines()][-2:]
    first, second = sorted(last, key=lambda row: row["rank"])
    speeds, particles = second["speed"] / first["speed"], second["n_end"] / first["n_end"]
    assert speeds > 1.5, "two threads, if there is a processor for each"
    assert abs(particles / speeds - 1) < 0.1
