"""`bench compare` times two installs in turn, and does not judge on a busy machine."""

from __future__ import annotations

import json
import stat
import sys
from pathlib import Path

import pytest

from motes.cli import main
from motes.errors import MotesError
from motes_lab.bench import compare, quiet

PYTHON = sys.executable


def install(folder: Path, name: str, **ns: float) -> str:
    """Make a program that answers `-m motes bench births --json` with these figures, like another install."""
    path = folder / name
    figures = json.dumps({f"{row}_ns": value for row, value in ns.items()})
    path.write_text(f"#!{PYTHON}\nimport sys\nprint({figures!r}, file=sys.stdout)\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@pytest.fixture
def idle(monkeypatch):
    """Let the machine seem quiet."""
    monkeypatch.setattr(quiet, "LOOK_S", 0.0)
    monkeypatch.setattr(quiet.OthersAtWork, "processors", lambda _: 0.0)


def compared(monkeypatch, tmp_path, *, now: float, busy: bool = False):
    old = install(tmp_path, "old", make=10.0, gone=5.0)
    monkeypatch.setattr(compare.sys, "executable", install(tmp_path, "new", make=now, added=5.0))
    return compare.compare(old_python=old, rounds=3, only=["births"], busy=busy)


@pytest.mark.usefixtures("idle")
@pytest.mark.parametrize(("now", "slower"), [(10.2, []), (10.4, ["births: make, ns"])])
def test_rows_that_both_have_are_compared(now, slower, monkeypatch, tmp_path):
    found = compared(monkeypatch, tmp_path, now=now)
    (row,) = found["rows"]
    assert row == {"row": "births: make, ns", "before": 10, "now": now} | dict.fromkeys(
        ("ratio", "low", "high"), now / 10
    )
    assert found["slower"] == slower


@pytest.mark.usefixtures("idle")
def test_a_relative_path_is_one_from_here(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    install(tmp_path, "old", make=10.0)
    monkeypatch.setattr(compare.sys, "executable", install(tmp_path, "new", make=5.0))
    found = compare.compare(old_python="./old", rounds=1, only=["births"], busy=False)
    assert found["rows"][0]["ratio"] == 0.5


def test_a_busy_machine_is_not_judged_unless_asked(monkeypatch, tmp_path):
    monkeypatch.setattr(quiet, "LOOK_S", 0.0)
    monkeypatch.setattr(quiet.OthersAtWork, "processors", lambda _: 1.5)
    with pytest.raises(MotesError, match=r"other programs use 1\.50 processors.*--busy"):
        compared(monkeypatch, tmp_path, now=20)
    found = compared(monkeypatch, tmp_path, now=20, busy=True)
    assert found["rows"][0]["ratio"] == 2
    assert not found["slower"]


def test_what_began_while_it_ran_counts(monkeypatch, tmp_path):
    looks = iter([0.0, 1.0])
    monkeypatch.setattr(quiet, "LOOK_S", 0.0)
    monkeypatch.setattr(quiet.OthersAtWork, "processors", lambda _: next(looks))
    with pytest.raises(MotesError, match="not judged"):
        compared(monkeypatch, tmp_path, now=20)


@pytest.mark.usefixtures("idle")
def test_the_exit_code_tells_that_something_became_slower(monkeypatch, tmp_path, capsys):
    old = install(tmp_path, "old", make=10.0)
    monkeypatch.setattr(compare.sys, "executable", install(tmp_path, "new", make=20.0))
    assert main(["bench", "compare", old, "--only", "births", "--rounds", "2"]) == 1
    assert "slower: births: make, ns" in capsys.readouterr().out


@pytest.mark.usefixtures("idle")
@pytest.mark.parametrize("python", ["/nowhere/python", "/bin/false"])
def test_an_install_that_cannot_run_is_named(python, capsys):
    assert main(["bench", "compare", python, "--only", "births"]) == 2
    said = capsys.readouterr().err
    assert python in said
    assert "install" in said


def test_other_programs_are_seen():
    others = quiet.OthersAtWork()
    assert others.processors() >= 0
