"""Writes the course: a folder per evening with a notebook in nbgrader's format, a log and a scene."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

from motes.errors import ArgumentError, MotesError

from ._logs import write_log
from ._secret import PRACTICE
from ._texts import TEXTS, Cell, cells
from .grading import TASKS
from .policies import practice

__all__ = ["notebook", "write"]

STUB = "# YOUR CODE HERE\nraise NotImplementedError()"
_REGION = re.compile(r"^( *)### BEGIN SOLUTION\n.*?^ *### END SOLUTION$", re.MULTILINE | re.DOTALL)


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


def _stub(found: re.Match[str]) -> str:
    return "\n".join(found[1] + line for line in STUB.splitlines())
