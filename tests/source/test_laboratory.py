"""The engine does not know the laboratory, which uses few private names of the engine."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ENGINE, LABORATORY = ROOT / "python" / "motes", ROOT / "python" / "motes_lab"
WAY = ENGINE / "_extras.py"
"""The one module of the engine that leads to the laboratory."""
ALLOWED = {
    "motes._core": "what it measures and torments; tables of loads, for policies in other processes",
    "motes._extras": "where pandas, matplotlib or websockets is missing, it says the same as the engine",
    "motes._interchange.formats.FORMATS": "a benchmark times each format alone, without a run",
    "motes._io.files": "it writes leagues and programs whole or not at all",
    "motes._values.arguments": "its workloads, machines and clusters check what they are given",
    "motes._values.environment": "the table of all variables has two for SimGrid",
    "motes._world.recovering.EVERY": "a benchmark takes apart the frames between two replicas",
    "motes._world.world.session_of": "benchmarks time single calls of the engine behind a world",
}
"""Private names of the engine that the laboratory may import, and what for. Users need none of them."""
MOST_IMPORTS = 12

if not LABORATORY.is_dir():
    pytest.skip("needs the source tree", allow_module_level=True)


def imported(path: Path, root: Path) -> Iterator[str]:
    """Yield the full name of everything that a module imports, and of what it takes from `motes` by a dot."""
    package = path.relative_to(root).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = (*package[: len(package) - node.level + 1], node.module) if node.level else (node.module,)
            yield from (".".join((*filter(None, base), alias.name)) for alias in node.names)
        elif isinstance(node, ast.Attribute) and ast.unparse(node).startswith("motes._"):
            yield ast.unparse(node)


def private(path: Path, root: Path) -> list[str]:
    """Return the engine's private names that a module imports."""
    return [name for name in imported(path, root) if re.match(r"motes\.(.*\.)?_[a-z]", name)]


def test_the_laboratory_uses_only_the_private_names_that_are_listed():
    found = [name for path in LABORATORY.rglob("*.py") for name in private(path, ROOT / "python")]
    assert set(found) == set(ALLOWED)
    assert len(found) <= MOST_IMPORTS


@pytest.mark.parametrize(
    ("code", "name"),
    [
        ("from motes._run import losses", "motes._run.losses"),
        ("import motes._run.losses", "motes._run.losses"),
        ("from motes.balance._options import MOST", "motes.balance._options.MOST"),
        ("def f():\n    from motes import World, _core", "motes._core"),
        ("import motes\nmotes._core", "motes._core"),
    ],
)
def test_a_private_name_is_found_however_it_is_imported(code: str, name: str, tmp_path: Path):
    (tmp_path / "motes_lab").mkdir()
    path = tmp_path / "motes_lab" / "a.py"
    path.write_text(f"from motes import World\nfrom ._engine import arguments\n{code}\n")
    assert private(path, tmp_path) == [name]


def test_the_engine_does_not_import_the_laboratory():
    for path in ENGINE.rglob("*.py"):
        assert not [name for name in imported(path, ENGINE.parent) if name.startswith("motes_lab")], path
        assert path == WAY or "motes_lab" not in path.read_text(), path


def test_only_tests_of_the_laboratory_import_it():
    tests = [path for path in (ROOT / "tests").rglob("*.py") if "lab" not in path.relative_to(ROOT).parts]
    assert len(tests) > 100
    found = {path: [name for name in imported(path, ROOT) if name.startswith("motes_lab")] for path in tests}
    assert {path: names for path, names in found.items() if names} == {}
