"""What pictures show of objects and lights: a lit stone, meshes beside shapes, shadows, wrong input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import motes
from motes.shapes import Plane, Sphere

SIZE = (192, 108)
CAMERA = motes.Camera((0, 3, 7), (0, 0.8, 0))
GROUND = motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (0.5, 0.5, 0.5))
STONE = motes.Solid(Sphere((0, 1, 0), 1), (0.6, 0.5, 0.4))
NIGHT: dict[str, Any] = {"sun": (0, 0, 0), "background": (0, 0, 0)}


DEFAULTS = {"sun": (-0.5, 0.8, 0.4), "lights": (), "background": (0.1, 0.1, 0.15), "smooth": True}


def pictures(*views: dict[str, Any]) -> list[np.ndarray]:
    """Light of frames without particles, one after the other by one renderer."""
    renderer = motes.Renderer(*SIZE, camera=CAMERA, linear=True)
    light = []
    with motes.World(seed=1, renderer=renderer, progress="off") as world:
        for view in views:
            for name, value in (DEFAULTS | view).items():
                setattr(renderer, name, value)
            light.append(np.array(world.render().linear))
    return light


def view(*objects: motes.Solid, **more: Any) -> dict[str, Any]:
    return {"objects": objects, **more}


def ball_mesh(rings: int = 48) -> motes.Mesh:
    """The triangles of STONE."""
    up = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[:, None]
    turn = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)[None, :]
    points = np.stack(
        [np.cos(up) * np.cos(turn), np.sin(up) + 1 + 0 * turn, np.cos(up) * np.sin(turn)], axis=-1
    )
    at = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    a, b = at[:-1], np.roll(at, -1, axis=1)[:-1]
    c, d = at[1:], np.roll(at, -1, axis=1)[1:]
    triangles = np.concatenate(
        [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([b, d, c], -1).reshape(-1, 3)]
    )
    return motes.Mesh(points.reshape(-1, 3), triangles)


def test_a_fire_lights_its_stone():
    fire = motes.Light((2.5, 1, 1), (1, 0.5, 0.2), power=3)
    dark, lit = pictures(view(GROUND, STONE, **NIGHT), view(GROUND, STONE, lights=[fire], **NIGHT))
    gain = lit - dark
    assert gain.min() > -1e-4, "one step of the stored light"
    right, left = gain[:, 96:], gain[:, :96]
    assert right.sum() > 2 * left.sum(), "the side of the fire"
    brightest = np.unravel_index(gain[..., 0].argmax(), gain.shape[:2])
    assert gain[brightest][0] > gain[brightest][1] > gain[brightest][2] > 0, "the colour of the fire"
    # Behind the stone its shadow: the ground there gets nothing.
    assert (gain[55:70, :50] == 0).any()


def test_lights_move_without_the_camera():
    def fire_at(x: float) -> dict[str, Any]:
        return view(GROUND, STONE, lights=[motes.Light((x, 1.5, 2))], **NIGHT)

    first, second, again = pictures(fire_at(-2), fire_at(2), fire_at(-2))
    assert np.array_equal(first, again)
    assert np.abs(first[:, ::-1] - second).mean() < 2e-3, "the scene is symmetric"
    assert np.abs(first - second).mean() > 0.01


def test_a_mesh_looks_like_its_shape():
    fire = motes.Light((2, 3, 3), power=4)
    mesh = motes.Solid(ball_mesh(), STONE.color)
    shape, triangles = pictures(*(view(GROUND, one, lights=[fire]) for one in (STONE, mesh)))
    assert np.abs(shape - triangles).mean() < 2e-3
    nothing, coarse = pictures(view(GROUND), view(GROUND, motes.Solid(ball_mesh(4), STONE.color)))
    assert np.abs(nothing - coarse).mean() > 0.01


def test_what_emits_light_shines_at_night():
    lamp = motes.Solid(STONE.shape, STONE.color, light=1.5)
    dark, shining = pictures(view(STONE, **NIGHT), view(lamp, **NIGHT))
    gain = shining - dark
    assert gain.max(axis=(0, 1)) == pytest.approx(1.5 * np.array(STONE.color), rel=0.05)


def test_edges_are_smooth_unless_asked_otherwise():
    black = motes.Solid(STONE.shape, (0, 0, 0))
    look: dict[str, Any] = {"background": (1, 1, 1)}
    smooth, rough = (p[..., 0] for p in pictures(view(black, **look), view(black, smooth=False, **look)))
    fog = rough[rough < 0.5].max()
    assert ((smooth > fog + 0.1) & (smooth < 0.9)).sum() > 30
    assert ((rough > fog + 0.1) & (rough < 0.9)).sum() == 0
