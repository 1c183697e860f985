"""`World(progress="bar")`: one line that is redrawn in place."""

from __future__ import annotations

import pytest

import motes


@pytest.fixture(autouse=True)
def no_wish(monkeypatch):
    monkeypatch.delenv("MOTES_PROGRESS", raising=False)


def run(progress: str, frames: int = 3) -> None:
    world = motes.World(seed=1, progress=progress)
    system = world.system("a")
    with world:
        for _ in world.frames(frames):
            system.burst((0, 0, 0), count=5)
            system.move()
            world.step()


def test_a_bar_is_drawn_in_place_and_ends_its_line(capfd):
    run("bar")
    said = capfd.readouterr().err
    drawn = said[said.index("\r") :]
    assert drawn.count("\n") == 1, "one line"
    assert drawn.endswith("\n"), "what is printed next starts on a line of its own"
    parts = drawn.split("\r\x1b[K")[1:]
    assert parts[0].startswith("frame 1/3  33%")
    assert parts[-1].startswith("frame 3/3  100%")
    assert "15 particles" in parts[-1]


def test_lines_are_whole_and_never_move_the_cursor(capfd):
    run("lines")
    said = capfd.readouterr().err
    assert "frame 3/3  100%" in said
    assert "\r" not in said
    assert "\x1b" not in said


def test_the_environment_chooses_the_bar(capfd, monkeypatch):
    monkeypatch.setenv("MOTES_PROGRESS", "bar")
    run("off")
    assert "\r\x1b[Kframe 3/3" in capfd.readouterr().err
