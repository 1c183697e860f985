"""What a renderer's attributes do to a picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from launching import mpirun

import motes
from motes.errors import ArgumentError

CAMERA = motes.Camera((0, 0, 5), (0, 0, 0))


def rendered(*, sprite: motes.Sprite | None = None, **attributes: Any) -> motes.Frame:
    """One particle in the middle of a picture."""
    renderer = motes.Renderer(**{"width": 96, "height": 64, "camera": CAMERA, "linear": True, **attributes})
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("a", sprite=sprite or motes.Sprite(pixels=9))
    with world:
        system.burst((0, 0, 0), count=1)
        return world.render()


# --- bloom


def test_bloom_spreads_light_and_keeps_it():
    sharp, soft = rendered().linear, rendered(bloom=0.3).linear
    assert soft.sum() == pytest.approx(sharp.sum(), rel=1e-3)
    assert soft.max() < sharp.max()
    assert (soft > 0).sum() > 2 * (sharp > 0).sum()
    assert np.array_equal(soft, rendered(bloom=0.3).linear)


def test_pixels_with_bloom_are_the_same_whether_their_light_is_kept_or_not():
    assert rendered(bloom=0.3, linear=False).digest() == rendered(bloom=0.3).digest() != rendered().digest()


@pytest.mark.parametrize("bloom", [-0.1, 1.1, float("nan"), "much", None])
def test_bloom_is_a_part(bloom):
    with pytest.raises(ArgumentError, match="bloom must be a"):
        motes.Renderer(96, 64, camera=CAMERA, bloom=bloom)


def test_bloom_may_change_between_frames():
    renderer = motes.Renderer(96, 64, camera=CAMERA)
    renderer.bloom = 0.5
    with pytest.raises(ArgumentError, match="bloom"):
        renderer.bloom = 2
    assert renderer.bloom == 0.5


ON_RANKS = """
import json, sys
import motes
from motes import shapes

path, linear = sys.argv[1:]
renderer = motes.Renderer(
    320, 180, camera=motes.Camera((0, 0, 11), (0, 0, 0)), path=path, linear=linear == "True", bloom=0.3,
    objects=[shapes.Sphere((1, 0, 0), 1)],
)
world = motes.World(seed=3, space=(-8, 8), roles="shared", renderer=renderer, progress="off")
dust = world.system("dust")
with world:
    for _ in world.frames(2):
        dust.configure(color=(0.2, 0.5, 1), alpha=0.3)
        dust.burst(shapes.Box((-8, -4, -1), (8, 4, 1)), count=20_000)
        picture = world.render()
        if picture:
            print(json.dumps([picture.digest(), float(picture.linear.sum()) if renderer.linear else None]))
"""


@pytest.mark.parametrize("linear", [False, True])
def test_bloom_is_the_same_on_all_paths(linear: bool):
    alone = mpirun(1, ON_RANKS, "gather", linear).lines
    assert len(set(alone)) == 2
    for path in ("gather", "tiles", "composite"):
        assert mpirun(3, ON_RANKS, path, linear).lines == alone


# --- objects and what lights them

MESH = motes.Mesh([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [(0, 1, 2)])
RED = (1, 0, 0)


def brightness(**attributes: Any) -> np.ndarray:
    """The light of a picture without particles, by colour."""
    return rendered(sprite=motes.Sprite("point"), **attributes).linear.reshape(-1, 3).mean(axis=0)


def test_a_mesh_is_drawn_like_the_triangle_that_it_is():
    triangle = motes.shapes.Triangle(*MESH.vertices)
    assert rendered(objects=[MESH]).digest() == rendered(objects=[motes.Solid(MESH)]).digest()
    difference = rendered(objects=[MESH]).linear - rendered(objects=[triangle]).linear
    assert np.abs(difference).mean() < 1e-3
    assert rendered(objects=[MESH]).digest() != rendered().digest()


def test_lights_light_and_solids_shine():
    night = {"objects": [MESH], "sun": (0, 0, 0)}
    dark = brightness(**night)
    lit = brightness(**night, lights=[motes.Light((0, 0, 2), RED, power=3)])
    assert lit[0] > dark[0] + 0.02
    assert lit[1] == pytest.approx(dark[1])
    assert (brightness(objects=[motes.Solid(MESH, light=2)], sun=(0, 0, 0)) > dark + 0.02).all()
    assert (brightness(objects=[MESH], sun=(0, 0, 1)) > dark + 0.02).all()


def test_smooth_edges_have_colours_in_between():
    few, many = (rendered(objects=[MESH], smooth=smooth).pixels for smooth in (False, True))
    assert len(np.unique(many.reshape(-1, 3), axis=0)) > len(np.unique(few.reshape(-1, 3), axis=0))


def test_lights_and_sun_may_change_between_frames():
    renderer = motes.Renderer(96, 64, camera=CAMERA, objects=[MESH])
    world = motes.World(seed=1, renderer=renderer, progress="off")
    with world:
        first = world.render()
        renderer.lights = [motes.Light((0, 0, 2))]
        second = world.render()
        renderer.sun = (0, 0, 0)
        third = world.render()
    assert len({frame.digest() for frame in (first, second, third)}) == 3
