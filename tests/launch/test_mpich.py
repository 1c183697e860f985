"""MPICH's launcher, from PyPI: ranks start, fail and end under it. With `--slow`, a core is built for it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from launching import Result, command, python
from mpis import MPICH, build_core, environment, install_package

OLDER = "mpich==4.3.2"

# Without a core built for MPICH: what `motes` would say and do in a rank is done by hand.
RANK = """
import os, sys, time
def end():
    {end}
rank, pipe = os.environ["PMI_RANK"], int(os.environ["MOTES_RANK_PIPE"])
if rank == "1":
    end()
os.write(pipe, b"waits\\n")
from mpi4py import MPI
os.write(pipe, b"has\\n")
print("ran", MPI.COMM_WORLD.allreduce(1))
"""


def run(python: Path, *arguments: object, ranks: int = 3) -> Result:
    """Start ranks with the Python of an environment, and the motes that it has itself."""
    argv = [python, "-m", "motes", "run", "-n", ranks, *arguments]
    return command(argv, env={"PYTHONPATH": ""}, timeout=60)


@pytest.fixture(scope="module")
def mpich(tmp_path_factory):
    """Return the Python of an environment with MPICH."""
    folder = tmp_path_factory.mktemp("mpich")
    made = environment(folder, MPICH)
    install_package(folder)
    return made


@pytest.mark.parametrize("ranks", [2, 5])
def test_ranks_keep_the_connection_to_their_launcher(mpich, ranks):
    """MPICH passes it on as an open file, whose number differs from rank to rank."""
    assert run(mpich, "-c", RANK.format(end="pass"), ranks=ranks).lines == [f"ran {ranks}"] * ranks


@pytest.mark.parametrize(
    "end", ["sys.exit(0)", "os._exit(0)", "raise ValueError('the mistake')", "os.kill(os.getpid(), 9)"]
)
def test_the_others_do_not_wait_for_a_rank_that_is_gone(mpich, end):
    ended = run(mpich, "-c", RANK.format(end=end))
    told = ended.err.splitlines()[-1]
    assert ended.code == (9 if "kill" in end else 1) and "ran" not in ended.out, ended.text
    assert told.startswith(f"motes run: exit code {ended.code}: rank 1 ended before MPI had started"), (
        ended.text
    )
    assert ("ValueError: the mistake" in told) == ("ValueError" in end)
    assert "of rank" not in ended.err, "the watchers' own lines"


# --- a core that is built for it

SCENE = """
import os, sys, motes
from motes.shapes import Sphere
world = motes.World(seed=7, space=(-3, 3), progress="off")
sparks = world.system("sparks")
with world:
    for frame in world.frames(4):
        if frame == 2 and world.rank == 1:
            {end}
        sparks.source(Sphere((0, 1, 0), 0.3), rate=1000)
        sparks.gravity((0, -9.81, 0))
        sparks.move()
        world.step()
    print(world.digest())
"""


@pytest.fixture(scope="module", params=[MPICH, OLDER])
def built(request, tmp_path_factory):
    """Return the Python of an environment with motes built for its MPICH."""
    folder = tmp_path_factory.mktemp("built")
    made = environment(folder, request.param)
    install_package(folder, build_core(tmp_path_factory.mktemp("build"), folder / "bin" / "mpicc"))
    return made


@pytest.mark.slow
def test_a_core_built_for_mpich_gives_the_same_bits(built):
    (wanted,) = python(SCENE.format(end="pass")).lines
    for ranks in (1, 2, 3, 5):
        assert set(run(built, "-c", SCENE.format(end="pass"), ranks=ranks).lines) == {wanted}, ranks
    report = json.loads(command([built, "-m", "motes", "doctor", "--json"], env={"PYTHONPATH": ""}).out)
    assert report["mpi_library"].startswith("MPICH") and report["hello"] == ["rank 0 of 2", "rank 1 of 2"]
    assert not [problem for problem in report["problems"] if "not installed" not in problem], report[
        "problems"
    ]


@pytest.mark.slow
def test_memory_that_mpich_leaves_is_removed(built):
    mapped = "(line.split()[5] for line in open('/proc/self/maps') if '/dev/shm/' in line)"
    script = SCENE.format(end=f"print(*{mapped}, flush=True); 1 / 0")
    ended = run(built, "-c", script)
    assert ended.code == 1 and "ZeroDivisionError" in ended.err.splitlines()[-1], ended.text
    assert not [path for path in ended.out.split() if Path(path).exists()]


@pytest.mark.slow
@pytest.mark.parametrize("attempt", range(10))
@pytest.mark.parametrize(
    ("end", "code", "told"),
    [
        ("raise ValueError('the mistake')", 1, "rank 1 (manager), frame 2: ValueError: the mistake"),
        ("sys.exit(3)", 3, "rank 1 (manager), frame 2: called sys.exit(3) in the middle of the run"),
        ("os.kill(os.getpid(), 11)", 11, "rank 1 (manager), frame 2: segmentation fault"),
        (
            "os.kill(os.getpid(), 9)",
            137,
            "a rank was killed inside `with world:`, and mpiexec has ended the others",
        ),
    ],
)
def test_failures_of_a_core_built_for_mpich(built, end, code, told, attempt):
    ended = run(built, "-c", SCENE.format(end=end))
    assert ended.code == code, ended.text
    assert ended.err.splitlines()[-1] == f"motes run: exit code {code}: {told}", ended.text
