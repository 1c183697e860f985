"""Importing motes does not change how other pybind11 modules translate exceptions."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

pybind11 = pytest.importorskip("pybind11")

SOURCE = """
#include <pybind11/pybind11.h>
#include <stdexcept>
PYBIND11_MODULE(foreign, m) {
  m.def("refuse", [] { throw std::invalid_argument("x must be 3"); });
}
"""
SCRIPT = """
import motes, foreign
from motes import _core
try:
    foreign.refuse()
except Exception as error:
    print(type(error).__name__)
try:
    _core.Shape("Sphere", [0, 0, 0, -1, 0])
except Exception as error:
    print(type(error).__name__)
"""


@pytest.mark.slow
def test_an_invalid_argument_of_another_module_is_not_ours(tmp_path: Path):
    (tmp_path / "foreign.cpp").write_text(SOURCE)
    module = tmp_path / f"foreign{sysconfig.get_config_var('EXT_SUFFIX')}"
    folders = [f"-I{folder}" for folder in (pybind11.get_include(), sysconfig.get_paths()["include"])]
    compiler = os.environ.get("CXX", "g++")
    flags = ["-std=c++20", "-shared", "-fPIC", "-fvisibility=hidden"]
    subprocess.run(
        [compiler, *flags, *folders, tmp_path / "foreign.cpp", "-o", module], check=True, timeout=300
    )
    path = os.pathsep.join([str(tmp_path), *filter(None, sys.path)])
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert run.stdout.split() == ["ValueError", "ArgumentError"]
