"""Grades are reproducible, and the grade of a failed submission says why."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from submissions import BAD

from motes import course
from motes.cli import main
from motes.errors import MotesError
from motes_lab.course import cutting, reading
from motes_lab.course._secret import Secret

EVENINGS = range(1, 7)
WORTH = {1: 100, 2: 100, 3: 80, 4: 80, 5: 80, 6: 80}
"""The least points of the course's own solutions by evening, for any key."""


def hand_in(folder: Path, text: str) -> Path:
    path = folder / "mine.py"
    path.write_text(text)
    return path


@pytest.mark.parametrize("evening", EVENINGS)
def test_solutions_are_worth_their_points(evening: int, tmp_path: Path) -> None:
    path = hand_in(tmp_path, course.solution(evening))
    found = course.grade(evening, path)
    assert not found.problem, found.problem
    assert found.score >= WORTH[evening], str(found)
    assert found == course.grade(found.name, str(path))
    other = course.grade(evening, path, key="another")
    assert other.score >= WORTH[evening], str(other)
    if evening > 2:
        assert [part.result for part in other.parts] != [part.result for part in found.parts]


@pytest.mark.slow
@pytest.mark.parametrize("evening", EVENINGS)
def test_twenty_grades_beside_other_work_are_the_same(evening: int, tmp_path: Path) -> None:
    path = hand_in(tmp_path, course.solution(evening))
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        first = course.grade(evening, path, key="twenty")
        for _ in range(19):
            assert course.grade(evening, path, key="twenty") == first
    finally:
        for one in busy:
            one.kill()
            one.wait()
    assert not first.problem


@pytest.mark.parametrize("wrong", BAD)
def test_a_submission_that_fails_says_why(wrong: str, tmp_path: Path) -> None:
    text, said = BAD[wrong]
    found = course.grade(3, hand_in(tmp_path, text))
    assert found.score == 0 and found.parts == []
    assert re.search(said, found.problem), found.problem
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.py"]


@pytest.mark.slow
@pytest.mark.parametrize("line", ["while True: pass", "__import__('threading').Event().wait()"])
def test_a_submission_that_never_answers_is_ended(line: str, tmp_path: Path) -> None:
    text = (
        f"from motes.balance import Balancer\nclass Mine(Balancer):\n  def decide(self, load):\n    {line}\n"
    )
    found = course.grade(3, hand_in(tmp_path, text))
    assert re.search("processor time|does not answer", found.problem)


@pytest.mark.slow
def test_a_submission_that_stops_itself_or_waits_often_is_ended(tmp_path: Path) -> None:
    for line in ("signal.raise_signal(signal.SIGSTOP)", "threading.Event().wait(5)"):
        text = "import signal, threading\nfrom motes.balance import *\nclass Mine(Balancer):\n"
        text += f"  def decide(self, load):\n    {line}\n    return Orders([])\n"
        assert "does not answer" in course.grade(3, hand_in(tmp_path, text)).problem


def test_the_submission_s_process_finds_mpi_as_the_grader_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    modules, private = tmp_path / "modules", tmp_path / "class"
    for folder in (modules, private):
        folder.mkdir()
        (folder / f"from_{folder.name}.py").write_text("x = 1\n")
    monkeypatch.chdir(private)
    monkeypatch.setenv("PYTHONPATH", f"{modules}:.:{tmp_path}:")
    monkeypatch.setenv("OPAL_PREFIX", "/opt/there")
    text = "import os, from_modules\nprint(os.environ['OPAL_PREFIX'])\nimport from_class\n"
    found = course.grade(2, hand_in(private, text))
    assert found.printed == "/opt/there\n" and "No module named 'from_class'" in found.problem
    monkeypatch.setenv("MPI4PY_LIBMPI", str(tmp_path / "libnone.so"))
    with pytest.raises(MotesError, match=r"does not start in the process for the submission: .*libnone\.so"):
        course.grade(2, private / "mine.py")


def test_printing_does_not_count(tmp_path: Path) -> None:
    quiet = course.solution(2)
    loud = quiet.replace("    below =", "    print('edges', len(edges))\n    below =")
    assert loud != quiet
    found = course.grade(2, hand_in(tmp_path, loud))
    assert found.score == 100 and found.printed.startswith("edges ")
    assert "it printed, which does not count: edges" in str(found)


def test_a_submission_sees_nothing_of_the_grader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTES_SPEEDS", "1:0.5")
    monkeypatch.setenv("COURSE_KEY", "secret")
    text = "import os, sys\nprint(sorted(os.environ), sys.argv[1:], os.listdir())\n"
    printed = course.grade(2, hand_in(tmp_path, text), key="secret").printed
    assert "secret" not in printed and "MOTES" not in printed and "COURSE_KEY" not in printed
    assert printed.rstrip().endswith("[]")


def test_what_everybody_tries_first_is_worth_less(tmp_path: Path) -> None:
    simple = (
        "import motes\nfrom motes.balance import *\n\n\nclass Mine(Balancer):\n    def __init__(self, **_):\n"
    )
    simple += "        pass\n\n    def decide(self, load):\n        return Targets(load.powers)\n"
    path = hand_in(tmp_path, simple)
    assert {course.grade(evening, path).score for evening in (3, 4)} == {0}
    still = hand_in(tmp_path, "from motes.balance import Static\n\n\nclass Mine(Static):\n    pass\n")
    found = course.grade(3, still)
    assert [part.points for part in found.parts] == [0, 0, 0]
    assert found.parts[1].hint == "you moved nothing, but moving pays here"


@pytest.mark.parametrize(
    ("change", "key", "hint"),
    [
        (("mean / longest", "longest / mean"), "load_balance", "its inverse"),
        (("mean / longest", "np.mean(seconds.mean(1) / seconds.max(1))"), "load_balance", "nearly"),
        (("/ len(frame_s)", ""), "saving_s", "for the whole run"),
        (("(longest - shared)", "(longest - mean)"), "saving_s", "fast machines"),
        (
            ("np.argmin(speed)", "np.argmax(seconds.sum(0))"),
            "slow",
            "longest",
        ),
        (('"crowded": np.argmax(particles.sum(axis=0)),', ""), "crowded", "not return a dict with 'crowded'"),
        (("mean / total", "float('nan')"), "parallel", "finite"),
    ],
)
def test_wrong_reports_get_a_hint(change: tuple[str, str], key: str, hint: str, tmp_path: Path) -> None:
    right = course.solution(1)
    assert change[0] in right
    found = course.grade(1, hand_in(tmp_path, right.replace(*change)))
    part = next(part for part in found.parts if part.name == key)
    assert part.points < 100 and hint in part.hint, str(found)
    assert all(other.points == 100 for other in found.parts if other is not part)


@pytest.mark.parametrize(
    ("returned", "hint"),
    [
        ("np.searchsorted(below, wanted)", "wrong side"),
        ("edges[np.searchsorted(below, wanted)]", "inside the bin"),
        ("[1.0]", "cuts"),
        ("None", "cuts"),
        ("wanted * np.nan", "finite and ascend"),
        ("np.interp(wanted, below, edges)[::-1]", "finite and ascend"),
    ],
)
def test_wrong_cuts_get_a_hint(returned: str, hint: str, tmp_path: Path) -> None:
    text = course.solution(2).replace("np.interp(wanted, below, edges)", returned)
    found = course.grade(2, hand_in(tmp_path, text))
    assert found.score < 100 and any(hint in part.hint for part in found.parts), str(found)


# --- hidden cases


def test_keys_decide_the_cases() -> None:
    for made in (cutting.cases, reading.cases):
        one, two, other = made("a"), made("a"), made("b")
        for field in vars(one[0]):
            values = [[getattr(case, field) for case in cases] for cases in (one, two, other)]
            assert all(np.array_equal(x, y) for x, y in zip(values[0], values[1], strict=True))
        assert not np.array_equal(one[0].__dict__["counts" if made is cutting.cases else "seconds"], None)
    assert [Secret("a", "x").uniform() for _ in range(2)] == [Secret("a", "x").uniform() for _ in range(2)]
    assert Secret("a", "x").uniform() != Secret("b", "x").uniform() != Secret("a", "y").uniform()


def test_balance_saves_more_than_the_mean_wait_between_unlike_machines() -> None:
    speeds, particles = np.array([1.0, 0.5, 0.25, 0.25]), np.full((10, 4), 100.0)
    seconds = particles / speeds
    case = reading.Case("unlike", seconds, particles, seconds.max(axis=1))
    assert reading.answers(case)["saving_s"] == pytest.approx(400 - 400 / 2.0)
    assert reading.answers(case)["load_balance"] == pytest.approx(275 / 400)


def test_secret_numbers_are_spread_as_they_say() -> None:
    secret = Secret("key", "spread")
    numbers = [secret.whole(3, 7) for _ in range(2000)]
    assert set(numbers) == {3, 4, 5, 6, 7} and 300 < numbers.count(5) < 500
    assert sorted(secret.shuffled([1, 2, 2, 3])) == [1, 2, 2, 3]
    noise = secret.noise((200, 10), 0.05)
    assert abs(noise.mean()) < 0.005 and 0.045 < noise.std() < 0.055


# --- the command line


def test_the_command_grades(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(hand_in(tmp_path, course.solution(2)))
    assert main(["grade", "2", path]) == 0
    assert capsys.readouterr().out.startswith("evening 2, cutting: 100 of 100\n")
    assert main(["grade", "cutting", path, "--json", "--key", "k"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["score"] == 100 and figures["problem"] == "" and len(figures["parts"]) == 7
    hand_in(tmp_path, "x = 1\n")
    assert main(["grade", "2", path]) == 1
    assert "the submission fails: it raises NameError" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["7", "mine.py"], "1 to 6"),
        (["noize", "mine.py"], "did you mean 'noise'"),
        (["3", "nowhere.py"], "file nowhere.py does not exist"),
        (["3", "mine.py", "--key", ""], "key"),
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
    hand_in(tmp_path, course.solution(3))
    assert main(["grade", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_a_key_may_come_from_the_standard_input(tmp_path: Path) -> None:
    path = hand_in(tmp_path, course.solution(2))
    command = [sys.executable, "-m", "motes", "grade", "2", str(path), "--key", "-", "--json"]
    told = subprocess.run(command, input="secret\n", capture_output=True, text=True, check=True)
    assert json.loads(told.stdout)["score"] == 100
