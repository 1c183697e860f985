"""Mesh sprites: normals at corners and pictures at their `uv`, as of a `Solid` of the same mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from made_meshes import globe
from numpy.typing import NDArray

import motes
from motes.errors import ArgumentError

Picture = NDArray[np.float64]
POINTS, TRIANGLES = globe(8, 16, 1)
UV = np.stack([np.arctan2(POINTS[:, 0], POINTS[:, 2]) / 3 + 0.5, POINTS[:, 1] * 0.4 + 0.5], axis=1)
FLAT = motes.Mesh(POINTS, TRIANGLES, uv=UV)
SMOOTH = motes.Mesh(POINTS, TRIANGLES, uv=UV, smooth=True)
GIVEN = motes.Mesh(POINTS, TRIANGLES[:, ::-1], normals=-3 * POINTS)  # faces inwards
LEAF = np.random.default_rng(3).random((8, 8, 3)).astype(np.float32)
AWAY = {"background": (0.1, 0.1, 0.1), "fog": ("black", 1e9), "sun": (0.5, 0.4, 0.8)}


def picture(what: motes.Sprite | None, solid: motes.Solid | None, lens: Any = None, **facts: Any) -> Picture:
    camera = motes.Camera((0, 0.5, 5), (0, 0, 0), fov_deg=32, **(lens or {}))
    objects = [] if solid is None else [solid]
    renderer = motes.Renderer(120, 96, camera=camera, linear=True, objects=objects, **(AWAY | facts))
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("one", **({} if what is None else {"sprite": what}))
    with world:
        if what is not None:
            system.configure(size=1, color=(0.9, 0.8, 0.5))
            system.burst((0, 0, 0))
            system.move()
        return world.render().linear.astype(float)


def difference(mesh: motes.Mesh, other: motes.Mesh, image: Any = None, **members: Any) -> float:
    """Return how much a mesh sprite differs from the solid of another mesh, where both are."""
    solid = picture(None, motes.Solid(other, (0.9, 0.8, 0.5), image=image))
    sprite = picture(motes.Sprite("mesh", mesh=mesh, image=image, **members), None)
    ball = np.hypot(*(np.mgrid[:96, :120] - np.array((47.5, 59.5))[:, None, None])) < 27
    return float((np.abs(sprite - solid)[ball] / solid[ball].max(axis=1, keepdims=True)).mean())


@pytest.mark.parametrize("lit", [False, True])
@pytest.mark.parametrize("blend", ["opaque", "alpha"])
@pytest.mark.parametrize("mesh", [SMOOTH, GIVEN])
def test_a_mesh_sprite_is_shaded_by_its_normals(mesh: motes.Mesh, blend: Any, lit: bool) -> None:
    assert difference(mesh, mesh, blend=blend, lit=lit) < 0.006
    assert difference(FLAT, SMOOTH, blend=blend, lit=lit) > 0.03


@pytest.mark.parametrize("lit", [False, True])
@pytest.mark.parametrize("mesh", [FLAT, SMOOTH])
def test_a_mesh_sprite_shows_its_picture_at_its_uv(mesh: motes.Mesh, lit: bool) -> None:
    assert difference(mesh, mesh, LEAF, blend="opaque", lit=lit) < 0.01
    assert difference(mesh, mesh, LEAF, blend="alpha", lit=lit) < 0.01


def test_pictures_and_normals_through_a_lens_and_a_shutter() -> None:
    """Each way of drawing has the same mean light."""
    for blend in ("opaque", "alpha", "add"):
        sprite = motes.Sprite("mesh", mesh=SMOOTH, image=LEAF, blend=blend, lit=True)  # type: ignore[arg-type]
        dark: dict[str, Any] = {"background": (0, 0, 0)}
        sharp, blurred = (
            picture(sprite, None, lens, **dark) for lens in (None, {"focus": 4, "aperture": 0.2})
        )
        np.testing.assert_allclose(blurred.mean(axis=(0, 1)), sharp.mean(axis=(0, 1)), rtol=0.03)


def test_a_picture_needs_places() -> None:
    bare = motes.Mesh(POINTS, TRIANGLES)
    with pytest.raises(ArgumentError, match="image must be given with a mesh that has `uv`"):
        motes.Sprite("mesh", mesh=bare, image=LEAF)
    for image in ("no_such.png", np.zeros((0, 4, 3)), np.zeros((4, 4)), -LEAF, [LEAF, LEAF]):
        with pytest.raises(ArgumentError, match="image"):
            motes.Sprite("mesh", mesh=FLAT, image=image)
    with pytest.raises(ArgumentError, match="tiles"):
        motes.Sprite("mesh", mesh=FLAT, image=LEAF, tiles=(2, 2))
    with pytest.raises(ArgumentError, match="pick"):
        motes.Sprite("mesh", mesh=FLAT, image=LEAF, pick="age")


def test_a_deformed_mesh_gets_new_normals() -> None:
    """They follow the new vertices; sharp edges of given normals stay sharp."""
    squeezed = POINTS * (1, 0.5, 1)
    right = motes.Mesh(squeezed, TRIANGLES, uv=UV, smooth=True)
    for mesh in (SMOOTH, motes.Mesh(POINTS, TRIANGLES, normals=POINTS)):
        deformed = mesh.at(vertices=squeezed)
        seen, expected = (picture(None, motes.Solid(one)) for one in (deformed, right))
        np.testing.assert_allclose(seen, expected, atol=1e-3)
        assert np.abs(picture(None, motes.Solid(mesh)) - expected).max() > 0.1
    np.testing.assert_array_equal(SMOOTH.at(vertices=squeezed).uv, UV.astype(np.float32))
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0), (0, 1, 0), (0, 0, -1)], float)
    edge = motes.Mesh(corners, [(0, 1, 2), (3, 4, 5)], normals=[(0, 0, 1)] * 3 + [(-1, 0, 0)] * 3)
    moved = edge.at(vertices=corners * (1, 2, 1) + 3)
    assert edge.normals is not None
    assert moved.normals is not None
    np.testing.assert_allclose(np.abs(moved.normals), np.abs(edge.normals), atol=1e-6)
    partly = motes.Mesh(corners, [(0, 1, 2), (3, 4, 5)], normals=[(0, 0, 1)] * 3 + [(0, 0, 0)] * 3)
    assert partly.at(vertices=corners * 2).normals is not None
    np.testing.assert_array_equal(partly.at(vertices=corners * 2).normals[3:], 0)  # type: ignore[index]
