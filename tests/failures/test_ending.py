"""A rank fails: one message, and the job ends by itself. Real jobs, each with a time limit.

MOTES_STALL_S exceeds a job's time limit: a job that ends in time ended because a rank noticed the failure.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from launching import command, said

from motes._launch import starting
from motes._run import ending, peers, speaking
from motes._run.peers import Peer, PeerWatch
from motes.errors import RankError

# The ranks `who` fail in the way `how` while the others wait for a message that never comes.
SCRIPT = """
import os, resource, sys, threading, time
from mpi4py import MPI
from motes._run import ending
from motes._world import handshake
from motes._run.peers import Peer, PeerWatch
from motes.errors import RankError

ending.install()
how, who = sys.argv[1], [int(rank) for rank in sys.argv[2].split(",")]
world = MPI.COMM_WORLD
rank = world.rank


def block():
    world.Recv(bytearray(1), source=MPI.ANY_SOURCE, tag=1)


def fail():
    if how == "exception":
        raise ValueError("the mistake")
    if how == "sys.exit":
        sys.exit(int(sys.argv[3]))
    if how == "interrupt":
        os.kill(os.getpid(), 2)
        time.sleep(5)
    if how == "thread":
        thread = threading.Thread(target=lambda: 1 / 0, name="worker")
        thread.start()
        block()
    if how == "kill":
        os.kill(os.getpid(), 9)
    if how == "no files":
        if sys.argv[3] == "socket":
            os.environ.pop("PMIX_SERVER_TMPDIR", None)
        resource.setrlimit(resource.RLIMIT_NOFILE, (200, 200))
        try:
            while True:
                os.open("/dev/null", 0)
        except OSError:
            raise ValueError("the mistake")
    if how == "agreed":
        raise RankError("the mistake", rank=2, role="calculator 0", frame=7, speaker=2)


if how == "early":  # the others need longer than this rank before they start
    if rank in who:
        sys.exit(0)
    time.sleep(float(sys.argv[3]))
state = handshake.begin(world)
state.role = "image generator" if rank == 0 else "manager" if rank == 1 else f"calculator {rank - 2}"
state.frame = 7
peers = world.allgather(Peer.here(rank=rank, role=state.role))
world.Barrier()
try:
    if rank in who:
        if how == "leave":
            sys.exit  # the script ends here without an error
        else:
            fail()
    elif how == "kill":
        watch = PeerWatch(peers, rank=rank)
        while True:
            lost = watch.check(time.monotonic())
            if lost is not None:
                ending.report_lost(lost, watch.peers[lost].role, state.frame)
            time.sleep(0.002)
    else:
        block()
except BaseException as error:
    if how in ("sys.exit", "agreed"):  # as World does when its block is left
        ending.stop_job(error, state)
    raise
"""

QUIET = """
import sys, time
from mpi4py import MPI
from motes._run import ending
from motes._world import handshake

how = sys.argv[1]
rank = MPI.COMM_WORLD.rank
if how == "some" and rank == 0:
    sys.exit(0)  # never installs
ending.install()
if how == "part":  # a run of three ranks; the fourth has left meanwhile, and is not missed
    part = MPI.COMM_WORLD.Split(int(rank == 0), rank)
    if rank == 0:
        sys.exit(0)
    time.sleep(0.8)
    handshake.close(handshake.begin(part), well=True)
if how == "late":
    handshake.close(handshake.begin(MPI.COMM_WORLD), well=True)
if how in ("late", "no run") and rank == 0:
    time.sleep(1.2)
"""


@dataclass
class Job:
    """How a job ended."""

    code: int
    text: str

    @property
    def reports(self) -> list[str]:
        """Return the first line of each report."""
        return said(self.text, "*** motes: ")


@pytest.fixture
def job(tmp_path: Path):
    """Run a script on 4 ranks."""

    def run(script: str, *arguments: str) -> Job:
        path = tmp_path / "script.py"
        path.write_text(script)
        argv = starting.command(4, [sys.executable, str(path), *arguments])
        answer = command(argv, timeout=60, env={"MOTES_STALL_S": "600"})
        return Job(answer.code, answer.out + answer.err)

    return run


ROLES = {"0": "rank 0 (image generator)", "2": "rank 2 (calculator 0)"}


@pytest.mark.parametrize("who", ["0", "2"])
@pytest.mark.parametrize(
    ("how", "code", "message"),
    [
        (["exception"], 1, "ValueError: the mistake"),
        (["sys.exit", "0"], 1, "called sys.exit(0) in the middle of the run"),
        (["sys.exit", "3"], 3, "called sys.exit(3) in the middle of the run"),
        (["leave"], 1, "the script left in the middle of the run"),
        (["interrupt"], 130, "KeyboardInterrupt"),
        (["thread"], 1, "ZeroDivisionError: division by zero (in thread worker)"),
        (["kill"], None, "its process is gone (killed or crashed)"),
        (["no files", "folder"], 1, "ValueError: the mistake"),
        (["no files", "socket"], 1, "ValueError: the mistake"),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, list) else "",
)
def test_one_failing_rank_ends_the_job_with_one_message(job, who, how, code, message):
    ended = job(SCRIPT, how[0], who, *how[1:])
    assert ended.reports == [f"{ROLES[who]}, frame 7: {message}"], ended.text
    assert ended.code == code if code is not None else ended.code != 0


def test_the_same_mistake_on_all_ranks_is_reported_once(job):
    ended = job(SCRIPT, "exception", "0,1,2,3")
    assert len(ended.reports) == 1, ended.text
    assert ended.text.count("Traceback") == 1
    assert ended.code == 1


def test_an_error_that_ranks_agreed_on_is_printed_by_its_speaker(job):
    ended = job(SCRIPT, "agreed", "0,1,2,3")
    message = "rank 2 (calculator 0), frame 7: the mistake"
    assert ended.reports == [f"motes.errors.RankError: {message}"], ended.text


@pytest.mark.parametrize("wait", ["0", "0.2", "1.5"])
@pytest.mark.parametrize("who", ["0", "2"])
def test_a_rank_that_left_before_the_run_is_not_waited_for(job, who, wait):
    ended = job(SCRIPT, "early", who, wait)
    assert len(ended.reports) == 1, ended.text
    assert ended.reports[0].startswith(f"rank {who} left the script before the run started")
    assert ended.code == 1


@pytest.mark.parametrize("how", ["late", "no run", "some", "part"])
def test_ranks_may_end_well_at_different_times(job, how):
    ended = job(QUIET, how)
    assert (ended.code, ended.text) == (0, "")


# Two worlds are open at once; rank 2 leaves the script when the first one is closed.
TWO = """
import os, sys, time
import motes

worlds = [motes.World(seed=k, progress="off", roles="shared") for k in (1, 2)]
for world in worlds:
    world.__enter__()
for frame in range(3):
    for world in worlds:
        world.system(f"s{frame}").burst((frame, 0, 0))
        world.step()
worlds[int(sys.argv[2])].__exit__(None, None, None)
if worlds[0].rank == 2 and sys.argv[1] == "leave":
    sys.exit
else:
    worlds[1 - int(sys.argv[2])].step()
    worlds[1 - int(sys.argv[2])].__exit__(None, None, None)
"""


@pytest.mark.parametrize("first", ["0", "1"])
def test_of_two_open_worlds_each_is_protected(job, first):
    ended = job(TWO, "leave", first)
    assert ended.reports == ["rank 2 (calculator 2), frame 3: the script left in the middle of the run"], (
        ended.text
    )
    ended = job(TWO, "stay", first)
    assert (ended.code, ended.reports) == (0, []), ended.text


# --- within this process


@pytest.mark.parametrize("gil", ["held", "free"])
def test_an_abort_that_hangs_ends_nevertheless(gil):
    script = (
        "import ctypes, signal, time\n"
        "import motes\n"
        "from mpi4py import MPI\n"
        "from motes._run import ending\n"
        "class Hanging:\n"
        "    def Abort(self, code):\n"
        f"        (ctypes.PyDLL(None).sleep if {gil == 'held'} else time.sleep)(60)\n"
        "MPI.COMM_WORLD = Hanging()\n"
        "signal.signal(signal.SIGALRM, lambda *_: None)\n"
        "signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM, signal.SIGTERM])\n"
        "ending.abort(3)\n"
    )
    ended = subprocess.run([sys.executable, "-c", script], timeout=30)
    assert ended.returncode == 3


def test_a_single_rank_behaves_as_python_does():
    hook = sys.excepthook
    ending.install()
    assert sys.excepthook is hook
    ending.stop_job(ValueError("of no consequence"))


@pytest.mark.parametrize("means", ["directory", "socket"])
def test_one_rank_per_host_prints_the_report(monkeypatch, tmp_path, means):
    monkeypatch.setenv("PMIX_NAMESPACE", f"test {tmp_path}")
    monkeypatch.setenv("PMIX_SERVER_TMPDIR", str(tmp_path))
    if means == "socket":
        monkeypatch.delenv("PMIX_SERVER_TMPDIR")
    assert [speaking.claim_report() for _ in range(3)] == [True, False, False]
    monkeypatch.setenv("PMIX_NAMESPACE", f"another job {tmp_path}")
    assert speaking.claim_report()


def test_exit_codes_are_never_zero():
    codes = [ending._exit_code(SystemExit(code)) for code in (0, None, 3, 256, -1, "text")]
    assert codes == [1, 1, 3, 1, 255, 1]
    assert ending._exit_code(KeyboardInterrupt()) == 130


def test_an_agreed_error_names_the_guilty_rank_alone():
    error = RankError("no memory", rank=3, role="calculator 1", frame=12, action="gravity", speaker=3)
    assert ending._headline(error).endswith("rank 3 (calculator 1), frame 12, gravity: no memory")


@pytest.mark.parametrize("how", ["handles", "numbers"])
def test_a_dead_process_is_noticed_before_and_after_it_is_reaped(monkeypatch, how):
    if how == "numbers":
        monkeypatch.delattr(os, "pidfd_open")
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    try:
        here = Peer.here(rank=0, role="image generator")
        there = here._replace(rank=1, role="calculator 0", pid=child.pid, started=peers._started(child.pid))
        elsewhere = here._replace(rank=2, pid=2**22 + 1, space="another host")
        watch = PeerWatch([here, there, elsewhere], rank=0)
        assert watch.check(0.0) is None
        child.send_signal(signal.SIGKILL)
        os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)  # dead, but still a zombie
        assert watch.check(0.001) is None, "looked again too soon"
        assert watch.check(1.0) == 1
        child.wait()
        assert watch.check(2.0) == 1
        late = PeerWatch([here, there], rank=0)
        assert late.check() == 1
    finally:
        child.kill()
        child.wait()


def test_nobody_is_declared_dead_for_want_of_file_descriptors(monkeypatch):
    monkeypatch.delattr(os, "pidfd_open")
    here = Peer.here(rank=0, role="")
    watch = PeerWatch([here, here._replace(rank=1), here._replace(rank=2, space="another host")], rank=0)
    assert [watch.alive(rank) for rank in range(3)] == [True, True, None]
    held = []
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(map(int, os.listdir("/proc/self/fd"))) + 10, hard))
        with pytest.raises(OSError, match="Too many open files"):
            while True:
                held.append(os.open(os.devnull, os.O_RDONLY))
        assert watch.check() is None
        assert watch.alive(1)
    finally:
        for file in held:
            os.close(file)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_what_is_said_of_a_process():
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    try:
        here = Peer.here(rank=0, role="")
        there = here._replace(rank=1, pid=child.pid, started=peers._started(child.pid))
        watch = PeerWatch([here, there], rank=0)
        assert watch.life(1) == (True, f"its process {child.pid} is alive")
        assert watch.life(-1) == (True, "their processes are alive")
        child.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, child.pid, os.WSTOPPED)
        stopped = f"its process {child.pid} is stopped (`kill -CONT {child.pid}` resumes it)"
        assert watch.life(1) == (True, stopped)
        elsewhere = PeerWatch([here, there, here._replace(rank=2, space="another host")], rank=0)
        assert elsewhere.life(2)[0] is None and "another host" in elsewhere.life(2)[1]
        assert elsewhere.life(-1)[0] is None
        child.kill()
        child.wait()
        assert watch.life(1) == (False, "its process is gone")
        assert elsewhere.life(-1)[0] is False
    finally:
        child.kill()
        child.wait()


def test_another_process_with_the_same_number_is_not_the_peer():
    here = Peer.here(rank=0, role="")
    impostor = here._replace(rank=1, started=here.started - 1)
    assert PeerWatch([here, impostor], rank=0).check() == 1
