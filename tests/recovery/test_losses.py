"""Ranks killed under `motes run --survive`: the others continue, and the job ends without a hang."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest
from launching import Result, command, said
from mpiruns import FIVE, FOUR, HYDRA

from motes import _core  # noqa: F401  (MPI must start before the query below, which does not start it)
from motes._launch import starting, supervisor
from motes._run import losses
from motes.cli import main
from motes.errors import MotesError

pytestmark = pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))

# Survives without a world: communicates in rounds; after a loss, the others restart without the lost rank.
SURVIVOR = """
import os, random, signal, sys, threading, time
from mpi4py import MPI
from motes import World
from motes._run.process import process

everybody = MPI.COMM_WORLD
seed, victims = int(sys.argv[1]), [int(rank) for rank in sys.argv[2].split(",")]
moment = random.Random(seed)
assert process.survives


def die():
    time.sleep(0.2 * moment.random())
    os.kill(os.getpid(), signal.SIGKILL)


def until(done):
    while not done():
        time.sleep(1e-4)


def talk(comm):
    sent = bytearray(moment.choice([10, 300_000]))
    for _ in range(40):
        others = [rank for rank in range(comm.size) if rank != comm.rank]
        requests = [comm.Isend(sent, to, 3) for to in others]
        for source in others:
            until(lambda: comm.Iprobe(source, 3))
            comm.Recv(bytearray(300_000), source, 3)
        for request in [*requests, comm.Ibarrier()]:
            until(request.Test)
        time.sleep(0.005)


comm = everybody.Dup()
everybody.Barrier()
if everybody.rank in victims:
    threading.Thread(target=die, daemon=True).start()
while True:
    try:
        talk(comm)
        good = 1
    except MPI.Exception:
        comm.Revoke()
        good = 0
    try:
        all_good = comm.Agree(good)
    except MPI.Exception:
        all_good = 0
    if good and all_good:
        break
    comm = comm.Shrink()
print(f"rank {everybody.rank} with {comm.size}", flush=True)
"""


def survive(
    n: int, script: str, tmp_path: Path, *arguments: object, env: dict[str, str] | None = None
) -> Result:
    """Run a script, given as text, on ranks of which some may be lost."""
    path = tmp_path / "script.py"
    path.write_text(script)
    run = [sys.executable, "-m", "motes", "run", "--survive", "-n", n, path, *arguments]
    return command(run, timeout=60, env=env)


@pytest.mark.parametrize(
    ("meanwhile", "victims"),
    [
        ("receive", "2"),
        ("receive", "0"),
        ("send", "2"),
        ("compute", "2"),
        ("finish", "1"),
        ("shrink", "1,2"),
        ("anything", "2"),
    ],
)
def test_the_core_goes_on_whatever_the_others_wait_in(losing_program, meanwhile, victims):
    argv = starting.command(4, [str(losing_program), meanwhile, victims, "0.2"], survive=True)
    result = command(argv, env=losses.ENVIRONMENT, timeout=60)
    left = [rank for rank in range(4) if str(rank) not in victims.split(",")]
    with_whom = " ".join(map(str, left))
    assert sorted(result.lines) == [f"rank {rank} came through with {with_whom}" for rank in left], (
        result.text
    )


@pytest.mark.parametrize("seed", [1, 2, pytest.param(3, marks=pytest.mark.slow)])
def test_a_script_may_go_on_and_end_well_after_losses(tmp_path, seed):
    victims = random.Random(seed).sample(range(5), 1 + seed % 2)
    result = survive(5, SURVIVOR, tmp_path, seed, ",".join(map(str, victims)))
    left = [rank for rank in range(5) if rank not in victims]
    assert sorted(result.lines) == [f"rank {rank} with {len(left)}" for rank in left], result.text
    assert result.err.strip() == "", result.text


def test_without_a_loss_nothing_is_different(tmp_path):
    script = "import motes\nwith motes.World(roles='shared') as world:\n    world.say(world.size)\n"
    result = survive(3, script, tmp_path)
    assert result.lines == ["3"], result.text


def test_a_mistake_after_a_loss_ends_the_job_with_one_report(tmp_path):
    # Five ranks: with up to four, Open MPI's own abort would end them anyway.
    mistake = "if everybody.rank == 3: raise ValueError('afterwards')\ntime.sleep(50)\n"
    result = survive(5, SURVIVOR + mistake, tmp_path, 1, 2)
    assert result.code == 1, result.text
    assert said(result.err, "*** motes: ") == ["rank 3: ValueError: afterwards"], result.text


def test_an_exit_code_after_a_loss_is_the_jobs(tmp_path):
    result = survive(3, SURVIVOR + "if everybody.rank == 0: sys.exit(7)\n", tmp_path, 1, 2)
    assert result.code == 7, result.text


@pytest.mark.parametrize(("last", "code"), [("handshake.forget_lost()", 0), ("pass", 1)])
def test_the_note_of_a_lost_rank_is_taken_back_by_those_that_end_well(tmp_path, last, code):
    notes = "from motes._world import handshake; from motes._run import open_worlds\nimport os\n"
    enters = "noted = open_worlds.enter(int(os.environ['OMPI_COMM_WORLD_RANK']), '1.1')\n"
    result = survive(3, notes + enters + SURVIVOR + f"open_worlds.leave(noted)\n{last}\n", tmp_path, 1, 2)
    assert result.code == code, result.text


@pytest.mark.parametrize("enters", ["True", "everybody.rank != 1"])
def test_a_loss_before_a_world_starts_ends_the_job(tmp_path, enters):
    # Rank 2 is killed while the others wait for it in `with World()`, or while one leaves the script.
    script = f"""
import os, time
from mpi4py import MPI
import motes
everybody = MPI.COMM_WORLD
if everybody.rank == 2:
    time.sleep(0.3)
    os.kill(os.getpid(), 9)
if {enters}:
    with motes.World(roles="shared"):
        pass
"""
    result = survive(5, script, tmp_path)
    assert result.code == 1, result.text
    reports = said(result.err, "*** motes: ")
    assert len(reports) == 1, result.text
    assert "is lost (killed or crashed)" in reports[0] or "left the script" in reports[0], result.text


def test_a_loss_while_the_core_enters_ends_the_job(tmp_path):
    script = """
import os, time, types
import motes, motes._world.running
from motes._run.process import process
if process.rank == 2:
    def die(**_):
        time.sleep(0.3)
        os.kill(os.getpid(), 9)
    core = motes._world.running._core
    names = {name: getattr(core, name) for name in dir(core)}
    motes._world.running._core = types.SimpleNamespace(**{**names, "Engine": die})
with motes.World(roles="shared"):
    pass
"""
    result = survive(4, script, tmp_path)
    assert result.code == 1, result.text
    (report,) = said(result.err, "*** motes: ")
    assert report.endswith("MotesError: rank 2 is lost: its process was killed or has crashed"), result.text


def test_a_job_whose_ranks_all_die_where_a_world_starts_has_failed(tmp_path):
    script = """
import os
import motes
from motes._world import handshake
handshake._exchange_cards = lambda *_: os.kill(os.getpid(), 9)
with motes.World(roles="shared"):
    pass
"""
    result = survive(2, script, tmp_path)
    assert result.code != 0, result.text


def test_a_loss_is_survived_only_where_it_was_asked_for(losing_program):
    result = command(starting.command(4, [str(losing_program), "receive", "2", "0.2"]), timeout=60)
    assert result.code == 137, result.text


# --- checks before anything starts


def test_flags():
    argv = starting.command(3, ["python", "x.py"], mpirun=FIVE, survive=True)
    assert argv[:5] == [FIVE.path, "-n", "3", "--with-ft", "ulfm"]
    for mpirun in (FOUR, HYDRA):
        with pytest.raises(
            MotesError, match=f"Open MPI 5 or later, built with ULFM; this is {mpirun.version}"
        ):
            starting.command(3, ["python", "x.py"], mpirun=mpirun, survive=True)


@pytest.mark.parametrize("ranks", ["1", "3"])
def test_where_the_mpi_cannot_the_run_does_not_start(monkeypatch, capsys, tmp_path, ranks):
    monkeypatch.setattr(starting, "library", lambda: FOUR.version)
    monkeypatch.setattr(starting, "find_mpirun", lambda: FOUR)
    script = tmp_path / "script.py"
    script.write_text("raise SystemExit('started')")
    assert main(["run", "--survive", "-n", ranks, str(script)]) == 2
    said = capsys.readouterr().err
    assert "--survive: surviving the loss of a rank needs Open MPI 5" in said
    assert f"this is {FOUR.version}" in said


# --- how the launcher's supervisor treats the lines of ranks


def test_what_is_said_of_broken_collectives_is_left_out():
    noise = b"NBC_Progress: an error 77 was found during schedule 0x555 at row-offset 93 - aborting it\n\n"
    start = b"Error in NBC_Start_round() (-1)\n\n"
    out: list[bytes] = []
    relay = supervisor.Relay(out.append)
    relay.feed(b"a\n" + noise + b"b\n\n" + noise + start + noise + b"\nc\n")
    assert b"".join(out) == b"a\nb\n\n\nc\n"


def test_the_first_report_says_whether_a_rank_was_lost():
    """The line before the report decides, not its text, and is not shown."""
    gone, wrong = "*** motes: rank 2: its process is gone\n", "*** motes: rank 1: ValueError: the mistake\n"
    lost = f"{losses.LOST}\n"
    for text, expected in (
        (lost + gone, True),
        (lost + wrong, True),
        (gone, False),
        (wrong + lost + gone, False),
        (lost + wrong + gone, True),
        (lost, False),
    ):
        out: list[bytes] = []
        relay = supervisor.Relay(out.append)
        relay.feed(text.encode())
        assert relay.lost is expected, text
        assert b"".join(out).decode() == text.replace(lost, "")


def test_a_rank_ends_the_job_by_a_line():
    out: list[bytes] = []
    ended: list[str] = []
    relay = supervisor.Relay(out.append, end=lambda: ended.append("now"))
    relay.feed(b"a\n\x00" + f"{losses.END}130\n{losses.END}1\nb\n".encode())
    assert relay.code == 130 and ended == ["now"]
    assert b"".join(out) == b"a\nb\n"
    assert relay.message == ""
