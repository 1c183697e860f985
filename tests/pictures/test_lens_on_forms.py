"""Meshes, cards and ribbons out of focus, and turning while the shutter is open."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import motes
from motes import shapes

POINTS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = motes.Mesh(POINTS, [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])
SHEET = np.full((6, 8, 4), 255, np.uint8)
SHEET[:3, :4, 1:3] = 60
FOCAL = 60 / np.tan(np.radians(22.5))
STILL = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=45)


def sprite_of(kind: str, blend: Any, **facts: Any) -> motes.Sprite:
    """Return a sprite: a mesh, a card or a ribbon."""
    if kind == "mesh":
        return motes.Sprite("mesh", mesh=CUBE, blend=blend, **facts)
    if kind == "card":
        return motes.Sprite("image", image=SHEET, blend=blend, facing="orientation", **facts)
    return motes.Sprite("ribbon", width=0.12, length=0.5, blend=blend, **facts)


def turn(axis: tuple[float, float, float], angle_deg: float) -> tuple[float, ...]:
    """Return a rotation as a quaternion x, y, z, w."""
    half = np.radians(angle_deg) / 2
    return (*(np.sin(half) * np.array(axis) / np.linalg.norm(axis)), float(np.cos(half)))


def seen(
    sprite: motes.Sprite,
    camera: motes.Camera = STILL,
    *,
    frames: int = 1,
    facts: dict[str, Any] | None = None,
    **state: Any,
) -> NDArray[np.float32]:
    """Return the light of one particle in a picture of 160 x 120 pixels."""
    renderer = motes.Renderer(160, 120, camera=camera, linear=True, smooth=False, **(facts or {}))
    world = motes.World(seed=1, dt=1 / 16, renderer=renderer, progress="off")
    system = world.system("one", sprite=sprite)
    given = {"position": [(0, 0, 0)], "color": [(0.4, 0.4, 0.4)], "size": [(0.4, 1, 1)]} | state
    with world:
        for frame in world.frames(frames):
            if frame == 0:
                system.emit(**given)
            if frames > 1:
                system.move()
            picture = world.render()
        return picture.linear


def lens(focus: float, aperture: float) -> motes.Camera:
    return motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=45, focus=focus, aperture=aperture)


@pytest.mark.parametrize("kind", ["mesh", "card", "ribbon"])
@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
def test_what_is_out_of_focus_keeps_its_light(kind: str, blend: Any) -> None:
    state: dict[str, Any] = {"orientation": [turn((1, 2, 3), 40)]}
    if kind == "ribbon":
        state = {"frames": 12, "velocity": [(1, 0.3, 0)], "position": [(-0.5, 0, 0)]}
    sprite = sprite_of(kind, blend)
    sharp, blurred, wide = (seen(sprite, lens(*of), **state) for of in ((5, 0.3), (3, 0.3), (2.2, 0.6)))
    assert blurred.sum() == pytest.approx(sharp.sum(), rel=0.02)
    assert wide.sum() == pytest.approx(sharp.sum(), rel=0.02)
    counts = [np.count_nonzero(light[:, :, 0]) for light in (sharp, blurred, wide)]
    assert 1.3 * counts[0] < counts[1] < 0.8 * counts[2]
    assert wide.max() < 0.6 * blurred.max()


@pytest.mark.parametrize("kind", ["mesh", "card"])
def test_the_circle_of_confusion_is_that_of_a_thin_lens(kind: str) -> None:
    light = seen(sprite_of(kind, "add"), lens(2.5, 0.25), size=[(0.02, 1, 1)], color=[(1, 1, 1)])[:, :, 0]
    wanted = 0.25 * FOCAL * (1 / 2.5 - 1 / 5)
    rows, columns = np.nonzero(light)
    across = np.ptp(columns) + 1, np.ptp(rows) + 1
    assert across == pytest.approx((wanted, wanted), abs=3.5)
    inner = light[(np.hypot(*np.mgrid[-59.5:60, -79.5:80]) < 0.4 * wanted)]
    assert inner.min() > 0.4 * inner.mean(), "a disc, not dots"


@pytest.mark.parametrize("kind", ["mesh", "card"])
@pytest.mark.parametrize("blend", ["add", "alpha"])
def test_turning_while_the_shutter_is_open_is_the_mean_of_stills(kind: str, blend: Any) -> None:
    axis, angle = (0.3, -0.5, 1.0), 80.0
    spin = tuple(np.radians(angle) * 16 * np.array(axis) / np.linalg.norm(axis))
    sprite, size = sprite_of(kind, blend), [(1.2, 1, 1)]
    whole = {"shutter": 1.0}
    turned = seen(sprite, facts=whole, size=size, spin=[spin], orientation=[turn(axis, 30)])
    stills = [
        seen(sprite, facts=whole, size=size, orientation=[turn(axis, 30 - angle * (k + 0.5) / 24)])
        for k in range(24)
    ]
    mean = np.mean(stills, axis=0)
    assert np.abs(turned - stills[0]).max() > 0.2
    assert np.abs(turned - mean).mean() < 0.002
    assert np.abs(turned - mean).max() < 0.06
    opaque = seen(
        sprite_of(kind, "opaque"), facts=whole, size=size, spin=[spin], orientation=[turn(axis, 30)]
    )
    reached = mean[:, :, 0] > 0.05
    assert np.mean(opaque[reached] > 0) > 0.97, "an opaque one covers all that it passes"


def test_the_head_of_a_ribbon_runs_while_the_shutter_is_open() -> None:
    """Each point of the head's path is covered for part of the exposure, its midpoint for half of it."""
    sprite = motes.Sprite("ribbon", width=0.1, length=0.5)
    state = {"frames": 12, "velocity": [(2, 0, 0)], "position": [(-1, 0, 0)], "color": [(1, 1, 1)]}
    still, open_ = (seen(sprite, facts={"shutter": part}, **state)[60, :, 0] for part in (0, 2))
    head = (-1 + 2 * 12 / 16) * FOCAL / 5 + 80
    way = 2 * 2 / 16 * FOCAL / 5
    middle = int(head - way / 2)
    assert open_[middle] == pytest.approx((head - middle - 0.5) / way, abs=0.08)
    assert still[middle] > 0.7
    assert open_[int(head - 1)] < 0.4 < 0.9 < still[int(head - 1)]
    assert open_.sum() < still.sum()


@pytest.mark.parametrize("blend", ["opaque", "alpha"])
def test_a_leaf_on_the_ground_is_whole_through_a_lens(blend: Any) -> None:
    """Each pixel of the leaf is depth-tested against the ground, not only its centre, which may be below."""
    ground = motes.Solid(shapes.Plane((0, 0, 0), (0, 1, 0)), (0, 0, 0))
    leaf = motes.Sprite("image", image=SHEET, blend=blend, facing="orientation")
    state = {"orientation": [turn((1, 0, 0), -90)], "size": [(1.5, 1, 1)], "position": [(0, 0.002, 0)]}
    eye: dict[str, Any] = {"position": (0, 1, 4), "look_at": (0, 0, 0), "fov_deg": 45}
    facts = {"objects": [ground], "sun": (0, 0, 0), "background": (0, 0, 0)}
    through = motes.Camera(**eye, focus=3.0, aperture=0.1)
    lying = seen(leaf, through, facts=facts, **state)
    free = seen(leaf, through, facts=facts | {"objects": []}, **state)
    # The ground is blurred by other points of the lens than a blended leaf.
    assert lying.sum() == pytest.approx(free.sum(), rel=0.02 if blend == "opaque" else 0.05)
    state |= {"orientation": [(1, 0, 0, 0)], "position": [(0, -0.1, 0)]}
    sunk = seen(leaf, through, facts=facts, **state)
    free = seen(leaf, through, facts=facts | {"objects": []}, **state)
    assert 0.3 * free.sum() < sunk.sum() < 0.6 * free.sum()
