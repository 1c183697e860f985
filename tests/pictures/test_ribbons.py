"""Ribbons: width and light compared with a reference in double, joints, the same pixels on all ranks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from standing import on_ranks

import motes
from motes import shapes
from motes.errors import ArgumentError

FRONT = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=45)
FOCAL = 75 / np.tan(np.radians(22.5))  # px


def flown(
    velocities: list[tuple[float, float, float]],
    start: tuple[float, float, float] = (0, 0, 0),
    dt: float = 1 / 16,
    *,
    born: int = 0,
    periodic: Any = None,
    sprite: motes.Sprite | None = None,
    camera: motes.Camera = FRONT,
    color: tuple[float, float, float] = (1, 1, 1),
    **facts: Any,
) -> motes.Frame:
    """Render a particle born in frame `born` in 200 x 150 pixels, with one of these velocities per frame."""
    renderer = motes.Renderer(200, 150, camera=camera, layers=["depth"], smooth=False, linear=True, **facts)
    world = motes.World(seed=1, dt=dt, renderer=renderer, periodic=periodic, progress="off")
    made = sprite or motes.Sprite("ribbon", width=0.25, length=2, blend="add")
    system = world.system("all", sprite=made)
    picture = None
    with world:
        for number, velocity in enumerate(velocities):
            if number == 0:
                for _ in range(born):
                    world.step()
                system.emit(position=[start], color=[color])
            system.set(velocity=velocity)
            system.move()
            picture = world.render()
    assert picture is not None
    return picture


def light_of(picture: motes.Frame) -> NDArray[Any]:
    """Return the red light of the pixels."""
    return np.asarray(picture.linear[:, :, 0], np.float64)


@pytest.mark.parametrize(("depth", "length"), [(5.0, 2.0), (3.0, 1.0), (11.0, 1.5)])
@pytest.mark.parametrize("ages", [40, 41, 43])
def test_a_straight_ribbon_has_the_width_and_light_of_its_formula(
    depth: float, length: float, ages: int
) -> None:
    """Both decrease linearly along the length; the joints at recorded positions do not show."""
    speed, width, dt = 0.75, 0.25, 1 / 16
    head = 0.5
    start = (head - speed * dt * ages, 0, 5 - depth)
    sprite = motes.Sprite("ribbon", width=width, length=length)
    light = light_of(flown([(speed, 0, 0)] * ages, start, dt, sprite=sprite))
    columns = np.arange(200) + 0.5 - 100
    along = (head - columns * depth / FOCAL) / (speed * length)
    wanted = np.where((along > 0) & (along < 1), (1 - along) * (1 - along) * width * FOCAL / depth, 0)
    inner = (along > 0.15) & (along < 0.95)
    assert inner.sum() > 10
    drawn = light.sum(axis=0)
    assert np.abs(drawn - wanted)[inner].max() < 0.02 * wanted.max() + 0.01
    assert drawn[along > 1.1].max(initial=0) == 0
    middle = light[74:76].max(axis=0)
    core = inner & ((1 - along) * width * FOCAL / depth > 3)
    assert np.abs(middle - (1 - along))[core].max() < 0.01, "no joint is darker or brighter"


@pytest.mark.parametrize("blend", ["add", "alpha"])
def test_joints_and_corners_are_covered_once(blend: Any) -> None:
    """The ribbon is half-transparent and has a sharp corner and a loop."""
    around = 2 * np.pi * np.arange(16) / 16
    loop = [(6 * np.cos(a), 6 * np.sin(a), 0) for a in around]
    path = [(4.0, 0, 0)] * 3 + [(0, 4.0, 0)] * 3 + [(-4.0, -4.0, 0)] * 3 + loop
    sprite = motes.Sprite("ribbon", width=0.3, length=1.6, blend=blend)
    picture = flown([(*v[:2], 0.0) for v in path], sprite=sprite, color=(0.5, 0.5, 0.5))
    light = light_of(picture)
    assert 0.4 < light.max() <= 0.505
    dim = motes.Sprite("ribbon", width=0.3, length=1.6, blend=blend)
    still = light_of(flown([(0, 0, 0)] * 9, sprite=dim, color=(0.5, 0.5, 0.5)))
    assert 0.49 < still.max() <= 0.505, "a particle at rest is a disc"
    assert np.pi * (0.15 * FOCAL / 5) ** 2 * 0.5 == pytest.approx(still.sum(), rel=0.02)


def test_the_ribbon_of_a_young_particle_begins_where_it_was_born() -> None:
    sprite = motes.Sprite("ribbon", width=0.1, length=8)
    for frames, earlier in ((2, 0), (3, 1), (4, 1), (9, 2), (40, 3)):  # positions are kept every few frames
        light = light_of(flown([(0.5, 0, 0)] * frames, (-0.5, 0, 0), born=earlier, sprite=sprite))
        lit = np.flatnonzero(light.sum(axis=0)) + 0.5 - 100
        born, now = (-0.5 + 0.5 / 16) * FOCAL / 5, (-0.5 + 0.5 / 16 * frames) * FOCAL / 5
        assert lit.min() >= born - 3 and lit.max() <= now + 3
        assert lit.min() <= born + 0.3 * (now - born) + 1


def test_ribbons_stay_whole_where_particles_wrap() -> None:
    """With binary fractions the wrapped picture is exactly that of a camera one period further on."""
    velocities = [(2.0, 0.5, 0)] * 13 + [(-2.0, 0.5, 0)] * 6
    start = (0.25, -0.5, 0)
    boxed = flown(velocities, start, periodic={"x": (-1, 1)})
    aside = motes.Camera((2, 0, 5), (2, 0, 0), fov_deg=45)
    free = flown(velocities, start, camera=aside)
    assert light_of(free).max() > 0.5
    assert np.array_equal(boxed.linear, free.linear)


def test_a_picture_drawn_again_has_the_same_ribbons() -> None:
    renderer = motes.Renderer(80, 60, camera=FRONT)
    world = motes.World(seed=1, dt=1 / 16, renderer=renderer, progress="off")
    system = world.system("all", sprite=motes.Sprite("ribbon", width=0.5, length=3))
    with world:
        for frame in world.frames(7):
            if frame == 0:
                system.emit(position=[(-1, 0, 0)], velocity=[(4, 1, 0)])
            system.move()
            assert world.render().digest() == world.redraw().digest()


def test_solids_hide_the_part_behind_them() -> None:
    """The particle flies in front of a ball, turns, and ends behind it."""
    ball = shapes.Sphere((0, 0, 0), 0.5)
    path = [(0.0, 0, -4.0)] * 4 + [(-2.0, 0, 0)] * 16 + [(0.0, 0, -4.0)] * 5 + [(2.0, 0, 0)] * 16
    for blend in ("add", "alpha", "opaque"):
        sprite = motes.Sprite("ribbon", width=0.2, length=2.6, blend=blend)
        clear = flown(path, (1, 0, 2), sprite=sprite)
        hidden = flown(path, (1, 0, 2), sprite=sprite, objects=[ball])
        alone = flown([(0, 0, 0)], (0, 0, 900), sprite=sprite, objects=[ball])
        changed = np.abs(hidden.linear - alone.linear).max(axis=2) > 0.01
        assert changed[70:80, 90:110].any(), "in front"
        assert clear.linear[75, 60:140].max() > 0
        wall, seen = alone.layer("depth"), hidden.layer("depth")
        assert (seen <= wall + 1e-4).all()
        if blend == "add":
            front = (hidden.linear - alone.linear)[74:76, 96:104]
            assert (front < 0.9 * clear.linear[74:76, 96:104]).all(), "the part behind adds nothing"


def test_opaque_ribbons_have_their_depth_at_each_pixel() -> None:
    sprite = motes.Sprite("ribbon", width=0.3, length=4, blend="opaque")
    picture = flown([(1.0, 0, -1.0)] * 33, (-1, 0, 2), sprite=sprite)
    depth = picture.layer("depth")[75]
    columns = np.flatnonzero(np.isfinite(depth))
    assert len(columns) > 50
    way = (columns + 0.5 - 100) / FOCAL  # x / depth, on the line z = 1 - x
    wanted = 4 / (1 - way)
    drawn = depth[columns]
    inner = slice(6, -6)
    assert np.abs(drawn - wanted)[inner].max() < 0.02 * wanted.max()


def test_light_and_shutter() -> None:
    sprite = motes.Sprite("ribbon", width=0.2, length=2, lit=True, blend="alpha")
    path = [(1.0, 0, 0)] * 20
    lamp = motes.Light((-1, 0.5, 0.5), (1, 0.1, 0.1), 1)
    lit = light_of(flown(path, (-1, 0, 0), sprite=sprite, sun=(0, 0, 0), lights=[lamp]))[75]
    plain = motes.Sprite("ribbon", width=0.2, length=2, blend="alpha")
    part = lit / np.maximum(light_of(flown(path, (-1, 0, 0), sprite=plain))[75], 0.05)
    assert part[70:80].max() > 2 * part[95:105].max(), "a lamp at its end lights its end"
    for shutter in (0.5, 4):
        blurred = light_of(flown(path, (-1, 0, 0), sprite=sprite, shutter=shutter))
        assert np.isfinite(blurred).all() and blurred.max() > 0.1


EVERYWHERE = """
import hashlib, json, sys
import numpy as np, motes
from motes import shapes
from motes.expressions import column

path, roles, frames, *where = sys.argv[1:]
renderer = motes.Renderer(320, 180, camera=motes.Camera((0, 0, 9), (0, 0, 0)), path=path, shutter=1.5,
    layers=["depth", "alpha", "velocity"], objects=[shapes.Sphere((1, 0, 0), 1)])
facts = {"checkpoint": motes.Checkpoint(where[0], every=5)} if where else {}
world = motes.World(seed=3, space=(-4, 4), roles=roles, renderer=renderer, periodic={"x": (-4, 4)},
                    balancer=motes.balance.Pairwise(), progress="off", **facts)
systems = [world.system(blend, sprite=motes.Sprite("ribbon", width=0.1, length=0.8, blend=blend, lit=lit))
           for blend, lit in (("add", False), ("alpha", True), ("opaque", False))]
with world:
    for frame in world.frames(int(frames)):
        world.renderer.camera = motes.Camera((0.1 * frame, 0, 9), (0, 0, 0))
        for system in systems:
            system.configure(color=(0.2, 0.5, 1), alpha=0.5, velocity=shapes.Sphere((0, 0, 0), 9))
            system.configure(lifetime=motes.Uniform(0.2, 1))
            system.burst(shapes.Box((-4, -3, -1), (4, 3, 3)), count=20)
            system.set(velocity=column("velocity") - column("position") * 0.4)
            system.move()
            system.kill_expired()
        picture = world.render()
        digest = world.digest()
        if picture:
            layers = [hashlib.sha256(picture.layer(name).tobytes()).hexdigest() for name in renderer.layers]
            print(json.dumps([frame, str(digest), picture.digest(), *layers]))
"""


def test_ribbons_are_the_same_on_all_paths_and_ranks_and_after_a_restart(tmp_path: Any) -> None:
    alone = on_ranks(1, EVERYWHERE, "gather", "auto", 14).lines
    assert len(set(alone)) == 14
    for ranks, path, roles in ((2, "tiles", "shared"), (3, "composite", "auto"), (5, "gather", "shared")):
        assert on_ranks(ranks, EVERYWHERE, path, roles, 14).lines == alone
    on_ranks(2, EVERYWHERE, "gather", "shared", 12, tmp_path / "kept")
    anyway = {"MOTES_ANYWAY": "1"}  # the arguments differ
    again = on_ranks(3, EVERYWHERE, "tiles", "auto", 14, tmp_path / "kept", env=anyway).lines
    assert again and again == alone[-len(again) :]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({}, "width"),
        ({"width": 1}, "length"),
        ({"length": 1}, "width"),
        ({"width": 0, "length": 1}, "width must be above 0.*0"),
        ({"width": -1, "length": 1}, "width"),
        ({"width": float("nan"), "length": 1}, "width"),
        ({"width": 1, "length": 0}, "length must be above 0.*0"),
        ({"width": 1, "length": -2}, "length"),
        ({"width": "1", "length": 1}, "width"),
        ({"kind": "disc", "width": 1}, "width"),
        ({"kind": "disc", "length": 1}, "length"),
        ({"width": 1, "length": 1, "pixels": 9}, "pixels"),
        ({"width": 1, "length": 1, "height": 0.1}, "height"),
        ({"width": 1, "length": 1, "shadow": 0.5}, "shadow"),
        ({"width": 1, "length": 1, "facing": "velocity"}, "facing"),
    ],
)
def test_impossible_ribbons_are_refused(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        motes.Sprite(**{"kind": "ribbon", **wrong})


def test_a_system_keeps_positions_from_the_start() -> None:
    world = motes.World(progress="off")
    plain = world.system("plain")
    banded = world.system("banded", sprite=motes.Sprite("ribbon", width=1, length=2))
    banded.sprite = motes.Sprite("ribbon", width=3, length=2, blend="alpha")
    with pytest.raises(ArgumentError, match="not a ribbon"):
        plain.sprite = banded.sprite
    for other in (motes.Sprite(), motes.Sprite("ribbon", width=1, length=3)):
        with pytest.raises(ArgumentError, match="a ribbon of 2"):
            banded.sprite = other
