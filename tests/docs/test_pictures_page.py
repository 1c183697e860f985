"""docs/pictures.md shows what its script makes, and its code runs."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = DOCS / "pictures.md"

spec = importlib.util.spec_from_file_location("make_pictures", DOCS / "scripts" / "make_pictures.py")
make_pictures = importlib.util.module_from_spec(spec)
spec.loader.exec_module(make_pictures)
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
