"""Rooms: each folder includes or imports only those below it, and has a limited number of files."""

from __future__ import annotations

import ast
import re
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import TypeVar

import imports
import pytest
from imports import LABORATORY, PACKAGE

CPP = Path(__file__).resolve().parents[2] / "cpp"
MOST_FILES = 40
Room = TypeVar("Room", str, Path)
KNOWN_BY_TYPE = {  # these use names from above only as types
    "_system": {"_world"},
    "actions": {"_system"},
    "analysis._plots": {"analysis"},
}
pytestmark = pytest.mark.skipif(not CPP.is_dir(), reason="the rooms are those of the source tree")


def includes() -> dict[Path, set[str]]:
    """Return the includes of each file: paths below `cpp`, and library headers."""
    files = [path for path in CPP.rglob("*") if path.suffix in (".h", ".cpp", ".inc")]
    find = re.compile(r'^#include ["<]([^">]+)[">]', re.MULTILINE)
    return {path.relative_to(CPP): set(find.findall(path.read_text())) for path in files}


def rooms(files: dict[Path, set[str]]) -> dict[Path, set[Path]]:
    """Return which rooms each room includes."""
    below: dict[Path, set[Path]] = {path.parent: set() for path in files}
    for path, names in files.items():
        below[path.parent] |= {Path(name).parent for name in names if Path(name) in files} - {path.parent}
    return below


def circle(below: dict[Room, set[Room]]) -> list[Room]:
    """Return the rooms of a cycle in order, or [] if there is none."""
    try:
        TopologicalSorter(below).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_rooms_do_not_include_each_other_in_circles():
    below = rooms(includes())
    assert len(below) > 25
    assert circle(below) == []
    assert circle({**below, Path("base"): {Path("engine")}}) != []


def test_the_engine_includes_nothing_of_the_laboratory():
    assert knowing_the_laboratory(includes()) == []
    assert knowing_the_laboratory({Path("engine/engine.h"): {"lab/soak/story.h"}}) == [
        Path("engine/engine.h")
    ]


def knowing_the_laboratory(files: dict[Path, set[str]]) -> list[Path]:
    """Return the files outside `lab` that include one inside."""
    engine = {path: names for path, names in files.items() if path.parts[0] != "lab"}
    return [path for path, names in engine.items() if any(name.startswith("lab/") for name in names)]


def test_files_of_interactions_do_not_include_each_other_in_circles():
    below: dict[Path, set[Path]] = {}
    for path, names in includes().items():
        if path.parts[0] == "interactions":
            units = {Path(name).with_suffix("") for name in names if name.startswith("interactions/")}
            below.setdefault(path.with_suffix(""), set()).update(units - {path.with_suffix("")})
    assert len(below) > 25
    assert circle(below) == []


def test_rooms_of_the_package_do_not_import_each_other_in_circles():
    below = imports.rooms(imports.modules(imports.START, imports.LATER))
    assert len(below) > 20
    assert circle(below) == []
    assert circle({**below, "_values": {"_world"}}) != []


def test_rooms_of_the_laboratory_do_not_import_each_other_in_circles():
    graph = imports.modules(imports.START, imports.LATER, imports.TYPES, package=LABORATORY)
    below = {room.split(".")[0]: set[str]() for room in graph}
    for name, others in graph.items():
        below[name.split(".")[0]] |= {one.split(".")[0] for one in others} - {name.split(".")[0]}
    assert len(below) > 5
    assert circle(below) == []


def test_rooms_of_the_package_name_few_types_of_those_above():
    below = imports.rooms(imports.modules(imports.START, imports.LATER))
    for room, others in imports.rooms(imports.modules(imports.TYPES)).items():
        above = {one for one in others if not reaches(below, room, one) and reaches(below, one, room)}
        assert above == KNOWN_BY_TYPE.get(room, set()), room


def reaches(below: dict[str, set[str]], start: str, end: str) -> bool:
    """Return whether a room imports another (or itself), directly or through others."""
    seen, waiting = set(), [start]
    while waiting:
        new = below.get(waiting.pop(), set()) - seen
        seen |= new
        waiting += new
    return end in seen


def test_modules_do_not_import_each_other_in_circles():
    graph = imports.modules(imports.START, imports.LATER)
    found = {name for name in graph if reaches(graph, name, name)}
    values = ("_arrays", "_conditions", "_expression", "_functions", "_numpy_calls")
    assert found == {
        *(f"expressions.{name}" for name in values),
        "shapes",
        "shapes._mesh",
        "shapes._outlines",
    }  # expressions and conditions are built from each other; shapes has Mesh, a shape, and shapes made of it


def test_rooms_know_their_place():
    graph = imports.modules()
    for name in graph:
        room = name.split(".")[0]
        found = imports.reached(graph, name)
        if room == "analysis":
            assert not found & {"_core", "replay", "_world", "cli"}, name
        if room == "replay":
            assert not found & {"analysis", "_world", "cli"}, name
        if room == "_io":
            assert not found - {"_io"}, name
        if room != "cli" and name != "__main__":
            assert "cli" not in found, name


PUBLIC_WITH_UNDERSCORE = {"_exit", "_getframe", "_replace", "_asdict", "_make"}  # Python's own
ARGPARSE = {  # argparse has no public way to read these
    Path("motes", "_values", "options.py"): {"_SubParsersAction", "_actions", "_option_string_actions"},
    Path("motes_lab", "cli", "parser.py"): {"_SubParsersAction"},
}


def private_names(path: Path) -> set[str]:
    """Return the private names that a module uses but does not define."""
    tree = ast.parse(path.read_text())
    own, used = set(PUBLIC_WITH_UNDERSCORE), set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            own.add(node.name)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            own.add(node.target.id)
        elif isinstance(node, ast.Attribute) and re.match("_[^_]", node.attr):
            (own if ast.unparse(node.value) in ("self", "cls") else used).add(node.attr)
    return used - own


def test_modules_do_not_use_private_names_of_each_other(tmp_path: Path):
    files = [*PACKAGE.rglob("*.py"), *LABORATORY.rglob("*.py")]
    found = {path.relative_to(PACKAGE.parent): private_names(path) for path in files}
    assert {path: names for path, names in found.items() if names} == ARGPARSE
    (tmp_path / "a.py").write_text("def f(world): world._run(); return world._replace()")
    assert private_names(tmp_path / "a.py") == {"_run"}


def test_only_the_command_line_prints_usage():
    others = ("options.py", "script.py", "overhead.py", "paths.py")
    for path in (*PACKAGE.rglob("*.py"), *LABORATORY.rglob("*.py")):
        if "cli" not in path.parts and path.name not in others:
            assert "argparse" not in path.read_text(), path


@pytest.mark.parametrize("folder", ["cpp", "docs", "examples", "python", "tests"])
def test_a_room_fits_on_a_screen(folder: str):
    found = [path for path in (CPP.parent / folder).rglob("*") if path.is_file() and not is_made(path)]
    count = Counter(path.parent.relative_to(CPP.parent) for path in found)
    assert {str(room): files for room, files in count.items() if files > MOST_FILES} == {}


def is_made(path: Path) -> bool:
    """Return whether a build or a run made the file; such files are not in the repository."""
    pages = any(path.is_relative_to(CPP.parent / "docs" / name) for name in ("files", "reference"))
    return pages or "__pycache__" in path.parts or path.suffix == ".so"


@pytest.mark.parametrize(
    ("header", "allowed"),
    [
        (r"mpi\.h|mpi-ext\.h|smpi/.*", set()),  # the engine has its own, one per ABI
        (r"comm/mpi/.*", {"comm"}),
        (r"pybind11/.*|Python\.h", {"bindings"}),
    ],
    ids=["MPI", "ABIs", "pybind11"],
)
def test_libraries_of_one_room_stay_in_it(header: str, allowed: set[str]):
    files = includes()
    used = {
        path.parts[0] for path, names in files.items() if any(re.fullmatch(header, name) for name in names)
    }
    assert used == allowed


def test_what_a_folder_is_for_stands_in_architecture():
    text = (CPP.parent / "ARCHITECTURE.md").read_text()
    folders = {path.parent for package in (PACKAGE, LABORATORY) for path in package.glob("*/__init__.py")}
    missing = [room for room in rooms(includes()) if f"| `cpp/{room}` |" not in text]
    missing += [room for room in folders if f"| `python/{room.relative_to(PACKAGE.parent)}` |" not in text]
    assert missing == []


def test_architecture_lists_rooms_of_the_package_below_those_that_they_import():
    text = (CPP.parent / "ARCHITECTURE.md").read_text()
    listed = re.findall(r"^\| `python/motes/(\w+)` \|", text, re.MULTILINE)
    graph = imports.rooms(imports.modules(imports.START, imports.LATER))
    above = [(one.split(".")[0], room.split(".")[0]) for room, others in graph.items() for one in others]
    for one, room in above:
        if one != room and {one, room} <= set(listed):
            assert listed.index(one) < listed.index(room), f"{room} imports {one}"


def test_each_word_of_the_glossary_leads_to_its_place():
    text = (CPP.parent / "docs" / "glossary.md").read_text()
    entries = re.findall(r"^\|.*\| `([\w/.]+)` \| `(\w+)` \|$", text, re.MULTILINE)
    assert len(entries) == sum(line.startswith("| ") for line in text.splitlines()) - 4  # table heads
    for path, name in entries:
        assert re.search(rf"\b{name}\b", (CPP.parent / path).read_text()), f"{path} has no {name}"


def test_files_that_comments_name_are_there():
    """A comment that names a file names an existing one: `shapes/box.h`, or just `box.h`."""
    root = CPP.parent
    sources = [*CPP.rglob("*"), *(root / "tests" / "cpp").rglob("*")]
    ends = [f"/{path.relative_to(root)}" for path in sources if path.suffix in (".h", ".cpp", ".inc")]
    find = re.compile(r"(?<![\w/.])((?:\w+/)*\w+\.(?:h|cpp|inc))\b")
    gone = [
        f"{path}: {name}"
        for path in ends
        for line in (root / path[1:]).read_text().splitlines()
        for name in find.findall(line.partition("//")[2])
        if not any(other.endswith(f"/{name}") for other in ends)
    ]
    assert gone == []


NAMED_ALIKE = {  # in each room that has one, or as a kind of sprites is named in scripts
    *("Channels", "Spread"),  # one for wide vectors, one for narrow ones
    *("Kernels", "Kind", "Options", "Value"),
    *("Mesh", "Picture"),
}


def defined_types(headers: dict[str, str]) -> Counter[str]:
    """Count how often headers define a type of each name."""
    find = re.compile(r"^(?:struct|class|enum class|using) (\w+)(?: final)?(?: :| \{| =)", re.MULTILINE)
    return Counter(name for text in headers.values() for name in find.findall(text))


def test_the_name_of_a_type_has_one_meaning():
    found = defined_types({str(path): path.read_text() for path in CPP.rglob("*.h")})
    assert len(found) > 400
    alike = {name for name, times in found.items() if times > 1 and not name.startswith("MPI_")}  # per ABI
    assert alike == NAMED_ALIKE
    assert defined_types({"a.h": "struct Place {\n", "b.h": "class Place final : Base {\n"}) == {"Place": 2}
