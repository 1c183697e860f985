"""A job that is suspended and resumed (Ctrl-Z, a laptop's lid) continues, however long it was suspended.

So does a job with a single suspended or slow rank, because its process is alive.
"""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest
from launching import mpirun, said

STALL_S = 2.0
STOPPED_S = 2 * STALL_S
SCRIPT = """
import os, sys, time
from pathlib import Path
import motes

world = motes.World(progress="off", roles="shared")
system = world.system("only")

def slow(particles):
    if world.rank == 1:
        time.sleep(0.25)

with world:
    Path(sys.argv[1], f"{world.rank}.part").write_text(str(os.getpid()))
    Path(sys.argv[1], f"{world.rank}.part").rename(Path(sys.argv[1], f"{world.rank}.pid"))
    for frame in world.frames(8):
        system.burst(motes.shapes.Box((-10, 0, 0), (10, 1, 1)), count=100)
        system.callback(slow)
        system.move()
        world.step()
world.say("all frames")
"""


@pytest.mark.slow
def test_a_job_that_was_stopped_for_long_goes_on(tmp_path: Path):
    stops: list[float] = []

    def stop_and_continue(_: int) -> None:
        files = sorted(tmp_path.glob("*.pid"))
        if len(files) < 2 or stops:
            return
        time.sleep(0.4)  # rank 0 waits for rank 1, which sleeps
        processes = [int(file.read_text()) for file in files]
        for process in processes:
            os.kill(process, signal.SIGSTOP)
        stops.append(time.monotonic())
        time.sleep(STOPPED_S)
        for process in processes:
            os.kill(process, signal.SIGCONT)

    result = mpirun(
        2, SCRIPT, tmp_path, timeout=60, env={"MOTES_STALL_S": str(STALL_S)}, watch=stop_and_continue
    )
    assert stops
    assert result.lines == ["all frames"], result.text
    assert "waited" not in result.err, result.text


# Warnings come four times per second here instead of once per minute.
LONG = """
import os, sys, time
from pathlib import Path
from motes._run import waiting
import motes

waiting.WARN_S = 0.25
world = motes.World(progress="off", space=(-10, 10), births=sys.argv[2])
system = world.system("only")

def slow(particles):
    if world.frame == 2 and world.rank == world.size - 1 and not Path(sys.argv[1], "pid").exists():
        Path(sys.argv[1], "part").write_text(str(os.getpid()))
        Path(sys.argv[1], "part").rename(Path(sys.argv[1], "pid"))
        time.sleep(3.5)

with world:
    for frame in world.frames(4):
        system.burst(motes.shapes.Box((-10, 0, 0), (10, 1, 1)), count=100)
        system.callback(slow)
        system.move()
        world.step()
world.say("all frames")
"""


@pytest.mark.parametrize(
    ("ranks", "births"),
    [
        pytest.param(2, "manager", marks=pytest.mark.slow),
        (3, "calculators"),
        pytest.param(5, "manager", marks=pytest.mark.slow),
    ],
)
def test_a_rank_whose_process_lives_is_waited_for_forever(tmp_path: Path, ranks: int, births: str):
    # More than ten warning intervals, after which ranks stop waiting for an unknown process.
    result = mpirun(ranks, LONG, tmp_path, births, timeout=60)
    assert result.lines == ["all frames"], result.text
    told = said(result.err, f"for rank {ranks - 1} ")
    assert len(told) > 5, result.text
    pid = (tmp_path / "pid").read_text()
    assert all(f"its process {pid} is alive, so it keeps waiting" in line for line in told), result.text


def test_a_limit_that_was_set_counts_for_living_processes(tmp_path: Path):
    result = mpirun(3, LONG, tmp_path, "manager", timeout=60, env={"MOTES_STALL_S": "2"})
    assert result.code == 1, result.text
    (report,) = said(result.err, "*** motes: ")
    assert "waited 2 s for rank 2 (calculator 0)" in report, result.text
    assert "the limit was set by MOTES_STALL_S=2: increase it" in report, result.text


@pytest.mark.slow
def test_a_stopped_rank_is_waited_for_and_its_state_is_said(tmp_path: Path):
    stopped: list[float] = []

    def stop_for_a_while(_: int) -> None:
        if not (tmp_path / "pid").exists() or len(stopped) == 2:
            return
        pid = int((tmp_path / "pid").read_text())
        if not stopped:
            os.kill(pid, signal.SIGSTOP)
            stopped.append(time.monotonic())
        elif time.monotonic() > stopped[0] + 3:  # more than ten warnings
            os.kill(pid, signal.SIGCONT)
            stopped.append(time.monotonic())

    result = mpirun(3, LONG, tmp_path, "manager", timeout=60, watch=stop_for_a_while)
    assert result.lines == ["all frames"], result.text
    pid = (tmp_path / "pid").read_text()
    assert f"its process {pid} is stopped (`kill -CONT {pid}` resumes it), so it keeps waiting" in result.err


@pytest.mark.slow
def test_a_callback_of_more_than_a_minute_ends_nothing(tmp_path: Path):
    script = LONG.replace("waiting.WARN_S = 0.25", "").replace("sleep(3.5)", "sleep(80)")
    result = mpirun(3, script, tmp_path, "manager", timeout=120)
    assert result.lines == ["all frames"], result.text
    assert "waited 75 s for rank 2" in result.err
