"""Rooms of the C++ core: each folder includes only those below it, and keeps MPI and pybind11 out."""

from __future__ import annotations

import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

CPP = Path(__file__).resolve().parents[1] / "cpp"
MOST_FILES = 40
pytestmark = pytest.mark.skipif(not CPP.is_dir(), reason="the rooms are those of the source tree")


def includes() -> dict[Path, set[str]]:
    """Return what each file includes: paths below `cpp`, and headers of libraries."""
    files = [path for path in CPP.rglob("*") if path.suffix in (".h", ".cpp", ".inc")]
    find = re.compile(r'^#include ["<]([^">]+)[">]', re.MULTILINE)
    return {path.relative_to(CPP): set(find.findall(path.read_text())) for path in files}


def rooms(files: dict[Path, set[str]]) -> dict[Path, set[Path]]:
    """Return which rooms each room includes."""
    below: dict[Path, set[Path]] = {path.parent: set() for path in files}
    for path, names in files.items():
        below[path.parent] |= {Path(name).parent for name in names if Path(name) in files} - {path.parent}
    return below


def circle(below: dict[Path, set[Path]]) -> list[Path]:
    """Return the rooms of a circle, in order; nothing where there is none."""
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


def test_a_room_fits_on_a_screen():
    count = {room: sum(path.parent == room for path in includes()) for room in rooms(includes())}
    assert {room: files for room, files in count.items() if files > MOST_FILES} == {}


@pytest.mark.parametrize(
    ("header", "allowed"),
    [(r"mpi\.h|mpi-ext\.h|smpi/.*", {"comm"}), (r"pybind11/.*|Python\.h", {"bindings"})],
    ids=["MPI", "pybind11"],
)
def test_libraries_of_one_room_stay_in_it(header: str, allowed: set[str]):
    files = includes()
    used = {
        path.parts[0] for path, names in files.items() if any(re.fullmatch(header, name) for name in names)
    }
    assert used == allowed


def test_what_a_folder_is_for_stands_in_architecture():
    text = (CPP.parent / "ARCHITECTURE.md").read_text()
    missing = [room for room in rooms(includes()) if f"| `cpp/{room}` |" not in text]
    assert missing == []


def test_each_word_of_the_glossary_leads_to_its_place():
    text = (CPP.parent / "docs" / "glossary.md").read_text()
    entries = re.findall(r"^\|.*\| `([\w/.]+)` \| `(\w+)` \|$", text, re.MULTILINE)
    assert len(entries) == sum(line.startswith("| ") for line in text.splitlines()) - 4  # heads of tables
    for path, name in entries:
        assert re.search(rf"\b{name}\b", (CPP.parent / path).read_text()), f"{path} has no {name}"
