"""Meshes and cards in space: compared with solids, plane geometry, and other paths and ranks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from standing import on_ranks

import motes
from motes import shapes
from motes.errors import ArgumentError

CAMERA = motes.Camera((0.5, 1, 4), (0, 0, 0), fov_deg=40)
FRONT = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=45)
SIDES = np.zeros((8, 8, 4), np.uint8)
SIDES[:, :4] = (255, 0, 0, 255)
SIDES[:, 4:] = (0, 255, 0, 255)


def rock() -> motes.Mesh:
    """Return a closed, concave surface: a ball of 12 x 16 faces with random dents."""
    dice = np.random.default_rng(3)
    rows, columns = 12, 16
    polar, around = np.pi * np.arange(1, rows) / rows, 2 * np.pi * np.arange(columns) / columns
    p, a = np.meshgrid(polar, around, indexing="ij")
    ring = np.stack([np.sin(p) * np.cos(a), np.cos(p), np.sin(p) * np.sin(a)], -1).reshape(-1, 3)
    points = np.concatenate([[(0, 1, 0)], ring * dice.uniform(0.7, 1, (len(ring), 1)), [(0, -1, 0)]])
    at = 1 + np.arange(len(ring)).reshape(rows - 1, columns)
    right = np.roll(at, -1, axis=1)
    sides = [(a, b, c) for k in range(rows - 2) for i in range(columns)
             for a, b, c in ((at[k, i], right[k, i], at[k + 1, i]),
                             (right[k, i], right[k + 1, i], at[k + 1, i]))]  # fmt: skip
    ends = [(0, right[0, i], at[0, i]) for i in range(columns)]
    ends += [(len(points) - 1, at[-1, i], right[-1, i]) for i in range(columns)]
    return motes.Mesh(points, [*sides, *ends])


ROCK = rock()


def turn(axis: tuple[float, float, float], angle_deg: float) -> tuple[float, ...]:
    """Return a rotation as a quaternion x, y, z, w."""
    half = np.radians(angle_deg) / 2
    return (*(np.sin(half) * np.array(axis) / np.linalg.norm(axis)), float(np.cos(half)))


def seen(
    sprite: motes.Sprite | None, state: dict[str, Any], camera: motes.Camera = FRONT, **facts: Any
) -> motes.Frame:
    """Render some particles in a picture of 200 x 150 pixels."""
    renderer = motes.Renderer(200, 150, camera=camera, layers=["depth"], smooth=False, linear=True, **facts)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("all", sprite=sprite)
    with world:
        if state:
            system.emit(**state)
        return world.render()


def edges(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which pixels are inside with a neighbour outside, or vice versa."""
    padded = np.pad(inside, 1, mode="edge")
    rows, columns = inside.shape
    around = [padded[y : y + rows, x : x + columns] for y in range(3) for x in range(3)]
    return np.any([part != inside for part in around], axis=0)


@pytest.mark.parametrize("place", [(0.6, 0.2, 0.5), (-1.2, 0.9, -2.0), (0.4, 0.7, 2.2)])
def test_an_instance_of_a_mesh_looks_like_the_solid(place: tuple[float, float, float]) -> None:
    axis, angle = (0.3, -0.5, 0.2), 70.0
    scaled = motes.Mesh(ROCK.vertices * 0.6, ROCK.triangles)
    solid = motes.Solid(scaled.at(place, axis=axis, angle_deg=angle), (0.8, 0.6, 0.4))
    state = {"position": [place], "orientation": [turn(axis, angle)], "color": [(0.8, 0.6, 0.4)]}
    state["size"] = [(0.6, 1, 1)]
    wanted = seen(None, {}, CAMERA, objects=[solid])
    drawn = seen(motes.Sprite("mesh", mesh=ROCK, blend="opaque"), state, CAMERA)
    depth, other = wanted.layer("depth"), drawn.layer("depth")
    inside, covered = np.isfinite(depth), np.isfinite(other)
    assert inside.sum() > 200
    assert not ((inside != covered) & ~edges(inside)).any()
    both = inside & covered & ~edges(inside)
    off = np.abs(depth[both] / other[both] - 1)
    assert np.median(off) < 1e-4
    assert np.mean(off < 0.005) > 0.99, "but where a dent's rim hides the dent, within a pixel"
    # The solid casts shadows on itself: outside them, where haze is thin, the light is the same.
    light = np.abs(wanted.linear[both] - drawn.linear[both]).max(axis=1)
    assert np.mean(light < 0.06) > 0.7


@pytest.mark.parametrize("blend", ["add", "alpha"])
def test_a_blended_mesh_covers_what_the_opaque_one_does(blend: Any) -> None:
    state = {"position": [(0.1, 0.2, 0)], "orientation": [turn((1, 2, 3), 40)]}
    opaque = seen(motes.Sprite("mesh", mesh=ROCK, blend="opaque"), state)
    blended = seen(motes.Sprite("mesh", mesh=ROCK, blend=blend), state)
    inside = np.isfinite(opaque.layer("depth"))
    sums = [float(frame.linear.sum()) for frame in (opaque, blended)]
    assert sums[1] == pytest.approx(sums[0], rel=0.06), "samples soften edges, dents may count twice"
    assert (blended.linear[~inside & ~edges(inside)] == 0).all()


def test_a_mesh_of_many_triangles_adds_each_sample_once() -> None:
    corners = np.stack(np.meshgrid(np.linspace(-1, 1, 17), np.linspace(-1, 1, 17)), -1).reshape(-1, 2)
    points = np.concatenate([corners, np.zeros((289, 1))], axis=1)
    first = (17 * np.arange(16)[:, None] + np.arange(16)).ravel()
    halves = [np.stack([first, first + 1, first + 18], -1), np.stack([first, first + 18, first + 17], -1)]
    many, few = (
        motes.Mesh(points, np.concatenate(halves)),
        motes.Mesh(points[[0, 16, 288, 272]], [(0, 1, 2), (0, 2, 3)]),
    )
    shape = {"alpha": [0.5], "color": [(0.1, 0.2, 0.3)]}
    turned = {"position": [(0, 0, 0)], "orientation": [turn((1, 2, 0), 30)]}
    pixel = 5 * np.tan(np.radians(22.5)) / 75
    on_samples = {"position": [(pixel / 8, pixel / 8, 0)], "size": [(64 * pixel, 1, 1)]}
    for state in (turned, on_samples):
        sums = [
            seen(motes.Sprite("mesh", mesh=mesh, blend="add"), shape | state).linear for mesh in (many, few)
        ]
        assert np.abs(sums[0] - sums[1]).max() < 0.003
        assert sums[0].max() < 0.2


def card(orientation: tuple[float, ...], blend: Any = "opaque", **state: Any) -> motes.Frame:
    sprite = motes.Sprite("image", image=SIDES, blend=blend, facing="orientation")
    given = {"position": [(0, 0, 0)], "orientation": [orientation], "size": [(2, 1, 1)]}
    return seen(sprite, given | state)


@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
def test_cards_are_seen_from_both_sides(blend: Any) -> None:
    front, back = (card(turn((0, 1, 0), angle), blend).linear for angle in (0, 180))
    left, right = front[75, 80], front[75, 120]
    assert left[0] > 0.9 > left[1] and right[1] > 0.9 > right[0]
    np.testing.assert_allclose(back[:, ::-1], front, atol=0.05)
    assert (card(turn((0, 1, 0), 90), blend).linear == 0).all(), "from its edge"
    upside = card(turn((1, 0, 0), 180), blend).linear
    assert upside[75, 80, 0] > 0.9, "turned about its own x axis, left stays left"


@pytest.mark.parametrize("angle", [0.0, 35.0, -60.0, 150.0])
def test_cards_are_in_perspective(angle: float) -> None:
    depth = card(turn((0, 1, 0), angle)).layer("depth")
    focal = 75 / np.tan(np.radians(22.5))
    a = np.radians(angle)
    for end in (-1, 1):
        x, z = end * np.cos(a), -end * np.sin(a)
        column = 100 + focal * x / (5 - z)
        row = np.isfinite(depth[75])
        inside = np.flatnonzero(row)
        wanted = inside.max() + 1 if x > 0 else inside.min()
        assert abs(wanted - column) < 1
        half = focal / (5 - z)
        rows = np.isfinite(depth[:, inside.max() if x > 0 else inside.min()]).sum()
        assert abs(rows - 2 * half) < 2.5
    columns = np.flatnonzero(np.isfinite(depth[75]))[1:-1]
    offset = (columns + 0.5 - 100) / focal  # the card's plane: x sin(a) + z cos(a) = 0
    np.testing.assert_allclose(depth[75, columns], 5 / (1 - offset * np.tan(a)), rtol=1e-3)


def test_cards_face_where_they_fly() -> None:
    sprite = motes.Sprite("image", image=SIDES, blend="opaque", facing="velocity")
    for velocity, width in (((0, 0, 3), 1), ((3, 0, 3), np.sqrt(0.5)), ((3, 0, 0), 0), ((0, 0, 0), 1)):
        state = {"position": [(0, 0, 0)], "velocity": [velocity], "size": [(2, 1, 1)]}
        covered = np.isfinite(seen(sprite, state).layer("depth")).sum()
        assert covered == pytest.approx(width * (2 * 75 / np.tan(np.radians(22.5)) / 5) ** 2, rel=0.06, abs=1)


@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
def test_streaks_of_posed_sprites_follow_the_way(blend: Any) -> None:
    for sprite in (motes.Sprite("image", image=SIDES, blend=blend, facing="orientation"),
                   motes.Sprite("mesh", mesh=ROCK, blend=blend)):  # fmt: skip
        state = {"position": [(1, 0, 0)], "size": [(0.5, 1, 1)]}
        still = seen(sprite, state, shutter=1).linear
        moved = seen(sprite, state | {"velocity": [(24, 0, 0)]}, shutter=1).linear
        light = moved.sum(axis=2) > 0
        columns = np.flatnonzero(light.any(axis=0))
        focal = 75 / np.tan(np.radians(22.5))
        assert columns.max() - columns.min() == pytest.approx(focal * 1 / 5 + np.ptp(
            np.flatnonzero((still.sum(axis=2) > 0).any(axis=0))), abs=4)  # fmt: skip
        if blend == "add":
            assert moved.sum() == pytest.approx(still.sum(), rel=0.05), (
                "dents that overlap count less at rest"
            )


EVERYWHERE = """
import hashlib, json, sys
import numpy as np
import motes
from motes import shapes

path, roles = sys.argv[1:]
renderer = motes.Renderer(
    320, 180, camera=motes.Camera((0, 0, 9), (0, 0, 0)), path=path, shutter=2.5,
    layers=["depth", "alpha", "velocity"], objects=[shapes.Sphere((1, 0, 0), 1)],
)
world = motes.World(seed=3, space=(-8, 8), roles=roles, renderer=renderer, progress="off")
leaf = np.random.default_rng(1).integers(0, 255, (9, 7, 4), dtype=np.uint8)
wedge = motes.Mesh(
    [(-1, -1, -1), (1, -1, -0.5), (0, 1, -1), (0, 0, 1.5)],
    [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
)
sprites = []
for blend in ("add", "alpha", "opaque"):
    sprites.append(motes.Sprite("mesh", mesh=wedge, blend=blend, facing="velocity"))
    sprites.append(motes.Sprite("image", image=leaf, facing="orientation", blend=blend))
systems = [world.system(f"s{i}", sprite=sprite) for i, sprite in enumerate(sprites)]
with world:
    for _ in world.frames(2):
        for system in systems:
            system.configure(color=(0.2, 0.5, 1), alpha=0.5, size=0.4, velocity=shapes.Sphere((0, 0, 0), 8))
            system.configure(orientation="random", spin=motes.Uniform((-9, -9, -9), (9, 9, 9)))
            system.burst(shapes.Box((-8, -4, -1), (8, 4, 8)), count=60)
            system.move()
        picture = world.render()
        if picture:
            layers = [hashlib.sha256(picture.layer(name).tobytes()).hexdigest() for name in renderer.layers]
            print(json.dumps([picture.digest(), *layers]))
"""


def test_posed_sprites_are_the_same_on_all_paths_and_ranks() -> None:
    alone = on_ranks(1, EVERYWHERE, "gather", "auto").lines
    assert len(set(alone)) == 2
    for path in ("gather", "tiles", "composite"):
        assert on_ranks(2, EVERYWHERE, path, "shared").lines == alone
        assert on_ranks(3, EVERYWHERE, path, "auto").lines == alone


def test_impossible_meshes_and_cards_are_refused() -> None:
    many = motes.Mesh(np.eye(3), [(0, 1, 2)] * 10_001)
    for wrong, name in (
        ({"kind": "mesh"}, "mesh"),
        ({"kind": "mesh", "mesh": shapes.Sphere((0, 0, 0), 1)}, "mesh"),
        ({"kind": "mesh", "mesh": many}, "10001 triangles"),
        ({"kind": "mesh", "mesh": ROCK, "pixels": 9}, "pixels"),
        ({"kind": "mesh", "mesh": ROCK, "height": 0.1}, "height"),
        ({"kind": "mesh", "mesh": ROCK, "image": SIDES}, "image"),
        ({"kind": "disc", "mesh": ROCK}, "mesh"),
        ({"kind": "disc", "facing": "velocity"}, "facing"),
        ({"kind": "image", "image": SIDES, "facing": "sun"}, "facing"),
    ):
        with pytest.raises(ArgumentError, match=name):
            motes.Sprite(**wrong)
    near = {"position": [(0, 0, 4.5)], "orientation": [turn((1, 0, 0), 89)], "size": [(3, 1, 1)]}
    for sprite in (motes.Sprite("mesh", mesh=ROCK, blend="opaque"),
                   motes.Sprite("image", image=SIDES, blend="alpha", facing="orientation")):  # fmt: skip
        assert np.isfinite(seen(sprite, near).linear).all(), "the camera is inside"
