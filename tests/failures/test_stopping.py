"""SIGINT, SIGTERM and SIGUSR1 stop a run at the end of its frame, the same frame on all ranks. Real jobs."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from launching import Result, command, mpirun, python, said

from motes._launch import starting

av = pytest.importorskip("av")

SCENE = Path(__file__).parents[1] / "scenes" / "stoppable.py"
LIMIT_S = 50
PATIENT = {"MOTES_STALL_S": "600"}
INT, TERM, USR1 = signal.SIGINT, signal.SIGTERM, signal.SIGUSR1
CODES = {INT: 130, TERM: 143, USR1: 143}


def job_of(launcher: int) -> list[int]:
    """Return the ids of a process and all its descendants, which a scheduler signals to end a job."""
    children = Path(f"/proc/{launcher}/task/{launcher}/children").read_text().split()
    return [launcher, *(pid for child in children for pid in job_of(int(child)))]


class Sender:
    """Signals "run" (the launcher), "all" ranks, the whole "job" or a rank when `ranks` are ready."""

    def __init__(self, folder: Path, to: object, numbers: list[int], *, ranks: int, every_s: float = 1.2):
        self.folder, self.to, self.numbers, self.ranks = folder, to, numbers, ranks
        self.every_s, self.sent, self.at = every_s, 0, 0.0

    def __call__(self, launcher: int) -> None:
        files = sorted(self.folder.glob("*.pid"))
        if len(files) < self.ranks or self.sent == len(self.numbers) or time.monotonic() < self.at:
            return
        if self.sent == 0 and self.at == 0:  # let the ranks reach the point where they wait
            self.at = time.monotonic() + 0.2
            return
        pids = {int(file.stem): int(file.read_text()) for file in files}
        several = {"run": [launcher], "all": pids.values(), "job": job_of(launcher)}
        targets = several[self.to] if isinstance(self.to, str) else [pids[self.to]]
        for pid in targets:
            os.kill(pid, self.numbers[self.sent])
        self.sent += 1
        self.at = time.monotonic() + self.every_s


def stopped_after(result: Result, folder: Path, ranks: int, number: int) -> int:
    """Check that the run stopped in an orderly way; return the number of frames."""
    assert result.code == CODES[number], result.text
    ends = sorted(line for line in result.out.splitlines() if "stopped after" in line)
    frames = int(ends[0].split()[-1])
    assert ends == sorted(f"rank {rank} stopped after frame {frames}" for rank in range(ranks)), result.text
    assert result.out.count("no second run") == ranks and not (folder / "second").exists()
    whole(result, folder, frames, number, total=" of 1000")
    return frames


def whole(result: Result, folder: Path, frames: int, number: int, total: str) -> None:
    """Check the closing line, the log and the film."""
    name = signal.Signals(number).name
    (line,) = said(result.err, "motes: stopped by ")
    assert line.startswith(f"{name} after frame {frames}{total}; "), result.text
    assert "*** motes" not in result.err and "Traceback" not in result.err, result.text
    rows = [json.loads(row)["frame"] for row in (folder / "log" / "frames.jsonl").read_text().splitlines()]
    assert rows == list(range(frames))
    assert json.loads((folder / "log" / "events.jsonl").read_text().splitlines()[-1])["kind"] == "end"
    with av.open(str(folder / "a.mp4")) as film:
        assert sum(1 for _ in film.decode(video=0)) == frames


@pytest.mark.parametrize(
    ("ranks", "to", "number"),
    [
        (1, "run", INT),
        pytest.param(1, "run", USR1, marks=pytest.mark.slow),
        pytest.param(2, "run", INT, marks=pytest.mark.slow),
        pytest.param(2, 1, TERM, marks=pytest.mark.slow),
        pytest.param(3, "run", TERM, marks=pytest.mark.slow),
        (3, "all", INT),
        pytest.param(3, 0, USR1, marks=pytest.mark.slow),
        pytest.param(5, "run", USR1, marks=pytest.mark.slow),
        pytest.param(5, 3, INT, marks=pytest.mark.slow),
        (5, "all", TERM),
    ],
)
def test_all_ranks_stop_after_the_same_frame(tmp_path, ranks, to, number):
    sender = Sender(tmp_path, to, [number], ranks=ranks)
    result = mpirun(ranks, SCENE, "loop", tmp_path, timeout=LIMIT_S, env=PATIENT, watch=sender)
    assert stopped_after(result, tmp_path, ranks, number) >= 3
    assert "mpirun's own messages" not in result.err, result.text


@pytest.mark.parametrize(
    ("kind", "ranks", "to", "most"),
    [
        ("first", 3, "run", 8),
        ("callback", 3, 2, 3),  # the current frame is the last
        # rank 0 has already reported on its frame
        pytest.param("wait", 3, 0, 4, marks=pytest.mark.slow),
        ("wait", 3, "job", 4),  # as `scancel` does; the frame takes longer than mpirun's grace period
        ("gather", 3, 0, 3),
        pytest.param("gather", 1, "run", 8, marks=pytest.mark.slow),
    ],
)
def test_a_signal_comes_at_any_moment(tmp_path, kind, ranks, to, most):
    noted = 1 if kind == "callback" else ranks
    sender = Sender(tmp_path, to, [TERM], ranks=noted)
    result = mpirun(ranks, SCENE, kind, tmp_path, timeout=LIMIT_S, env=PATIENT, watch=sender)
    assert 1 <= stopped_after(result, tmp_path, ranks, TERM) <= most, result.text


@pytest.mark.parametrize("ranks", [pytest.param(1, marks=pytest.mark.slow), 3])
def test_a_loop_of_ones_own_ends_by_system_exit(tmp_path, ranks):
    sender = Sender(tmp_path, "run", [INT], ranks=ranks)
    result = mpirun(ranks, SCENE, "own", tmp_path, timeout=LIMIT_S, env=PATIENT, watch=sender)
    assert (result.code, result.out) == (130, ""), result.text
    frames = int(said(result.err, "motes: stopped by SIGINT after frame ")[0].split(";")[0])
    whole(result, tmp_path, frames, INT, total="")


@pytest.mark.parametrize("ranks", [pytest.param(1, marks=pytest.mark.slow), 3])
@pytest.mark.parametrize("number", [INT, TERM], ids=["INT", "TERM"])
def test_a_second_signal_ends_at_once(tmp_path, ranks, number):
    sender = Sender(tmp_path, "run", [number, number], ranks=ranks)
    result = mpirun(ranks, SCENE, "long", tmp_path, timeout=LIMIT_S, env=PATIENT, watch=sender)
    assert result.code in (CODES[number], -number), result.text
    assert result.seconds < 25 and sender.sent == 2, "the frame takes 30 s"
    assert "stopped by" not in result.err, result.text
    assert "a second one ends it at once" in result.err, result.text


def test_a_signal_to_ranks_that_insist_ends_at_once(tmp_path):
    sender = Sender(tmp_path, 1, [USR1, TERM, TERM], ranks=3)
    result = mpirun(3, SCENE, "long", tmp_path, timeout=LIMIT_S, env=PATIENT, watch=sender)
    assert result.code == 143, result.text
    assert sender.sent == 3, "SIGTERM after the scheduler's warning is the first one"


def test_plain_mpirun_passes_sigusr1_on(tmp_path):
    argv = starting.command(3, [sys.executable, str(SCENE), "loop", str(tmp_path)])
    sender = Sender(tmp_path, "run", [USR1], ranks=3)
    result = command(argv, timeout=LIMIT_S, env=PATIENT, watch=sender)
    assert stopped_after(result, tmp_path, 3, USR1) >= 3


def test_plain_mpirun_leaves_ranks_half_a_second_after_sigterm(tmp_path):
    argv = starting.command(2, [sys.executable, str(SCENE), "loop", str(tmp_path)])
    result = command(argv, timeout=LIMIT_S, watch=Sender(tmp_path, "run", [TERM], ranks=2))
    assert result.code != 0, result.text
    assert "Traceback" not in result.err, result.text


HANDLERS = """
import os, signal, sys
import motes

seen = []
before = signal.getsignal(signal.SIGINT)
signal.signal(signal.SIGTERM, lambda number, frame: seen.append(number))
world = motes.World(seed=1, progress="off")
with world:
    for frame in world.frames(4):
        if frame == 1:
            os.kill(os.getpid(), signal.SIGTERM)
        world.step()
assert (seen, world.frame) == ([signal.SIGTERM], 4)
assert signal.getsignal(signal.SIGINT) is before
try:
    os.kill(os.getpid(), signal.SIGINT)
    sys.exit("SIGINT was noted behind the run")
except KeyboardInterrupt:
    print("as ever")
"""


def test_handlers_of_the_script_stay_and_signals_are_pythons_afterwards():
    assert python(HANDLERS, timeout=LIMIT_S).lines == ["as ever"]


FORKS = """
import os, signal, time
import motes

world = motes.World(seed=1, progress="off")
with world:
    for frame in world.frames(3):
        child = os.fork()
        if child == 0:
            time.sleep(30)
            os._exit(0)
        os.kill(child, signal.SIGTERM)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
        world.step()
"""


def test_children_of_the_script_end_as_ever():
    assert python(FORKS, timeout=LIMIT_S).lines == ["-15"] * 3


LAST = """
import os, signal, sys
import motes

world = motes.World(seed=1, progress="off")
with world:
    for frame in world.frames(3):
        if frame == 2:
            os.kill(os.getpid(), signal.SIGINT)
        world.step()
sys.exit(int(sys.argv[1]))
"""


def test_a_run_that_was_done_anyway_is_not_stopped_and_other_codes_stay():
    result = python(LAST, 0, timeout=LIMIT_S)
    assert result.code == 0 and "stopped by" not in result.err, result.text
    again = LAST.replace("frame == 2", "frame == 1")
    assert [python(again, code, timeout=LIMIT_S).code for code in (0, 3)] == [130, 3]


PROMPT = """
import os, signal, sys
import motes

sys.ps1 = "> "
world = motes.World(seed=1, progress="off")
world.open()
done = []
def cell():
    for frame in world.frames(6):
        done.append(frame)
        if frame in (1, 3):
            os.kill(os.getpid(), signal.SIGINT)
        world.step()
for _ in range(2):
    try:
        cell()
        sys.exit("not interrupted")
    except KeyboardInterrupt:
        print("interrupted after", done[-1])
cell()
print(done)
try:
    os.kill(os.getpid(), signal.SIGINT)
    sys.exit("not interrupted")
except KeyboardInterrupt:
    world.close()
"""


def test_at_a_prompt_an_interrupt_ends_the_cell_and_the_next_one_goes_on():
    result = python(PROMPT, timeout=LIMIT_S)
    assert result.lines == ["interrupted after 1", "interrupted after 3", "[0, 1, 2, 3, 4, 5]"], result.text


HOOK = """
import os, signal
import motes
from motes._world.world import running_of

def before_stopping():
    print(f"rank {world.rank} before {world.frame}: {world.digest()[:4]}", flush=True)

world = motes.World(seed=1, progress="off")
running_of(world).viewers.before_stopping = before_stopping
with world:
    for frame in world.frames(9):
        if frame == 4 and world.rank == world.size - 1:
            os.kill(os.getpid(), signal.SIGUSR1)
        world.step()
"""


def test_all_ranks_may_converse_before_they_stop():
    check: Callable[[str], bool] = lambda line: line[:-4].endswith("before 5: ")  # noqa: E731
    result = mpirun(3, HOOK, timeout=LIMIT_S, env=PATIENT)
    assert result.code == 143, result.text
    assert len(lines := result.out.splitlines()) == 3 and all(map(check, lines)), result.text
