"""Options that several commands of the laboratory share."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from motes.cli.parser import Parser, positive

__all__ = ["add_commands", "add_key", "size"]


def add_commands(parser: argparse.ArgumentParser, title: str) -> argparse._SubParsersAction[Any]:
    """Add sub-commands, one of which must be given; its name is `args.<title in lower case>`."""
    return parser.add_subparsers(
        action=_Commands, dest=title.lower(), metavar=title, required=True, parser_class=Parser
    )


class _Commands(argparse._SubParsersAction):  # type: ignore[type-arg]
    """Sub-commands whose `--help` has a sentence and an example."""

    def add_parser(self, name: str, *, example: str = "", **options: Any) -> Any:
        """Add a command. `help` is the sentence, `example` the arguments in the example."""
        about = options["help"]
        line = f"{self._prog_prefix} {name} {example}".rstrip()
        return super().add_parser(name, description=f"{about[0].upper()}{about[1:]}.\n\n  {line}", **options)


def add_key(parser: argparse.ArgumentParser, default: str) -> None:
    """Add `--key`; with "-" the key does not show up in the list of processes."""
    parser.add_argument(
        "--key",
        type=lambda text: sys.stdin.readline().strip() if text == "-" else text,
        default=default,
        metavar="KEY",
        help="decides the hidden loads; -: read it from the first line of standard input",
    )


def size(text: str) -> tuple[int, int]:
    """Read WIDTHxHEIGHT."""
    width, x, height = text.partition("x")
    if not x:
        raise argparse.ArgumentTypeError(f"must be WIDTHxHEIGHT such as 1920x1080, got {text!r}")
    return positive(width), positive(height)
