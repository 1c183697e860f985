"""Grades all submissions of a class, each in a process of its own, several at a time."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from motes.errors import MotesError

from ._secret import PRACTICE
from ._texts import ANSWER
from .grades import Grade
from .grading import cases_of, graded, task

__all__ = ["Graded", "grade_all"]

LIMIT_S = 900
"""Seconds after which a submission's grading is ended, however busy the machine is."""


@dataclass(frozen=True)
class Graded:
    """A student's grade.

    Attributes:
        student: the name of the student's folder or file.
        grade: points, or why there are none.
    """

    student: str
    grade: Grade

    @property
    def figures(self) -> dict[str, Any]:
        """The grade as plain values."""
        return {"student": self.student, **self.grade.figures}


def grade_all(
    task_of: int | str, directory: str | os.PathLike[str], *, key: str = PRACTICE, jobs: int | None = None
) -> list[Graded]:
    """Grade the submissions of a class, as `grade` does; one that fails has no effect on the others.

    Args:
        task_of: the evening, 1 to 6, or the task's name.
        directory: a folder with a file `NAME.py` or a folder `NAME` per student. A folder contains `mine.py`,
            or as nbgrader collects it `evening_N/evening_N.ipynb`, whose answer counts.
        key: decides the hidden cases.
        jobs: how many are graded at a time; None: one per processor.

    Returns:
        The grades, in the order of the students' names.

    Raises:
        ArgumentError: for an unknown task or an empty key.
        MotesError: if there is no such directory, or nothing in it.
    """
    chosen, folder = task(task_of), Path(directory)
    if not folder.is_dir():
        raise MotesError(f"{folder} is not a directory: name the one that holds the submissions")
    cases = cases_of(chosen.evening, key)
    handed_in = sorted(_handed_in(folder, f"evening_{chosen.evening}"))
    if not handed_in:
        raise MotesError(f"{folder} contains no submissions: expected NAME.py or NAME/mine.py per student")
    graded_one = partial(_graded, chosen.evening, chosen.name, cases)
    with ThreadPoolExecutor(jobs or len(os.sched_getaffinity(0))) as pool:
        grades = list(pool.map(graded_one, [path for _, path in handed_in]))
    return [Graded(student, grade) for (student, _), grade in zip(handed_in, grades, strict=True)]


def _handed_in(folder: Path, evening: str) -> Iterator[tuple[str, Path]]:
    """Yield each student's name, and the file that counts; it may not exist."""
    for entry in folder.iterdir():
        if entry.name.startswith((".", "__")):
            continue
        if entry.is_dir():
            notebook = entry / evening / f"{evening}.ipynb"
            files = [notebook, entry / evening / "mine.py"]
            yield entry.name, next(filter(Path.is_file, files), entry / "mine.py")
        elif entry.suffix == ".py":
            yield entry.stem, entry


def _graded(evening: int, name: str, cases: Any, path: Path) -> Grade:
    """Grade one submission in a process of its own; return why if that fails."""
    try:
        source = _source(path)
        given = pickle.dumps((evening, path, source, cases))
        told = subprocess.run(
            [sys.executable, "-P", "-m", __name__],
            input=given,
            capture_output=True,
            timeout=LIMIT_S,
            check=False,
        )
        if told.returncode:
            said = told.stderr.decode(errors="replace").strip().splitlines() or [f"code {told.returncode}"]
            raise MotesError(f"its grading ended: {said[-1]}")
        found: Grade = pickle.loads(told.stdout)
    except subprocess.TimeoutExpired:
        return Grade(evening, name, [], f"it takes more than {LIMIT_S} s")
    except MotesError as error:
        return Grade(evening, name, [], str(error))
    return found


def _source(path: Path) -> bytes:
    """Read a submission: a Python file, or the answer of a notebook in nbgrader's format."""
    if path.is_symlink() or path.parent.is_symlink():
        raise MotesError(f"{path.name} is a link: hand in the file itself")
    if not path.is_file():
        raise MotesError(f"{path.parent.name} contains no {path.name}")
    try:
        read = path.read_bytes()
        if path.suffix != ".ipynb":
            return read
        for cell in json.loads(read)["cells"]:
            first, _, rest = "".join(cell["source"]).partition("\n")
            if first.strip() == ANSWER and cell["metadata"].get("nbgrader", {}).get("solution"):
                return rest.encode()
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise MotesError(f"{path.name} cannot be read: {type(error).__name__}: {error}") from None
    raise MotesError(f"{path.name} has no answer: its cell begins with {ANSWER}")


def main() -> None:
    """Grade what the standard input holds, and write the grade to the standard output, both pickled."""
    evening, path, source, cases = pickle.loads(sys.stdin.buffer.read())
    sys.stdout.buffer.write(pickle.dumps(graded(task(evening), path, source, cases)))


if __name__ == "__main__":
    main()
