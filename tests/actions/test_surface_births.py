"""Births on meshes: velocities along normals, colours of vertices and pictures, deforming meshes."""

from __future__ import annotations

import numpy as np
import pytest
from acting import born
from made_meshes import TETRAHEDRON
from standing import on_ranks

import motes
from motes.errors import ArgumentError
from motes.shapes import Sphere

CORNERS, FACES = TETRAHEDRON
COLORS = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.5, 0.5)])


def test_velocities_are_along_the_outward_normals():
    mesh = motes.Mesh(CORNERS, FACES).at((1, 2, 3), axis=(1, 2, 0.5), angle_deg=40)
    p = born(mesh, velocity=motes.along_normal(2.0))
    v = p.velocity.astype(float)
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), 2, rtol=1e-5)
    flat = born(motes.Mesh(CORNERS, FACES), velocity=motes.along_normal(-1.5))
    normals = np.array([(0, 0, -1), (0, -1, 0), (-1, 0, 0), np.ones(3) / np.sqrt(3)])
    planes = zip(normals, (0, 0, 0, 2 / np.sqrt(3)), strict=True)
    distances = np.abs(np.stack([flat.position @ n - d for n, d in planes]))
    on = distances.argmin(axis=0)
    np.testing.assert_allclose(flat.velocity, -1.5 * normals[on], atol=1e-5)
    assert set(on) == {0, 1, 2, 3}


def test_colours_are_mixed_between_vertices():
    p = born(motes.Mesh(CORNERS, FACES, colors=COLORS), color=motes.surface_color())
    # Barycentric coordinates in the tetrahedron: half the position, and the rest to 1.
    parts = p.position.astype(float) / 2
    parts = np.concatenate([1 - parts.sum(axis=1, keepdims=True), parts], axis=1)
    np.testing.assert_allclose(p.color, parts @ COLORS, atol=1e-5)


def test_a_picture_colours_vertices_at_their_places():
    picture = np.zeros((4, 4, 3), np.uint8)
    picture[:2, :, 0] = 255  # upper half: red
    picture[2:, 2:, 2] = 255  # lower right: blue
    uv = [(0.25, 0.75), (0.75, 0.25), (0.125, 0.125), (0.5, 0.75)]
    mesh = motes.Mesh(CORNERS, FACES, colors=picture, uv=uv)
    np.testing.assert_allclose(mesh.colors, [(1, 0, 0), (0, 0, 1), (0, 0, 0), (1, 0, 0)], atol=1e-6)


def test_vertices_have_colours_by_name():
    mesh = motes.Mesh(CORNERS, FACES, colors=["red", "#00ff00", "Blue", "black"])
    np.testing.assert_array_equal(mesh.colors, [*np.eye(3), np.zeros(3)])
    with pytest.raises(ArgumentError, match="colors.*purpel.*did you mean 'purple'"):
        motes.Mesh(CORNERS, FACES, colors=["red", "purpel", "blue", "black"])


def test_what_is_no_surface_has_neither():
    for shape in (Sphere((0, 0, 0), 1), motes.Mesh(CORNERS, FACES, solid=True)):
        with pytest.raises(ArgumentError, match="mesh"):
            born(shape, velocity=motes.along_normal(1.0))
    with pytest.raises(ArgumentError, match="colors="):
        born(motes.Mesh(CORNERS, FACES), color=motes.surface_color())
    with pytest.raises(ArgumentError, match="alpha"):
        born(motes.Mesh(CORNERS, FACES), alpha=motes.along_normal(1.0))


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("colors", [(1, 0, 0)]),
        ("colors", np.full((4, 3), -1.0)),
        ("colors", np.full((4, 3), np.nan)),
        ("colors", "no such file.png"),
        ("uv", [(0, 0)]),
        ("uv", np.zeros((4, 3))),
    ],
)
def test_wrong_colours_and_places_are_refused(name, given):
    with pytest.raises(ArgumentError):
        motes.Mesh(CORNERS, FACES, **{name: given})
    with pytest.raises(ArgumentError, match="uv"):
        motes.Mesh(CORNERS, FACES, colors=np.zeros((2, 2, 3), np.uint8))


def test_a_mesh_may_have_other_vertices():
    mesh = motes.Mesh(CORNERS, FACES, colors=COLORS)
    larger = mesh.at((1, 0, 0), vertices=2 * CORNERS)
    assert larger == motes.Mesh(2 * CORNERS, FACES, colors=COLORS).at((1, 0, 0))
    assert mesh.at((1, 0, 0)) != larger
    with pytest.raises(ArgumentError, match="vertices"):
        mesh.at(vertices=CORNERS[:3])
    with pytest.raises(ArgumentError, match="moving_from"):
        mesh.at(vertices=CORNERS, moving_from=motes.Mesh(2 * CORNERS, FACES, colors=COLORS))


SCRIPT = """
import sys
import numpy as np
import motes

mesh = motes.Mesh([(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)],
                  colors=np.eye(4, 3))
world = motes.World(seed=4, space=(-3, 3), births=sys.argv[1], roles="shared", progress="off")
s = world.system("s")
with world:
    for frame in world.frames(3):
        s.configure(velocity=motes.along_normal(3), color=motes.surface_color())
        s.source(mesh.at((frame, 0, 0), angle_deg=10 * frame), rate=20000)
        s.move()
        world.step()
    world.say(world.digest())
"""


def test_all_ranks_give_the_same_births():
    said = {on_ranks(n, SCRIPT, how).lines[-1] for n in (1, 3) for how in ("manager", "calculators")}
    assert len(said) == 1


@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize("length", [2.0, -0.5])
def test_normals_are_those_of_the_moment_of_birth(substeps, length):
    """A nozzle that turns during the frame sprays a fan, not one jet per frame."""
    square = [(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)]
    nozzle = motes.Mesh(square, [(0, 2, 1), (0, 3, 2)])  # normal +y
    world = motes.World(seed=1, substeps=substeps, progress="off")
    s = world.system("s")
    s.configure(velocity=motes.along_normal(length))
    with world:
        turned = nozzle.at((0, 0, 0), axis=(0, 0, 1), angle_deg=60)
        s.source(turned, 24_000, moving_from=nozzle)
        world.step()
        p = s.gather()
    np.testing.assert_allclose(np.linalg.norm(p.velocity, axis=1), abs(length), rtol=1e-5)
    v = p.velocity * np.sign(length)
    angle = np.degrees(np.arctan2(-v[:, 0], v[:, 1]))
    place = np.degrees(np.arctan(p.position[:, 1] / p.position[:, 0]))
    np.testing.assert_allclose(angle, place, atol=2)  # normal to the surface that the positions are on
    assert abs(angle.mean() - 30) < 1 and np.ptp(angle) > 58
