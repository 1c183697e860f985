"""Warnings about interactions: crowded cells, lasting overlaps, springs that are too stiff."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes import MotesWarning
from motes.shapes import Box


def told(frames: int, record, *, substeps: int = 2, log: Path | None = None, **state) -> list[str]:
    """Run particles with the given state for some frames; return the warnings."""
    world = motes.World(seed=1, substeps=substeps, progress="off", log=log)
    sand = world.system("sand")
    with warnings.catch_warnings(record=True) as caught, world:
        warnings.simplefilter("always")
        for frame in world.frames(frames):
            if frame == 0:
                sand.emit(**state)
            record(sand)
            sand.move()
            world.step()
    return [str(one.message) for one in caught if issubclass(one.category, MotesWarning)]


def nozzle(count: int) -> np.ndarray:
    return np.random.default_rng(1).uniform(0, 0.01, (count, 3))


def test_a_crowded_cell_is_told_once_and_logged(tmp_path: Path):
    log = tmp_path / "log"
    texts = told(4, lambda s: s.gravitate(1e-6, max_radius=1), position=nozzle(1200), log=log)
    assert len(texts) == 1
    assert "system 'sand': " in texts[0] and " particles are in one cell" in texts[0]
    assert told(4, lambda s: s.gravitate(1e-6, max_radius=1), position=nozzle(900)) == []
    run = motes.open_run(log)
    assert run.load["most_in_a_cell"].max() >= 1000
    event = run.events[run.events["kind"] == "crowded"]
    assert event["text"].tolist() == texts
    assert texts[0] in run.warnings()


def test_springs_that_are_too_stiff_are_told():
    pair = [(0, 0, 0), (0.15, 0, 0)]
    soft, stiff = (told(3, lambda s, k=k: s.contact(k, radius=0.1), position=pair) for k in (10.0, 1e6))
    assert soft == []
    assert len(stiff) == 1 and "softened" in stiff[0]
    # The longest sub-step is sqrt(0.39 mass / 2 / stiffness); grains have 1 kg, a frame lasts 1/24 s.
    assert "at most 0.00044 s (World(substeps=95), now 2)" in stiff[0]


def test_springs_are_judged_by_the_lightest_grain_before_anything_touches():
    far = [(0, 0, 0), (5, 0, 0)]
    needed = math.ceil(math.sqrt(2e3 * 2 / (0.39 * 0.01)) / 24)
    for mass in ([1, 0.01], [0.01, 0.01]):
        texts = told(1, lambda s: s.contact(2e3, radius=0.1), position=far, mass=mass)
        assert len(texts) == 1 and f"World(substeps={needed}), now 2" in texts[0]
    assert told(1, lambda s: s.contact(2e3, radius=0.1), position=far, mass=[1, 0.01], substeps=needed) == []


def squeeze(substeps: int, frames: int = 30, log: Path | None = None) -> list[str]:
    """Return the warnings about a tall stack of grains that needs many sub-steps."""
    grid = np.stack(np.meshgrid(np.arange(3), np.arange(40), np.arange(3), indexing="ij"), -1).reshape(-1, 3)
    walls = Box((-0.05, 0, -0.05), (0.25, 99, 0.25))

    def pile(sand: motes.System) -> None:
        sand.gravity((0, -9.81, 0))
        sand.collide(0.05)
        sand.bounce(walls, restitution=0)

    return told(frames, pile, substeps=substeps, position=grid * 0.1 + (0, 0.05, 0), log=log)


def test_overlaps_that_stay_are_told(tmp_path: Path):
    texts = squeeze(1, log=tmp_path / "log")
    assert len(texts) == 1 and " overlaps by " in texts[0] and "more sub-steps" in texts[0]
    deep = motes.open_run(tmp_path / "log").load["overlap_99"]
    assert deep.iloc[-1] > 0.3
    assert squeeze(30, log=tmp_path / "fine") == []
    assert motes.open_run(tmp_path / "fine").load["overlap_99"].max() < 0.2


def test_overlaps_are_those_of_the_grains(tmp_path: Path):
    def still(sand: motes.System) -> None:
        sand.collide(0.05, where=Box((5, 5, 5), (6, 6, 6)))

    told(1, still, position=[(0, 0, 0), (0.08, 0, 0), (1, 0, 0)], log=tmp_path / "log")
    load = motes.open_run(tmp_path / "log").load
    assert load["overlap_99"].tolist() == pytest.approx([0.2], abs=1e-6)


SCRIPT = """
import numpy as np, motes
world = motes.World(seed=1, space=(-1, 1), progress="off")
a, b = world.system("a"), world.system("b")
with world:
    for frame in world.frames(3):
        if frame == 0:
            b.emit(position=np.random.default_rng(1).uniform(0.5, 0.51, (1500, 3)))
        a.gravitate(max_radius=1)
        b.gravitate(1e-6, max_radius=1)
        b.move()
        world.step()
"""


@pytest.mark.parametrize("ranks", [1, 3, 5])
def test_one_rank_tells(ranks: int):
    ended = on_ranks(ranks, SCRIPT)
    assert ended.code == 0
    assert ended.err.count("1500 particles are in one cell") == 1
    assert "system 'b'" in ended.err
