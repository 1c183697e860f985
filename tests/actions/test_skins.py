"""The skin of neighbour lists, and when they are rebuilt, change no bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from launching import python
from skins import SCENE
from standing import on_ranks

import motes
from motes import expressions as ex

FAR = 1.5  # three radii of the largest grain


def digests(ranks: int, clumps: int, count: int, folder: Path, **env: str) -> list[str]:
    """Run the scene, from its checkpoint if there is one; return the lines of digests."""
    lines = on_ranks(ranks, SCENE, clumps, count, folder, env=env, timeout=300).lines
    return [line for line in lines if line.startswith("digest")]


def compare(clumps: int, count: int, skins: list[float], folder: Path) -> None:
    """Compare runs on one and three ranks with each skin, and a run that resumes with another skin."""
    expected = digests(1, clumps, count, folder / "own")
    assert expected[-1] == "digest touching True" and len(set(expected)) == 7
    for number, skin in enumerate(skins):
        for ranks in (1, 3):
            got = digests(ranks, clumps, count, folder / f"{skin} {ranks}", MOTES_SKIN=str(skin))
            assert got == expected, f"skin {skin}, {ranks} ranks"
        killed = folder / f"{skin} killed"
        assert python(SCENE, clumps, count, killed, env={"KILL": "5", "MOTES_SKIN": str(skin)}).code == 9
        rest = digests(3, clumps, count, killed, MOTES_SKIN=str(skins[number - 1]), MOTES_ANYWAY="1")
        assert 1 < len(rest) < len(expected) and rest == expected[-len(rest) :], f"skin {skin}, gone on"


@pytest.mark.parametrize("clumps", [0, 1])
def test_no_skin_changes_a_bit(clumps: int, tmp_path: Path):
    compare(clumps, 120, [0, 0.3, FAR], tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("clumps", [0, 1])
def test_no_skin_changes_a_bit_of_many(clumps: int, tmp_path: Path):
    compare(clumps, 1500, [0, 0.01, 0.1, 0.5, 1, FAR, 3], tmp_path)


@pytest.mark.parametrize("skin", ["", "0", "0.5", "3"])
def test_a_pair_goes_on_from_one_image_to_another(skin: str, monkeypatch: pytest.MonkeyPatch):
    """A pair half a period apart interacts across one end of space, and then within it."""
    monkeypatch.setenv("MOTES_SKIN", skin)
    world = motes.World(seed=1, dt=0.01, periodic={"x": (0, 1)}, progress="off")
    s = world.system("s", attributes={"seen": 0})
    with world:
        s.emit(position=[(0.1, 0, 0), (0.58, 0, 0)], velocity=[(0, 0, 0), (0.7, 0, 0)])
        for _ in range(8):
            s.interact(0.5, set={"k": ex.a.state.k + 1, "seen": ex.a.state.k}, state={"k": 1})
            s.move()
            world.step()
        np.testing.assert_array_equal(s.gather().seen, 7)


def test_ranks_with_other_skins_are_told():
    script = "import os, motes\nos.environ['MOTES_SKIN'] = os.environ['OMPI_COMM_WORLD_RANK']\n"
    result = on_ranks(2, script + "with motes.World(progress='off'):\n    pass\n")
    assert result.code != 0 and "skin" in result.err
