"""The settings of `.ci/run` agree with the project."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
import tomllib
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
LOWEST = ROOT / ".ci" / "lowest.txt"
pytestmark = pytest.mark.skipif(not LOWEST.is_file(), reason="the checks need the source tree")


def numbers(version: str) -> list[int]:
    return [int(part) for part in version.split(".")]


def test_the_oldest_dependencies_are_those_that_pyproject_allows():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    wanted = [*project["build-system"]["requires"], *project["project"].get("dependencies", [])]
    extras = project["project"]["optional-dependencies"]
    beside = ("docs", "lint", "peers")  # extras that document, lint or compare the package
    wanted += [one for name, ones in extras.items() if name not in beside for one in ones]
    for table in project["tool"].get("dynamic-metadata", []):  # dependencies chosen during the build
        wanted += [one for ones in table.values() if isinstance(ones, list) for one in ones]
    oldest = dict(re.findall(r"^([\w-]+)==([\d.]+)$", LOWEST.read_text(), re.MULTILINE))
    allowed = dict(re.fullmatch(r"([\w-]+)(?:\[\w+\])?[>=]=([\d.]+)", one).groups() for one in wanted)
    assert set(oldest) == set(allowed)
    for name, bound in allowed.items():
        assert numbers(oldest[name])[: len(numbers(bound))] == numbers(bound), f"{name} {oldest[name]}"


def test_requirements_of_an_extra():
    argv = [sys.executable, ROOT / ".ci" / "requirements", "video", "lint"]
    lines = subprocess.run(argv, capture_output=True, text=True, check=True).stdout.splitlines()
    assert lines[0].startswith("av>=")
    assert any(line.startswith("ruff==") for line in lines)


def mutations() -> ModuleType:
    loader = SourceFileLoader("mutations", str(ROOT / ".ci" / "mutations"))
    spec = importlib.util.spec_from_loader(loader.name, loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


def test_each_mutation_changes_a_line_that_is_there_once_and_names_a_test_that_is_there():
    found = mutations().mutations()
    assert mutations().faults(found) == []
    folders = {path.name for path in (ROOT / "cpp").iterdir() if path.is_dir()}
    assert folders <= {Path(one.file).parts[1] for one in found if "/" in one.file}


def test_what_is_wrong_with_a_mutation_is_named():
    module = mutations()
    one = module.mutations()[0]
    wrong = [one._replace(line="no such line"), one._replace(file="cpp/no_such_file.cpp")]
    wrong += [
        one._replace(test=test) for test in ("no_such_test", "tests/source/test_checks.py::test_no_such_test")
    ]
    assert len(module.faults(wrong)) == len(wrong)


def test_no_mutation_is_tried_on_what_another_left(tmp_path, monkeypatch, capsys):
    """What does not compile is not found, and those of Python are compiled like those of the core."""
    module = mutations()
    monkeypatch.setattr(module, "COPY", tmp_path)
    (tmp_path / "cpp").mkdir()
    for name in ("one.py", "cpp/one.cpp"):
        (tmp_path / name).write_text("a = 1")
    steps = []

    def compiled(targets):
        steps.append(",".join(targets))
        return "one.cpp:1: error: no b" if "b" in (tmp_path / "cpp" / "one.cpp").read_text() else ""

    monkeypatch.setattr(module, "compiled", compiled)
    monkeypatch.setattr(module, "failure", lambda test: steps.append(test) or "1 failed")
    good = module.Mutation("good", "one.py", "a", "b", "test_one.py::test_one")
    assert module.found(good)
    assert not module.found(good._replace(instead="b ="))
    assert not module.found(good._replace(file="cpp/one.cpp"))
    assert steps == ["_core,motes_replay", good.test, "_core,motes_replay"]
    told = capsys.readouterr().out
    assert told.count("NOT FOUND") == told.count("it does not compile: error: ") == 2
    assert "error: no b" in told and (tmp_path / "one.py").read_text() == "a = 1"


def test_no_two_files_of_tests_have_the_same_name():
    """Otherwise pytest collects only one of them."""
    names = [path.name for path in (ROOT / "tests").rglob("test_*.py")]
    assert sorted(names) == sorted(set(names))
