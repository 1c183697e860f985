"""The C++ unit tests, as one test that lists the failed ones."""

from __future__ import annotations

import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

PARTS = 2  # run concurrently: this test comes last, when other workers are idle


def test_cpp_units(cpp_units: Path):
    def run(part: int) -> subprocess.CompletedProcess[str]:
        return subprocess.run([cpp_units, f"{part}/{PARTS}"], capture_output=True, text=True, timeout=300)

    with ThreadPoolExecutor(PARTS) as pool:
        parts = list(pool.map(run, range(1, PARTS + 1)))
    said = [line for ran in parts for line in ran.stdout.splitlines()]
    failed = [line.removeprefix("FAILED").strip() for line in said if line.startswith("FAILED")]
    if failed or any(ran.returncode != 0 for ran in parts):
        names = ", ".join(failed) or f"exit codes {[ran.returncode for ran in parts]}"
        ends = "".join(f"\n{ran.stderr[-8000:]}{ran.stdout[-500:]}" for ran in parts)
        pytest.fail(names + ends, pytrace=False)
    assert sum(" 0 failed checks" in line for line in said) == PARTS


def test_the_unit_tests_need_no_mpi(cpp_units: Path):
    needed = subprocess.run(["ldd", cpp_units], capture_output=True, text=True, check=True).stdout
    assert "libstdc++" in needed
    assert "libmpi" not in needed
