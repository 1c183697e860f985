"""A job that is stopped and continued (Ctrl-Z, a laptop's lid) goes on, however long it was stopped."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from launching import mpirun

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
