"""A self-grading course of six evenings about load balancing: `python -m motes course DIR`.

    print(motes.course.grade(3, "mine.py"))

The evenings: read a log; cut space by prefix sums; noisy clocks; machines of unknown speeds; the cost of
moving particles; a tournament. No evening needs mpirun.
"""

from __future__ import annotations

from typing import Any

from motes.errors import missing

from ._secret import PRACTICE
from ._texts import cells, solution
from .classes import Graded, grade_all
from .grades import Grade, Part
from .grading import TASKS, Task, grade, task
from .scenes import Scene
from .writing import notebook, write

__all__ = [
    "PRACTICE",
    "TASKS",
    "Grade",
    "Graded",
    "Part",
    "Scene",
    "Task",
    "cells",
    "grade",
    "grade_all",
    "notebook",
    "solution",
    "task",
    "write",
]


def __getattr__(name: str) -> Any:
    raise missing("motes.course", name, __all__)


def __dir__() -> list[str]:
    return [*__all__]
