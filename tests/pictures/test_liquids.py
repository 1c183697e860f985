"""Sprites of kind "surface": smooth, bent, white where fast, the same pixels on all ranks and paths."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from same_bits import widths
from standing import on_ranks

import motes
from motes import shapes
from motes.errors import ArgumentError

FRONT = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=45)


def poured(
    positions: ArrayLike,
    *,
    sprite: motes.Sprite | None = None,
    before: Any = None,
    color: tuple[float, float, float] = (1, 1, 1),
    alpha: float = 1,
    speed: float = 0,
    **facts: Any,
) -> motes.Frame:
    """Render a liquid in 160 x 120 pixels. `before`: a function that adds other systems."""
    renderer = motes.Renderer(160, 120, camera=FRONT, smooth=False, linear=True, **facts)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    water = world.system("water", sprite=sprite or motes.Sprite("surface", radius=0.1))
    add = before(world) if before else lambda: None
    with world:
        places = np.asarray(positions, np.float32).reshape(-1, 3)
        rows = np.ones((len(places), 1), np.float32)
        if len(places):
            water.emit(
                position=places, color=rows * color, alpha=rows[:, 0] * alpha, velocity=rows * (speed, 0, 0)
            )
        add()
        return world.render()


def sheet(step: float = 0.1) -> NDArray[np.float64]:
    """Return places on a plane that faces the camera."""
    side = np.arange(-1.4, 1.4001, step)
    return np.stack(np.meshgrid(side, side, [0]), -1).reshape(-1, 3)


def test_a_liquid_is_drawn_where_its_particles_are():
    picture = poured([(0, 0, 0)], layers=["depth", "alpha"], background=(0.5, 0.5, 0.5))
    depth = picture.layer("depth")
    there = np.isfinite(depth)
    y, x = np.nonzero(there)
    focal = 60 / np.tan(np.radians(22.5))
    radius = 0.1 * focal / 5
    assert abs(there.sum() - np.pi * radius**2) < 8
    assert abs(x.mean() - 79.5) < 0.6 and abs(y.mean() - 59.5) < 0.6
    assert abs(depth[there].min() - 4.9) < 0.03
    assert (picture.layer("alpha")[there] == 1).all()


def test_the_skin_is_smooth():
    depth = poured(sheet(), sprite=motes.Sprite("surface", radius=0.08), layers=["depth"]).layer("depth")
    inner = depth[45:75, 60:100]
    ball = 0.08 - np.sqrt(0.08**2 - 0.05**2)  # between the tops of two balls and where they meet
    assert np.isfinite(inner).all()
    assert np.ptp(inner) < 0.35 * ball


def test_clear_liquid_shows_what_is_behind():
    back = shapes.Box((-3, -3, -2), (3, 3, -1.5))
    objects = [motes.Solid(back, color=(1, 1, 1), light=0.5)]
    bare = poured([], objects=objects).linear[60, 80]
    clear = poured(sheet(), objects=objects, alpha=0.02).linear[60, 80]
    tinted = poured(sheet(), objects=objects, alpha=0.02, color=(0, 1, 1)).linear[60, 80]
    deep = poured(sheet(), objects=objects, alpha=1, color=(0, 1, 1)).linear[60, 80]
    assert (abs(clear - bare) < 0.12 * bare + 0.02).all()
    assert tinted[0] < clear[0] - 0.02 and tinted[1] == pytest.approx(clear[1], rel=1e-3)
    assert deep[0] < tinted[0]


def edges(glass: float) -> float:
    """Return how far a ball shifts an edge behind it, px."""
    back = shapes.Box((0, -3, -2), (3, 3, -1.5))
    sprite = motes.Sprite("surface", radius=0.6, glass=glass)
    facts: dict[str, Any] = {"objects": [motes.Solid(back, light=0.5)], "sun": (0, 0, 0)}
    row = poured([(-0.2, 0, 0)], sprite=sprite, alpha=0.02, **facts).linear[60, :, 0]
    return float(np.count_nonzero(row > 0.3))


def test_glass_bends_what_is_behind():
    assert edges(1.5) != edges(1)


def test_fast_liquid_is_white():
    sprite = motes.Sprite("surface", radius=0.1, foam=4)
    still, fast = (poured(sheet(), sprite=sprite, color=(0, 0, 0), speed=v).linear[60, 80] for v in (0, 9))
    assert (fast > still + 0.2).all() and np.ptp(fast) < 0.1


def test_particles_in_front_are_drawn_over_a_liquid_and_those_behind_under_it():
    def smoke(z: float) -> Any:
        def add(world: motes.World) -> Any:
            system = world.system("smoke", sprite=motes.Sprite(pixels=60, blend="alpha"))
            return lambda: system.emit(position=[(0, 0, z)], color=[(1, 0, 0)], alpha=[0.9])

        return add

    plain = poured(sheet()).linear[60, 80]
    front = poured(sheet(), before=smoke(1)).linear[60, 80]
    behind = poured(sheet(), before=smoke(-1)).linear[60, 80]
    bare = poured([], before=smoke(1)).linear[60, 80]
    assert np.allclose(front, 0.9 * np.array([1, 0, 0]) + 0.1 * plain, atol=0.06)
    assert bare[0] > 0.8
    assert abs(behind - plain).max() < 0.9 * abs(front - plain).max()


def test_solids_in_front_hide_a_liquid():
    objects = [motes.Solid(shapes.Sphere((0, 0, 1), 0.5), color=(1, 0, 0))]
    assert (
        poured(sheet(), objects=objects).linear[60, 80] == poured([], objects=objects).linear[60, 80]
    ).all()


def test_a_liquid_without_particles_changes_nothing():
    bare = poured([], sprite=motes.Sprite("disc"), background=(0.1, 0.2, 0.3), bloom=0.2)
    assert (poured([], background=(0.1, 0.2, 0.3), bloom=0.2).pixels == bare.pixels).all()


def test_a_liquid_leaves_nothing_where_it_was():
    """The planes of a tile are cleared once the liquid has left it: smoothing in the next tile reads them."""
    renderer = motes.Renderer(160, 120, camera=FRONT, smooth=False, linear=True, layers=["depth"])
    sprite = motes.Sprite("surface", radius=0.3)
    world = motes.World(seed=1, dt=1, renderer=renderer, progress="off")
    water = world.system("water", sprite=sprite)
    with world:
        water.emit(position=[(-0.9, 0.25, 0)], velocity=[(0.7, 0, 0)])  # just before and behind the border
        for k in range(2):
            frame = world.render()
            alone = poured([(-0.9 + 0.7 * k, 0.25, 0)], sprite=sprite, layers=["depth"])
            assert np.isfinite(frame.layer("depth")).any(0)[[62, 66]].tolist() == [k == 0, k == 1]
            assert (frame.linear == alone.linear).all()
            assert (frame.layer("depth") == alone.layer("depth")).all()
            water.move()


def test_a_liquid_bends_what_is_in_the_tile_beside_it():
    """Deep liquid at the border of a tile shows what is behind pixels of the next."""
    focal = 60 / np.tan(np.radians(22.5))
    away = np.linspace(5, 7, 60)[:, None]
    column = FRONT.position + away * [(60 - 80) / focal, 0, -1]  # all in front of pixel 60
    back = shapes.Box(((64 - 80) / focal * 13, -9, -9), (9, 9, -8))  # from the second column of tiles on
    sprite = motes.Sprite("surface", radius=0.12, glass=1.5)
    facts: dict[str, Any] = {"objects": [motes.Solid(back, light=0.5)], "sun": (0, 0, 0), "alpha": 0.002}
    deep = poured(column, sprite=sprite, **facts)
    assert not np.isfinite(poured(column, sprite=sprite, layers=["depth"]).layer("depth"))[:, 64:].any()
    assert deep.linear[:, :64].max() > 0.3 > poured([], **facts).linear[:, :64].max()
    both = poured([*column, (0, 1, 0)], sprite=sprite, **facts)  # the tile beside it has some liquid, too
    assert (both.linear[:, :64] == deep.linear[:, :64]).all()


EVERYWHERE = """
import hashlib, json, sys
import motes
from motes import shapes

path, roles, frames = sys.argv[1:]
renderer = motes.Renderer(320, 180, camera=motes.Camera((0, 1, 9), (0, 0, 0)), path=path, shutter=0.5,
    bloom=0.1,
    background=motes.Gradient((0.6, 0.7, 0.8), (0.1, 0.3, 0.7)), lights=[motes.Light((1, 3, 3), power=4)],
    layers=["depth", "alpha", "velocity"], objects=[shapes.Sphere((1, 0, 0), 1)], fog=((0.5, 0.5, 0.5), 40))
world = motes.World(seed=3, space=(-4, 4), roles=roles, renderer=renderer,
                    balancer=motes.balance.Pairwise(), progress="off")
looks = {"water": motes.Sprite("surface", radius=0.12, foam=12),
         "oil": motes.Sprite("surface", radius=0.3, glass=1.5),
         "smoke": motes.Sprite(pixels=30, blend="alpha"), "sparks": motes.Sprite(pixels=5),
         "balls": motes.Sprite("sphere", pixels=9, blend="opaque", shadow=0.3)}
systems = [world.system(name, sprite=sprite) for name, sprite in looks.items()]
with world:
    for frame in world.frames(int(frames)):
        for system in systems:
            system.configure(color=motes.Uniform((0, 0.2, 0.4), (0.2, 0.8, 1)), alpha=0.5)
            system.configure(velocity=shapes.Sphere((0, 0, 0), 9), lifetime=motes.Uniform(0.2, 1))
            system.burst(shapes.Box((-4, -3, -1), (4, 3, 3)), count=40 if system is not systems[0] else 900)
            system.move()
            system.kill_expired()
        picture = world.render()
        if picture:
            layers = [hashlib.sha256(picture.layer(name).tobytes()).hexdigest() for name in renderer.layers]
            print(json.dumps([frame, picture.digest(), *layers]))
"""


@cache
def alone() -> list[str]:
    """Return the pictures of one rank."""
    lines = on_ranks(1, EVERYWHERE, "gather", "auto", 4).lines
    assert len(set(lines)) == 4
    return lines


def test_liquids_are_the_same_on_all_paths_and_ranks():
    one = alone()
    for ranks, path, roles in ((2, "tiles", "shared"), (3, "composite", "auto"), (5, "auto", "shared")):
        assert on_ranks(ranks, EVERYWHERE, path, roles, 4).lines == one


def test_liquids_are_the_same_with_any_threads():
    env = {"MOTES_THREADS": "3", "MOTES_GRAIN": "100"}
    assert on_ranks(1, EVERYWHERE, "gather", "auto", 4, env=env).lines == alone()


@pytest.mark.parametrize("width", widths())
def test_liquids_are_the_same_with_any_vector_width(width: str):
    assert on_ranks(1, EVERYWHERE, "gather", "auto", 4, env={"MOTES_SIMD": width}).lines == alone()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({}, "radius must be given for kind='surface'"),
        ({"radius": 0}, "radius must be a finite number"),
        ({"radius": "1"}, "radius must be a number"),
        ({"radius": float("nan")}, "radius"),
        ({"radius": 1, "foam": -1}, "foam"),
        ({"radius": 1, "foam": None}, "foam must be a number"),
        ({"radius": 1, "glass": 0.9}, "glass"),
        ({"radius": 1, "glass": 9}, "glass"),
        ({"radius": 1, "pixels": 9}, "pixels must be left out for a surface"),
        ({"radius": 1, "height": 0.1}, "height must be left out for a surface"),
        ({"radius": 1, "blend": "alpha"}, "blend must be left out for a surface"),
        ({"radius": 1, "softness": 0.1}, "softness must be left out"),
        ({"radius": 1, "lit": True}, "lit must be left out"),
        ({"kind": "disc", "radius": 1}, "radius must be given for kind='surface'"),
        ({"kind": "disc", "foam": 1}, "foam must be left out"),
        ({"kind": "disc", "glass": 1.5}, "glass must be left out"),
    ],
    ids=str,
)
def test_wrong_arguments(wrong: dict[str, Any], said: str):
    with pytest.raises(ArgumentError, match=said):
        motes.Sprite(**{"kind": "surface", **wrong})


def test_a_surface_shows_itself():
    sprite = motes.Sprite("surface", radius=0.1, foam=2)
    assert repr(sprite) == "Sprite(kind='surface', radius=0.1, foam=2.0)"
    assert sprite == motes.Sprite("surface", radius=0.1, foam=2) != motes.Sprite("surface", radius=0.1)
