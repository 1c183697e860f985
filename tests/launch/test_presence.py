"""Ranks that end before MPI has started: the others do not wait for them."""

from __future__ import annotations

import subprocess
import sys
import threading

import pytest
from launching import Result, command

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
    lines = ["*** motes: of rank 7: waits", "*** motes: of rank 7: has", "*** motes: of rank 7: ended"]
    assert watched("").splitlines() == lines[2:]
    assert watched(SAYS.format(words=[b"waits"])).splitlines() == [lines[0], lines[2]]
    assert watched(SAYS.format(words=[b"waits", b"has"])).splitlines() == lines[:2]


def test_a_script_may_close_all_files():
    assert watched("import os, time\nos.closerange(3, 64)\ntime.sleep(1.5)") == ""


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


def test_the_launcher_knows_which_failed_first():
    presence, _ = told("0 ended", "2 ended")
    assert presence.sentence("", b"") == "ranks 0, 2 ended before MPI had started"
    of_two = b"Process name: [prterun-vm-1@1,2]\n Exit code: 3"
    assert presence.sentence("", of_two) == "rank 2 ended before MPI had started"
    killed = b"prterun noticed that process rank 2 with PID 3 on node vm exited on\nsignal 9 (Killed)."
    assert presence.sentence("", killed) == "rank 2 ended before MPI had started, on signal 9 (Killed)"
