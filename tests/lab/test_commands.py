"""The laboratory's commands: the same grammar as the engine's, and a sentence where it is not installed."""

from __future__ import annotations

import pytest
from commands import examples_can_be_given, exit_code, explains_itself, inner, parser_of

from motes.cli import LAB, command


@pytest.mark.parametrize("name", LAB)
def test_each_command_is_a_module_that_explains_itself(name, capsys):
    assert callable(command(name).run)
    assert command(name).__doc__.split("\n")[0] in explains_itself(name, capsys)


@pytest.mark.parametrize("name", ["bench", "cluster"])
def test_each_command_of_a_command_explains_itself(name, capsys):
    assert len(inner(name)) > 3
    for one in inner(name):
        explains_itself(f"{name} {one}", capsys)


@pytest.mark.parametrize("name", LAB)
def test_each_example_of_a_help_can_be_given(name, capsys):
    examples_can_be_given(name, capsys)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("bench snwo", "did you mean 'snow'?"),
        ("cluster papre", "did you mean 'paper'?"),
        ("bench", "required: NAME"),
        ("bench snow --particles -3", "must be a whole number >= 1, got '-3'"),
        ("bench render --size 640", "must be WIDTHxHEIGHT such as 1920x1080, got '640'"),
        ("bench snow --steps x", "must be a whole number >= 1, got 'x'"),
        ("bench snow --partciles=3", "did you mean '--particles'?"),
        ("cluster growth --qqq", "unrecognized arguments: --qqq\n"),
        ("cluster growth --ranks 2", "must be whole numbers >= 3, got '2'"),
        ("cluster growth --births nobody", "must be one or more of calculators, manager, got 'nobody'"),
        ("cluster growth --plot x.gif", "ending in .png, .svg, .pdf in an existing folder, got 'x.gif'"),
        ("cluster paper --table 1 --plot no/such/x.png", "in an existing folder, got 'no/such/x.png'"),
        ("cluster paper --table 4", "invalid choice: 4"),
        ("cluster build", "required: --source"),
    ],
)
def test_usage_errors_exit_with_2(capsys, line, says):
    assert exit_code(*line.split()) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    "line",
    ["bench snow", "cluster paper --table 1", "arena", "course folder", "grade 1 mine.py", "soak files"],
)
def test_each_command_takes_json(line):
    name, *argv = line.split()
    assert parser_of(name).parse_args([*argv, "--json"]).json
