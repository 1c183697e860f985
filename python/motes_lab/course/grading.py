"""Grades a submission by its answers to hidden cases, in two separate processes that must agree."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from motes.errors import ArgumentError, MotesError

from . import cutting, policies, reading
from ._secret import PRACTICE
from .asking import Asked, StartError, SubmissionError
from .grades import Grade, Part

__all__ = ["TASKS", "Task", "cases_of", "grade", "graded", "task"]


@dataclass(frozen=True)
class Task:
    """An evening's task.

    Attributes:
        evening: 1 to 6.
        name: one word.
        about: a sentence.
        cases: function that makes the hidden cases from a key.
        graded: function that grades a submission on them.
    """

    evening: int
    name: str
    about: str
    cases: Callable[[str], Any]
    graded: Callable[[Asked, Any], list[Part]]


def _games(evening: int, name: str, about: str) -> Task:
    return Task(evening, name, about, policies.GAMES[evening], policies.graded)


TASKS = (
    Task(
        1, "reading", "read a log: who is slow, and what would balance save?", reading.cases, reading.graded
    ),
    Task(2, "cutting", "cut space by prefix sums", cutting.cases, cutting.graded),
    _games(3, "noise", "balance equal machines with a noisy clock"),
    _games(4, "unknown", "balance machines of unknown speed"),
    _games(5, "moving", "balance only where it pays"),
    _games(6, "tournament", "your own policy against everything"),
)
"""The tasks of the course."""


def task(which: int | str) -> Task:
    """Return a task.

    Args:
        which: its evening, 1 to 6, or its name.

    Raises:
        ArgumentError: if there is no such task.
    """
    for one in TASKS:
        if str(which) in (str(one.evening), one.name):
            return one
    names = [one.name for one in TASKS]
    raise ArgumentError("task", which, f"1 to {len(TASKS)}, or {', '.join(names)}", known=names)


def grade(task_of: int | str, submission: str | os.PathLike[str], *, key: str = PRACTICE) -> Grade:
    """Grade a submission. The same file and key always give the same grade.

    The file runs in a separate process, which sees only its requests and has restricted rights.

    Args:
        task_of: the evening, 1 to 6, or the task's name.
        submission: the student's Python file.
        key: decides the hidden cases. With the default key they can be derived from the package; with your
            own key they cannot.

    Returns:
        Points in parts, with hints.

    Raises:
        ArgumentError: for an unknown task or an empty key.
        MotesError: if there is no such file, or if motes does not start in the submission's process.
    """
    chosen, path = task(task_of), Path(submission)
    if not path.is_file():
        raise MotesError(f"file {path} does not exist")
    return graded(chosen, path, path.read_bytes(), cases_of(chosen.evening, key))


def graded(chosen: Task, path: Path, source: bytes, cases: Any) -> Grade:
    """Grade a submission's source on cases.

    Args:
        chosen: the task.
        path: where the source comes from.
        source: of the submission.
        cases: made by `cases_of`.

    Raises:
        MotesError: if motes does not start in the submission's process.
    """
    printed = ""
    try:
        runs = []
        for _ in range(2):
            asked = Asked(path, source)
            try:
                with asked:
                    runs.append(chosen.graded(asked, cases))
            finally:
                printed = asked.printed
        if runs[0] != runs[1]:
            raise SubmissionError(
                "two runs of it give different results: seed the random numbers, and do not read the clock"
            )
    except StartError:
        raise
    except MotesError as error:
        return Grade(chosen.evening, chosen.name, [], _sentence(error), printed)
    return Grade(chosen.evening, chosen.name, runs[0], "", printed)


@lru_cache(maxsize=len(TASKS))
def cases_of(evening: int, key: str) -> Any:
    """Make hidden cases once, since games cache the reference results for their points.

    Raises:
        ArgumentError: for an empty key.
    """
    if not key:
        raise ArgumentError("key", key, "a non-empty string")
    return task(evening).cases(key)


def _sentence(error: MotesError) -> str:
    text = str(error)
    if "NotImplementedError" in text:
        return text.replace("it raises NotImplementedError", "it has not been written yet")
    return text
