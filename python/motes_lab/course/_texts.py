"""The evenings' texts: their cells, and the solutions in them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from motes.balance import Balancer

__all__ = ["ANSWER", "TEXTS", "Cell", "cells", "own", "solution"]

TEXTS = Path(__file__).parent / "texts"
ANSWER = "%%writefile mine.py"
"""The first line of the cell that holds a student's answer."""
_FENCE = re.compile(r"^```python( solution)?\n(.*?)^```$\n?|^<!-- grade -->$\n?", re.MULTILINE | re.DOTALL)

Cell = dict[str, Any]


def solution(evening: int) -> str:
    """Read an evening's solution.

    Args:
        evening: 1 to 6.

    Returns:
        The content of the file that its notebook writes.
    """
    (cell,) = (one for one in cells(evening) if one["metadata"].get("nbgrader", {}).get("solution"))
    lines = cell["source"].splitlines()
    return "\n".join(line for line in lines if "SOLUTION" not in line and line != ANSWER) + "\n"


@lru_cache(maxsize=6)
def own(evening: int) -> Callable[..., Balancer]:
    """Return the class `Mine` of an evening's solution.

    Args:
        evening: 3 to 6.
    """
    names: dict[str, Any] = {"__name__": "solution"}
    exec(compile(solution(evening), f"<solution {evening}>", "exec"), names)
    made: Callable[..., Balancer] = names["Mine"]
    return made


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
    lines = ["import json", "import subprocess", "import sys", "", *_graded(evening, "")]
    if key:
        lines += ["### BEGIN HIDDEN TESTS", *_graded(evening, key), "### END HIDDEN TESTS"]
    return "\n".join([*lines, 'grade["score"]', ""])


def _graded(evening: int, key: str) -> list[str]:
    """Return lines that grade in a process of its own, which nothing that a notebook defines can change."""
    hidden = ', "--key", "-"' if key else ""
    return [
        f'command = [sys.executable, "-P", "-m", "motes", "grade", "{evening}", "mine.py", "--json"{hidden}]',
        f"graded = subprocess.run(command, input={key!r}, capture_output=True, text=True)",
        "assert graded.stdout, graded.stderr",
        "grade = json.loads(graded.stdout)",
        'print(grade["text"])',
    ]


def _nbgrader(grade_id: str, **kind: Any) -> dict[str, Any]:
    return {"nbgrader": {"schema_version": 3, "grade_id": grade_id, "task": False, **kind}}


def _code(source: str, metadata: dict[str, Any]) -> Cell:
    return {"cell_type": "code", "metadata": metadata, "source": source.rstrip("\n")}


def _markdown(text: str) -> Iterator[Cell]:
    if text.strip():
        yield {"cell_type": "markdown", "metadata": {}, "source": text.strip("\n")}
