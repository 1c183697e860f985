"""`Checkpoint(every="auto")` bounds how long any frame takes to compute, within a budget of disk."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import motes
from motes._checkpoint import folder, pacing
from motes._checkpoint.manifest import Manifest, PartEntry
from motes.errors import ArgumentError


class Ranks:
    """An engine whose ranks need a time per frame; counts how often they talk."""

    def __init__(self, others: list[Callable[[int], float]] | None = None) -> None:
        self.others = others or []
        self.frame = 0
        self.talks = 0
        self.seconds = 0.0
        self.drawing = 5.0

    @property
    def times(self) -> dict[str, float]:
        """This rank's times in the last frame."""
        return {"t_frame_s": self.seconds + self.drawing, "t_render_s": self.drawing}

    def tell(self, say: Callable[[], str]) -> list[str]:
        """Return what all ranks say."""
        self.talks += 1
        return [say(), *(repr(other(self.frame)) for other in self.others)]


def due_frames(engine: Ranks, seconds: float, cost: Callable[[int], float], frames: int) -> list[int]:
    """Return the frames before which a checkpoint is due."""
    pace, due = pacing.Pace(seconds, 0), []
    for frame in range(1, frames):
        engine.frame, engine.seconds = frame, cost(frame)
        if pace.due(engine):  # type: ignore[arg-type]
            pace.begin(engine)  # type: ignore[arg-type]
            due.append(frame)
    assert pace.total_s == pytest.approx(sum(map(cost, range(1, 1 + max(due, default=0)))))
    return due


def longest(due: list[int], cost: Callable[[int], float], frames: int) -> float:
    """Return the longest time of computing from a checkpoint to a frame after it."""
    ends = [0, *due, frames - 1]
    return max(sum(map(cost, range(a + 1, b + 1))) for a, b in zip(ends, ends[1:], strict=False))


@pytest.mark.parametrize(
    "cost", [lambda k: 0.01, lambda k: 0.3, lambda k: 0.001 * k, lambda k: 0.3 if k % 50 > 30 else 0.02]
)
def test_computing_any_frame_takes_at_most_the_seconds(cost: Callable[[int], float]) -> None:
    engine = Ranks()
    due = due_frames(engine, 2, cost, 1000)
    assert 1.2 < longest(due, cost, 1000) < 2.35  # one frame's surprise
    assert engine.talks <= 103 * (len(due) + 1)


def test_a_frame_that_takes_longer_gets_a_checkpoint_each() -> None:
    assert due_frames(Ranks(), 2, lambda k: 3.0, 5) == [1, 2, 3, 4]


def test_ranks_that_wait_for_the_picture_do_not_count() -> None:
    waits = Ranks([lambda frame: 1000.0])
    assert due_frames(waits, 2, lambda k: 0.5, 9) == [4, 8]


def checkpoint(directory: Path, frame: int, stepped_s: float, size: int) -> None:
    """Write a checkpoint without particles."""
    place = directory / f"frame-{frame:06}"
    place.mkdir()
    facts: dict[str, Any] = {"time_s": 0, "seed": 1, "dt_s": 1, "substeps": 1, "motes": "", "script": {}}
    parts = [PartEntry("part", size, [0])]
    Manifest(frame, systems=["s"], parts=parts, world={"bytes": 0}, stepped_s=stepped_s, **facts).write(place)


def frames_in(directory: Path) -> list[int]:
    """List the frames of the checkpoints."""
    return [frame for frame, _ in reversed(folder.whole(directory))]


def test_checkpoints_that_are_not_needed_go(tmp_path: Path) -> None:
    for frame, seconds in [(10, 0.9), (20, 1.9), (30, 2.5), (40, 3.8), (50, 5.7), (60, 5.8), (70, 5.9)]:
        checkpoint(tmp_path, frame, seconds, 10**6)
    (tmp_path / "frame-000015").mkdir()  # damaged: not counted, not removed
    pacing.thin(tmp_path, motes.Checkpoint(tmp_path, every="auto", keep=2))
    assert frames_in(tmp_path) == [10, 15, 30, 40, 60, 70]


def test_the_budget_thins_evenly(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    wish = motes.Checkpoint(tmp_path, every="auto", keep=2, gigabytes=0.008)
    for number in range(1, 41):
        checkpoint(tmp_path, number, 2.0 * number, 10**6)
        pacing.thin(tmp_path, wish)
    left = frames_in(tmp_path)
    assert len(left) == 8 and left[-2:] == [39, 40]
    gaps = [b - a for a, b in zip([0, *left], left[:-1], strict=False)]
    assert max(gaps) <= 10, left
    said = capfd.readouterr().err
    assert said.count("fill their 0.008 GB: from now on up to 4 s of computing lie between two") == 1


def test_a_run_keeps_checkpoints_for_all_its_frames(tmp_path: Path) -> None:
    world = motes.World(
        seed=1, progress="off", checkpoint=motes.Checkpoint(tmp_path, every="auto", seconds=0)
    )
    system = world.system("s")
    with world:
        for _ in world.frames(6):
            system.source((0, 0, 0), rate=100)
            system.move()
            world.step()
    assert frames_in(tmp_path) == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("every", bad) for bad in ("Auto", "", 0, 1.5, None)),
        *(("seconds", bad) for bad in (-1, "2", float("nan"), None)),
        *(("gigabytes", bad) for bad in (-1, "2", float("inf"))),
    ],
)
def test_arguments_are_checked(name: str, value: Any) -> None:
    with pytest.raises(ArgumentError, match=name):
        motes.Checkpoint("somewhere", **{name: value})
