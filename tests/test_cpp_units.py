"""The C++ unit tests, as one test that lists those that failed."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest


def test_cpp_units(cpp_units: Path):
    ran = subprocess.run([cpp_units], capture_output=True, text=True, timeout=300)
    failed = [
        line.removeprefix("FAILED").strip() for line in ran.stdout.splitlines() if line.startswith("FAILED")
    ]
    if failed or ran.returncode != 0:
        names = ", ".join(failed) or f"exit code {ran.returncode}"
        pytest.fail(f"{names}\n{ran.stderr[-8000:]}{ran.stdout[-500:]}", pytrace=False)
    assert " 0 failed checks" in ran.stdout


def test_the_unit_tests_need_no_mpi(cpp_units: Path):
    needed = subprocess.run(["ldd", cpp_units], capture_output=True, text=True, check=True).stdout
    assert "libstdc++" in needed
    assert "libmpi" not in needed
