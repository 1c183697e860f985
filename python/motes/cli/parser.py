"""Options and printing that all commands share."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping
from typing import Any

from .._values.options import Parser

__all__ = ["Parser", "add_commands", "add_json", "add_key", "plain", "positive", "print_figures", "size"]


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


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def add_key(parser: argparse.ArgumentParser, default: str) -> None:
    """Add `--key`; with "-" the key does not show up in the list of processes."""
    parser.add_argument(
        "--key",
        type=lambda text: sys.stdin.readline().strip() if text == "-" else text,
        default=default,
        metavar="KEY",
        help="decides the hidden loads; -: read it from the first line of standard input",
    )


def print_figures(args: argparse.Namespace, figures: Mapping[str, Any], text: str) -> None:
    """Print the figures as one JSON object if `--json` was given, else the text."""
    print(json.dumps(plain(figures)) if args.json else text, flush=True)


def plain(value: Any) -> Any:
    """Return the value with NaN and infinities as None, since JSON has neither."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    return value


def positive(text: str) -> int:
    """Read a whole number >= 1."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number >= 1, got {text!r}")
    return value


def size(text: str) -> tuple[int, int]:
    """Read WIDTHxHEIGHT."""
    width, x, height = text.partition("x")
    if not x:
        raise argparse.ArgumentTypeError(f"must be WIDTHxHEIGHT such as 1920x1080, got {text!r}")
    return positive(width), positive(height)
