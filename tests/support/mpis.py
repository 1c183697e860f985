"""Environments with MPIs from PyPI: in the tests' own, MPICH would put its mpirun in the place of another."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

import motes

__all__ = ["MPICH", "build_core", "environment", "install_package"]

MPICH = "mpich==5.0.2"
ROOT = Path(__file__).parents[2]
PACKAGE = Path(motes.__file__).parent
_INSTALL_S = 300
_BUILD_S = 1800


def environment(folder: Path, *packages: str) -> Path:
    """Make an environment with this one's packages and, over them in this order, some of its own.

    Returns its Python. Skips the test where they cannot be had, unless MOTES_TEST_MPICH=required.
    """
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    python = folder / "bin" / "python"
    (_site(folder) / "outer.pth").write_text(f"{sysconfig.get_path('purelib')}\n")
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install", "-q", "--no-deps"]
    for package in packages:
        made = subprocess.run(
            [*pip, "--ignore-installed", package], capture_output=True, text=True, timeout=_INSTALL_S
        )
        if made.returncode != 0:
            reason = f"{package} cannot be installed: {made.stderr.strip().splitlines()[-1]}"
            if os.environ.get("MOTES_TEST_MPICH") == "required":
                pytest.fail(reason)
            pytest.skip(reason)
    return python


def install_package(folder: Path, core: Path | None = None) -> None:
    """Put motes into an environment as a wheel would: with a copy of this core, or of another one."""
    own = core or next(PACKAGE.glob("_core*.so"))
    target = _site(folder) / "motes"
    target.mkdir()
    for entry in PACKAGE.iterdir():
        if entry.suffix != ".so":
            (target / entry.name).symlink_to(entry)
    shutil.copy(own, target)


def build_core(folder: Path, mpicc: Path) -> Path:
    """Compile the core for another MPI, as `MPICC=... pip install` does; return the module."""
    if not (ROOT / "CMakeLists.txt").is_file():
        pytest.skip("compiling the core needs the source tree")
    tools = [
        shutil.which(name, path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")
        for name in ("cmake", "ninja")
    ]
    if None in tools:
        pytest.skip("compiling the core needs cmake and ninja: pip install motes[test]")
    cmake, ninja = map(str, tools)
    configure = [
        *(cmake, "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={ninja}"),
        *("-DMOTES_ISAS=widest", "-DMOTES_UNITY=ON", "-DMOTES_DRIVER=OFF"),
        *(f"-DPython_EXECUTABLE={sys.executable}", f"-DCMAKE_LIBRARY_OUTPUT_DIRECTORY={folder}"),
    ]
    for argv in (configure, [cmake, "--build", str(folder), "-j2", "--target", "_core"]):
        made = subprocess.run(
            argv, env={**os.environ, "MPICC": str(mpicc)}, capture_output=True, text=True, timeout=_BUILD_S
        )
        assert made.returncode == 0, made.stdout + made.stderr
    return next(folder.glob("_core*.so"))


def _site(folder: Path) -> Path:
    return next(folder.glob("lib/python*/site-packages"))
