"""A warning if no picture shows any particle of a system: all are behind the camera, or outside its view."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import pytest
from standing import on_ranks

import motes

BEHIND = "all its particles are behind the camera"
BESIDE = "all its particles are outside the camera's view"


def said(
    position: tuple[float, float, float],
    frames: int,
    velocity: tuple[float, float, float] = (0, 0, 0),
    *,
    alpha: float = 1,
    other_seen: bool = True,
    log: Path | None = None,
    checkpoint: Path | None = None,
) -> list[str]:
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    renderer = motes.Renderer(32, 18, camera=camera)
    world = motes.World(seed=1, progress="off", renderer=renderer, log=log, checkpoint=checkpoint)
    system, other = world.system("s"), world.system("other")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with world:
            for frame in world.frames(frames):
                if frame == 0:
                    system.emit(position=[position], velocity=[velocity], alpha=[alpha])
                    other.emit(position=[(0, 0, 0) if other_seen else (0, 30, 0)])
                other.move()
                system.move()
                world.render()
    return [str(one.message) for one in caught]


def test_a_system_behind_the_camera_is_said_after_its_first_picture():
    for frames in (1, 2, 40):
        (told,) = said((0, 0, 9), frames)
        assert told.startswith(f"system 's': {BEHIND}")


def test_a_system_outside_of_the_picture_is_said_when_it_stays_there(tmp_path):
    (told,) = said((0, 30, 0), 40)
    assert told.startswith(f"system 's': {BESIDE}")
    for frames in (1, 3):
        told, _ = said((0, 30, 0), frames, other_seen=False)
        assert told.startswith(f"system 's': {BESIDE}")
    assert said((0, 30, 0), 3) == [], "a short film, and another system is in it"
    told, _ = said((0, 30, 0), 5, other_seen=False, checkpoint=tmp_path / "kept")
    assert BESIDE in told, "the checkpoint at the end has asked for the last picture's account before the end"
    assert said((0, 6, 0), 40, velocity=(0, -6, 0)) == [], "it comes into the picture"
    assert said((0, 0, 0), 40, velocity=(0, 30, 0)) == [], "it was in it"


def test_what_is_in_the_picture_and_too_dark_is_no_reason():
    assert said((0, 0, 0), 3) == said((0, 0, 0), 30, alpha=0) == []


def test_the_log_has_it_as_an_event(tmp_path):
    said((0, 0, 9), 3, log=tmp_path / "log")
    rows = [json.loads(line) for line in (tmp_path / "log" / "events.jsonl").read_text().splitlines()]
    (row,) = [row for row in rows if row["kind"] == "unseen"]
    assert row["frame"] == 0 and BEHIND in row["text"]
    assert [row["frame"] for row in rows] == sorted(row["frame"] for row in rows)


SCENE = """
import sys, warnings
import numpy as np
import motes

path, at = sys.argv[1], tuple(float(x) for x in sys.argv[2:5])
camera = motes.Camera((0, 0, 5), (0, 0, 0))
renderer = motes.Renderer(64, 36, camera=camera, path=path)
world = motes.World(seed=1, progress="off", space=(-2, 2), renderer=renderer)
s = world.system("s")
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    with world:
        for frame in world.frames(2):
            if frame == 0:
                s.emit(position=(np.linspace(-1, 1, 60)[:, None] * (1, 0, 0) + at).astype(np.float32))
            s.move()
            world.render()
        digest = world.digest()
print(f"digest {digest}", flush=True)
for one in caught:
    print(f"told {one.message}", flush=True)
"""


@pytest.mark.parametrize("path", ["gather", "tiles", "composite"])
def test_it_is_said_once_on_any_number_of_ranks(path):
    digests = set()
    for ranks in (1, 3):
        lines = on_ranks(ranks, SCENE, path, 0, 0, 9).lines
        digests |= {line for line in lines if line.startswith("digest")}
        (told,) = [line for line in lines if line.startswith("told")]
        assert BEHIND in told
    assert len(digests) == 1
    lines = on_ranks(3, SCENE, path, -1.5, 0, 2).lines
    assert len(lines) == 3, "a part of it is in the picture, and all of it on other ranks is not"
