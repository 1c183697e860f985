"""Fixtures and options that all tests share: the marker `slow`, C++ programs built once, the cost of jobs."""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import standing
from launching import launches

ROOT = Path(__file__).resolve().parents[1]
SLOW_S = 7200
BUILD_S = 900


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add --slow."""
    parser.addoption(
        "--slow", action="store_true", help="run the slow tests too: repetitions, long random searches"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker `slow`; give jobs the environment of a user's terminal.

    A shell makes its background jobs ignore Ctrl-C. With PYTHONUNBUFFERED, Python writes each line in
    pieces, and Open MPI 5.0.8 mixes the pieces of several ranks.
    """
    # Tests of single actions omit what an animation needs, and motes would warn about that.
    config.addinivalue_line("filterwarnings", "ignore::motes.errors.MotesWarning")
    config.addinivalue_line("markers", "slow: takes long; runs with --slow only")
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.pop("PYTHONUNBUFFERED", None)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip slow tests unless --slow is given; with --slow, give them a longer time limit."""
    for item in items:
        if "slow" in item.keywords:
            wanted = config.getoption("--slow")
            item.add_marker(
                pytest.mark.timeout(SLOW_S) if wanted else pytest.mark.skip(reason="slow: runs with --slow")
            )


def pytest_sessionfinish(session: pytest.Session) -> None:
    """End the standing jobs; in a worker of pytest -n, report the cost of this process's jobs."""
    standing.end()
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["jobs"] = launches.told()


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Add the cost of a worker's jobs."""
    launches.add(getattr(node, "workeroutput", {}).get("jobs"))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the cost of the jobs."""
    for line in launches.lines():
        terminalreporter.write_line(line)


def _tool(name: str) -> str:
    """Find a program; this Python environment takes precedence over PATH."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    found = shutil.which(name, path=path)
    if found is None:
        pytest.skip(f"the C++ programs need {name}: pip install motes[test]")
    return found


def _compiled() -> list[str]:
    """Return CMake's options for reusing the engine that pip compiled from these sources, if there is one.

    pip leaves its build folder below build/; CMake writes the manifest there when installation is complete.
    """
    sources = [ROOT / "CMakeLists.txt", *(ROOT / "cpp").rglob("*")]
    newest = max(path.stat().st_mtime for path in sources)
    for made in (ROOT / "build").glob(f"cp{sys.version_info[0]}{sys.version_info[1]}-*/install_manifest.txt"):
        if made.stat().st_mtime > newest:
            cache = (made.parent / "CMakeCache.txt").read_text()
            (isas,) = re.findall("^MOTES_ISAS:.*=(.*)$", cache, re.MULTILINE)
            return [f"-DMOTES_COMPILED={made.parent}", f"-DMOTES_ISAS={isas}"]
    return ["-DMOTES_COMPILED=", "-DMOTES_ISAS=runnable"]


@cache
def _build(target: str, mpi: str = "mpi") -> Path:
    """Build a C++ target without Python; the build folder is kept for incremental builds.

    The folder is $MOTES_TEST_BUILD, or a folder below build/ per Python environment, whose MPI it uses. One
    that has the module, too, such as build/dev, is not configured again.
    `mpi="smpi"` builds for SimGrid's simulated clusters, in a separate folder. The engine is the one that pip
    compiled, or is compiled with the same options. Sanitizer builds enable assertions.
    """
    if not (ROOT / "CMakeLists.txt").is_file():
        pytest.skip("the C++ programs need the source tree")
    key = hashlib.sha256(sys.prefix.encode()).hexdigest()[:12]
    folder = Path(os.environ.get("MOTES_TEST_BUILD") or ROOT / "build" / f"tests-{key}")
    if mpi != "mpi":
        folder = folder.with_name(f"{folder.name}-{mpi}")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    cmake, ninja = _tool("cmake"), _tool("ninja")
    configure = [
        *(cmake, "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={ninja}"),
        *("-DMOTES_PYTHON=OFF", "-DMOTES_TESTS=ON", "-DMOTES_UNITY=ON", f"-DMOTES_MPI={mpi}", *_compiled()),
        f"-DCMAKE_BUILD_RPATH={sys.prefix}/lib",  # where a program finds the environment's MPI
    ]
    folder.mkdir(parents=True, exist_ok=True)
    cache = folder / "CMakeCache.txt"
    configured = cache.is_file() and "\nMOTES_PYTHON:BOOL=ON\n" in cache.read_text()
    commands = [*([] if configured else [configure]), [cmake, "--build", str(folder), "--target", target]]
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # if two sessions run at once, one builds and the other waits
        for argv in commands:
            made = subprocess.run(
                argv, capture_output=True, text=True, env={**os.environ, "PATH": path}, timeout=BUILD_S
            )
            if made.returncode != 0:
                told = f"{' '.join(argv)}\n{made.stdout[-6000:]}\n{made.stderr[-6000:]}"
                pytest.fail(told, pytrace=False)
    return folder


@pytest.fixture
def children_import_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let processes that a test starts import modules of `tests/support`."""
    path = [str(Path(__file__).parent / "support"), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, path)))


@pytest.fixture(scope="session")
def cpp_units() -> Path:
    """Build the C++ unit tests."""
    return _build("unit_tests") / "tests" / "cpp" / "unit_tests"


@pytest.fixture(scope="session")
def motes_replay() -> Path:
    """Find the driver: $MOTES_TEST_REPLAY, or the one beside this Python; build it if neither exists."""
    installed = Path(os.environ.get("MOTES_TEST_REPLAY") or Path(sys.executable).parent / "motes_replay")
    return installed if installed.is_file() else _build("motes_replay") / "cpp" / "driver" / "motes_replay"


@pytest.fixture(scope="session")
def simulated_replay() -> Path:
    """Build the driver for a simulated cluster."""
    if shutil.which("smpirun") is None:
        if os.environ.get("MOTES_TEST_SIMGRID") == "required":
            pytest.fail("SimGrid's smpirun is absent, and MOTES_TEST_SIMGRID says that it must be there")
        pytest.skip("needs SimGrid: apt-get install libsimgrid-dev")
    return _build("motes_replay", "smpi") / "cpp" / "driver" / "motes_replay"


@pytest.fixture(scope="session")
def abandoned_waits() -> Path:
    """Build the program that abandons waits in a real MPI."""
    return _build("abandoned_waits") / "tests" / "cpp" / "abandoned_waits"


@pytest.fixture(scope="session")
def progress_program() -> Path:
    """Build the program whose ranks compute while messages travel."""
    return _build("progress") / "tests" / "cpp" / "progress"


@pytest.fixture(scope="session")
def losing_program() -> Path:
    """Build the program whose ranks are killed while others wait for them."""
    return _build("losses") / "tests" / "cpp" / "losses"


@pytest.fixture(scope="session")
def native_example() -> Path:
    """Build the example of a user's C++ program."""
    return _build("sparks") / "examples" / "native" / "sparks"
