"""Shadows of single particles: what they block, what they leave to themselves, and that they stand still."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import motes
from motes.shapes import Plane

Place = tuple[float, float, float]
GROUND = motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (1, 1, 1))
ABOVE = motes.Camera((0, 40, 0), (0, 0, 0), up=(0, 0, -1), fov_deg=14)
SIDE = motes.Camera((0, 0, 4), (0, 0, 0))
FAR = 1000.0
PIXEL = 2 * 40 * np.tan(np.radians(7)) / 160  # m on the ground
SUN: dict[str, Any] = {"sun": (0, 1, 0)}
LAMP: dict[str, Any] = {"sun": (0, 0, 0), "lights": [motes.Light((0, FAR, 0), (1, 1, 1), 0.7 * FAR**2)]}


def shot(
    places: list[Place], shadow: float, camera: motes.Camera, size: float = 1, lit: bool = False, **light: Any
) -> NDArray[np.float64]:
    """Return the light of a picture of balls: black ones above the ground, or white ones without it."""
    objects = [] if lit else [GROUND]
    facts = {"background": (0, 0, 0), "fog": ("black", 1e9), "linear": True, "objects": objects}
    world = motes.World(
        seed=1, progress="off", renderer=motes.Renderer(160, 160, camera=camera, **facts, **light)
    )
    sprite = motes.Sprite("disc", None, "alpha" if lit else "add", lit=lit, shadow=shadow)
    balls = world.system("balls", sprite=sprite)
    with world:
        balls.configure(size=size, color=(float(lit),) * 3)
        balls.emit(position=np.reshape(places, (-1, 3)))
        return world.render().linear[..., 0].astype(float)


def lost(places: list[Place], shadow: float, light: dict[str, Any], size: float = 1) -> NDArray[np.float64]:
    """Return the part of the light that each pixel of the ground lacks."""
    dark, bright = shot([], 0, ABOVE, sun=(0, 0, 0)), shot([], 0, ABOVE, **light)
    return (bright - shot(places, shadow, ABOVE, size, **light)) / (bright - dark)


@pytest.mark.parametrize("light", [SUN, LAMP])
@pytest.mark.parametrize("shadow", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("size", [0.13, 0.4, 1.0, 1.9])
def test_a_ball_takes_its_disc_from_the_ground(light: dict[str, Any], shadow: float, size: float) -> None:
    """The light that the ground loses is that of the ball's disc, which is dark in the middle."""
    for places in ([(0.0, 2.0, 0.0)], [(-1.3, 2.0, 0.4), (1.3, 1.2, -0.7)]):
        found = lost(places, shadow, light, size)
        assert found.sum() * PIXEL**2 == pytest.approx(len(places) * np.pi / 4 * size**2 * shadow, rel=0.02)
        if size >= 0.4:
            assert found.max() == pytest.approx(shadow, rel=0.02)


def test_ten_large_puffs_are_as_dark_as_ray_tracing_says() -> None:
    """Each ray keeps 1 - shadow of its light at every disc that it crosses."""
    dice = np.random.default_rng(4)
    places = [(x, y, z) for x, y, z in dice.uniform((-1, 2, -1), (1, 3, 1), (10, 3)).tolist()]
    found = lost(places, 0.3, SUN, 1.2)
    middles = (np.arange(160) - 79.5) * PIXEL
    x, z = np.meshgrid(middles, middles)
    left = np.ones_like(x)
    for px, _, pz in places:
        left *= np.where(np.hypot(x - px, z - pz) < 0.6, 0.7, 1)
    assert found.sum() == pytest.approx((1 - left).sum(), rel=0.02)
    assert found[80, 80] == pytest.approx(1 - left[80, 80], abs=0.02)


@pytest.mark.parametrize("shadow", [0.1, 0.5])
def test_a_ball_shades_others_and_not_itself(shadow: float) -> None:
    """A lone ball keeps all of its sun; one under another keeps what that leaves."""
    for places, due in (([(0, 0, 0)], 1.0), ([(0, 0, 0), (0, 3, 0)], 1 - shadow)):
        sky, full, now = (
            shot(places, s, SIDE, lit=True, sun=sun)[80, 80]
            for s, sun in ((0, (0, 0, 0)), (0, (0, 1, 0)), (shadow, (0, 1, 0)))
        )
        assert (now - sky) / (full - sky) == pytest.approx(due, abs=0.015)


def test_discs_about_a_cell_wide_block_their_area() -> None:
    """Opaque discs that do not overlap take their area from the ground, wherever they lie between cells."""
    dice = np.random.default_rng(2)
    grid = np.stack(np.meshgrid(*[np.linspace(-3.5, 3.5, 8)] * 2), -1).reshape(-1, 2)
    for size in (0.1, 0.125, 0.2):
        at = grid + dice.uniform(-0.25, 0.25, grid.shape)
        found = lost([(x, 1.0, z) for x, z in at.tolist()], 1, SUN, size)
        assert found.sum() * PIXEL**2 == pytest.approx(len(at) * np.pi / 4 * size**2, rel=0.03)


@pytest.mark.parametrize("blend", ["alpha", "opaque"])
@pytest.mark.parametrize("lights", [{}, {"sun": (0, 0, 0), "lights": [motes.Light((-2, 3, 1), power=9)]}])
def test_no_shadow_moves_when_another_particle_leaves(blend: Any, lights: dict[str, Any]) -> None:
    """A particle far from a resting scene changes no pixel of it."""
    camera = motes.Camera((0, 3.2, 3.2), (0, 0, 0), fov_deg=36)
    dice = np.random.default_rng(0)
    resting = (dice.uniform(-1, 1, (25, 3)) * (1, 0, 1) + (0, 0.12, 0)).tolist()
    pictures = []
    for far in ((40.0, 1.0, 3.0), (7.0, 90.0, -300.0), (-9.0, 0.4, 25.0)):
        renderer = motes.Renderer(160, 120, camera=camera, objects=[GROUND], linear=True, **lights)
        world = motes.World(seed=1, renderer=renderer, progress="off")
        sprite = motes.Sprite("sphere", None, blend, lit=True, shadow=0.9)
        system = world.system("m", sprite=sprite)
        with world:
            system.configure(size=0.12, color=(0.8, 0.4, 0.2))
            system.emit(position=[*resting, far])
            pictures.append(world.render().linear.copy())
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])
