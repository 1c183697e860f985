"""Births on a mesh with a density: linear between vertices, the same on any ranks."""

from __future__ import annotations

import numpy as np
import pytest
from acting import born
from made_meshes import TETRAHEDRON
from standing import on_ranks

import motes
from motes.errors import ArgumentError

CORNERS, FACES = TETRAHEDRON
COUNT = 200_000


def shares(corners, places):
    """Return the barycentric coordinates of positions on a triangle."""
    a, b, c = np.asarray(corners, float)
    sides = np.stack([b - a, c - a], axis=1)
    two = np.linalg.lstsq(sides, (places - a).T, rcond=None)[0].T
    return np.column_stack([1 - two.sum(axis=1), two])


@pytest.mark.parametrize("density", [(0, 1, 2), (1, 0, 0), (3, 3, 3), (1, 100, 1e-3)])
def test_births_are_as_dense_as_a_linear_density_says(density):
    corners = [(0.5, 0, 1), (2, 0.25, 1), (1, 3, -1)]
    mesh = motes.Mesh(corners, [(0, 1, 2)], density=density)
    found = shares(corners, born(mesh, COUNT).position.astype(float))
    assert found.min() > -1e-5
    # In each of the small triangles, the mean of a linear density is its value at the centre.
    cells = 6
    down = np.clip(np.floor(found * cells), 0, cells - 1)
    upright = down.sum(axis=1) == cells - 1
    middle = np.where(upright[:, None], down + 1 / 3, down + 2 / 3)
    kinds, counts = np.unique(np.rint(middle * 3).astype(int), axis=0, return_counts=True)
    middles = kinds / (3 * cells)
    expected = COUNT * (middles @ np.array(density, float)) / (cells**2 * sum(density) / 3)
    assert len(kinds) == cells**2
    chi = ((counts - expected) ** 2 / expected).sum()
    assert chi < cells**2 + 4 * np.sqrt(2 * cells**2), chi
    np.testing.assert_allclose(
        found.mean(axis=0), (sum(density) + np.array(density)) / (4 * sum(density)), atol=2e-3
    )


def test_triangles_share_births_by_area_and_mean_density():
    density = np.array([0, 1, 0, 3])
    p = born(motes.Mesh(CORNERS, FACES, density=density), COUNT).position.astype(float)
    planes = np.stack([p[:, 2], p[:, 1], p[:, 0], np.abs(p.sum(axis=1) - 2)])
    areas = np.array([2, 2, 2, 2 * np.sqrt(3)])
    expected = areas * density[FACES].mean(axis=1)
    on = np.bincount(planes.argmin(axis=0), minlength=4) / len(p)
    np.testing.assert_allclose(on, expected / expected.sum(), atol=4e-3)


def test_where_the_density_is_0_nobody_is_born():
    flat = np.array([(x, 0, z) for x in range(4) for z in range(2)], float)
    faces = [(2 * i + a, 2 * i + b, 2 * i + c) for i in range(3) for a, b, c in ((0, 1, 2), (1, 3, 2))]
    p = born(motes.Mesh(flat, faces, density=[0, 0, 0, 0, 1, 1, 1, 1]), COUNT).position
    assert p[:, 0].min() >= 1 and p[:, 0].max() <= 3
    np.testing.assert_allclose((p[:, 0] > 2).mean(), 2 / 3, atol=4e-3)


def test_an_even_density_is_none():
    p, even = (born(motes.Mesh(CORNERS, FACES, density=d), COUNT).position for d in ([2] * 4, None))
    np.testing.assert_allclose(p.mean(axis=0), even.mean(axis=0), atol=0.01)
    np.testing.assert_allclose(np.cov(p.T), np.cov(even.T), atol=0.01)


def test_normals_and_colours_are_those_of_the_place():
    colors = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.5, 0.5)])
    mesh = motes.Mesh(CORNERS, FACES, colors=colors, density=[0, 1, 2, 5])
    p = born(mesh, 5000, velocity=motes.along_normal(1), color=motes.surface_color())
    parts = p.position.astype(float) / 2
    parts = np.concatenate([1 - parts.sum(axis=1, keepdims=True), parts], axis=1)
    np.testing.assert_allclose(p.color, parts @ colors, atol=1e-5)
    outward = (p.position - 0.4) * p.velocity
    assert (outward.sum(axis=1) > 0).all()


def test_a_picture_says_the_density_by_its_brightness():
    picture = np.zeros((4, 4, 3), np.uint8)
    picture[:2] = 255  # the upper half
    picture[2:, 2:] = (51, 102, 153)  # lower right
    uv = [(0.25, 0.75), (0.75, 0.25), (0.125, 0.125), (0.5, 0.75)]
    mesh = motes.Mesh(CORNERS, FACES, density=picture, uv=uv)
    np.testing.assert_allclose(mesh.density, [1, 0.4, 0, 1], atol=1e-6)


@pytest.mark.parametrize(
    "given",
    [
        [1, 1, 1],
        [[1, 1, 1, 1]],
        [1, -1, 1, 1],
        [1, np.nan, 1, 1],
        [1, np.inf, 1, 1],
        [1, 1e7, 1, 1],
        [0, 0, 0, 0],
        "no such file.png",
        np.zeros((2, 2, 3), np.uint8),
        np.zeros((2, 2, 3)),
        object(),
    ],
)
def test_wrong_densities_are_refused(given):
    with pytest.raises(ArgumentError, match="density"):
        motes.Mesh(CORNERS, FACES, uv=np.zeros((4, 2)), density=given)


def test_a_density_needs_a_surface_and_a_place_for_a_picture():
    with pytest.raises(ArgumentError, match="uv"):
        motes.Mesh(CORNERS, FACES, density=np.full((2, 2, 3), 255, np.uint8))
    with pytest.raises(ArgumentError, match="density.*solid"):
        motes.Mesh(CORNERS, FACES, density=np.ones(4), solid=True)
    # The density is above 0 only where there is no area.
    flat = motes.Mesh([*CORNERS, (3, 3, 3)], [*FACES, (4, 4, 4)], density=[0, 0, 0, 0, 1])
    with pytest.raises(ArgumentError, match="density above 0"):
        born(flat, COUNT)


SCRIPT = """
import sys
import numpy as np
import motes

at = np.array([(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)], float)
mesh = motes.Mesh(at, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], density=[0, 1, 2, 5], colors=np.eye(4, 3))
how = {"births": sys.argv[1], "threads": int(sys.argv[2]), "roles": "shared"}
world = motes.World(seed=4, space=(-3, 3), progress="off", **how)
s = world.system("s")
with world:
    for frame in world.frames(3):
        s.configure(velocity=motes.along_normal(3), color=motes.surface_color())
        s.source(mesh.at((frame, 0, 0), angle_deg=10 * frame, vertices=at * (1 + frame)), rate=20000)
        s.move()
        world.step()
    world.say(world.digest())
"""


def test_all_ranks_and_threads_give_the_same_births_also_of_a_mesh_that_deforms():
    hows = (("manager", "1"), ("calculators", "2"))
    said = {on_ranks(n, SCRIPT, *how).lines[-1] for n in (1, 3) for how in hows}
    assert len(said) == 1


def test_a_density_stays_with_the_mesh():
    import pickle

    mesh = motes.Mesh(CORNERS, FACES, density=[0, 1, 2, 5])
    assert pickle.loads(pickle.dumps(mesh)) == mesh != motes.Mesh(CORNERS, FACES)
    np.testing.assert_array_equal(mesh.at(vertices=2 * CORNERS).density, [0, 1, 2, 5])
