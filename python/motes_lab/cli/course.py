"""Write a course of six evenings about load balancing: a notebook, a log and a scene for each.

  python -m motes course evenings
  python -m motes course source --solutions --key "our secret"

With --solutions the notebooks contain solutions and hidden tests, for the teacher, in nbgrader's format.
"""

from __future__ import annotations

import argparse

from motes.cli.parser import add_json, add_key, print_figures

from ..course import PRACTICE, write

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `course`."""
    parser.add_argument("directory", metavar="DIR", help="where to write: one folder per evening")
    parser.add_argument("--solutions", action="store_true", help="with solutions and hidden tests")
    add_key(parser, PRACTICE)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Write the course and print where the notebooks are."""
    written = list(map(str, write(args.directory, key=args.key, solutions=args.solutions)))
    print_figures(args, {"notebooks": written}, "\n".join(written))
    return 0
