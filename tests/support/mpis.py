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

__all__ = ["MPICH", "environment", "install_package"]

MPICH = "mpich==5.0.2"
PACKAGE = Path(motes.__file__).parent
_INSTALL_S = 300


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


def install_package(folder: Path) -> None:
    """Put motes into an environment as a wheel would: with copies of what is compiled."""
    target = _site(folder) / "motes"
    target.mkdir()
    for entry in PACKAGE.iterdir():
        if entry.suffix == ".so":
            shutil.copy(entry, target)
        else:
            (target / entry.name).symlink_to(entry)


def _site(folder: Path) -> Path:
    return next(folder.glob("lib/python*/site-packages"))
