"""Roughness and metal: spheres, meshes and cards reflect as solids do, and only those that say so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from made_meshes import globe
from one_thing import CARD, CENTER, COLOR, LAMPS, WHITE, inside, picture, smooth

import motes
from motes import shapes
from motes.errors import ArgumentError

BALL = motes.Mesh(*globe(48, 96, 0.5), smooth=True)
SPHERE = shapes.Sphere(CENTER, 0.5)
KINDS: dict[str, tuple[dict[str, Any], Any]] = {
    "sphere": ({"kind": "sphere", "pixels": None}, SPHERE),
    "mesh": ({"kind": "mesh", "mesh": BALL}, SPHERE),
    "card": ({"kind": "image", "pixels": None, "image": WHITE, "facing": "orientation"}, CARD),
}
FINISHES = {
    "brass": (0.3, 1.0),
    "mirror": (0.0, 1.0),
    "wet": (0.25, 0.0),
    "satin": (0.6, 0.4),
    "lead": (1.0, 1.0),
}
SKY = np.zeros((32, 64, 3), np.float32)
SKY[:, 40:56] = (0.9, 0.5, 0.2)
SKY[:10] += 0.4
LIGHTS: dict[str, dict[str, Any]] = {
    "sun": {"sun": (0.5, 0.6, 0.7), "sun_color": "orange", "sun_power": 1.3},
    "picture": {"sun": (0.5, 0.6, 0.7), "background": SKY},
    **LAMPS,
}


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("finish", FINISHES)
@pytest.mark.parametrize("kind", KINDS)
def test_the_reflections_of_a_solid(kind: str, finish: str, light: str) -> None:
    members, form = KINDS[kind]
    roughness, metal = FINISHES[finish]
    look: dict[str, Any] = {"roughness": roughness, "metal": metal}
    expected = picture(None, motes.Solid(form, COLOR, **look), **LIGHTS[light])
    blend: Any = "alpha" if finish == "brass" else "opaque"
    found = picture(motes.Sprite(**members, **look, blend=blend, lit=True), None, **LIGHTS[light])
    dark = picture(None, motes.Solid(form), sun=(0, 0, 0), background=(0, 0, 0), smooth=False)
    there = inside(dark.max(axis=2) > 0) & smooth(expected) & smooth(found) & (expected.max(axis=2) <= 1)
    assert there.sum() > 300
    differs = np.abs(found - expected)[there] / np.maximum(expected[there].max(axis=1), 0.02)[:, None]
    assert np.quantile(differs, 0.95) < 0.02
    assert np.median(differs) < 0.006


def test_the_defaults_change_no_bit() -> None:
    for kind, (members, form) in KINDS.items():
        plain, said = (
            picture(motes.Sprite(**members, lit=True, **more), None) for more in ({}, {"roughness": 1})
        )
        assert (plain == said).all(), kind
        plain, said = (
            picture(None, motes.Solid(form, **more)) for more in ({}, {"metal": 0, "roughness": 1})
        )
        assert (plain == said).all(), kind


def test_a_solid_that_reflects_leaves_its_neighbour_as_it_is() -> None:
    """Vectors of rays that meet both have the light of each."""
    wall = motes.Solid(shapes.Rectangle((-3, -3, -1), (6, 0, 0), (0, 6, 0)), (0.5, 0.4, 0.3))
    facts: dict[str, Any] = {"sun": (0.1, 0.2, 1), "smooth": False}
    seen = []
    for roughness in (1, 0.2):
        ball = motes.Solid(SPHERE, (0.75, 0.6, 0.35), roughness=roughness)
        seen.append(picture(None, wall, ball, **facts))
    differs = (seen[0] != seen[1]).any(axis=2)
    form = (
        picture(None, motes.Solid(SPHERE), sun=(0, 0, 0), background=(0, 0, 0), smooth=False).max(axis=2) > 0
    )
    assert differs.any()
    assert not (differs & ~form).any()


def test_smooth_metal_has_a_brighter_and_smaller_highlight() -> None:
    seen = [
        picture(
            None,
            motes.Solid(SPHERE, (1, 1, 1), roughness=r, metal=1),
            sun=(0.3, 0.3, 1),
            background=(0, 0, 0),
        )
        for r in (0.6, 0.3, 0.15)
    ]
    brightest = [float(one.max()) for one in seen]
    assert brightest[0] * 2 < brightest[1]
    assert brightest[1] * 2 < brightest[2]
    wide = [int((one.max(axis=2) > 0.5 * one.max()).sum()) for one in seen]
    assert wide[0] > 2 * wide[1] > 2 * wide[2] > 0


def test_a_mirror_shows_the_sky_behind_the_camera() -> None:
    sky = np.zeros((64, 128, 3), np.float32)
    sky[:, :8] = sky[:, -8:] = (0.2, 0.9, 0.4)  # behind a camera that looks along -z
    mirror = motes.Solid(
        shapes.Rectangle((-1, -1, 0), (2, 0, 0), (0, 2, 0)), (1, 0.5, 1), roughness=0, metal=1
    )
    seen = picture(None, mirror, sun=(0, 0, 0), background=sky)
    np.testing.assert_allclose(seen[45, 60], (0.2, 0.45, 0.4), atol=0.01)


def test_wrong_finishes_are_refused() -> None:
    for given in (-0.1, 1.1, float("nan"), "smooth", (0.5, 0.5)):
        for name in ("roughness", "metal"):
            facts: dict[str, Any] = {name: given}
            with pytest.raises(ArgumentError, match=name):
                motes.Solid(SPHERE, **facts)
            with pytest.raises(ArgumentError, match=name):
                motes.Sprite("sphere", **facts)
    flat: dict[str, Any] = {"image": WHITE, "roughness": 0.5}
    for kind in ("point", "disc", "ribbon"):
        more: dict[str, Any] = {"width": 1, "length": 1} if kind == "ribbon" else {}
        with pytest.raises(
            ArgumentError, match=r"metal must be left out for all but spheres, meshes, and images"
        ):
            motes.Sprite(kind, metal=1, **more)  # type: ignore[arg-type]
    for facts in (flat, flat | {"lit": True}, flat | {"facing": "orientation"}):
        with pytest.raises(ArgumentError, match=r"roughness must be left out for all but"):
            motes.Sprite("image", **facts)
    assert motes.Sprite("image", lit=True, facing="velocity", **flat).roughness == 0.5
    assert "roughness=0.5, metal=1.0" in repr(motes.Sprite("sphere", roughness=0.5, metal=1))
