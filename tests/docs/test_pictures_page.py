"""docs/pictures.md shows the pictures that its script makes, and its code runs."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from docs_scripts import script_of_docs

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = DOCS / "pictures.md"

make_pictures = script_of_docs("make_pictures")
MADE = dict(make_pictures.pictures())


def test_the_page_shows_all_pictures_and_no_other():
    shown = re.findall(r"!\[\]\(pictures/([\w-]+)\.png\)", PAGE.read_text())
    assert sorted(shown) == sorted(MADE)
    assert sorted(path.stem for path in make_pictures.FOLDER.iterdir()) == sorted(MADE)


@pytest.mark.parametrize("name", MADE)
def test_pictures_are_what_the_script_makes(name):
    images = pytest.importorskip("PIL.Image")
    with images.open(make_pictures.FOLDER / f"{name}.png") as picture:
        assert np.array_equal(np.asarray(picture), np.asarray(MADE[name]())), (
            "run docs/scripts/make_pictures.py"
        )


def test_the_code_of_the_page_runs(tmp_path, monkeypatch):
    pytest.importorskip("OpenEXR")
    monkeypatch.chdir(tmp_path)
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL):
        exec(block, {})
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["balls.exr", "balls.png", "balls16.png"]
