"""What all commands share: the parser and the ways to print."""

from __future__ import annotations

import argparse
import difflib
import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

__all__ = ["Parser", "add_commands", "add_json", "nearest", "plain", "positive", "print_figures", "size"]


class Parser(argparse.ArgumentParser):
    """An argument parser without abbreviations that suggests the nearest name. Usage errors exit with 2."""

    def __init__(self, **options: Any) -> None:
        """Take what `argparse.ArgumentParser` takes."""
        options.setdefault("allow_abbrev", False)
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(**options)

    def error(self, message: str) -> NoReturn:
        """Print usage and message, with the nearest choice or option if one was mistyped, and exit with 2."""
        wrong = re.search(r"invalid choice: '([^']*)'.*\(choose from (.*)\)", message)
        if wrong is not None:
            message += nearest(wrong[1], [name.strip(" '") for name in wrong[2].split(",")])
        unknown = re.search(r"unrecognized arguments: .*?(--?[^\s=]+)", message)
        if unknown is not None:
            message += nearest(unknown[1], sorted(_options(self)))
        super().error(message)


def add_commands(parser: argparse.ArgumentParser, title: str) -> argparse._SubParsersAction[Any]:
    """Add sub-commands, one of which must be given; its name is `args.<title in lower case>`."""
    return parser.add_subparsers(
        action=_Commands, dest=title.lower(), metavar=title, required=True, parser_class=Parser
    )


class _Commands(argparse._SubParsersAction):  # type: ignore[type-arg]
    """Sub-commands whose `--help` says in a sentence what they do, with an example."""

    def add_parser(self, name: str, *, example: str = "", **options: Any) -> Any:
        """Add a command. `help` is the sentence, `example` what stands behind the name in the example."""
        about = options["help"]
        line = f"{self._prog_prefix} {name} {example}".rstrip()
        return super().add_parser(name, description=f"{about[0].upper()}{about[1:]}.\n\n  {line}", **options)


def _options(parser: argparse.ArgumentParser) -> set[str]:
    """Return the options of a parser and of its commands."""
    found = set(parser._option_string_actions)
    for action in parser._actions:
        if isinstance(action, _Commands):
            found = found.union(*(_options(command) for command in action.choices.values()))
    return found


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def nearest(name: str, known: Sequence[str]) -> str:
    """Return `; did you mean 'bench'?`, or nothing where no name is near."""
    near = difflib.get_close_matches(name, known, 1, 0.6)
    return f"; did you mean {near[0]!r}?" if near else ""


def print_figures(args: argparse.Namespace, figures: Mapping[str, Any], text: str) -> None:
    """Print the figures as one JSON object where `--json` was given, else the text."""
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
    """Read a whole number from 1 on."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number from 1 on, got {text!r}")
    return value


def size(text: str) -> tuple[int, int]:
    """Read WIDTHxHEIGHT."""
    width, x, height = text.partition("x")
    if not x:
        raise argparse.ArgumentTypeError(f"must be WIDTHxHEIGHT such as 1920x1080, got {text!r}")
    return positive(width), positive(height)
