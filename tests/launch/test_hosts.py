"""Runs on three hosts, simulated by network namespaces of this machine; one host is slow, one gets lost."""

from __future__ import annotations

import json
import os
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest
from hosts import Hosts, missing, three_hosts
from launching import Result, command, mpirun, python

import motes

EVERYTHING = Path(__file__).parents[1] / "scenes" / "everything.py"
VARIANTS = json.dumps([{"roles": "auto", "space": None}, {"roles": "shared", "space": [-3, 3]}])
LACK = missing()
pytestmark = pytest.mark.skipif(
    bool(LACK) and os.environ.get("MOTES_TEST_HOSTS") != "required", reason=LACK or "nothing lacks"
)

SCENE = """
import sys
import motes
from motes import balance, shapes

roles = motes.Roles(manager=0, image_generator=0, calculators=[1, 2])
policy = eval(sys.argv[1])
world = motes.World(seed=1, space=(-1, 1), roles=roles, balancer=policy, clock="wall", log=sys.argv[2])
snow = world.system("snow")
with world:
    for frame in world.frames(int(sys.argv[3])):
        if frame == 0:
            snow.burst(shapes.Box((-1, -1, -1), (1, 1, 1)), count=int(sys.argv[4]))
        for _ in range(int(sys.argv[5])):
            snow.curl_noise(0.1, 0.5)
        snow.move()
        world.step()
    digest = world.digest()
    if world.rank == 0:
        print(digest)
"""


@pytest.fixture(scope="module")
def hosts(tmp_path_factory):
    with three_hosts(tmp_path_factory.mktemp("hosts")) as up:
        yield up


def run(
    hosts: Hosts, wish: str, script: Path, *arguments: object, survive: bool = False, watch: Any = None
) -> Result:
    """Start `motes run` on the first host; `wish` has the form a:2,b:2,c."""
    at = dict(zip("abc", hosts.names, strict=True))
    where = ",".join(at[name[0]] + name[1:] for name in wish.split(","))
    ranks = sum(int(name[2:] or 1) for name in wish.split(","))
    argv = [sys.executable, "-m", "motes", "run", "-n", ranks, "--hosts", where]
    argv += [*["--survive"] * survive, "--", *hosts.options()]
    line = shlex.join(str(word) for word in (*argv, script, *arguments))  # as a shell gets it from ssh
    return command([hosts.agent, hosts.names[0], line], timeout=120, watch=watch)


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.py"
    path.write_text(SCENE)
    return path


def held(log: Path, *, since: int) -> list[int]:
    """Return the particles of each calculator, summed over the frames from `since` on."""
    rows = [json.loads(line) for line in (log / "load.jsonl").read_text().splitlines()]
    return [sum(row["n_end"] for row in rows if row["rank"] == c and row["frame"] >= since) for c in (1, 2)]


def test_everything_is_the_same_on_three_hosts(hosts):
    wanted = python(EVERYTHING, VARIANTS).lines
    assert sorted(run(hosts, "a:2,b:2,c", EVERYTHING, VARIANTS).lines) == sorted(wanted)
    assert sorted(run(hosts, "c,a,b", EVERYTHING, VARIANTS).lines) == sorted(wanted)


@pytest.mark.slow  # the share of a host with a quota depends on measured seconds
def test_the_log_names_the_hosts_and_a_slow_one_gets_less_work(hosts, scene, tmp_path):
    a, b, c = hosts.names
    if not hosts.limit(c):
        pytest.skip("no control group here that limits the share of a core")
    rows = tmp_path / "log" / "frames.jsonl"

    def brake(_: int) -> None:
        if rows.exists() and rows.stat().st_size:
            hosts.slow_down(c, 0.1)

    script = (scene, "balance.PrefixCuts()", tmp_path / "log", 32, 300_000, 4)
    lines = run(hosts, "a,b,c", *script, watch=brake).lines
    facts = json.loads((tmp_path / "log" / "run.json").read_text())
    assert [rank["host"] for rank in facts["ranks"]] == [a, b, c]
    quick, slow = held(tmp_path / "log", since=16)
    assert quick > slow > 0, "a tenth of a core, by wall clock: how much is up to the bursts of its quota"
    assert lines[-1] == mpirun(3, scene, "None", tmp_path / "one", 32, 300_000, 4).lines[-1]


@pytest.mark.slow  # a quota again
def test_doctor_gives_a_slow_host_a_small_power(hosts):
    a, b, c = hosts.names
    if not hosts.limit(b):
        pytest.skip("no control group here that limits the share of a core")
    hosts.slow_down(b, 0.2)
    line = shlex.join([sys.executable, "-m", "motes", "doctor", "--json", "--hosts", f"{b},{c}"])
    try:
        env = {"PRTE_MCA_plm_ssh_agent": str(hosts.agent), "MOTES_THREADS": "1"}
        told = json.loads(command([hosts.agent, a, line], timeout=180, env=env).lines[-1])
    finally:
        hosts.slow_down(b, 1)
    slow, quick = (row["particles_per_s"] for row in told["hosts"])
    assert [row["host"] for row in told["hosts"]] == [b, c]
    assert slow < quick / 2
    assert told["powers"]["shared"] == [1.0, pytest.approx(quick / slow, abs=0.01)]


def test_a_lost_host_ends_the_run(hosts, scene, tmp_path):
    rows = tmp_path / "log" / "frames.jsonl"
    lost: list[None] = []

    def pull(_: int) -> None:
        if not lost and rows.exists() and rows.stat().st_size:
            lost.append(hosts.lose(hosts.names[2]))

    ended = run(hosts, "a,b,c", scene, "None", tmp_path / "log", 100_000, 1000, 1, watch=pull)
    assert lost
    # A rank notices and ends the job, or Open MPI 5 ends the other ranks and returns 0 (test_launch.py).
    assert ended.code != 0, ended.text
    assert not motes.open_run(tmp_path / "log").finished


@pytest.mark.parametrize("survive", [False, True])
def test_a_rank_of_another_host_that_ends_before_mpi_ends_the_job(hosts, tmp_path, survive):
    script = tmp_path / "script.py"
    script.write_text(
        "import os, sys\n"
        "if os.environ['OMPI_COMM_WORLD_RANK'] == '2': sys.exit(0)\n"
        "import motes\n"
        "with motes.World(seed=1, progress='off') as world: world.step()\n"
    )
    ended = run(hosts, "a,b,c", script, survive=survive)
    assert ended.code == 1, ended.text
    assert "rank 2 ended before MPI had started" in ended.err.splitlines()[-1], ended.text


KILLED = """
import sys
from motes._launch import starting, supervisor
from motes._mpi import presence
presence._ABSENT_S = 5.0
killed = 'if [ "$OMPI_COMM_WORLD_RANK" = 2 ]; then kill -9 $$; fi; exec "$@"'
step = "import motes\\nwith motes.World(seed=1, progress='off') as world: world.step()"
rank = presence.started_by([sys.executable, "-c", step], is_rank=True)
argv = ["/bin/sh", "-c", killed, "sh", *rank]
argv = starting.command(3, argv, hosts=sys.argv[1], options=sys.argv[2:], survive=True)
raise SystemExit(supervisor.supervise(argv, presence.LAUNCHER_TELLS, 3).code)
"""


def test_a_rank_of_another_host_that_is_killed_before_it_has_a_watcher_ends_the_job(hosts):
    line = shlex.join([sys.executable, "-c", KILLED, ",".join(hosts.names), *hosts.options()])
    ended = command([hosts.agent, hosts.names[0], line], timeout=60)
    how = (
        "ended before MPI had started, on a signal",
        "did not start within 5 s",
    )  # mpirun may not learn of it
    told = [f"motes run: exit code 1: rank 2 {each}; the others would wait forever" for each in how]
    assert ended.code == 1 and ended.err.splitlines()[-1] in told, ended.text
