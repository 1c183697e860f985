"""Processes that a rank starts are not ranks: they run by themselves and do not disturb the rank's MPI."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from launching import Result, command, mpirun

from motes._launch import starting
from motes._mpi import rank_process

CHILDREN = Path(__file__).parents[1] / "scenes" / "child_processes.py"
WAYS = ("fork", "spawn", "forkserver")
SAYS = "import motes; print(motes.World(seed=1).size, flush=True)"


def told(result: Result, ranks: int) -> list[str]:
    """Return what the ranks printed, once; all ranks must have printed the same."""
    assert result.code == 0, result.text
    lines = sorted(result.out.split("\n")[:-1])
    assert lines == sorted(lines[::ranks] * ranks), result.text
    assert "*** motes" not in result.err, result.text
    return lines[::ranks]


def expected(where: str, forks: list[int], helper: bool = True) -> list[str]:
    """Return the expected output of `child_processes.py`."""
    lines = [f"{where} forks {forks}", *(f"{where} {way} (0, 1, 6)" for way in WAYS)]
    return [*lines, f"{where} helper 0 1 6 "] if helper else lines


def test_processes_of_a_rank_inside_its_world_run_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = mpirun(2, CHILDREN, "inside", timeout=90)
    assert told(result, 2) == sorted([*expected("inside", [7, 5, 1, 1]), "end 27"])
    assert result.err.count("this world belongs to its parent") == 2


@pytest.mark.slow
@pytest.mark.parametrize("more", [(), ("mpi4py",)])
@pytest.mark.parametrize("options", [(), ("--survive",)])
def test_processes_of_a_rank_before_and_behind_its_world_run_alone(tmp_path, monkeypatch, more, options):
    monkeypatch.chdir(tmp_path)
    job = [sys.executable, "-m", "motes", "run", *options, "-n", "3", CHILDREN, "before,inside,behind", *more]
    lines = [
        *expected("before", [7, 1], helper=False),
        *expected("inside", [7, 5, 1, 1]),
        *expected("behind", [7, 5, 9]),
    ]
    assert told(command(job, timeout=240), 3) == sorted([*lines, "end 27"])


@pytest.mark.parametrize("before", ["", "from mpi4py import MPI\n"])
def test_what_was_started_before_motes_is_no_rank(before):
    script = f"{before}import subprocess, sys\nsubprocess.run([sys.executable, '-c', {SAYS!r}])\n{SAYS}"
    assert sorted(mpirun(2, script).lines) == ["1", "1", "2", "2"]


@pytest.mark.parametrize("wrapper", [("sh", "-c", '"$@"; exit $?', "sh"), ("env", "-u", "NOTHING")])
def test_what_a_wrapper_starts_is_the_rank(wrapper):
    argv = starting.command(2, [*wrapper, sys.executable, "-c", SAYS])
    assert command(argv).lines == ["2", "2"]


def test_a_job_that_a_rank_starts_has_ranks():
    inner = [sys.executable, "-m", "motes", "run", "-n", "2", "-c", SAYS]
    script = f"import subprocess\n{SAYS}\nif motes.World(seed=1).rank == 0: subprocess.run({inner!r})"
    assert mpirun(2, script).lines == ["2"] * 4


# --- without a launcher


def settled(folder: Path, **variables: str) -> list[str]:
    """Return which of a process, its child and its grandchild count as ranks under these variables."""
    shows = "print(settle(), flush=True)"
    child = "if len(sys.argv) < 3: os.system(f'{sys.executable} {__file__} - ' + ' '.join(sys.argv[1:]))"
    (folder / "script.py").write_text(f"{Path(rank_process.__file__).read_text()}\n{shows}\n{child}\n")
    env = {**os.environ, **variables}
    argv = [sys.executable, str(folder / "script.py")]
    return subprocess.run(argv, env=env, capture_output=True, text=True, check=True).stdout.splitlines()


@pytest.mark.parametrize(
    "variables",
    [
        {"PMIX_NAMESPACE": "a", "PMIX_RANK": "1", "OMPI_COMM_WORLD_SIZE": "2"},
        {"PMI_RANK": "1", "PMI_SIZE": "2", "PMI_FD": "9"},
        {"FLUX_TASK_RANK": "0", "FLUX_JOB_SIZE": "2"},
    ],
)
def test_a_rank_leaves_its_number_to_what_it_starts(tmp_path, variables):
    assert settled(tmp_path, **variables) == ["True", "False", "False"]


def test_without_a_launcher_nobody_is_a_rank(tmp_path):
    assert settled(tmp_path) == ["False"] * 3
