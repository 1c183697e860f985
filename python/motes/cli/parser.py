"""Options and printing that all commands share."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Mapping
from typing import Any

from .._values.options import Parser

__all__ = ["Parser", "add_json", "plain", "positive", "print_figures"]


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


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
