"""The door for who comes next: `./dev`, the tests it picks, messages of commits, pages that name commands."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

import pytest

from motes.cli import COMMANDS, LAB

ROOT = Path(__file__).resolve().parents[2]
DEV = ROOT / "dev"
PAGES = ["CONTRIBUTING.md", "docs/releasing.md", ".github/pull_request_template.md"]
TOOLS = ("cmake", "ruff", "clang-format", "mypy")
pytestmark = pytest.mark.skipif(not DEV.is_file(), reason="the door is that of the source tree")


def script(name: str) -> ModuleType:
    """Load a script of `.ci`."""
    spec = spec_from_loader(name, SourceFileLoader(name, str(ROOT / ".ci" / name)))
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def dev(*words: str, folder: Path = ROOT, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run `./dev` of a folder."""
    job = [folder / "dev", *words]
    return subprocess.run(job, capture_output=True, text=True, timeout=60, env={**os.environ, **variables})


def words() -> list[str]:
    """Return the words that `./dev` explains."""
    return re.findall(r"^  (\w+)  ", dev("help").stdout, re.MULTILINE)


# --- ./dev


def test_help_explains_the_words_that_are_there():
    told = dev("--help")
    assert told.returncode == 0 and told.stdout == dev("help").stdout
    assert words() == ["build", "test", "check", "all"]
    cases = DEV.read_text().partition("\ncase ")[2]
    assert [word for word in words() if f":{word})" not in cases] == []


@pytest.mark.parametrize(
    "given", [(), ("biuld",), ("build", "now"), ("check", "pictures"), ("all", "of", "it")]
)
def test_wrong_words_get_a_sentence(given):
    told = dev(*given)
    assert told.returncode == 2 and told.stdout == ""
    assert told.stderr.endswith(dev("help").stdout)
    assert f"'{' '.join(given)}'" in told.stderr or not given


def test_a_wrong_room_gets_a_sentence_before_anything_is_built():
    told = dev("test", "picturs")
    assert told.returncode == 2 and told.stdout == ""
    assert "there is no room 'picturs'; did you mean pictures? The rooms are " in told.stderr


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Make a tree with `./dev` and an environment whose tools write down how they are called."""
    (tmp_path / "dev").write_bytes(DEV.read_bytes())
    (tmp_path / "dev").chmod(0o755)
    (tmp_path / ".ci").symlink_to(ROOT / ".ci")
    (tmp_path / "tests").symlink_to(ROOT / "tests")
    (tmp_path / "env" / "bin").mkdir(parents=True)
    for tool in (*TOOLS, "python"):
        path = tmp_path / "env" / "bin" / tool
        path.write_text(f"""#!/bin/sh
echo "{tool} $*" >> {tmp_path}/calls
case "$*" in .ci/requirements*) echo numpy ;; .ci/rooms) echo tests/source; echo tests/pictures ;; esac
case "{tool} $*" in $FAILS*) exit 1 ;; esac
""")
        path.chmod(0o755)
    return tmp_path


def calls(tree: Path) -> str:
    return (tree / "calls").read_text()


def run(tree: Path, *given: str, fails: str = "nothing") -> subprocess.CompletedProcess[str]:
    return dev(*given, folder=tree, VIRTUAL_ENV=str(tree / "env"), FAILS=fails)


def test_check_passes_if_each_step_does(tree):
    told = run(tree, "check")
    assert told.returncode == 0, told.stdout + told.stderr
    ran = calls(tree)
    for call in (
        "cmake --build",
        "ruff check",
        "ruff format --check",
        "clang-format",
        "mypy",
        "python .ci/stubs",
    ):
        assert f"\n{call}" in ran
    assert "python -m pytest -q -n 2 --dist loadfile tests/pictures\n" in ran


@pytest.mark.parametrize(
    "fails",
    ["cmake --build", "ruff format", "clang-format", "mypy", "python .ci/subjects", "python -m pytest"],
)
def test_check_fails_if_a_step_does_and_runs_the_others(tree, fails):
    told = run(tree, "check", fails=fails)
    assert told.returncode == 1
    assert "FAILED after" in told.stdout
    assert "python -m pytest" in calls(tree)


def test_check_says_which_tests_it_has_no_time_for(tree):
    path = tree / "dev"
    path.write_text(path.read_text().replace("most_s=200", "most_s=-1"))
    told = run(tree, "check")
    assert told.returncode == 0 and "-m pytest" not in calls(tree)
    assert "no time was left for tests/source tests/pictures" in told.stdout


def test_packages_are_installed_once(tree):
    assert run(tree, "build").returncode == 0
    assert calls(tree).count("pip install") == 1
    assert run(tree, "build").returncode == 0
    assert calls(tree).count("pip install") == 1
    (tree / "env" / "dev-requirements.txt").unlink()
    assert run(tree, "build", fails="python -m pip").returncode == 1
    assert not (tree / "env" / "dev-requirements.txt").exists()


def test_tests_of_a_room_run_after_a_build(tree):
    units = tree / "build" / "dev" / "tests" / "cpp" / "unit_tests"
    units.parent.mkdir(parents=True)
    units.write_text(f'#!/bin/sh\necho "units $*" >> {tree}/calls\n')
    units.chmod(0o755)
    python = "python -m pytest -q -n 2 --dist loadfile tests/pictures"
    assert run(tree, "test", "image").returncode == 0
    assert calls(tree).splitlines()[-3:] == ["cmake --build --preset dev", "units tests/cpp/image", python]
    assert run(tree, "test", "image", "-k", "tiles").returncode == 0
    assert calls(tree).splitlines()[-2:] == ["cmake --build --preset dev", f"{python} -k tiles"]
    assert run(tree, "test", "pictures", fails="python -m pytest").returncode == 1
    before = calls(tree).count("-m pytest")
    assert run(tree, "test", fails="cmake --build").returncode == 1
    assert calls(tree).count("-m pytest") == before == 3


def test_without_an_active_environment_an_old_python_gets_a_sentence(tree):
    old = tree / "env" / "bin" / "python3"
    old.write_text("#!/bin/sh\n[ $1 = --version ] && echo Python 3.9.2 && exit 0\nexit 1\n")
    old.chmod(0o755)
    told = dev("build", folder=tree, VIRTUAL_ENV="", PATH=f"{old.parent}:{os.environ['PATH']}")
    assert told.returncode == 1
    assert "needs Python 3.11 or newer, not Python 3.9.2" in told.stderr
    assert not (tree / ".venv").exists()


# --- rooms


def test_each_folder_of_sources_and_of_tests_is_a_room():
    rooms = script("rooms")
    known = set(rooms.rooms())
    cpp = {path.name for path in (ROOT / "cpp").iterdir() if path.is_dir()}
    packages = {path.parent.name for path in (ROOT / "python").glob("*/*/__init__.py")}
    assert (cpp | packages) - known == set()
    for room in known:
        assert rooms.of_room(room) != [], room


@pytest.mark.parametrize(
    ("changed", "wanted"),
    [
        ([], []),
        (["cpp/image/raster/kind_disc.h", "tests/cpp/image/test_image_lens.cpp"], ["tests/pictures"]),
        (["cpp/engine/act/act.cpp"], ["tests/world"]),
        (["python/motes/_picture/sprites.py"], ["tests/pictures"]),
        (["python/motes/actions/forces.py", "cpp/actions/wind.h"], ["tests/actions"]),
        (["python/motes/errors.py"], ["tests/cli"]),
        (["cpp/lab/soak/disaster.h", "python/motes_lab/arena/play.py"], ["tests/lab"]),
        (["docs/guide.md"], ["tests/docs"]),
        (["examples/snow.py"], ["tests/docs"]),
        (["pyproject.toml", ".ci/run", "dev", "cpp/CMakeLists.txt"], []),
    ],
)
def test_rooms_that_changed_are_tested_after_the_rules(changed, wanted):
    assert script("rooms").of_changes(changed) == ["tests/source", *wanted]


def test_changed_tests_come_first_and_removed_ones_not_at_all():
    found = script("rooms").of_changes(
        ["python/motes/_film/movie.py", "tests/world/test_reads.py", "tests/world/test_no_longer_there.py"]
    )
    assert found == ["tests/world/test_reads.py", "tests/source", "tests/films"]


def test_what_tests_share_is_tested_by_those_that_name_it():
    *own, rules = script("rooms").of_changes(["tests/scenes/steered.py"])
    assert rules == "tests/source"
    assert [path for path in own if "steered" not in (ROOT / path).read_text()] == [] != own


def test_unit_tests_are_picked_by_their_files(cpp_units):
    def run(word: str) -> str:
        return subprocess.run([cpp_units, word], capture_output=True, text=True, timeout=60).stdout

    inside = (ROOT / "tests" / "cpp" / "threads").glob("test_*.cpp")
    names = sorted(
        name for path in inside for name in re.findall(r"^TEST\((\w+)\)", path.read_text(), re.MULTILINE)
    )
    assert sorted(re.findall(r"^ok     (\w+)$", run("tests/cpp/threads"), re.MULTILINE)) == names != []


# --- messages of commits


@pytest.mark.parametrize(
    ("message", "wrong"),
    [
        ("Add wind to the actions\n\nArtists asked for it.\n", 0),
        (f"Add {'x' * 68}", 0),
        (f"Add {'x' * 69}", 1),
        ("Add wind.\n", 1),
        ("Add wind\nto the actions", 1),
        (f"Add {'x' * 80}.\nto the actions", 3),
    ],
)
def test_faults_of_a_message(message, wrong):
    assert len(script("subjects").faults(message)) == wrong


def test_only_messages_that_are_not_on_origin_main_are_checked(tmp_path):
    """A long subject counts until it is on origin/main; what git writes does not."""
    ci = tmp_path / ".ci"
    ci.mkdir()
    (ci / "subjects").write_bytes((ROOT / ".ci" / "subjects").read_bytes())

    def git(*given: str) -> None:
        me = ["-c", "user.name=n", "-c", "user.email=e", "-c", "commit.gpgsign=false"]
        subprocess.run(["git", *me, *given], cwd=tmp_path, check=True, capture_output=True)

    def checked() -> tuple[int, str]:
        told = subprocess.run([sys.executable, ci / "subjects"], capture_output=True, text=True)
        return told.returncode, told.stdout

    git("init", "-b", "main")
    git("commit", "--allow-empty", "-m", "Begin " + "x" * 80)
    code, text = checked()
    assert code == 0 and text.startswith("no commit was checked: ")
    git("update-ref", "refs/remotes/origin/main", "HEAD")
    assert checked() == (0, "0 messages of commits are in order\n")
    git("commit", "--allow-empty", "-m", "Merge branch 'x' of " + "x" * 80)
    git("commit", "--allow-empty", "-m", "Add wind")
    assert checked() == (0, "1 messages of commits are in order\n")
    git("commit", "--allow-empty", "-m", "Add " + "y" * 80)
    code, text = checked()
    assert code == 1 and "has 84 characters; 72 are allowed" in text


def test_the_hook_ignores_comments_of_the_editor(tmp_path):
    path = tmp_path / "message"
    argv = [sys.executable, ROOT / ".ci" / "subjects", path]
    path.write_text("Add wind\n# Please enter the commit message.\n")
    assert subprocess.run(argv, capture_output=True).returncode == 0
    path.write_text("Add wind.\n# Please enter the commit message.\n")
    assert subprocess.run(argv, capture_output=True).returncode == 1


# --- pages and settings


def test_hooks_use_the_tools_that_the_checks_use():
    hooks = (ROOT / ".pre-commit-config.yaml").read_text()
    pinned = re.findall(r'"([\w-]+==[\d.]+)"', hooks)
    assert len(pinned) == 3
    assert set(pinned) <= set(
        tomllib.loads((ROOT / "pyproject.toml").read_text())["dependency-groups"]["lint"]
    )


@pytest.mark.parametrize("page", PAGES)
def test_commands_and_files_that_a_page_names_exist(page):
    text = (ROOT / page).read_text()
    codes = re.findall(r"`([^`]+)`", text) + re.findall(r"^    (\S.*?)(?:  +#.*)?$", text, re.MULTILINE)
    codes = [" ".join(code.split()) for code in codes]
    assert len(codes) > 1
    for code in codes:
        for word in re.findall(r"\./dev (\S+)", code):
            assert word in words(), code
        for room in re.findall(r"\./dev test (\w+)", code):
            assert script("rooms").of_room(room), code
        for command in re.findall(r"-m motes (\w+)", code):
            assert command in {**COMMANDS, **LAB}, code
        for path in re.findall(r"(?<![\w./$-])\.?\w[\w.-]*/[\w./-]*", code):
            if path.split("/")[0] not in ("build", "origin", ".venv"):
                assert (ROOT / path).exists(), code
        for path in re.findall(r"\b[\w-]+\.(?:md|toml)\b", code):
            assert any((ROOT / folder / path).exists() for folder in ("", "docs")), code
