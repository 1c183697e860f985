"""`motes run` supervises its launcher: what it prints, what ends with it, how it handles signals."""

from __future__ import annotations

import shlex
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from launching import command, kill_session, mpirun

from motes._launch.supervisor import Relay

RULE = b"-" * 74 + b"\n"
ABORT = RULE + b"MPI_ABORT was invoked on rank 2 in communicator MPI_COMM_WORLD\n  Errorcode: 1\n" + RULE
EXITED = RULE + b"prterun has exited due to process rank 2 with PID 0 on node a calling\n" + RULE
REPORT = b"\n*** motes: rank 2 (calculator 0), frame 3: ValueError: the mistake\nTraceback ...\n"
WARNING = RULE + b"WARNING: there is no network here.\n" + RULE


def relayed(*pieces: bytes) -> tuple[bytes, Relay]:
    """Feed pieces of output; return the bytes passed on before the end, and the relay."""
    out: list[bytes] = []
    relay = Relay(out.append)
    for piece in pieces:
        relay.feed(piece)
    return b"".join(out), relay


def test_the_launchers_own_messages_are_taken_out():
    out, relay = relayed(b"a\n" + WARNING, REPORT + ABORT, EXITED + b"b\n")
    assert out == b"a\n" + WARNING + REPORT + b"b\n"
    assert b"".join(relay.own) == ABORT + EXITED
    assert relay.message == "rank 2 (calculator 0), frame 3: ValueError: the mistake"


def test_cut_anywhere_it_is_the_same():
    text = b"a\n" + WARNING + ABORT + REPORT + EXITED + b"b\n"
    for cut in range(len(text)):
        out, relay = relayed(text[:cut], text[cut:])
        assert out == b"a\n" + WARNING + REPORT + b"b\n", cut
        assert relay.message == "rank 2 (calculator 0), frame 3: ValueError: the mistake", cut
        assert b"".join(relay.own) == ABORT + EXITED


def test_a_report_between_the_launchers_lines_is_passed_on():
    cut = ABORT.index(b"  Errorcode")
    out, relay = relayed(ABORT[:cut] + REPORT[1 : REPORT.index(b"Traceback")] + ABORT[cut:])
    assert out == REPORT[1 : REPORT.index(b"Traceback")]
    assert b"".join(relay.own) == ABORT


def test_nulls_behind_the_launchers_texts_are_left_out():
    out: list[bytes] = []
    relay = Relay(out.append)
    relay.feed(ABORT + b"\0a\n\0")
    relay.close(failed=True)
    assert out[0] == b"a\n" and b"\0" not in b"".join(out)


def test_a_run_without_a_standard_error_ends_as_it_did(tmp_path):
    """File descriptor 2 is closed, so the first pipe that opens could take its place."""
    line = shlex.join([sys.executable, "-m", "motes", "run", "-n", "2", "-c", "import motes; print('well')"])
    ended = subprocess.run(f"{line} 2>&-", shell=True, stdout=subprocess.PIPE, text=True, timeout=60)
    assert ended.returncode == 0 and ended.stdout == "well\n" * 2


FORKS = """
import os, sys, motes
world = motes.World(seed=1, progress="off")
with world:
    world.step()
    for end in (lambda: sys.exit(0), lambda: sys.exit(7), lambda: 1 / 0):
        child = os.fork()
        if child == 0:
            end()
        print("child", os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    world.step()
print("end", world.frame)
"""


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_process_that_a_rank_forks_off_ends_without_a_word_of_the_run(ranks):
    ended = mpirun(ranks, FORKS, timeout=60)
    assert ended.code == 0, ended.text
    assert sorted(ended.out.split("\n")[:-1]) == sorted(["child 0", "child 7", "child 1", "end 2"] * ranks)
    assert "motes:" not in ended.err and ended.err.count("ZeroDivisionError") == ranks


def test_an_unfinished_line_is_not_held_back():
    assert relayed(b"\rframe 1/3")[0] == b"\rframe 1/3"
    assert relayed(b"---")[0] == b"", "a line of dashes may follow"


FAILING = """
import motes
world = motes.World(seed=1, progress="off")
with world:
    for frame in world.frames(5):
        if frame == 2 and world.rank == 2:
            raise ValueError("the mistake")
        world.step()
"""


def test_the_failing_ranks_message_comes_last():
    result = mpirun(3, FAILING, timeout=30)
    report = "rank 2 (calculator 0), frame 2: ValueError: the mistake"
    assert result.code == 1, result.text
    assert result.err.splitlines()[-1] == f"motes run: exit code 1: {report}", result.text
    assert "MPI_ABORT was invoked on rank 2" in result.trailer
    assert "MPI_ABORT" not in result.err, result.text
    assert result.err.count("*** motes: ") == 1


def test_what_only_the_launcher_says_is_shown():
    result = mpirun(2, "import motes, os; os.kill(os.getpid(), 9)", timeout=30)
    assert result.code == 137, result.text
    assert "exited on\nsignal 9" in result.err, result.text
    assert result.trailer in result.err


def test_a_full_disk_behind_standard_error_loses_only_the_text():
    script = "import motes\nwith motes.World(progress='lines') as w:\n for _ in w.frames(3): w.step()\n"
    for options in ([], ["-m", "motes", "run", "-n", "2"]):
        shell = 'exec "$0" "$@" 2>/dev/full'
        result = command(["/bin/sh", "-c", shell, sys.executable, *options, "-c", script], timeout=30)
        assert result.code == 0, result.text


# --- its end


@contextmanager
def job(*options: str) -> Iterator[subprocess.Popen[str]]:
    """Start `motes run` in its own session; kill the session afterwards."""
    argv = [sys.executable, "-m", "motes", "run", *options]
    process = subprocess.Popen(
        argv, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
    )
    try:
        yield process
    finally:
        kill_session(process.pid)
        process.communicate(timeout=10)


RANKS = "import os, time, motes; print('up', os.getpid(), os.getppid(), flush=True); time.sleep(60)"


@pytest.mark.parametrize("hosts", [[], ["--hosts", f"{socket.gethostname()}:2"]], ids=["here", "hosts"])
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT], ids=lambda how: how.name)
def test_the_launcher_and_the_ranks_end_with_it(hosts, how):
    with job("-n", "2", *hosts, "-c", RANKS) as process:
        assert process.stdout is not None
        told = [process.stdout.readline().split() for _ in range(2)]
        pids = {int(number) for line in told for number in line[1:]}
        assert len(pids) == 3, "two ranks and their launcher"
        process.send_signal(how)
        limit = time.monotonic() + 15
        while left := [pid for pid in pids if lives(pid)]:
            assert time.monotonic() < limit, f"{left} live"
            time.sleep(0.05)
        assert process.wait(10) != 0


def lives(pid: int) -> bool:
    """Return whether a process exists and is not a zombie."""
    with suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    return False


def test_a_signal_before_the_launcher_is_up_ends_it_too():
    code = (
        "import os, signal, sys\n"
        "from motes._launch import supervisor\n"
        "popen = supervisor.subprocess.Popen\n"
        "def early(*arguments, **options):\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
        "    return popen(*arguments, **options)\n"
        "supervisor.subprocess.Popen = early\n"
        "raise SystemExit(supervisor.supervise(['sleep', '60']).code)\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], timeout=20)
    assert ended.returncode == 128 + signal.SIGTERM


def test_the_launcher_does_not_outlive_an_error_of_ours(monkeypatch):
    from motes._launch import supervisor

    started: list[subprocess.Popen[bytes]] = []
    popen = subprocess.Popen

    class Noted(popen):  # type: ignore[valid-type, misc]
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            started.append(self)

    def broken(*_):
        raise RuntimeError("of ours")

    monkeypatch.setattr(supervisor.subprocess, "Popen", Noted)
    monkeypatch.setattr(supervisor, "Relay", broken)
    with pytest.raises(RuntimeError, match="of ours"):
        supervisor.supervise(["sleep", "60"])
    assert started[0].poll() == -signal.SIGHUP
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
