"""Ranks that end before MPI has started: the others do not wait for them."""

from __future__ import annotations

import contextlib
import os
import random
import select
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from launching import Hang, Result, command, kill_session

from motes._launch import starting
from motes._mpi.presence import Presence, started_by

ENDS = {
    "exit0": "sys.exit(0)",
    "raise": "raise FileNotFoundError('only some hosts have it')",
    "exit3": "os._exit(3)",
    "kill": "os.kill(os.getpid(), 9)",
}
SCRIPT = """
import os, sys
if os.environ["OMPI_COMM_WORLD_RANK"] == "1":
    {end}
import motes
with motes.World(seed=1, progress="off") as world:
    world.step()
print("ran")
"""


def run(script: str, *options: str, ranks: int = 2) -> Result:
    """Run a script, given as text, with `motes run`."""
    return command([sys.executable, "-m", "motes", "run", *options, "-n", ranks, "-c", script], timeout=30)


@pytest.mark.parametrize(
    ("end", "options"),
    [
        ("exit0", ()),
        ("raise", ()),
        ("kill", ("--survive",)),
        ("exit0", ("--survive", "--hosts", "localhost:2")),
        *(
            pytest.param(end, options, marks=pytest.mark.slow)
            for end in ENDS
            for options in ((), ("--survive",), ("--hosts", "localhost:2"))
        ),
    ],
)
def test_a_rank_that_ends_before_mpi_ends_the_job(end, options):
    result = run(SCRIPT.format(end=ENDS[end]), *options)
    assert result.code != 0 and result.out == "", result.text
    told = result.err.splitlines()[-1]
    assert told.startswith("motes run: exit code") and "rank 1 ended before MPI had started" in told
    assert ("FileNotFoundError: only some hosts have it" in told) == (end == "raise")
    assert "of rank" not in result.err, "the watchers' own lines"
    if not options and end == "exit3":
        assert result.code == 3


needs_survival = pytest.mark.skipif(
    starting.cannot_survive() is not None, reason=str(starting.cannot_survive())
)
STEP = "import motes\nwith motes.World(seed=1, progress='off') as world: world.step()\n"
LAUNCH = """
import sys
from motes._launch import starting, supervisor
from motes._launch import starting
from motes._mpi.presence import LAUNCHER_TELLS, started_by
killed = 'if [ "$OMPI_COMM_WORLD_RANK" = 1 ]; then kill -9 $$; fi; exec "$@"'
rank = started_by([sys.executable, "-c", sys.argv[1]], is_rank=True)
argv = starting.command(3, ["/bin/sh", "-c", killed, "sh", *rank], survive=True)
raise SystemExit(supervisor.supervise(argv, LAUNCHER_TELLS).code)
"""


@needs_survival
@pytest.mark.parametrize("script", [STEP, f"from mpi4py import MPI\n{STEP}"], ids=["motes", "mpi4py first"])
def test_a_rank_killed_before_it_has_a_watcher_ends_the_job(script):
    ended = command([sys.executable, "-c", LAUNCH, script], timeout=30)
    sentence = "rank 1 ended before MPI had started, on a signal; the others would wait forever"
    assert ended.code == 1 and ended.err == f"motes run: exit code 1: {sentence}\n", ended.text


@needs_survival
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(120))
def test_ranks_are_killed_at_any_moment_of_their_start(seed):
    """At first the process is still the launcher's, then the program that starts a rank, then the rank."""
    drawn = random.Random(seed)
    ranks, victim, after_s = 3, drawn.randrange(3), drawn.choice([0, 0, drawn.uniform(0, 0.3)])
    argv = [sys.executable, "-m", "motes", "run", "--survive", "-n", str(ranks), "-c", STEP]
    job = subprocess.Popen(
        argv, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
    try:
        while job.poll() is None and victim not in (found := ranks_below(job.pid)):
            pass
        time.sleep(after_s)
        with contextlib.suppress(ProcessLookupError):
            os.kill(found[victim], signal.SIGKILL)
        out = job.communicate(timeout=30)[0]
    except subprocess.TimeoutExpired:
        raise Hang(f"rank {victim} was killed after {after_s:.3f} s") from None
    finally:
        kill_session(job.pid)
        job.wait()
    told = out.splitlines()[-1:]
    assert job.returncode == 0 or (told and told[0].startswith("motes run: exit code")), out
    assert f"rank {victim}" in out or job.returncode == 0, out


def ranks_below(pid: int) -> dict[int, int]:
    """Return the processes of ranks that descend from a process, by rank."""
    found = {}
    with contextlib.suppress(OSError):
        for child in map(int, Path(f"/proc/{pid}/task/{pid}/children").read_text().split()):
            found |= ranks_below(child)
            with contextlib.suppress(OSError):
                for variable in Path(f"/proc/{child}/environ").read_bytes().split(b"\0"):
                    if variable.startswith(b"OMPI_COMM_WORLD_RANK="):
                        found[int(variable[21:])] = child
    return found


@pytest.mark.parametrize("options", [(), ("--survive",)])
def test_a_job_without_mpi_may_end_well(options):
    result = run("import time; time.sleep(0.1); print('ran')", *options)
    assert result.lines == ["ran", "ran"] and result.err == "", result.text


@pytest.mark.slow
@pytest.mark.parametrize("options", [(), ("--survive",)])
def test_all_ranks_may_make_the_same_mistake(options):
    result = run("this is no Python", *options, ranks=3)
    assert result.code == 1 and "SyntaxError" in result.err.splitlines()[-1], result.text


def watched(script: str) -> str:
    """Run one process under a watcher; return the watcher's output."""
    argv = started_by([sys.executable, "-c", script], is_rank=True)
    env = {"OMPI_COMM_WORLD_RANK": "7", "PATH": "/usr/bin:/bin"}
    ended = subprocess.run(argv, env=env, stderr=subprocess.PIPE, text=True, timeout=30)
    return ended.stderr


SAYS = "import os\nfor word in {words}: os.write(int(os.environ['MOTES_RANK_PIPE']), word + b'\\n')\n"


def test_watchers_tell_what_ranks_say_and_that_they_are_gone():
    starts, waits, has, ended = (
        f"*** motes: of rank 7: {word}" for word in ("starts", "waits", "has", "ended")
    )
    assert watched("").splitlines() == [starts, ended]
    assert watched(SAYS.format(words=[b"waits"])).splitlines() == [starts, waits, ended]
    assert watched(SAYS.format(words=[b"waits", b"has"])).splitlines() == [starts, waits, has]


def test_watchers_need_no_folder_for_temporary_files():
    argv = started_by([sys.executable, "-c", "pass"], is_rank=True)
    env = {"OMPI_COMM_WORLD_RANK": "7", "PATH": "/nowhere", "TMPDIR": "/nowhere"}
    ended = subprocess.run(argv, env=env, stderr=subprocess.PIPE, text=True, timeout=30)
    assert ended.stderr == "*** motes: of rank 7: starts\n*** motes: of rank 7: ended\n"


def test_watchers_take_no_open_file_of_the_rank_and_keep_none():
    """A launcher may have given the rank any file, and learns from the file's end that the rank is gone."""
    heard, said = os.pipe()
    given = [os.dup(said) for _ in range(20)]
    script = f"import os, time\nfor file in {given}: os.write(file, b'.'), os.close(file)\ntime.sleep(60)"
    argv = started_by([sys.executable, "-c", script], is_rank=True)
    env = {"OMPI_COMM_WORLD_RANK": "7"}
    with subprocess.Popen(argv, env=env, pass_fds=given, stderr=subprocess.DEVNULL) as rank:
        for file in (said, *given):
            os.close(file)
        text = b""
        while select.select([heard], [], [], 10)[0] and (more := os.read(heard, 100)):
            text += more
        closed = bool(select.select([heard], [], [], 0)[0])
        rank.kill()
    os.close(heard)
    assert text == b"." * len(given) and closed


def test_a_child_of_the_rank_may_have_its_pipe_open():
    """It is the rank that must be there, not its files."""
    child = (
        "import os, subprocess; subprocess.Popen(['sleep', '5'], close_fds=False, stderr=subprocess.DEVNULL)"
    )
    begin = time.monotonic()
    assert watched(child).endswith("*** motes: of rank 7: ended\n") and time.monotonic() - begin < 4


def test_a_script_may_close_all_files():
    assert watched("import os, time\nos.closerange(3, 64)\ntime.sleep(1.5)") == (
        "*** motes: of rank 7: starts\n"
    )


def test_the_process_that_is_started_is_the_rank_itself():
    script = "import os; print(os.environ['MOTES_RANK_PROCESS'].split()[0] == str(os.getpid()))"
    argv = started_by([sys.executable, "-c", script], is_rank=True)
    process = subprocess.Popen(argv, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.communicate(timeout=30)[0] == "True\n"


def told(*words: str) -> tuple[Presence, threading.Event]:
    """Feed a new Presence with messages of watchers, such as "1 waits"."""
    ended = threading.Event()
    presence = Presence(ended.set)
    for word in words:
        rank, said = word.split()
        assert presence.take(f"[1,1]<stderr>: *** motes: of rank {rank}: {said}\n".encode())
    return presence, ended


def test_only_those_that_wait_are_waited_for_in_vain(monkeypatch):
    monkeypatch.setattr("motes._mpi.presence._GRACE_S", 0.05)
    for words in (["0 ended", "1 waits"], ["1 waits", "0 ended"], ["1 waits", "0 waits", "0 ended"]):
        presence, ended = told(*words)
        assert ended.wait(10) and presence.hopeless
        assert presence.sentence("E", b"") == (
            "rank 0 ended before MPI had started; the others would wait forever: E"
        )
    for words in (["0 ended"], ["0 ended", "1 ended"], ["0 ended", "1 waits", "1 has"]):
        presence, ended = told(*words)
        assert not ended.wait(0.2) and not presence.hopeless
    assert told("0 waits", "0 has")[0].sentence("E", b"") == ""
    assert not presence.take(b"*** motes: rank 1: an error\n")


def failure(rank: int, state: str, job: int = 1) -> bytes:
    """Return the line in which mpirun of Open MPI 5 says that a rank failed, or a daemon (job 0)."""
    name = f"prterun-vm-7@{job},{rank}"
    return f"[vm:7] [prterun-vm-7@0,0] errmgr:dvm: for proc [{name}] state {state}\n".encode()


def test_what_the_launcher_says_counts_until_mpi_has_started(monkeypatch):
    monkeypatch.setattr("motes._mpi.presence._GRACE_S", 0.05)
    presence, ended = told("0 waits")
    assert presence.take(failure(2, "EXITED WITH NON-ZERO STATUS"))
    assert ended.wait(10)
    assert presence.sentence("", b"") == "rank 2 ended before MPI had started; the others would wait forever"

    presence, ended = told()  # scripts that load MPI before motes say nothing
    assert presence.take(failure(1, "ABORTED BY SIGNAL"))
    assert ended.wait(10) and "rank 1 ended before MPI had started, on a signal" in presence.sentence("", b"")

    presence, ended = told("0 waits", "1 waits", "0 has")
    assert presence.take(failure(1, "ABORTED BY SIGNAL"))
    presence.take(b"*** motes: of rank 1: has\n")  # by way of another host
    assert presence.take(failure(0, "ABORTED BY SIGNAL"))
    assert presence.take(failure(2, "COMMUNICATION FAILURE", job=0)), "of a daemon"
    assert not ended.wait(0.2) and presence.sentence("", b"") == ""


def test_a_rank_that_does_not_start_is_not_waited_for(monkeypatch):
    """mpirun may not learn that a process was killed on another host."""
    monkeypatch.setattr("motes._mpi.presence._ABSENT_S", 0.1)
    for words in (["0 starts", "0 waits", "2 starts"], ["0 waits", "0 has", "2 waits"]):
        ended = threading.Event()
        presence = Presence(ended.set, ranks=3)
        for word in words:
            presence.take(f"*** motes: of rank {word.replace(' ', ': ')}\n".encode())
        assert ended.wait(10)
        assert presence.sentence("", b"") == "rank 1 did not start within 0 s; the others would wait forever"
    ended = threading.Event()
    presence = Presence(ended.set, ranks=2)
    for word in ("0: starts", "0: waits", "1: starts"):
        presence.take(f"*** motes: of rank {word}\n".encode())
    assert not ended.wait(0.3) and presence.sentence("", b"") == "", "it is slow, but it is there"


def test_the_launcher_knows_which_failed_first():
    presence, _ = told("0 ended", "2 ended")
    assert presence.sentence("", b"") == "ranks 0, 2 ended before MPI had started"
    of_two = b"Process name: [prterun-vm-1@1,2]\n Exit code: 3"
    assert presence.sentence("", of_two) == "rank 2 ended before MPI had started"
    killed = b"prterun noticed that process rank 2 with PID 3 on node vm exited on\nsignal 9 (Killed)."
    assert presence.sentence("", killed) == "rank 2 ended before MPI had started, on signal 9 (Killed)"
