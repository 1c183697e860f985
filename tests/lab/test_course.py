"""The written course: notebooks in nbgrader's format that run, logs and scenes that reveal no speed."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from launching import mpirun

import motes
from motes import course
from motes.cli import main
from motes.errors import ArgumentError

EVENINGS = range(1, 7)
SPEEDS = re.compile(r'"speeds": *\{\s*"|MOTES_SPEEDS')


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("course")
    course.write(folder / "students", key="test")
    course.write(folder / "source", key="test", solutions=True)
    return folder


def notebook(folder: Path, which: str, evening: int) -> dict[str, Any]:
    name = f"evening_{evening}"
    return json.loads((folder / which / name / f"{name}.ipynb").read_text())


@pytest.mark.parametrize("evening", EVENINGS)
def test_notebooks_are_valid_and_in_the_format_of_nbgrader(written: Path, evening: int) -> None:
    nbformat = pytest.importorskip("nbformat")
    for which in ("students", "source"):
        made = notebook(written, which, evening)
        nbformat.validate(made)
        marked = {
            cell["metadata"]["nbgrader"]["grade_id"]: cell
            for cell in made["cells"]
            if "nbgrader" in cell["metadata"]
        }
        answer, test = (marked.pop(f"evening_{evening}_{kind}") for kind in ("answer", "grade"))
        assert marked == {}
        told = answer["metadata"]["nbgrader"]
        assert (told["solution"], told["grade"], told["locked"], told["schema_version"]) == (
            True,
            False,
            False,
            3,
        )
        told = test["metadata"]["nbgrader"]
        assert (told["solution"], told["grade"], told["locked"], told["points"]) == (False, True, True, 100)
        text = "".join(answer["source"])
        assert ("### BEGIN SOLUTION" in text) == ("### END SOLUTION" in text) == (which == "source")
        assert ("raise NotImplementedError()" in text) == (which == "students")
        shown, begins, hidden = "".join(test["source"]).partition("### BEGIN HIDDEN TESTS\n")
        hidden, ends, last = hidden.partition("### END HIDDEN TESTS\n")
        assert bool(begins) == bool(ends) == (which == "source")
        for secret in ("--key", repr("test")):
            assert (secret in hidden) == (which == "source") and secret not in shown + last


def test_students_get_no_solution_and_no_key(written: Path) -> None:
    for evening in EVENINGS:
        text = (written / "students" / f"evening_{evening}" / f"evening_{evening}.ipynb").read_text()
        assert not any(word in text for word in ("SOLUTION", "HIDDEN", "--key", "'test'"))
        longest = max(course.solution(evening).splitlines(), key=len)
        assert longest.strip() not in text


def test_logs_tell_no_speed(written: Path) -> None:
    for path in written.rglob("run/*"):
        assert not SPEEDS.search(path.read_text()), path
    pytest.importorskip("pandas")
    for evening in EVENINGS:
        run = motes.open_run(written / "students" / f"evening_{evening}" / "run")
        assert run.finished and run.speeds == {} and len(run.frames) >= 40
        assert run.load.groupby("frame")["n_end"].sum().tolist() == run.frames["particles"].tolist()
        replay = run.replay(motes.balance.PrefixCuts())
        # Over all frames: a crowd may have jumped in the last.
        assert replay.imbalance("n_end").mean() < run.imbalance("n_end").mean() + 0.5


@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    "evening", [pytest.param(n, marks=pytest.mark.slow) if n > 1 else n for n in EVENINGS]
)
def test_notebooks_run_with_their_solutions(evening: int, tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    for needed in ("ipykernel", "pandas", "matplotlib"):
        pytest.importorskip(needed)
    course.write(tmp_path / "course", solutions=True)
    folder = tmp_path / "course" / f"evening_{evening}"
    made = nbformat.read(folder / f"{folder.name}.ipynb", as_version=4)
    nbclient.NotebookClient(made, timeout=600, resources={"metadata": {"path": str(folder)}}).execute()
    (test,) = (cell for cell in made.cells if cell.metadata.get("nbgrader", {}).get("grade"))
    (score,) = (out["data"]["text/plain"] for out in test.outputs if out.output_type == "execute_result")
    assert float(score) >= 50
    figures = [
        out for cell in made.cells if cell.cell_type == "code" for out in cell.outputs if "data" in out
    ]
    assert sum("image/png" in out["data"] for out in figures) >= 1


def test_a_notebook_still_to_be_solved_has_no_points(tmp_path: Path) -> None:
    (answer,) = (
        cell for cell in course.notebook(3)["cells"] if cell["metadata"].get("nbgrader", {}).get("solution")
    )
    (tmp_path / "mine.py").write_text("".join(answer["source"]).partition("\n")[2])
    found = course.grade(3, tmp_path / "mine.py")
    assert found.score == 0 and "not been written yet" in found.problem


# --- scenes


def test_a_scene_runs_on_ranks_and_tells_no_speed(written: Path, tmp_path: Path) -> None:
    folder = written / "source" / "evening_4"
    (tmp_path / "mine.py").write_text(course.solution(4))
    result = mpirun(
        2, folder / "scene.py", "--log", tmp_path / "log", "--policy", tmp_path / "mine.py", timeout=200
    )
    assert result.code == 0, result.text
    for path in (tmp_path / "log").iterdir():
        assert not SPEEDS.search(path.read_text()), path
    rows = [json.loads(line) for line in (tmp_path / "log" / "frames.jsonl").read_text().splitlines()]
    assert len(rows) == course.Scene(4).frames and rows[-1]["particles"] == 200_000


def test_scenes_name_what_there_is() -> None:
    scene = course.Scene("moving", 2)
    assert set(scene.options) == {"move_s", "frames"} and scene.world["axis"] == "x"
    for wrong in ({"evening": 7}, {"evening": "noize"}, {"evening": 5, "game": 3}, {"evening": 1, "game": 1}):
        with pytest.raises(ArgumentError):
            course.Scene(**wrong)


# --- the command line


def test_the_command_writes_and_overwrites_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["course", str(tmp_path / "new"), "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["notebooks"]
    assert [Path(path).name for path in listed] == [f"evening_{evening}.ipynb" for evening in EVENINGS]
    before = Path(listed[2]).read_bytes()
    assert main(["course", str(tmp_path / "new"), "--solutions"]) == 2
    assert "overwrites nothing" in capsys.readouterr().err and Path(listed[2]).read_bytes() == before
    assert main(["course", str(tmp_path / "other"), "--key", ""]) == 2
    assert not (tmp_path / "other").exists()


def test_the_same_key_writes_the_same_course(written: Path, tmp_path: Path) -> None:
    course.write(tmp_path / "again", key="test")
    for path in sorted(path for path in (written / "students").rglob("*") if path.is_file()):
        assert path.read_bytes() == (tmp_path / "again" / path.relative_to(written / "students")).read_bytes()


def test_nothing_needs_mpi(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(course.solution(2))
    program = "import sys, mpi4py; mpi4py.rc.initialize = False\nimport motes\n"
    program += (
        "print(motes.course.grade(2, 'mine.py').score)\nfrom mpi4py import MPI\nprint(MPI.Is_initialized())"
    )
    environment = {name: value for name, value in os.environ.items() if not name.startswith("OMPI_")}
    told = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert told.stdout.split() == ["100.0", "False"]


NOTES = Path(__file__).parents[2] / "docs" / "notes" / "course.md"


@pytest.mark.skipif(not NOTES.is_file(), reason="the page stands in the source tree")
def test_the_teachers_page_has_the_solutions() -> None:
    shown = re.findall(r"^```python\n(.*?)^```$", NOTES.read_text(), re.MULTILINE | re.DOTALL)
    assert [text.rstrip() for text in shown] == [course.solution(evening).rstrip() for evening in EVENINGS]
