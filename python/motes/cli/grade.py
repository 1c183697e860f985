"""Grade a submission for an evening of the course: points, and hints where points are missing.

  python -m motes grade 3 mine.py
  python -m motes grade noise mine.py --key "our secret" --json

The submission runs in a separate process, for a few seconds at most. The same file and key always get the
same score. The exit code is 1 if the submission fails.
"""

from __future__ import annotations

import argparse

from ..course import PRACTICE, grade
from .parser import add_json, add_key, print_figures

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `grade`."""
    parser.add_argument("task", metavar="TASK", help="the evening, 1 to 6, or the task's name")
    parser.add_argument("submission", metavar="FILE", help="the student's Python file")
    add_key(parser, PRACTICE)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Print the grade."""
    found = grade(args.task, args.submission, key=args.key)
    print_figures(args, found.figures, str(found))
    return 1 if found.problem else 0
