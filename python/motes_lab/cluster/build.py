"""Builds `motes_replay` for SimGrid's SMPI, and finds the program."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from motes.errors import MotesError

from .._engine import environment, files

__all__ = ["build", "find_replay", "find_smpirun"]

PROGRAM = "motes_replay_smpi"


def find_smpirun() -> str:
    """Find SimGrid's launcher. Raises MotesError if it is absent."""
    found = shutil.which(str(environment.read("MOTES_SMPIRUN")))
    if found is None:
        raise MotesError(
            "virtual clusters need SimGrid's smpirun, which was not found: apt-get install libsimgrid-dev"
        )
    return found


def find_replay() -> Path:
    """Find `motes_replay` built for SMPI: `MOTES_SMPI_REPLAY`, or the one from `cluster build` beside Python.

    Raises MotesError if neither exists. Compiles nothing.
    """
    named = environment.read("MOTES_SMPI_REPLAY")
    if named:
        if not Path(named).is_file():
            raise MotesError(f"MOTES_SMPI_REPLAY={named} does not exist")
        return Path(named)
    built = _default_program()
    if not built.is_file():
        raise MotesError(
            f"virtual clusters need motes_replay built for SMPI, and {built} does not exist: run "
            "`python -m motes cluster build --source DIR`, where DIR is a clone of motes, or set "
            "MOTES_SMPI_REPLAY to the program"
        )
    return built


def build(source: Path, program: Path | None = None) -> Path:
    """Compile `motes_replay` for SMPI from a clone of motes, copy it to `program`, and return its path.

    The build folder is `source`/build/smpi, so the next build compiles only what has changed. `program`: None
    is beside this Python, where `find_replay` looks. Raises MotesError if `source` is not a clone of motes,
    if CMake is absent, or with the compiler's errors.
    """
    find_smpirun()
    source = source.resolve()
    if not (source / "cpp" / "driver" / "CMakeLists.txt").is_file():
        raise MotesError(f"--source {source} is not a clone of motes: it has no cpp/driver/CMakeLists.txt")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    cmake, ninja = shutil.which("cmake", path=path), shutil.which("ninja", path=path)
    if cmake is None:
        raise MotesError(f"cluster build needs CMake: {sys.executable} -m pip install cmake ninja")
    folder = source / "build" / "smpi"
    steps = [[cmake, "--build", str(folder), "--target", "motes_replay", "--parallel", "2"]]
    if not (folder / "CMakeCache.txt").is_file():
        generator = ["-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={ninja}"] if ninja else []
        options = ["-DMOTES_MPI=smpi", "-DMOTES_PYTHON=OFF", *generator]
        steps.insert(0, [cmake, "-S", str(source), "-B", str(folder), *options])
    for argv in steps:
        made = subprocess.run(argv, capture_output=True, text=True, errors="replace", check=False)
        if made.returncode != 0:
            raise MotesError(f"{' '.join(argv)}\n{made.stdout[-3000:]}{made.stderr[-3000:]}".rstrip())
    target = _default_program() if program is None else program
    with files.whole_path(target) as draft:
        shutil.copy2(folder / "cpp" / "driver" / "motes_replay", draft)
    return target


def _default_program() -> Path:
    return Path(sys.executable).parent / PROGRAM
