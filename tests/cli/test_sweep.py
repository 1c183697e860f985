"""`motes sweep`: grids, runs in folders, resuming, tables."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from motes._sweep import grid, slurm
from motes.errors import ArgumentError

SCRIPT = """
import sys, time
import motes
from motes.shapes import Box

camera = motes.Camera((0, 0, 8), (0, 0, 0))
renderer = motes.Renderer(64, 48, camera=camera)
world = motes.World(space=(-3, 3), roles="shared", renderer=renderer, log="own")
gravity = world.control("gravity", 1.0, low=0, high=10)
flakes = world.control("flakes", 50, low=1, high=500, step=1)
kind = world.control("kind", "disc", choices=["disc", "sphere"])
snow = world.system("snow", sprite=motes.Sprite(kind.value, pixels=5))
with world:
    for frame in world.frames(3):
        if frame == 0:
            snow.burst(Box((-2, -1, -1), (2, 2, 1)), count=flakes.value)
        if gravity.value == 3:
            raise ValueError("three is too much")
        snow.gravity((0, -gravity.value, 0))
        snow.move()
        world.render().save("frame.png")
        time.sleep(float(sys.argv[1]) if len(sys.argv) > 1 else 0)
"""


def command(directory: Path, *arguments: str) -> list[str]:
    """Return the command of a sweep of SCRIPT into directory/out."""
    (directory / "script.py").write_text(SCRIPT)
    script, out = directory / "script.py", directory / "out"
    return [sys.executable, "-m", "motes", "sweep", str(script), "-o", str(out), *arguments]


def swept(directory: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a sweep to its end."""
    return subprocess.run(command(directory, *arguments), capture_output=True, text=True, timeout=240)


def rows_of(directory: Path) -> list[dict[str, str]]:
    """Return the rows of the table."""
    with (directory / "out" / "sweep.csv").open() as file:
        return list(csv.DictReader(file))


def test_the_values_of_a_grid() -> None:
    """Numbers between two, whole numbers, lists; all combinations, the last one fastest."""
    cases = grid.cases(["a=1:2:3", "seed=3..4", "b=x,y"], [1, 2], ["Static"])
    assert len(cases) == 3 * 2 * 2 * 2
    assert cases[0].name == "a=1, b=x, seed=3, ranks=1, balancer=Static"
    assert cases[1].name == "a=1, b=x, seed=3, ranks=2, balancer=Static"
    assert cases[-1].name == "a=2, b=y, seed=4, ranks=2, balancer=Static"
    assert {dict(case.controls)["a"] for case in cases} == {"1", "1.5", "2"}
    assert [dict(case.controls)["a"] for case in grid.cases(["a=0:0.3:4"], [1])] == ["0", "0.1", "0.2", "0.3"]
    assert [case.seed for case in grid.cases(["seed=7"], [1])] == [7]
    assert grid.whole_numbers("--ranks", "1,2,4") == [1, 2, 4]
    assert grid.whole_numbers("--ranks", "2..4") == [2, 3, 4]
    odd = grid.cases(["path=../x,y/" + "z" * 300], [1])
    folders = [case.folder for case in odd]
    assert len(set(folders)) == 2 and all("/" not in one and len(one) < 200 for one in folders)


@pytest.mark.parametrize(
    "text",
    ["a", "=1", "a=", "a=1,,2", "a=1:2:0", "a=1:1:2", "a=3..1", "a=1,1", "a=1:x:3", "a=0:inf:3"],
)
def test_wrong_values_are_named(text: str) -> None:
    """The message says what is allowed."""
    with pytest.raises(ArgumentError, match=r"NAME=a:b:n"):
        grid.cases([text], [1])


def test_other_wrong_arguments_are_named() -> None:
    """Values twice, options as values, too many runs, seeds and ranks that are none."""
    for given, text in (
        (["a=1", "a=2"], "given twice"),
        (["ranks=1,2"], "use --ranks"),
        (["seed=-1..2"], "seed must be"),
        (["seed=x"], "seed must be"),
        (["a=1:2:1000", "b=1..1000"], "for at most 100000 runs.*these are 1000000"),
    ):
        with pytest.raises(ArgumentError, match=text):
            grid.cases(given, [1])
    for text in ("0", "1,1", "x", "", "-1..2"):
        with pytest.raises(ArgumentError, match="--ranks must be whole numbers above 0"):
            grid.whole_numbers("--ranks", text)


def test_an_array_for_slurm_names_what_is_missing(tmp_path: Path) -> None:
    """The script starts one task per missing run, with enough ranks."""
    path = slurm.write_script(tmp_path, ["a b.py", "-o", "out"], [0, 1, 2, 5, 7, 8], 4)
    text = path.read_text()
    assert "#SBATCH --array=0-2,5,7-8\n" in text and "#SBATCH --ntasks=4\n" in text
    assert "-m motes sweep --only \"$SLURM_ARRAY_TASK_ID\" 'a b.py' -o out" in text


def test_a_sweep_runs_compares_and_repeats_nothing(tmp_path: Path) -> None:
    """One row per run; digests do not depend on ranks or balancers; a failed run is a row, and runs again."""
    given = (
        "--set",
        "gravity=1,3",
        "--set",
        "kind=sphere",
        "--ranks",
        "1,2",
        "--balancer",
        "Static,Pairwise",
    )
    first = swept(tmp_path, *given, "--set", "seed=5", "--jobs", "2")
    assert first.returncode == 1, first.stderr
    rows = rows_of(tmp_path)
    assert [(row["gravity"], row["ranks"], row["balancer"]) for row in rows] == [
        (gravity, ranks, balancer)
        for gravity in "13"
        for ranks in "12"
        for balancer in ("Static", "Pairwise")
    ]
    good, bad = rows[:4], rows[4:]
    assert len({row["particles"] for row in good}) == len({row["picture"] for row in good}) == 1
    assert all(float(row["frame_s"]) > 0 and row["frames"] == "3" and row["count"] == "50" for row in good)
    assert all("three is too much" in row["error"] and not row["particles"] for row in bad)
    assert not any(row["error"] for row in good)
    out = tmp_path / "out"
    facts = json.loads((out / good[1]["folder"] / "log" / "run.json").read_text())
    assert facts["seed"] == 5 and facts["balancer"].startswith("Pairwise(")
    assert (out / good[0]["folder"] / "frame.png").exists() and not (out / good[0]["folder"] / "own").exists()
    assert (out / "sheet.png").exists()
    marks = {path: path.stat().st_mtime_ns for path in out.glob("*/done.json")}
    assert len(marks) == 4
    again = swept(tmp_path, *given, "--set", "seed=5")
    assert again.returncode == 1 and "4 of 8 runs are complete" in again.stderr
    assert {path: path.stat().st_mtime_ns for path in out.glob("*/done.json")} == marks
    assert [row["particles"] for row in rows_of(tmp_path)] == [row["particles"] for row in rows]
    changed = command(tmp_path, *given, "--set", "seed=5")
    (tmp_path / "script.py").write_text(SCRIPT + "\n")
    other = subprocess.run(changed, capture_output=True, text=True, timeout=60)
    assert other.returncode == 2 and "the script has changed since; --fresh removes its runs" in other.stderr


def test_an_unknown_control_ends_it_before_anything_runs(tmp_path: Path) -> None:
    """The message lists the script's controls; other balancers are named, too."""
    wrong = swept(tmp_path, "--set", "gravty=1")
    assert wrong.returncode == 2 and not (tmp_path / "out").exists()
    assert "(flakes, gravity, kind), got 'gravty'; did you mean 'gravity'?" in wrong.stderr
    wrong = swept(tmp_path, "--balancer", "Static,Pairwize")
    assert wrong.returncode == 2 and "did you mean 'Pairwise'?" in wrong.stderr


@pytest.mark.parametrize("runs", [6, pytest.param(24, marks=pytest.mark.slow)])
def test_a_sweep_killed_in_the_middle_does_the_rest(tmp_path: Path, runs: int) -> None:
    """The second start runs what is missing and nothing else, and writes the whole table."""
    given = ("--set", f"flakes=1..{runs}", "--set", "seed=1", "--jobs", "2", "--", "0.2")
    out = tmp_path / "out"
    sweep = subprocess.Popen(command(tmp_path, *given), stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 120
    while len(list(out.glob("*/done.json"))) < runs // 3 and time.monotonic() < deadline:
        time.sleep(0.05)
    sweep.kill()
    sweep.wait()
    marks = {path: path.stat().st_mtime_ns for path in out.glob("*/done.json")}
    assert runs // 3 <= len(marks) < runs
    rest = swept(tmp_path, *given)
    assert rest.returncode == 0, rest.stderr
    assert f"{len(marks)} of {runs} runs are complete" in rest.stderr
    assert f"1 of {runs - len(marks)}: " in rest.stderr
    assert {path: path.stat().st_mtime_ns for path in marks} == marks
    assert [row["count"] for row in rows_of(tmp_path)] == [str(n) for n in range(1, runs + 1)]
    assert os.listdir(out / "flakes=1,seed=1,ranks=1")
