"""docs/extending.md shows real code: each of its blocks is an excerpt from the file that it names."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "extending.md"
QUOTE = re.compile(r"^`([\w./]+)`:\n\n```\w+\n(.*?)\n```$", re.MULTILINE | re.DOTALL)

if not PAGE.is_file():
    pytest.skip("the page stands in the source tree", allow_module_level=True)


def test_every_block_of_code_is_a_piece_of_its_file():
    text = PAGE.read_text()
    quotes = QUOTE.findall(text)
    assert len(quotes) == text.count("\n```\n") == 17, "each block has its file's name above it"
    for path, code in quotes:
        assert f"{code}\n" in (ROOT / path).read_text(), f"{path} has changed: quote it anew\n{code}"


def test_every_file_that_the_page_names_exists():
    named = set(re.findall(r"`((?:cpp|python|tests|docs|\.ci)/[\w./]+)`", PAGE.read_text()))
    assert len(named) >= 10
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []


def test_the_list_is_the_only_place_that_registers():
    """The page says that a new action is one entry: no other file of the core names the action it shows."""
    core = [path for path in (ROOT / "cpp").rglob("*") if path.suffix in (".h", ".cpp", ".inc", ".txt")]
    named = {str(path.relative_to(ROOT)) for path in core if re.search(r"\bwind\b", path.read_text())}
    # Some comments name a user's column `wind`; in code, only the kernel and the list have the word.
    code = {path for path in named if re.search(r"\bwind\b", re.sub(r"//.*", "", (ROOT / path).read_text()))}
    assert code == {"cpp/actions/wind.h", "cpp/actions/list.inc"}


def test_a_law_is_named_where_the_page_says():
    """The core derives everything else about a law between particles from its file and its entry."""
    core = [path for path in (ROOT / "cpp").rglob("*") if path.suffix in (".h", ".cpp", ".inc", ".txt")]
    named = {str(path.relative_to(ROOT)) for path in core if re.search(r"\bfluid\b", code_of(path))}
    assert named == {"cpp/interactions/laws/law_fluid.h", "cpp/actions/list.inc"}


def test_a_family_is_named_where_the_page_says():
    """A class in a file of its own and an entry are all that the core has of a family of actions."""
    core = [path for path in (ROOT / "cpp").rglob("*") if path.suffix in (".h", ".cpp", ".inc", ".cmake")]
    named = {str(path.relative_to(ROOT)) for path in core if re.search(r"\bgravitating\b", code_of(path))}
    assert named == {"cpp/interactions/kinds/gravitating.cpp", "cpp/actions/list.inc"}


def test_the_engine_asks_for_few_kinds():
    """What differs between kinds is told by their classes and facts, not by tests in the engine."""
    engine = [path for path in (ROOT / "cpp" / "engine").rglob("*") if path.suffix in (".h", ".cpp")]
    lines = [line for path in engine for line in path.read_text().splitlines() if "actions::Kind::" in line]
    assert len(lines) <= 4, lines


def code_of(path: Path) -> str:
    return re.sub(r"//.*", "", path.read_text())


def test_a_shape_is_named_where_the_page_says():
    """The core derives everything else about a shape from its line in the list."""
    core = [path for path in (ROOT / "cpp").rglob("*") if path.suffix in (".h", ".cpp", ".inc", ".txt")]
    named = {str(path.relative_to(ROOT)) for path in core if re.search(r"\b(blob|Blob)", code_of(path))}
    table = PAGE.read_text().split("# Adding a shape")[1].split("# Adding a kind of sprite")[0]
    told = {path for path in re.findall(r"`(cpp/[\w./]+)`", table) if path != "cpp/shapes/lanes.h"}
    assert named == told and len(named) == 9


def test_the_compiler_finds_a_shape_that_was_forgotten():
    """No switch over shapes has a default, so the compiler names the kinds that it omits."""
    core = [path for path in (ROOT / "cpp").rglob("*") if path.suffix in (".h", ".cpp")]
    kinds = re.compile(r"case (?:shapes::)?Kind::(?:plane|kind):")
    switches = {path.name: code_of(path) for path in core if kinds.search(code_of(path))}
    assert set(switches) == {
        "visit.h",
        "rare_lanes.cpp",
        "shape.cpp",
        "avoid.h",
        "solids.cpp",
        "cast_scene.cpp",
        "cast_solids.h",
        "nearest.h",
    }
    assert [name for name, code in switches.items() if re.search(r"\bdefault:", code)] == []
