"""The effects of the gallery: what a small run of each yields, its still, and the page that shows all."""

from __future__ import annotations

import re
from pathlib import Path

import effects
import numpy as np
import pytest
from docs_scripts import script_of_docs
from standing import on_ranks

import motes

pytest.importorskip("av")
STILLS = effects.ROOT / "docs" / "gallery"
SMALL = effects.table()
NAMES = effects.names()

make_gallery = script_of_docs("make_gallery")


def test_there_are_thirty_effects_and_each_stands_in_the_table():
    assert len(NAMES) >= 30
    assert sorted(SMALL) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_the_last_frame_has_the_digests_of_the_table(name: str, tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MOTES_PROGRESS", "off")
    said = effects.lines(name, SMALL[name].options(tmp_path))
    assert [frame for frame, *_ in said] == [str(frame) for frame in range(SMALL[name].frames)]
    assert tuple(said[-1][1:]) == SMALL[name].digests, "another picture? python tests/support/effects.py"
    assert len({picture for *_, picture in said}) > SMALL[name].frames // 2, "it moves"
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"{name}.mp4", f"{name}.png"]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_an_effect_looks_the_same_on_three_ranks(name: str, tmp_path: Path):
    said = on_ranks(3, effects.script(name), *SMALL[name].options(tmp_path), timeout=60).lines
    last = [line.split() for line in said if line[0].isdigit()][-1]
    assert (int(last[0]), tuple(last[1:])) == (SMALL[name].frames - 1, SMALL[name].digests)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_an_effect_is_as_bright_at_any_resolution(name: str, tmp_path: Path):
    light = []
    for height in (90, 360):
        options = [*SMALL[name].options(tmp_path), "--size", f"{height * 16 // 9}x{height}"]
        effects.lines(name, options)
        shown = make_gallery.pixels(tmp_path / f"{name}.png") / 255
        linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
        light.append(linear.mean())
    assert light[0] == pytest.approx(light[1], rel=0.2)


@pytest.mark.parametrize("name", NAMES)
def test_stills_are_neither_dark_nor_empty(name: str):
    picture = make_gallery.pixels(make_gallery.still(name))
    assert (picture.max(axis=2) > 80).mean() > 0.01, "dark"
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 200, "empty"
    assert picture.shape == (270, 480, 3)
    assert make_gallery.still(name).stat().st_size < 300_000


def test_scripts_are_short_and_say_how_they_are_run():
    for name in NAMES:
        text = effects.script(name).read_text()
        path = effects.script(name).relative_to(effects.ROOT)
        assert len(text.splitlines()) < 100, name
        assert "World(**args.world," in text or name == "shielding", "it obeys all options"
        assert re.match(rf'"""[A-Z][^\n]*: python -m motes run -n 4 {re.escape(str(path))}\b', text), name


def test_the_readme_and_the_page_show_all_effects_and_no_other():
    readme = (effects.ROOT / "README.md").read_text()
    assert (
        re.findall(r"\[!\[(\w+)\]\(docs/gallery/(?:light/)?\1\.png\)\]\(docs/gallery\.md#\1\)", readme)
        == NAMES
    )
    assert (effects.ROOT / "docs" / "gallery.md").read_text() == make_gallery.page(), (
        "python docs/scripts/make_gallery.py --page"
    )
    assert sorted(path.stem for path in STILLS.rglob("*.png")) == NAMES


def test_the_page_says_which_actions_an_effect_shows():
    assert make_gallery.shows("swirl")[:2] == ["damping", "orbit_line"]
    assert {"emit", "follow", "follow_path"} <= set(make_gallery.shows("snake"))


def test_a_loop_closes():
    shots = np.arange(120, dtype=np.float64).reshape(-1, 1, 1, 1)
    loop = make_gallery.closed(shots)
    assert len(loop) == 96 and loop[0] == 24 and loop[71] == 95
    steps = np.diff(loop.ravel())
    assert np.all(np.abs(steps[:71]) == 1)
    assert abs(loop[-1, 0, 0, 0] - 23) < 5, "the last frame leads to the first"


def test_a_world_takes_its_part_of_the_command_line():
    args = motes.script.options(None, argv=["--axis", "xz", "--seed", "5", "--space", "-2,2"])
    world = motes.World(**args.world, progress="off")
    assert world.seed == 5
    assert world.system("a").axis == "xz"
