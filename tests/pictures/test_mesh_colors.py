"""A mesh's own colours: compared with rays in double precision, on all paths and ranks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from standing import on_ranks

import motes
from motes import shapes

CAMERA = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=45)
WIDE, HIGH = 200, 150
# A long range of depths: colours interpolated linearly on the screen would be far off.
CORNERS = np.array([(-1, -1.2, 2), (1.6, -0.8, 1.5), (0, 1.5, -9)], float)
COLORS = np.array([(1, 0, 0.1), (0, 1, 0.2), (0.3, 0.5, 1)])
COUPLE = np.array([(-2, -1, 1.5), (2, -1, 1.5), (2, -1, -5), (-2, -1, -5)], float)


def seen(sprite: motes.Sprite | None, state: dict[str, Any], **facts: Any) -> NDArray[np.float64]:
    """Return the light of a picture of one particle and some objects."""
    facts = {"smooth": False} | facts
    renderer = motes.Renderer(WIDE, HIGH, camera=CAMERA, linear=True, **facts)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("all", sprite=sprite)
    with world:
        if state:
            system.emit(**state)
        return world.render().linear.astype(float)


def drawn(how: str, mesh: motes.Mesh, **facts: Any) -> NDArray[np.float64]:
    if how == "solid":
        return seen(None, {}, objects=[motes.Solid(mesh, (1, 1, 1))], **facts)
    sprite = motes.Sprite("mesh", mesh=mesh, blend=how)  # type: ignore[arg-type]
    return seen(sprite, {"position": [(0, 0, 0)], "color": [(1, 1, 1)]}, **facts)


def shares(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return barycentric coordinates of each pixel's ray in a triangle's plane; outside 0..1 is a miss."""
    focal = HIGH / 2 / np.tan(np.radians(22.5))
    x, y = np.meshgrid(np.arange(WIDE) + 0.5 - WIDE / 2, HIGH / 2 - np.arange(HIGH) - 0.5)
    rays = np.stack([x / focal, y / focal, np.full_like(x, -1)], -1)
    # Solve from + t ray = a p + b q + c r with a + b + c = 1.
    found = np.linalg.solve((corners - (0, 0, 5)).T, rays[..., None])[..., 0]
    return found / found.sum(axis=-1, keepdims=True)


@pytest.mark.parametrize("how", ["solid", "opaque", "alpha", "add"])
def test_colours_are_linear_on_the_triangle_in_space(how: str) -> None:
    plain, own = (drawn(how, motes.Mesh(CORNERS, [(0, 1, 2)], colors=c)) for c in (None, COLORS))
    parts = shares(CORNERS)
    inside = parts.min(axis=-1) > 0.03
    assert inside.sum() > 800
    wanted = plain[inside] * (parts[inside] @ COLORS)
    np.testing.assert_allclose(own[inside], wanted, atol=2e-5 if how == "solid" else 0.006)
    assert (own[parts.min(axis=-1) < -0.1] == 0).all()


@pytest.mark.parametrize("how", ["opaque", "alpha", "add"])
def test_white_corners_draw_the_same_bits_as_none(how: str) -> None:
    for facts in ({}, {"shutter": 1}):
        plain, white = (
            drawn(how, motes.Mesh(CORNERS, [(0, 1, 2)], colors=c), **facts) for c in (None, np.ones((3, 3)))
        )
        np.testing.assert_array_equal(plain, white)
    # Colours above white are clipped on particles, but brighten solids.
    bright = motes.Mesh(CORNERS, [(0, 1, 2)], colors=np.full((3, 3), 3.0))
    np.testing.assert_array_equal(drawn(how, bright, **facts), plain)
    more, less = (drawn("solid", one) for one in (bright, motes.Mesh(CORNERS, [(0, 1, 2)])))
    np.testing.assert_allclose(more, 3 * less, rtol=1e-4)


def test_colours_stay_at_their_corners_whichever_way_triangles_face() -> None:
    points = np.array([(-1, -1, -1), (1, -1, -0.5), (0, 1, -1), (0, 0, 1.5)])
    outwards = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    colors = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0.5)])
    there = {"position": [(0.2, -0.3, 0)], "orientation": [(0.2, 0.6, 0.1, np.sqrt(1 - 0.41))]}
    one, other = (
        seen(motes.Sprite("mesh", mesh=motes.Mesh(points, faces, colors=colors), blend="opaque"), there)
        for faces in (outwards, outwards[:, ::-1])
    )
    assert np.abs(one - other).max() < 0.006 < one.max()
    axis, angle = np.array(there["orientation"][0][:3]), 2 * np.degrees(np.arccos(np.sqrt(1 - 0.41)))
    solid = motes.Mesh(points, outwards, colors=colors).at(there["position"][0], axis=axis, angle_deg=angle)
    traced = seen(None, {}, objects=[motes.Solid(solid, (1, 1, 1))])
    both = (one.sum(axis=2) > 0.05) & (traced.sum(axis=2) > 0.05)
    hues = [picture[both] / picture[both].sum(axis=1, keepdims=True) for picture in (one, traced)]
    assert np.mean(np.abs(hues[0] - hues[1]).max(axis=1) < 0.02) > 0.97


def test_the_particle_s_and_the_solid_s_colour_multiply_them() -> None:
    mesh = motes.Mesh(CORNERS, [(0, 1, 2)], colors=COLORS)
    tint = (0.5, 1, 0.2)
    sprite = motes.Sprite("mesh", mesh=mesh, blend="opaque")
    tinted = seen(sprite, {"position": [(0, 0, 0)], "color": [tint]})
    np.testing.assert_allclose(tinted, drawn("opaque", mesh) * tint, atol=0.006)
    tinted = seen(None, {}, objects=[motes.Solid(mesh, tint)])
    np.testing.assert_allclose(tinted, drawn("solid", mesh) * tint, atol=1e-5)


@pytest.mark.parametrize("blend", ["add", "alpha"])
def test_blurred_forms_keep_their_colour(blend: Any) -> None:
    tint = np.array((0.25, 0.5, 1))
    points = np.array([(-1, -1, -1), (1, -1, -0.5), (0, 1, -1), (0, 0, 1.5)]) * 0.6
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    state = {"position": [(0, 0, 0)], "velocity": [(20, 0, 0)], "spin": [(30, 20, 0)], "color": [(1, 1, 1)]}
    plain, own = (
        seen(
            motes.Sprite("mesh", mesh=motes.Mesh(points, faces, colors=c), blend=blend), state, shutter=1
        ).sum(axis=(0, 1))
        for c in (None, np.tile(tint, (4, 1)))
    )
    np.testing.assert_allclose(own / plain, tint, rtol=0.03)


def test_edges_and_shadows_of_coloured_solids_are_smooth() -> None:
    colors = np.array([(1, 0, 0.5), (0, 1, 0.5), (0, 0, 0.5), (1, 1, 0.5)])
    faces = [(0, 1, 2), (0, 2, 3)]
    ball = motes.Solid(shapes.Sphere((0, -0.4, -1), 0.5), (0, 0, 0))
    plain, own = (
        seen(
            None,
            {},
            smooth=True,
            objects=[motes.Solid(motes.Mesh(COUPLE, faces, colors=c), (1, 1, 1)), ball],
            lights=[motes.Light((1, 2, 0), power=3)],
        )
        for c in (None, colors)
    )
    wanted = np.zeros_like(plain)
    inside = np.zeros((HIGH, WIDE), bool)
    for face in faces:
        parts = shares(COUPLE[list(face)])
        here = parts.min(axis=-1) >= 0
        wanted[here] = plain[here] * (parts[here] @ colors[list(face)])
        inside |= here
    off = np.abs(own - wanted).max(axis=2)[inside]
    assert np.mean(off < 2e-4) > 0.9
    assert off.max() < 0.08, "the mean of an edge's samples"


EVERYWHERE = """
import json, sys
import numpy as np
import motes

path, roles = sys.argv[1:]
points = np.array([(-1, -1, -1), (1, -1, -0.5), (0, 1, -1), (0, 0, 1.5)])
faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
wedge = motes.Mesh(points, faces, colors=["red", "lime", "blue", "white"])
renderer = motes.Renderer(
    320, 180, camera=motes.Camera((0, 0, 9), (0, 0, 0), focus=8, aperture=0.3), path=path, shutter=1.5,
    objects=[motes.Solid(wedge.at((1, 0, 0), angle_deg=30))],
)
world = motes.World(seed=3, space=(-8, 8), roles=roles, renderer=renderer, progress="off")
blends = ("add", "alpha", "opaque")
systems = [world.system(b, sprite=motes.Sprite("mesh", mesh=wedge, blend=b)) for b in blends]
with world:
    for _ in world.frames(2):
        for system in systems:
            system.configure(color=(0.8, 0.9, 1), alpha=0.5, size=0.4, orientation="random",
                             velocity=motes.shapes.Sphere((0, 0, 0), 8),
                             spin=motes.Uniform((-9, -9, -9), (9, 9, 9)))
            system.burst(motes.shapes.Box((-8, -4, -1), (8, 4, 8)), count=60)
            system.move()
        picture = world.render()
        if picture:
            print(json.dumps(picture.digest()))
"""


def test_coloured_meshes_are_the_same_on_all_paths_and_ranks() -> None:
    alone = on_ranks(1, EVERYWHERE, "gather", "auto").lines
    assert len(set(alone)) == 2
    for path in ("gather", "tiles", "composite"):
        assert on_ranks(2, EVERYWHERE, path, "shared").lines == alone
    assert on_ranks(3, EVERYWHERE, "composite", "auto").lines == alone
