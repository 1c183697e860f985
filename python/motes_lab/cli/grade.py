"""Grade a submission for an evening of the course, or those of a whole class: points, and hints.

  python -m motes grade 3 mine.py
  python -m motes grade noise mine.py --key "our secret" --json
  python -m motes grade 3 --all submitted

Submissions run in processes of their own, for a few seconds at most. The same file and key always get the
same score. The exit code is 1 if a submission fails.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from motes.cli.parser import add_json, add_key, positive, print_figures
from motes.errors import MotesError

from ..course import PRACTICE, TASKS, Graded, grade, grade_all

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `grade`."""
    parser.add_argument("task", metavar="TASK", nargs="?", help="the evening, 1 to 6, or the task's name")
    parser.add_argument("submission", metavar="FILE", nargs="?", help="the student's Python file")
    parser.add_argument(
        "--all",
        metavar="DIR",
        help="grade a class: NAME.py, NAME/mine.py or nbgrader's NAME/evening_N per student; without TASK, "
        "each evening of nbgrader's",
    )
    parser.add_argument(
        "--jobs", type=positive, metavar="N", help="with --all: grade N at a time (one per processor)"
    )
    add_key(parser, PRACTICE)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Print the grades."""
    if args.all is None:
        if args.task is None or args.submission is None or args.jobs:
            raise MotesError("name TASK and FILE to grade one submission, or TASK and --all DIR for a class")
        found = grade(args.task, args.submission, key=args.key)
        print_figures(args, found.figures, str(found))
        return 1 if found.problem else 0
    if args.submission is not None:
        raise MotesError(f"--all grades the submissions in {args.all}: leave out FILE {args.submission!r}")
    every = [grade_all(one, args.all, key=args.key, jobs=args.jobs) for one in _tasks(args)]
    figures = {"grades": [one.figures for grades in every for one in grades]}
    print_figures(args, figures, "\n\n".join(map(_table, every)))
    return 1 if any(one.grade.problem for grades in every for one in grades) else 0


def _tasks(args: argparse.Namespace) -> list[int | str]:
    """Return the task, or all of which nbgrader has collected something."""
    if args.task is not None:
        return [args.task]
    found = [one.evening for one in TASKS if any(Path(args.all).glob(f"*/evening_{one.evening}"))]
    if Path(args.all).is_dir() and not found:
        raise MotesError(f"{args.all} does not say which evening its files are for: name TASK before --all")
    return [*found] or [1]


def _table(grades: list[Graded]) -> str:
    """Return one line per student: name, points, and the reason if there are none."""
    width = max(len(one.student) for one in grades)
    first = grades[0].grade
    lines = [f"evening {first.evening}, {first.name}:"]
    for one in grades:
        hints = (part.hint for part in one.grade.parts)
        reason = one.grade.problem or next(filter(None, hints), "")
        lines.append(f"  {one.student:{width}}  {one.grade.score:5.1f}  {reason}".rstrip())
    return "\n".join(lines)
