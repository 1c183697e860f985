"""Writes the course: a folder per evening with a notebook in nbgrader's format, a log and a scene."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..errors import ArgumentError, MotesError
from ._logs import write_log
from ._secret import PRACTICE
from .grading import TASKS
from .policies import practice

__all__ = ["cells", "notebook", "solution", "write"]

TEXTS = Path(__file__).parent / "texts"
STUB = "# YOUR CODE HERE\nraise NotImplementedError()"
_FENCE = re.compile(r"^```python( solution)?\n(.*?)^```$\n?|^<!-- grade -->$\n?", re.MULTILINE | re.DOTALL)
_REGION = re.compile(r"^( *)### BEGIN SOLUTION\n.*?^ *### END SOLUTION$", re.MULTILINE | re.DOTALL)

Cell = dict[str, Any]


def write(directory: str | os.PathLike[str], *, key: str = PRACTICE, solutions: bool = False) -> list[Path]:
    """Write the course.

    Each folder, `evening_1` to `evening_6`, has a notebook of the same name, the log `run` that it reads, and
    `scene.py` for real processes. With `solutions` the directory can serve as nbgrader's `source`.

    Args:
        directory: where to write; created if missing.
        key: decides the hidden loads: of the logs, and with `solutions` of the notebooks' hidden tests.
        solutions: whether to include solutions and hidden tests, for the teacher.

    Returns:
        The paths of the notebooks.

    Raises:
        ArgumentError: for an empty key.
        MotesError: if one of the folders exists.
    """
    if not key:
        raise ArgumentError("key", key, "a non-empty string")
    folders = [Path(directory) / f"evening_{one.evening}" for one in TASKS]
    for folder in folders:
        if folder.exists():
            raise MotesError(
                f"{folder} already exists, and the course overwrites nothing: choose a new directory"
            )
    written = []
    for one, folder in zip(TASKS, folders, strict=True):
        write_log(folder / "run", practice(one.evening, key))
        scene = (TEXTS / "scene.py.txt").read_text(encoding="utf-8")
        (folder / "scene.py").write_text(scene.replace("EVENING", str(one.evening)), encoding="utf-8")
        path = folder / f"{folder.name}.ipynb"
        made = notebook(one.evening, key=key, solutions=solutions)
        path.write_text(json.dumps(made, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        written.append(path)
    return written


def notebook(evening: int, *, key: str = PRACTICE, solutions: bool = False) -> dict[str, Any]:
    """Return a notebook in its JSON form.

    Args:
        evening: 1 to 6.
        key: of the hidden tests; the public key `PRACTICE` makes none.
        solutions: whether to include solutions and hidden tests.

    Returns:
        The notebook's cells and metadata.
    """
    made = []
    for number, cell in enumerate(cells(evening, key if solutions and key != PRACTICE else "")):
        source = cell["source"] if solutions else _REGION.sub(_stub, cell["source"])
        code: Cell = {"execution_count": None, "outputs": []} if cell["cell_type"] == "code" else {}
        told = {"cell_type": cell["cell_type"], "id": f"cell-{number:02d}", "metadata": cell["metadata"]}
        made.append({**told, **code, "source": source.splitlines(keepends=True)})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {"cells": made, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}


def solution(evening: int) -> str:
    """Read an evening's solution.

    Args:
        evening: 1 to 6.

    Returns:
        The content of the file that its notebook writes.
    """
    (cell,) = (one for one in cells(evening) if one["metadata"].get("nbgrader", {}).get("solution"))
    lines = cell["source"].splitlines()
    return "\n".join(line for line in lines if "SOLUTION" not in line and "%%" not in line) + "\n"


def cells(evening: int, key: str = "") -> Iterator[Cell]:
    """Read an evening's text as cells, including solutions.

    Args:
        evening: 1 to 6.
        key: of the hidden tests; "": no hidden tests.

    Yields:
        The cells: types, metadata and sources.
    """
    text = (TEXTS / f"evening_{evening}.md").read_text(encoding="utf-8")
    at = 0
    for found in _FENCE.finditer(text):
        yield from _markdown(text[at : found.start()])
        at = found.end()
        name = f"evening_{evening}"
        if found[0].startswith("<!--"):
            graded = {"grade": True, "locked": True, "solution": False, "points": 100}
            yield _code(_test(evening, key), _nbgrader(f"{name}_grade", **graded))
        elif found[1]:
            answer = {"grade": False, "locked": False, "solution": True}
            yield _code(found[2], _nbgrader(f"{name}_answer", **answer))
        else:
            yield _code(found[2], {})
    yield from _markdown(text[at:])


def _test(evening: int, key: str) -> str:
    call = f'motes.course.grade({evening}, "mine.py"'
    lines = [f"grade = {call})", "print(grade)"]
    if key:
        hidden = f"grade = {call}, key={key!r})"
        lines += ["### BEGIN HIDDEN TESTS", hidden, "print(grade)", "### END HIDDEN TESTS"]
    return "\n".join([*lines, "grade.score", ""])


def _nbgrader(grade_id: str, **kind: Any) -> dict[str, Any]:
    return {"nbgrader": {"schema_version": 3, "grade_id": grade_id, "task": False, **kind}}


def _code(source: str, metadata: dict[str, Any]) -> Cell:
    return {"cell_type": "code", "metadata": metadata, "source": source.rstrip("\n")}


def _markdown(text: str) -> Iterator[Cell]:
    if text.strip():
        yield {"cell_type": "markdown", "metadata": {}, "source": text.strip("\n")}


def _stub(found: re.Match[str]) -> str:
    return "\n".join(found[1] + line for line in STUB.splitlines())
