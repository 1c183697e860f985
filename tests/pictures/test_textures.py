"""Textures and normals of solids: they belong to the mesh, and move and turn with it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from made_meshes import globe
from numpy.typing import ArrayLike, NDArray

import motes
from motes.errors import ArgumentError
from motes.shapes import Sphere

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CRATE = motes.Mesh(CORNERS, [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])
WOOD = np.random.default_rng(0).integers(0, 255, (16, 16, 3), dtype=np.uint8)
QUAD = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


def shot(solid: motes.Solid, position: ArrayLike, look_at: ArrayLike, **facts: Any) -> NDArray[np.float32]:
    facts = {"background": (0.5, 0.5, 0.5), "sun": (0, 0, 0), **facts}
    camera = motes.Camera(position, look_at)
    renderer = motes.Renderer(128, 96, camera=camera, objects=[solid], linear=True, **facts)
    world = motes.World(seed=1, progress="off", renderer=renderer)
    world.system("s")
    with world:
        picture = world.render().linear
    assert picture is not None
    return picture.copy()


def test_a_texture_travels_with_its_mesh() -> None:
    here = shot(motes.Solid(CRATE, (1, 1, 1), image=WOOD), (3, 2, 5), (0, 0, 0))
    place = np.array((0.375, 0.25, -0.5))
    moved = shot(motes.Solid(CRATE.at(place), (1, 1, 1), image=WOOD), (3, 2, 5) + place, place)
    np.testing.assert_allclose(moved, here, atol=0.01)
    turned = CRATE.at((0, 0, 0), axis=(0, 1, 0), angle_deg=90)  # z becomes x, x becomes -z
    there = shot(motes.Solid(turned, (1, 1, 1), image=WOOD), (5, 2, -3), (0, 0, 0))
    assert np.abs(there - here).mean() < 0.002
    assert (
        np.abs(shot(motes.Solid(turned, (1, 1, 1), image=WOOD), (3, 2, 5), (0, 0, 0)) - here).mean() > 0.001
    )


@pytest.mark.parametrize("angle_deg", [0, 90])
def test_a_mesh_shows_its_picture_at_its_uv(angle_deg: float) -> None:
    picture = np.zeros((2, 2, 3), np.float32)
    picture[0, 0], picture[0, 1], picture[1, 0], picture[1, 1] = (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)
    quad = motes.Mesh(QUAD, [(0, 1, 2), (0, 2, 3)], uv=[(0, 0), (1, 0), (1, 1), (0, 1)])
    solid = motes.Solid(quad.at(axis=(0, 0, 1), angle_deg=angle_deg), (1, 1, 1), image=picture, scale=77)
    seen = shot(solid, (0, 0, 5), (0, 0, 0))
    parts = [[seen[48 + 13 * dy, 64 + 13 * dx] for dx in (-1, 1)] for dy in (-1, 1)]
    shown = np.rot90(np.array(parts) / np.max(parts), -round(angle_deg / 90))
    np.testing.assert_allclose(shown, picture, atol=0.15)


BALL = globe(12, 24)


def test_a_smooth_mesh_is_shaded_like_the_round_shape() -> None:
    lit: dict[str, Any] = {"sun": (1, 1, 1), "background": (0, 0, 0)}
    rounded = shot(motes.Solid(Sphere((0, 0, 0), 1), (1, 1, 1)), (0, 0, 4), (0, 0, 0), **lit)

    def error(shape: Any) -> float:
        seen = shot(motes.Solid(shape, (1, 1, 1)), (0, 0, 4), (0, 0, 0), **lit)
        return float(np.abs(seen - rounded)[30:66, 46:82].mean())

    flat, smooth = motes.Mesh(*BALL), motes.Mesh(*BALL, smooth=True)
    given = motes.Mesh(flat.vertices, flat.triangles, normals=5 * flat.vertices)
    assert error(smooth) < 0.2 * error(flat)
    assert error(given) < 0.2 * error(flat)
    turned = smooth.at(axis=(0, 1, 0), angle_deg=15)  # by one column
    assert error(turned) < 0.2 * error(flat)


def test_bad_normals_are_refused() -> None:
    for normals in (np.zeros((3, 3)), [(0, 0, np.nan)] * 4, "up", np.full((4, 3), 1e9)):
        with pytest.raises(ArgumentError, match="normals"):
            motes.Mesh(QUAD, [(0, 1, 2)], normals=normals)
    with pytest.raises(ArgumentError, match="normals"):
        motes.Mesh(QUAD, [(0, 1, 2)], normals=QUAD, smooth=True)
    with pytest.raises(ArgumentError, match="smooth"):
        motes.Mesh(QUAD, [(0, 1, 2)], smooth="yes")  # type: ignore[arg-type]
