"""Recipes run as they stand, pictures are what they make, and pages written from the source are fresh."""

from __future__ import annotations

import inspect
import re
from io import BytesIO

import numpy as np
import pytest
from docs_scripts import script_of_docs

import motes

make_recipes = script_of_docs("make_recipes")


def test_each_recipe_is_shown_once():
    assert sorted(make_recipes.recipes()) == sorted(path.stem for path in make_recipes.FOLDER.glob("*.py"))
    assert sorted(make_recipes.recipes()) == sorted(path.stem for path in make_recipes.FOLDER.glob("*.png"))


@pytest.mark.parametrize("path", make_recipes.texts(), ids=lambda path: path.name)
def test_pages_are_what_the_script_writes(path):
    assert path.read_text() == make_recipes.texts()[path], "run docs/scripts/make_recipes.py"


@pytest.mark.parametrize("name", make_recipes.recipes())
def test_recipes_make_their_pictures(name):
    images = pytest.importorskip("PIL.Image")
    made, kept = (np.asarray(images.open(BytesIO(data))) for data in _pictures(name))
    assert np.array_equal(made, kept), "run docs/scripts/make_recipes.py"


def _pictures(name: str) -> tuple[bytes, bytes]:
    return make_recipes.run(name), make_recipes.script(name).with_suffix(".png").read_bytes()


def test_recipes_are_short():
    assert max(make_recipes.code(name).count("\n") for name in make_recipes.recipes()) <= 32


def test_the_page_of_the_surface_has_each_name():
    text = make_recipes.surface()
    names = {name for module in make_recipes.modules().values() for name in module.__all__}
    shown = set(re.findall(r"^##+ `?(?:motes\.)?(\w+)", text, re.MULTILINE))
    assert names <= shown
    assert "`.gravity(" in text and "- `restitution`: " in text


def test_help_says_what_each_field_of_each_value_is():
    for full, module in make_recipes.modules().items():
        for name in module.__all__:
            for field in getattr(getattr(module, name), "_fields", ()):
                told = re.search(rf"^ *{field}: ", inspect.getdoc(getattr(module, name)) or "", re.MULTILINE)
                assert told or field.startswith("_"), f"{full}.{name}.{field}"


def test_help_repeats_no_field():
    told = inspect.getdoc(motes.actions.Bounce) or ""
    assert told.count("hits: ") == told.count("where: ") == 1
