"""Command lines: a parser that suggests the closest name for a mistyped one."""

from __future__ import annotations

import argparse
import re
from typing import Any, NoReturn

from ..errors import near

__all__ = ["Parser"]


class Parser(argparse.ArgumentParser):
    """An argument parser without abbreviations that suggests the closest name. Usage errors exit with 2."""

    def __init__(self, **options: Any) -> None:
        """Accept the arguments of `argparse.ArgumentParser`."""
        options.setdefault("allow_abbrev", False)
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(**options)

    intermixed = False
    """Whether options may stand between positional arguments, and what follows `--` is the last of these."""

    def parse_args(  # type: ignore[override]
        self, args: Any = None, namespace: Any = None
    ) -> argparse.Namespace:
        """Parse a command line."""
        parse = self.parse_intermixed_args if self.intermixed else super().parse_args
        parsed: argparse.Namespace = parse(args, namespace)
        return parsed

    def error(self, message: str) -> NoReturn:
        """Print usage and message, suggest the closest choice or option if one was mistyped; exit with 2."""
        wrong = re.search(r"invalid choice: '([^']*)'.*\(choose from (.*)\)", message)
        if wrong is not None:
            message += near(wrong[1], [name.strip(" '") for name in wrong[2].split(",")])
        unknown = re.search(r"unrecognized arguments: .*?(--?[^\s=]+)", message)
        if unknown is not None:
            message += near(unknown[1], sorted(_options(self)))
        super().error(message)


def _options(parser: argparse.ArgumentParser) -> set[str]:
    """Return the options of a parser and of its commands."""
    options = set(parser._option_string_actions)
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            options = options.union(*(_options(command) for command in action.choices.values()))
    return options
