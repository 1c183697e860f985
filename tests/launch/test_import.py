"""`import motes` is quick and starts nothing; names are loaded on first use."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from handmade import moving_spot

import motes
from motes._mpi import rank_process
from motes.cli import LAB

PACKAGE = Path(motes.__file__).parent
ROOT = Path(__file__).resolve().parents[2]
LAUNCHERS = rank_process.LAUNCHED
SHOW = "; import sys, json; print(json.dumps(sorted(sys.modules)))"
COSTLY = {"mpi4py.MPI", "motes._core", "numpy", "pandas", "matplotlib", "argparse"}
SELDOM = {
    *(
        "argparse",
        "asyncio",
        "av",
        "difflib",
        "hashlib",
        "html",
        "logging",
        "matplotlib",
        "pandas",
        "PIL",
        "shutil",
    ),
    *(
        "socket",
        "subprocess",
        "sysconfig",
        "tempfile",
        "motes._checkpoint.finding",
        "motes._checkpoint.saving",
    ),
    *("motes._live.server", "motes._notebook.cells", "motes._run.log_directory", "motes._run.run_file"),
}
"""Modules that only some runs need."""
WORLD = """
import motes
from motes import shapes
camera, ball = motes.Camera((0, 0, 5), (0, 0, 0)), motes.Solid(shapes.Sphere((0, 0, 0), 1))
renderer = motes.Renderer(32, 24, camera=camera, objects=[ball])
world = motes.World(seed=1, progress="off", renderer=renderer)
snow = world.system("snow", capacity=8, sprite=motes.Sprite(height=0.1))
snow.configure(velocity=shapes.Box((0, 0, 0), (1, 1, 1)))"""


def alone(code: str, **changes: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a process without a launcher."""
    env = {name: value for name, value in os.environ.items() if name not in LAUNCHERS}
    job = [sys.executable, "-c", code]
    return subprocess.run(job, capture_output=True, text=True, env=env | changes, timeout=60)


def loaded(code: str, **changes: str) -> set[str]:
    """Run Python and return the modules that it has loaded at the end."""
    made = alone(code + SHOW, **changes)
    assert made.returncode == 0, made.stderr
    return set(json.loads(made.stdout.splitlines()[-1]))


# --- what starts, and when


def test_importing_the_package_starts_nothing():
    assert loaded("import motes") & (COSTLY | {"asyncio", "dataclasses", "inspect", "difflib"}) == set()


def test_values_of_errors_and_the_version_start_nothing():
    code = "import motes; motes.ArgumentError; motes.__version__; dir(motes)"
    assert loaded(code) & (COSTLY - {"argparse"}) == set()


def test_the_core_needs_no_arrays_to_be_loaded():
    assert "numpy" not in loaded("from motes import _core")


def test_a_world_is_made_without_what_only_some_runs_need():
    always = loaded("import numpy, numpy.typing; from mpi4py import MPI")
    found = loaded(WORLD) - always
    assert found & SELDOM == set()
    assert len(found) <= 140  # 139 on Python 3.11; each module adds 0.1 to 2 ms to each rank's start


def test_reading_a_log_needs_neither_mpi_nor_the_core(tmp_path):
    log = moving_spot(tmp_path / "log", frames=3)
    code = f"import motes; run = motes.open_run({str(log)!r}); run.summary(); run.plot.imbalance()"
    assert loaded(code) & {"mpi4py.MPI", "motes._core"} == set()


def test_watching_a_run_needs_neither_mpi_nor_the_core(tmp_path):
    log = moving_spot(tmp_path / "log", frames=3)
    found = loaded(f"from motes.cli import main; main({['watch', '--once', str(log)]!r})")
    assert found & {"mpi4py.MPI", "motes._core", "numpy", "pandas"} == set()


def test_a_report_does_without_the_core(tmp_path):
    """With it, a report replays the run under other balancers."""
    log = moving_spot(tmp_path / "log", frames=3)
    hidden = "import sys; sys.modules['motes.replay.costs'] = None; "  # the module that needs the core
    found = loaded(f"{hidden}from motes.cli import main; main({['report', str(log)]!r})")
    assert found & {"mpi4py.MPI", "motes._core"} == set()


@pytest.mark.parametrize("command", ["run", "bench", "record", "cluster", "doctor"])
def test_help_starts_nothing(command):
    code = f"from motes.cli import main\ntry: main([{command!r}, '--help'])\nexcept SystemExit: pass\n"
    assert loaded(code + "import motes") & {"mpi4py.MPI", "motes._core"} == set()


def test_a_script_loads_nothing_of_the_laboratory():
    assert not [name for name in loaded(WORLD) if name.startswith("motes_lab")]
    assert "motes_lab.workloads" in loaded("import motes; motes.workloads")


WITHOUT = """
import sys
from importlib.machinery import PathFinder
find = PathFinder.find_spec
PathFinder.find_spec = lambda name, *where: None if name == "motes_lab" else find(name, *where)
import motes
from motes.cli import main
"""


@pytest.mark.parametrize("name", ["cluster", "course", "workloads"])
def test_without_the_laboratory_its_names_say_so(name):
    for code in (f"motes.{name}", f"import motes.{name}", f"from motes.{name} import anything"):
        made = alone(f"{WITHOUT}try: {code}\nexcept ImportError as error: print(error)")
        assert made.stdout.startswith(f"motes.{name} needs motes's laboratory"), made.stderr
        assert made.stdout.count("\n") == 1


def test_without_the_laboratory_all_other_names_are_there():
    made = alone(
        f"{WITHOUT}import inspect; inspect.getmembers(motes)\nfrom motes import *\nprint(*dir(motes))"
    )
    assert made.returncode == 0, made.stderr
    assert {*dir(motes)} - {*made.stdout.split()} == {"cluster", "course", "workloads"}


@pytest.mark.parametrize("command", LAB)
def test_without_the_laboratory_its_commands_say_so(command):
    for argv in ([command], [command, "--help"]):
        made = alone(f"{WITHOUT}sys.exit(main({argv!r}))")
        assert (made.returncode, made.stdout) == (2, "")
        assert made.stderr.startswith(f"motes: `motes {command}` needs motes's laboratory")
        assert made.stderr.count("\n") == 1
    assert alone(f"{WITHOUT}main(['--help'])").returncode == 0


@pytest.mark.parametrize(
    "code",
    [
        "import motes; motes.World",
        "from motes import World, Roles",
        "import motes.shapes",
        "from motes.shapes import Box",
        "from motes import _core",
        "from motes import *",
    ],
)
def test_mpi_starts_before_the_core_is_loaded(code):
    found = loaded(code + "; from mpi4py import MPI; assert MPI.Is_initialized()")
    assert {"mpi4py.MPI", "motes._core", "motes._mpi.mpi_settings"} <= found


@pytest.mark.parametrize("name", ["World", "Frame", "Mesh", "shapes", "replay", "_core"])
def test_settings_are_made_before_mpi_starts(name):
    # sys.modules lists modules in the order of their first import. Late settings cost each script that runs
    # without a launcher a second.
    made = alone(f"import motes, sys; motes.{name}; print(*sys.modules)")
    assert made.returncode == 0, made.stderr
    modules = made.stdout.split()
    settings = modules.index("motes._mpi.mpi_settings")
    assert settings < modules.index("mpi4py.MPI")
    assert "numpy" not in modules[:settings]


@pytest.mark.parametrize("variable", LAUNCHERS)
def test_under_a_launcher_mpi_starts_at_once(variable):
    # MPI must not start, since there is no launcher to talk to.
    code = "import mpi4py; mpi4py.rc.initialize = mpi4py.rc.finalize = False; import motes"
    assert {"mpi4py.MPI"} <= loaded(code, **{variable: "1"})


# --- names


def test_all_names_are_listed_and_loaded():
    assert set(motes.__all__) <= set(dir(motes))
    assert [name for name in motes.__all__ if not hasattr(motes, name)] == []
    assert motes.World is motes._world.world.World


def test_checkers_read_the_same_names_as_the_loader():
    imported = {}
    for node in ast.parse((PACKAGE / "__init__.pyi").read_text()).body:
        if isinstance(node, ast.ImportFrom):
            assert all(alias.asname == alias.name for alias in node.names), "else checkers hide the name"
            imported |= {alias.name: node.module for alias in node.names}
    moved = dict.fromkeys(motes._MOVED, "expressions")
    assert imported == {**motes._MODULE_OF, **dict.fromkeys(motes._PUBLIC_MODULES), **moved}
    assert sorted(imported.keys() - moved) == motes.__all__


MOVED = """
import warnings
warnings.simplefilter("always")
import motes
import {modules}
with warnings.catch_warnings(record=True) as told:
    motes.a
    from motes import a, b, time  # line 8
    from motes.expressions import column as new
    assert motes.column is new and motes.b is b
    a, b, time, motes.a, motes.column
print([(str(w.message), w.category.__name__, w.filename, w.lineno) for w in told])
"""


def test_names_of_expressions_warn_once_at_the_top_level():
    everything = sorted(
        ".".join(["motes", *path.relative_to(PACKAGE).with_suffix("").parts])
        for path in PACKAGE.rglob("*.py")
        if "__" not in path.name and not {"peers", "_examples"} & {*path.parts}
    )
    made = alone(MOVED.format(modules=", ".join(everything)))
    assert made.returncode == 0, made.stderr
    told = ast.literal_eval(made.stdout.splitlines()[-1])
    lines = {"a": 7, "b": 8, "time": 8, "column": 10}
    assert [(name, row[3]) for name, row in zip(lines, told, strict=True)] == [*lines.items()]
    for name, (message, kind, file, _) in zip(lines, told, strict=True):
        assert message.startswith(f"motes.{name} is now motes.expressions.{name}; ")
        assert (kind, file) == ("DeprecationWarning", "<string>")
    assert "DeprecationWarning: motes" not in made.stderr, "the package uses the new names"


def test_names_that_have_moved_are_still_found_but_not_listed():
    for name in motes._MOVED:
        with pytest.warns(DeprecationWarning, match=rf"motes\.{name} is now motes\.expressions\.{name};"):
            vars(motes).pop(name, None)
            found = getattr(motes, name)
        assert found is getattr(motes.expressions, name)
        assert getattr(motes, name) is found, "the second time without a warning"
        del vars(motes)[name]
        assert name not in motes.__all__ and name not in dir(motes)
    found = {}
    exec("from motes import *", found)
    assert "column" not in found and "World" in found


OLD_NAMES = rf"\bmotes\.({'|'.join(motes._MOVED)})\b|from motes import .*\b({'|'.join(motes._MOVED)})\b"


@pytest.mark.parametrize("folder", ["cpp", "docs", "examples", "python", "tests"])
def test_nothing_here_uses_names_that_have_moved(folder: str):
    texts = [
        path for path in (ROOT / folder).rglob("*") if path.suffix in (".py", ".md", ".ipynb", ".h", ".cpp")
    ]
    if not texts:
        pytest.skip("the folder stands in the source tree")
    own = {Path(__file__), ROOT / "docs" / "files" / "CHANGELOG.md"}
    assert [str(path) for path in texts if path not in own and re.search(OLD_NAMES, path.read_text())] == []


def test_a_mistyped_name_is_answered_with_the_nearest():
    with pytest.raises(AttributeError, match="no attribute 'Wrold'; did you mean 'World'"):
        _ = motes.Wrold
    with pytest.raises(ImportError, match="Pairwize"):
        exec("from motes import Pairwize")
