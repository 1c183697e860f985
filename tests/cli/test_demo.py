"""`motes demo`: every example by name, with its options, on one rank or more."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from motes import cli
from motes.cli import demo, main

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SMALL = ("--particles", "100", "--frames", "3", "--size", "160x90", "--digest")


def start(*argv: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    job = [sys.executable, "-m", "motes", "demo", *map(str, argv)]
    return subprocess.run(job, capture_output=True, text=True, timeout=60, cwd=cwd)


def test_every_example_is_a_demo_wherever_the_package_lies(tmp_path):
    assert demo.names() == sorted(path.stem for path in EXAMPLES.rglob("*.py"))
    for name in demo.names():
        assert demo.script(name).read_bytes() == next(EXAMPLES.rglob(f"{name}.py")).read_bytes()


def test_without_a_name_all_are_listed(capsys):
    assert main(["demo"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == demo.names()
    assert "A waterfall breaks on rocks and raises mist" in lines[demo.names().index("waterfall")]
    assert main(["demo", "--json"]) == 0
    assert list(json.loads(capsys.readouterr().out)) == demo.names()


def test_one_film_and_one_picture_are_written_into_out(tmp_path):
    pytest.importorskip("av")
    made = start("grid", *SMALL, cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["grid.mp4", "grid.png"]
    assert "motes demo: Waves run through a grid of balls\n" in made.stderr


@pytest.mark.slow
def test_options_before_and_behind_the_name_are_understood(tmp_path):
    one = start("swirl", *SMALL, "--no-images", cwd=tmp_path)
    before = start("-n", 3, "swirl", *SMALL, "--no-images", cwd=tmp_path)
    behind = start("swirl", "--no-images", *SMALL, "-n", 3, cwd=tmp_path)
    assert one.stdout and one.stdout == before.stdout == behind.stdout, before.stderr + behind.stderr
    other = start("swirl", *SMALL, "--no-images", "--seed", 2, cwd=tmp_path)
    assert other.stdout != one.stdout
    log = ("--log", "log", "--no-images")
    for argv in (("-n", 3, "swirl", *SMALL, *log), ("swirl", *SMALL, "-n", 3, *log)):
        assert start(*argv, cwd=tmp_path).returncode == 0
        assert len(json.loads((tmp_path / "log" / "run.json").read_text())["ranks"]) == 3


def test_help_behind_a_name_is_that_of_the_script(tmp_path):
    assert "[--wind WIND]" not in start("--help", cwd=tmp_path).stdout
    said = start("photo", "--help", cwd=tmp_path).stdout
    assert "usage: photo.py" in said and "--picture" in said


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (["waterfal"], "no demo is called 'waterfal'; did you mean 'waterfall'?"),
        (["zzz"], "no demo is called 'zzz'; `python -m motes demo` lists all"),
        (["../snow"], "no demo is called '../snow'"),
    ],
)
def test_an_unknown_name_is_an_error_that_suggests_one(argv, says, capsys):
    assert main(["demo", *argv]) == 2
    assert says in capsys.readouterr().err


def test_an_unknown_option_of_a_script_suggests_one(tmp_path):
    made = start("grid", "--prticles", 5, cwd=tmp_path)
    assert made.returncode == 2
    assert "unrecognized arguments: --prticles 5; did you mean '--particles'?" in made.stderr


def test_live_is_the_command_live_or_refused_where_there_is_none(monkeypatch, capsys):
    monkeypatch.delitem(cli.COMMANDS, "live", raising=False)
    assert main(["demo", "grid", "--live"]) == 2
    assert "cannot show a run as it runs" in capsys.readouterr().err
    started = []
    monkeypatch.setitem(cli.COMMANDS, "live", "show a run in a browser")
    monkeypatch.setattr(cli, "main", lambda argv: started.append(argv) or 3)
    assert main(["demo", "grid", "--live", "-n", "2", "--frames", "5"]) == 3
    assert started == [["live", "-n", "2", str(demo.script("grid")), "--frames", "5"]]
