"""What ranks agree on before a run starts: which ranks are there, their settings, their launcher."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest
from launching import said
from standing import on_ranks

import motes
from motes._mpi.launchers import launcher_of
from motes._run import waiting
from motes._run.settings import RunSettings
from motes.errors import MotesError

# --- settings

DIFFERENT = """
import sys
import motes
from mpi4py import MPI
odd = MPI.COMM_WORLD.rank in eval(sys.argv[2])
options = {"seed": 1, "progress": "off", **eval(sys.argv[1])[odd]}
with motes.World(**options) as world:
    world.step()
"""


@pytest.mark.parametrize(
    ("ranks", "odd", "options", "reports"),
    [
        (
            *(4, [2], [{"roles": "auto"}, {"roles": "shared"}]),
            "rank 2 (calculator 2), frame 0: its script differs from the other ranks': World(roles=...) is "
            "'manager 0, image generator 0, calculators [0, 1, 2, 3]' on rank 2 and "
            "'manager 1, image generator 0, calculators [2, 3]' on rank 0",
        ),
        (
            *(3, [0], [{"seed": 1}, {"seed": None}]),
            "rank 0 (image generator), frame 0: its script differs from the other ranks': World(seed=...) is "
            "'None' on rank 0 and '1' on rank 1",
        ),
        (
            *(5, [1, 3], [{}, {"dt": 0.5, "balancer": motes.balance.Pairwise(0.2)}]),
            "rank 1 (manager), frame 0: its script differs from the other ranks': World(dt=...) is '0.5' on "
            "rank 1 and '0.041666666666666664' on rank 0; World(balancer=...) is 'Pairwise(threshold=0.2, "
            "min_particles=64, smoothing=0.5)' on rank 1 and 'Static()' on rank 0 "
            "(ranks 1, 3 differ from rank 0)",
        ),
        (
            *(2, [1], [{}, {"combine": "overlapped"}]),
            "rank 1 (calculator 0), frame 0: its script differs from the other ranks': World(combine=...) is "
            "'overlapped' on rank 1 and 'together' on rank 0",
        ),
    ],
    ids=["roles", "seed", "dt and balancer", "combine"],
)
def test_ranks_that_were_told_different_things_are_named(ranks, odd, options, reports):
    shown = repr(options).replace("Pairwise", "motes.balance.Pairwise")
    result = on_ranks(ranks, DIFFERENT, shown, odd, timeout=30)
    assert result.code == 1, result.text
    (told,) = said(result.err, "*** motes: ")
    assert told == f"motes.errors.ScriptMismatchError: {reports}"
    assert result.seconds < 25, "the stall limit was not waited for"


def test_a_log_that_differs_between_ranks_is_refused(tmp_path):
    own = (
        "import os, sys, tempfile, motes\n"
        "log = tempfile.mkdtemp(dir=sys.argv[1])\n"
        "with motes.World(seed=1, progress='off', log=log) as world: world.step()\n"
    )
    result = on_ranks(2, own, tmp_path, timeout=30)
    assert result.code == 1, result.text
    (told,) = said(result.err, "*** motes: ")
    assert "ScriptMismatchError" in told and "World(log=...) is" in told and str(tmp_path) in told
    assert not any(os.listdir(folder) for folder in tmp_path.iterdir())


def test_settings_are_frozen_and_say_everything_once():
    settings = RunSettings(
        seed=None, dt=0.5, substeps=1, axis="x", space=None, periodic=(), roles=(0, 0, [0]),
        balancer=motes.balance.Static(), combine="together", births="auto", fan_out=8, skin=None,
        threads=None, clock="cpu", digest=False, log="a",
        spans=False, speeds={0: 0.5}, stall_s=3.0,
    )  # fmt: skip
    with pytest.raises(AttributeError):
        settings.dt = 1.0  # type: ignore[misc]
    agreed = settings.agreed(seed=7, threads=3, continued_from=9, crowded=True)
    assert (settings.seed, agreed.seed) == (None, 7)
    assert agreed.for_core(rank=0, hosts=["h"])["speed"] == 0.5
    assert agreed.for_core(rank=1, hosts=["h"])["speed"] == 1.0
    assert agreed.for_log()["calculators"] == [0]
    assert agreed.for_core(rank=1, hosts=["h"])["threads"] == 3
    assert agreed.for_core(rank=1, hosts=["h"])["births"] == "manager", "its ranks take turns"
    assert settings._replace(seed=1).for_core(rank=1, hosts=["h"])["births"] == "auto"
    assert agreed.for_core(rank=1, hosts=["h"])["continued_from"] == 9
    assert {"speeds", "threads"}.isdisjoint(agreed.compared())
    assert agreed.compared()["log"] == "a"


@pytest.mark.parametrize("progress", ["off", "lines"])
def test_a_seed_that_was_drawn_is_told_whatever_progress_is(progress):
    script = (
        "import sys, motes\n"
        "with motes.World(progress=sys.argv[1]) as world:\n"
        "    world.step()\n"
        "print(world.seed)\n"
    )
    for ended in (on_ranks(1, script, progress, timeout=30), on_ranks(3, script, progress, timeout=30)):
        assert said(ended.err, "seed ") == list(set(ended.lines)), ended.text


# --- launcher


@pytest.mark.parametrize(
    ("environment", "told"),
    [
        ({}, None),
        ({"PMI_SIZE": "4", "PMI_RANK": "1"}, "a launcher of the PMI family"),
        ({"PMI_SIZE": "1", "PMI_RANK": "0"}, None),
        ({"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "0"}, "Open MPI's mpirun"),
        ({"OMPI_COMM_WORLD_SIZE": "1", "SLURM_STEP_NUM_TASKS": "4", "SLURM_PROCID": "0"}, None),
        ({"MPI_LOCALNRANKS": "2"}, "MPICH's or Intel's mpirun"),
        ({"PMIX_RANK": "3", "PMIX_NAMESPACE": "x"}, "a launcher of the PMIx family"),
        ({"PMIX_RANK": "0", "PMIX_NAMESPACE": "x"}, None),
        ({"SLURM_STEP_NUM_TASKS": "4", "SLURM_PROCID": "0", "SLURM_NTASKS": "4"}, "srun"),
        ({"SLURM_STEP_NUM_TASKS": "1", "SLURM_PROCID": "0", "SLURM_NTASKS": "4"}, None),
        ({"SLURM_NTASKS": "4", "SLURM_PROCID": "2"}, "srun"),
        ({"SLURM_NTASKS": "4", "SLURM_PROCID": "0", "SLURM_STEP_ID": "0"}, "srun"),
        ({"SLURM_NTASKS": "4", "SLURM_JOB_ID": "7"}, None),  # the shell of an allocation
        ({"SLURM_NTASKS": "4", "SLURM_PROCID": "0", "SLURM_JOB_ID": "7"}, None),  # a batch script
        ({"PMI_SIZE": "many"}, None),
    ],
    ids=lambda value: (
        " ".join(f"{name}={text}" for name, text in value.items()) if isinstance(value, dict) else ""
    ),
)
def test_launchers_are_known_by_what_they_set_in_each_process(environment, told):
    found = launcher_of(environment)
    assert (found is None) == (told is None)
    if found is not None and told is not None:
        assert found.name.startswith(told)
        assert all(environment[name] == text for name, _, text in (v.partition("=") for v in found.variables))


STEP = "import motes\nwith motes.World(seed=1, progress='off') as w: w.step()\nprint('ran')\n"


def test_ranks_that_do_not_see_each_other_are_refused_by_one_of_them():
    result = on_ranks(1, STEP, env={"PMI_SIZE": "4", "PMI_RANK": "0"}, timeout=30)
    assert result.code == 1
    assert result.out == "" and "Traceback" not in result.err
    other = on_ranks(1, STEP, env={"PMI_SIZE": "4", "PMI_RANK": "2"}, timeout=30)
    assert (other.code, other.out, other.err) == (1, "", "")
    for part in ("PMI_SIZE=4, PMI_RANK=0", "MPI here sees only this one", "motes run -n N", "MOTES_ALONE=1"):
        assert part in result.err
    assert on_ranks(1, STEP, env={"PMI_SIZE": "4", "MOTES_ALONE": "1"}, timeout=30).out == "ran\n"
    assert (
        "MOTES_ALONE must be 0 or 1, got 'yes'"
        in on_ranks(1, STEP, env={"MOTES_ALONE": "yes"}, timeout=30).err
    )
    assert on_ranks(2, STEP, timeout=30).out == "ran\nran\n", "its own launcher"


def test_a_part_of_an_allocation_is_pointed_out():
    result = on_ranks(1, STEP, env={"SLURM_JOB_ID": "7", "SLURM_NTASKS": "4"}, timeout=30)
    assert result.out == "ran\n"
    assert "the scheduler gave this job 4 tasks" in result.err


# --- waiting


def advance(monkeypatch, wait, now, seconds):
    """Advance the clock of a wait, in steps short enough to count fully."""
    monkeypatch.setattr(waiting.time, "monotonic", lambda: now[0])
    for _ in range(round(seconds / 0.5)):
        now[0] += 0.5
        wait.look()


def test_a_wait_warns_once_per_minute_and_ends_after_ten(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(waiting.time, "monotonic", lambda: now[0])
    wait = waiting.Wait(None, "a friend")
    advance(monkeypatch, wait, now, 600)
    rest = "; it waits for 600 s in total (MOTES_STALL_S=seconds changes the limit)"
    assert capsys.readouterr().err.splitlines() == [
        f"motes: waited {seconds} s for a friend{rest}" for seconds in range(60, 600, 60)
    ]
    with pytest.raises(
        MotesError, match=r"waited 600 s for a friend \(MOTES_STALL_S=seconds changes the limit"
    ):
        advance(monkeypatch, wait, now, 1)


def test_a_limit_that_was_set_ends_a_wait(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(waiting.time, "monotonic", lambda: now[0])
    with pytest.raises(MotesError, match=r"waited 2 s for a friend \(the limit was set by MOTES_STALL_S=2: "):
        advance(monkeypatch, waiting.Wait(2.0, "a friend"), now, 3)
    assert capsys.readouterr().err == ""
    wait = waiting.Wait(3600.0, "a friend")
    advance(monkeypatch, wait, now, 3600)
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 59
    assert told[0].endswith("; it waits for 3600 s in total (set by MOTES_STALL_S=3600)")


def test_suspension_does_not_count_as_waiting(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(waiting.time, "monotonic", lambda: now[0])
    wait = waiting.Wait(None, "a friend")
    for _ in range(20):
        now[0] += 3600
        wait.look()
    assert wait.waited_s == 20
    assert capsys.readouterr().err == ""


@pytest.mark.slow
def test_a_process_that_was_stopped_goes_on_waiting():
    code = (
        "from motes._run import waiting\n"
        "wait = waiting.Wait(0.5, 'the end')\n"
        "print('up', flush=True)\n"
        "waiting.poll(lambda: wait.waited_s > 0.45, wait)\n"
        "print('well')\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "up\n"
    process.send_signal(signal.SIGSTOP)
    time.sleep(6)
    process.send_signal(signal.SIGCONT)
    assert process.communicate(timeout=20)[0] == "well\n"
