"""`import motes` is quick and starts nothing; names are loaded when they are used; rooms know their place."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from handmade import moving_spot

import motes
from motes._run import rank_process

PACKAGE = Path(motes.__file__).parent
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
"""What only some runs need."""
WORLD = """
import motes
from motes import shapes
camera, ball = motes.Camera((0, 0, 5), (0, 0, 0)), motes.Solid(shapes.Sphere((0, 0, 0), 1))
renderer = motes.Renderer(32, 24, camera=camera, objects=[ball])
world = motes.World(seed=1, progress="off", renderer=renderer)
snow = world.system("snow", capacity=8, sprite=motes.Sprite(height=0.1))
snow.configure(velocity=shapes.Box((0, 0, 0), (1, 1, 1)))"""


def alone(code: str, **changes: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a process that no launcher started."""
    env = {name: value for name, value in os.environ.items() if name not in LAUNCHERS}
    job = [sys.executable, "-c", code]
    return subprocess.run(job, capture_output=True, text=True, env=env | changes, timeout=60)


def loaded(code: str, **changes: str) -> set[str]:
    """Run Python and return the modules that are then loaded."""
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
    assert len(found) <= 125  # 115 on Python 3.11: each module takes 0.1 to 2 ms of each rank's start


def test_reading_a_log_needs_neither_mpi_nor_the_core(tmp_path):
    log = moving_spot(tmp_path / "log", frames=3)
    code = f"import motes; run = motes.open_run({str(log)!r}); run.summary(); run.plot.imbalance()"
    assert loaded(code) & {"mpi4py.MPI", "motes._core"} == set()


@pytest.mark.parametrize("command", [["watch", "--once"], ["report"]])
def test_commands_that_read_logs_need_neither_mpi_nor_the_core(tmp_path, command):
    log = moving_spot(tmp_path / "log", frames=3)
    found = loaded(f"from motes.cli import main; main({[*command, str(log)]!r})")
    assert found & {"mpi4py.MPI", "motes._core"} == set()
    if command[0] == "watch":
        assert found & {"numpy", "pandas"} == set()


@pytest.mark.parametrize("command", ["run", "bench", "record", "cluster", "doctor"])
def test_help_starts_nothing(command):
    code = f"from motes.cli import main\ntry: main([{command!r}, '--help'])\nexcept SystemExit: pass\n"
    assert loaded(code + "import motes") & {"mpi4py.MPI", "motes._core"} == set()


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
    assert {"mpi4py.MPI", "motes._core", "motes._run.mpi_settings"} <= found


@pytest.mark.parametrize("name", ["World", "Frame", "Mesh", "shapes", "replay", "_core"])
def test_settings_are_made_before_mpi_starts(name):
    # Modules stand in sys.modules in the order of their first import. Settings made later cost each script
    # that runs without a launcher a second.
    made = alone(f"import motes, sys; motes.{name}; print(*sys.modules)")
    assert made.returncode == 0, made.stderr
    modules = made.stdout.split()
    settings = modules.index("motes._run.mpi_settings")
    assert settings < modules.index("mpi4py.MPI")
    assert "numpy" not in modules[:settings]


@pytest.mark.parametrize("variable", LAUNCHERS)
def test_under_a_launcher_mpi_starts_at_once(variable):
    # MPI must not start, since there is no launcher to talk to; a size of 1 says that nobody else waits.
    code = "import mpi4py; mpi4py.rc.initialize = mpi4py.rc.finalize = False; import motes"
    assert {"mpi4py.MPI"} <= loaded(code, **{variable: "1"})


# --- names


def test_all_names_are_listed_and_loaded():
    assert set(motes.__all__) <= set(dir(motes))
    assert [name for name in motes.__all__ if not hasattr(motes, name)] == []
    assert motes.World is motes.world.World


def test_checkers_read_the_same_names_as_the_loader():
    tree = ast.parse((PACKAGE / "__init__.py").read_text())
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imported = {}
    for node in block.body:
        if isinstance(node, ast.ImportFrom):
            imported |= {alias.name: node.module for alias in node.names}
    assert imported == {**motes._MODULE_OF, **dict.fromkeys(motes._PUBLIC_MODULES)}
    assert sorted(imported) == motes.__all__


def test_a_mistyped_name_is_answered_with_the_nearest():
    with pytest.raises(AttributeError, match="no attribute 'Wrold'; did you mean 'World'"):
        _ = motes.Wrold
    with pytest.raises(ImportError, match="Pairwize"):
        exec("from motes import Pairwize")


# --- rooms


def imports(path: Path, *, later: bool = False) -> set[str]:
    """List the modules of this package that a file imports; `later`: also those that its functions import."""
    here = path.relative_to(PACKAGE).with_suffix("").parts
    package = here[:-1]
    found = set()
    for node in _nodes(ast.parse(path.read_text()), later):
        if not isinstance(node, ast.ImportFrom) or node.level == 0:
            continue
        base = (*package[: len(package) - node.level + 1], *(node.module or "").split("."))
        base = tuple(part for part in base if part)
        for alias in node.names:
            whole = PACKAGE.joinpath(*base, alias.name)
            is_module = whole.is_dir() or whole.with_suffix(".py").is_file() or alias.name == "_core"
            found.add(".".join((*base, alias.name) if is_module else base))
    return found


def _nodes(tree: ast.AST, later: bool) -> list[ast.AST]:
    """List the nodes of a file but those for type checkers, and those in functions only where asked."""
    nodes = []
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and not later:
            continue
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        nodes += [node, *_nodes(node, later)]
    return nodes


def modules(*, later: bool = False) -> dict[str, set[str]]:
    """Map each module of the package to those that it imports."""
    graph = {}
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        name = ".".join(part for part in parts if part != "__init__")
        graph[name] = imports(path, later=later)
    return graph


def reached(graph: dict[str, set[str]], start: str) -> set[str]:
    """All modules that importing one of them loads, packages on the way included."""
    seen, waiting = set(), [start]
    while waiting:
        for name in graph.get(waiting.pop(), ()):
            parts = name.split(".")
            for one in (".".join(parts[: i + 1]) for i in range(len(parts))):
                if one not in seen:
                    seen.add(one)
                    waiting.append(one)
    return seen


ROOMS = ("analysis", "bench", "cli", "cluster", "replay", "_io")


def test_modules_of_the_rooms_do_not_import_each_other_in_circles():
    graph = modules(later=True)
    for name in graph:
        if name.split(".")[0] in ROOMS:
            seen, waiting = set(), list(graph[name])
            while waiting:
                one = waiting.pop()
                if one not in seen:
                    seen.add(one)
                    waiting += graph.get(one, ())
            assert name not in seen, f"{name} imports itself by way of {sorted(seen)}"


def test_rooms_know_their_place():
    graph = modules()
    for name in graph:
        room = name.split(".")[0]
        found = reached(graph, name)
        if room == "analysis":
            assert not found & {"_core", "replay", "world", "cli", "cluster"}, name
        if room == "replay":
            assert not found & {"analysis", "world", "cli"}, name
        if room == "_io":
            assert not found - {"_io"}, name
        if room != "cli" and name != "__main__":
            assert "cli" not in found, name


def test_only_the_command_line_prints_usage():
    others = ("options.py", "script.py", "overhead.py", "paths.py")
    for path in PACKAGE.rglob("*.py"):
        if "cli" not in path.parts and path.name not in others:
            assert "argparse" not in path.read_text(), path
