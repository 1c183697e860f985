"""The command line: one grammar for all commands, errors in one sentence, JSON for all figures."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest
from commands import examples_can_be_given, exit_code, explains_itself, parser_of
from handmade import moving_spot

from motes import script as script_options
from motes.cli import COMMANDS, LAB, command, main
from motes.cli.parser import plain

HELLO = """
import argparse, motes
parser = argparse.ArgumentParser()
for name in ("--json", "--full"):
    parser.add_argument(name, action="store_true")
parser.add_argument("-o")
print(vars(parser.parse_args()))
world = motes.World(seed=1, progress="off")
system = world.system("a")
with world:
    for frame in world.frames(2):
        system.move()
        world.step()
"""


@pytest.fixture
def script(tmp_path: Path) -> Path:
    path = tmp_path / "hello.py"
    path.write_text(HELLO)
    return path


def motes(*argv: object, **options: object) -> subprocess.CompletedProcess[str]:
    job = [sys.executable, "-m", "motes", *map(str, argv)]
    return subprocess.run(job, capture_output=True, text=True, timeout=60, **options)


# --- all commands


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_is_a_module_that_explains_itself(name, capsys):
    assert callable(command(name).run)
    assert command(name).__doc__.split("\n")[0] in explains_itself(name, capsys)


@pytest.mark.parametrize("name", COMMANDS)
def test_each_example_of_a_help_can_be_given(name, capsys):
    examples_can_be_given(name, capsys)


def test_the_commands_are_listed(capsys):
    assert exit_code() == 2
    assert exit_code("--help") == 0
    said = capsys.readouterr()
    for text in (said.out, said.err):
        own, _, laboratory = text.partition("\nlaboratory:\n")
        assert all(f"  {name} " in own for name in COMMANDS)
        assert all(f"  {name} " in laboratory for name in LAB)
    assert exit_code("--version") == 0
    assert capsys.readouterr().out.strip() == importlib.import_module("motes").__version__


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("wtach run", "unknown command 'wtach'; did you mean 'watch'?"),
        ("zzz", "unknown command 'zzz'\n"),
        ("run x.py", "required: -n"),
        ("run -n x y.py", "invalid int value: 'x'"),
        ("doctor --jsn", "unrecognized arguments: --jsn; did you mean '--json'?"),
        ("watch --wiat 3 run", "did you mean '--wait'?"),
        ("movei out", "did you mean 'movie'?"),
        ("report", "required: RUN"),
    ],
)
def test_usage_errors_exit_with_2(capsys, line, says):
    assert exit_code(*line.split()) == 2
    assert says in capsys.readouterr().err


def test_figures_that_are_nan_or_infinite_are_null_in_json():
    assert plain({"a": float("nan"), "b": [float("inf"), 1.5], "c": (2,)}) == {
        "a": None,
        "b": [None, 1.5],
        "c": [2],
    }


def test_each_command_that_prints_figures_takes_json():
    for name, argv in {"doctor": [], "watch": ["run"], "report": ["run"], "record": []}.items():
        assert parser_of(name).parse_args([*argv, "--json"]).json


def test_a_reader_that_leaves_is_no_error(tmp_path):
    log = moving_spot(tmp_path / "log", frames=3)
    job = f"{sys.executable} -m motes watch --once {log} | true; exit ${{PIPESTATUS[0]}}"
    made = subprocess.run(["bash", "-c", job], capture_output=True, text=True, timeout=60)
    assert made.returncode == 0
    assert made.stderr == ""


# --- report


@pytest.mark.parametrize("place", ["folder", "file/page.html", "/proc/none/page.html"])
def test_a_report_that_cannot_be_written_is_said_in_a_line(tmp_path, capsys, place):
    log = moving_spot(tmp_path / "log", frames=3)
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    assert main(["report", str(log), "-o", str(tmp_path / place)]) == 2
    said = capsys.readouterr().err
    assert "cannot write the report" in said
    assert said.count("\n") == 1


# --- record


def test_options_of_record_may_stand_at_the_end(script, tmp_path):
    for own in (["-o", "a.motes", "--json"], ["--json", "-o", "a.motes"], ["--output=a.motes", "--json"]):
        made = motes("record", script, *own, cwd=tmp_path)
        assert made.returncode == 0, made.stderr
        arguments, facts = made.stdout.splitlines()
        assert arguments == "{'json': False, 'full': False, 'o': None}"
        assert json.loads(facts)["frames"] == 2
        assert (tmp_path / "a.motes").is_file()
        (tmp_path / "a.motes").unlink()


def test_after_a_file_given_first_all_arguments_belong_to_the_script(script, tmp_path):
    made = motes("record", "-o", "a.motes", script, "--json", "-o", "mine", cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    arguments, facts = made.stdout.splitlines()
    assert arguments == "{'json': True, 'full': False, 'o': 'mine'}"
    assert facts.endswith("bytes")
    assert (tmp_path / "a.motes").is_file()


def test_record_without_a_file_says_what_to_add(script, capsys):
    assert main(["record", str(script), "--json"]) == 2
    assert "add `-o scene.motes`" in capsys.readouterr().err


# --- doctor


def test_doctor_says_what_is_wrong_where_the_core_does_not_load(tmp_path):
    # A copy of the package without its compiled core, as after a failed build.
    package = Path(importlib.import_module("motes").__file__).parent
    copy = tmp_path / "motes"
    copy.mkdir()
    for entry in package.iterdir():
        if not entry.name.startswith("_core") and entry.name != "__pycache__":
            (copy / entry.name).symlink_to(entry)
    env = {"PYTHONPATH": str(tmp_path), "PATH": "/usr/bin:/bin"}
    made = motes("doctor", "--json", env=env, cwd=tmp_path)
    assert made.returncode == 1, made.stderr
    told = json.loads(made.stdout)
    assert any("the compiled core does not load" in problem for problem in told["problems"])
    assert told["numpy"] and told["mpi_library"]
    assert "Traceback" not in made.stderr


def test_doctor_prints_the_environment_and_what_is_not_allowed_there(capsys, monkeypatch):
    monkeypatch.setenv("MOTES_STALL_S", "soon")
    monkeypatch.setenv("MOTES_BIRTHS", "calculators")
    assert main(["doctor", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["environment"] == {"MOTES_STALL_S": "soon", "MOTES_BIRTHS": "calculators"}
    assert "MOTES_STALL_S must be a number of seconds > 0, got 'soon'" in told["problems"]


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("--size=640", "argument --size: must be WIDTHxHEIGHT in pixels, such as 640x360, got '640'"),
        ("--size=0x9", "must be WIDTHxHEIGHT in pixels"),
        ("--size=640x-2", "must be WIDTHxHEIGHT in pixels"),
        (
            "--space=3",
            "argument --space: must be infinite, fit, or LOW,HIGH in metres, such as -30,30, got '3'",
        ),
        ("--space=a,b", "must be infinite, fit, or LOW,HIGH"),
        ("--frames=1.5", "argument --frames: must be a whole number, 0 or more, got '1.5'"),
        ("--frames=-1", "must be a whole number, 0 or more"),
        ("--balancer=best", "pairwise, diffusive, prefixcuts, bisection, costaware, greedy, got 'best'"),
    ],
)
def test_options_of_scripts_say_what_they_take(capsys, option, message):
    with pytest.raises(SystemExit):
        script_options.options("A scene.", argv=[option])
    assert message in capsys.readouterr().err
