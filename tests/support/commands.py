"""What every command of the command line keeps to, the engine's and the laboratory's."""

from __future__ import annotations

import re
import shlex
from typing import Any

import pytest

from motes.cli import command, main
from motes.cli.parser import Parser

__all__ = ["examples_can_be_given", "exit_code", "explains_itself", "inner", "parser_of"]


def exit_code(*argv: str) -> int:
    """Run a command and return its exit code."""
    try:
        return main(argv)
    except SystemExit as end:
        assert isinstance(end.code, int)
        return end.code


def parser_of(name: str) -> Parser:
    """Return a command's parser."""
    parser = Parser()
    command(name).configure(parser)
    return parser


def inner(name: str) -> list[str]:
    """Return a command's sub-commands, one of which must be given."""
    parser: Any = parser_of(name)
    return [one for action in parser._actions if isinstance(action.choices, dict) for one in action.choices]


def explains_itself(help_of: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Check that in the help of "bench" or "bench snow" a sentence and an example follow the usage."""
    assert exit_code(*help_of.split(), "--help") == 0
    said = capsys.readouterr().out
    about = said.partition("\n\n")[2]
    assert re.match(r"[A-Z][^\n]*(\n[^\n]+)*[.:]\n", about), said
    assert re.search(rf"^  (python -m )?motes {help_of}\b", about, re.MULTILINE), said
    return said


def examples_can_be_given(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Check that a command takes the examples of its help, and of its sub-commands' help."""
    parser = parser_of(name)
    for help_of in (name, *(f"{name} {one}" for one in inner(name))):
        examples = re.findall(
            rf"^  (?:python -m )?motes {name}\b(.*)", explains_itself(help_of, capsys), re.M
        )
        assert examples
        for example in examples:
            args = parser.parse_args(shlex.split(re.sub(r" \[.*|  .*", "", example), comments=True))
            if getattr(args, "scene", "").endswith(".motes"):
                assert not args.arguments, f"a recorded scene takes no arguments: {example}"
