"""A class is graded: all submissions at once, whatever some of them do."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from motes import course
from motes.cli import main


def hand_in(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def notebook(source: str) -> str:
    made = course.notebook(2, solutions=True)
    for cell in made["cells"]:
        if cell["metadata"].get("nbgrader", {}).get("solution"):
            cell["source"] = ["%%writefile mine.py\n", source]
    return json.dumps(made)


@pytest.fixture
def submitted(tmp_path: Path) -> Path:
    right = course.solution(2)
    folder = tmp_path / "submitted"
    hand_in(folder / "anna.py", right)
    hand_in(folder / "berta" / "mine.py", right.replace("wanted, below", "wanted, below[::-1]"))
    hand_in(folder / "carl" / "evening_2" / "evening_2.ipynb", notebook(right))
    hand_in(folder / "carl" / "evening_2" / "mine.py", "raise ValueError('an older version')\n")
    hand_in(folder / "dora.py", "def cuts(**_):\n    while True: pass\n")
    hand_in(folder / "emil.py", "import os\ndef cuts(**_):\n    os.kill(os.getppid(), 9)\n")
    hand_in(folder / "fritz" / "evening_2" / "evening_2.ipynb", '{"cells": 3}')
    hand_in(folder / "gustav" / "notes.txt", "nothing yet")
    (folder / "hans").mkdir()
    (folder / "hans" / "mine.py").symlink_to(folder / "anna.py")
    hand_in(folder / "ida.py", "def cuts(:\n")
    hand_in(folder / "__pycache__" / "anna.pyc", "")
    return folder


@pytest.mark.timeout(600)
def test_a_class_is_graded_whatever_some_submissions_do(
    submitted: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["grade", "2", "--all", str(submitted), "--json", "--jobs", "3"]) == 1
    grades = {one["student"]: one for one in json.loads(capsys.readouterr().out)["grades"]}
    assert list(grades) == ["anna", "berta", "carl", "dora", "emil", "fritz", "gustav", "hans", "ida"]
    assert grades["anna"]["score"] == grades["carl"]["score"] == 100
    alone = course.grade(2, submitted / "berta" / "mine.py").figures
    assert grades["berta"] == {"student": "berta", **alone} and alone["score"] < 100
    for student, reason in (
        ("dora", "processor time"),
        ("emil", "sends a signal"),
        ("fritz", "evening_2.ipynb cannot be read"),
        ("gustav", "gustav contains no mine.py"),
        ("hans", "mine.py is a link"),
        ("ida", "does not parse"),
    ):
        assert grades[student]["score"] == 0 and reason in grades[student]["problem"]


def test_the_table_has_a_line_per_student(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hand_in(tmp_path / "carl" / "evening_2" / "evening_2.ipynb", notebook(course.solution(2)))
    assert main(["grade", "--all", str(tmp_path)]) == 0
    assert capsys.readouterr().out == "evening 2, cutting:\n  carl  100.0\n"
    hand_in(tmp_path / "anna.py", "x = 1\n")
    assert main(["grade", "cutting", "--all", str(tmp_path)]) == 1
    assert "  anna    0.0  it raises NameError: the file does not define cuts" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["2", "--all", "none"], "none is not a directory"),
        (["--all", "none"], "none is not a directory"),
        (["2", "--all", "empty"], "empty contains no submissions"),
        (["--all", "empty"], "name TASK before --all"),
        (["2", "mine.py", "--all", "empty"], "leave out FILE 'mine.py'"),
        (["2"], "name TASK and FILE"),
        (["2", "mine.py", "--jobs", "2"], "name TASK and FILE"),
        (["9", "--all", "empty"], "1 to 6"),
        (["2", "--all", "empty", "--key", ""], "key"),
    ],
)
def test_wrong_arguments(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkdir("empty")
    assert main(["grade", *arguments]) == 2
    assert said in capsys.readouterr().err
