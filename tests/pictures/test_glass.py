"""Solids of glass: what is seen through them, what they reflect, and what they leave as it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from made_meshes import globe
from numpy.typing import NDArray

import motes
from motes import shapes
from motes.errors import ArgumentError

Picture = NDArray[np.float64]
GLASS = shapes.Sphere((0, 0, 0), 0.5)
CHECKS = np.kron([[1, 0] * 4, [0, 1] * 4] * 4, np.ones((4, 4)))[..., None] * (0.8, 0.6, 0.2) + 0.1
BOARD = motes.Solid(shapes.Rectangle((-4, -4, -2), (8, 0, 0), (0, 8, 0)), (1, 1, 1), image=CHECKS, scale=4)
CAMERA = motes.Camera((0, 0, 4), (0, 0, 0), fov_deg=30)


def picture(
    *objects: Any,
    sprite: motes.Sprite | None = None,
    place: Any = (0, 0, 0),
    finer: int = 1,
    **facts: Any,
) -> Picture:
    facts = {
        "background": (0.1, 0.1, 0.1),
        "fog": ("black", 1e9),
        "sun": (0.3, 0.5, 1),
        "camera": CAMERA,
    } | facts
    renderer = motes.Renderer(120 * finer, 90 * finer, linear=True, objects=objects, **facts)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("one", **({} if sprite is None else {"sprite": sprite}))
    with world:
        if sprite is not None:
            system.configure(size=0.2, color=(0.9, 0.3, 0.2))
            system.burst(place)
            system.move()
        return world.render().linear.astype(float)


def traced(x: float, y: float, index: float) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Follow a camera's ray through the ball by the textbook; return where, how and how dim it leaves."""
    ray = np.array((x, y, -1.0)) / np.sqrt(x * x + y * y + 1)
    start = np.array((0, 0, 4.0))
    b = ray @ start
    point = start + ray * (-b - np.sqrt(b * b - start @ start + 0.25))

    def bent(along: Any, normal: Any, ratio: float) -> Any:
        cosine = -along @ normal
        return ratio * along + (ratio * cosine - np.sqrt(1 - ratio**2 * (1 - cosine**2))) * normal

    normal = point / 0.5
    least = ((index - 1) / (index + 1)) ** 2
    mirrors = least + (1 - least) * (1 + ray @ normal) ** 5
    within = bent(ray, normal, 1 / index)
    leaves = point - 2 * (within @ point) * within
    return leaves, bent(within, -leaves / 0.5, index), mirrors


def test_a_ball_of_glass_bends_rays_as_snell_says() -> None:
    plain = motes.Solid(shapes.Rectangle((-40, -40, -2), (80, 0, 0), (0, 80, 0)), (0.8, 0.6, 0.2), light=1)
    split = motes.Solid(
        shapes.Rectangle((0.13, -40, -1.99), (80, 0, 0), (0, 80, 0)), (0.1, 0.2, 0.9), light=1
    )
    dark: dict[str, Any] = {"sun": (0, 0, 0), "background": (0, 0, 0), "smooth": False}
    seen = picture(plain, split, motes.Solid(GLASS, glass=1.5), **dark)
    per = np.tan(np.radians(15)) / 45
    wrong = checked = 0
    for row in range(30, 60, 3):
        for column in range(45, 75):
            x, y = (column + 0.5 - 60) * per, (45 - row - 0.5) * per
            if np.hypot(x, y) > 0.1:
                continue
            leaves, along, _ = traced(x, y, 1.5)
            hit = leaves + along * ((-1.99 - leaves[2]) / along[2])
            if abs(hit[0] - 0.13) < 0.02:
                continue
            checked += 1
            wrong += (seen[row, column, 2] > seen[row, column, 0]) != (hit[0] > 0.13)
    assert checked > 150
    assert wrong == 0


def test_what_glass_lets_through_and_reflects_adds_up() -> None:
    """In a sky of one light, a clear ball hardly shows; a coloured one tints what is behind it."""
    sky = np.full((8, 16, 3), 0.5, np.float32)
    facts: dict[str, Any] = {"background": sky, "sun": (0, 0, 0)}
    np.testing.assert_allclose(picture(motes.Solid(GLASS, glass=1.5), **facts), 0.5, atol=0.002)
    seen = picture(motes.Solid(GLASS, (1, 0.5, 0.25), glass=1.5), **facts)
    _, _, mirrors = traced(0, 0, 1.5)
    np.testing.assert_allclose(
        seen[45, 60], 0.5 * (mirrors + (1 - mirrors) * np.array((1, 0.5, 0.25))), atol=0.003
    )


def test_a_mesh_of_glass_is_the_shape() -> None:
    ball = motes.Mesh(*globe(60, 120, 0.5), smooth=True)
    shape, mesh = (picture(BOARD, motes.Solid(one, glass=1.5)) for one in (GLASS, ball))
    assert np.abs(shape - mesh).mean() < 0.004
    assert np.abs(shape - picture(BOARD)).mean() > 0.012


def test_panes_do_not_bend_and_planes_do() -> None:
    pane = motes.Solid(shapes.Rectangle((-9, -9, 0), (18, 0, 0), (0, 18, 0)), glass=1.5)
    bare = picture(BOARD, sun=(0, 0, 0), smooth=False)
    seen = picture(BOARD, pane, sun=(0, 0, 0), smooth=False)
    mirrored = ((1.5 - 1) / (1.5 + 1)) ** 2
    around = 0.5 * (0.1 + 0.24 + 0.5 * 0.1)  # the light of an even background from the side
    np.testing.assert_allclose(seen[45], bare[45] * (1 - mirrored) + mirrored * around, atol=0.003)
    ground = motes.Solid(shapes.Plane((0, -1, 0), (0, 1, 0)), (1, 1, 1), image=CHECKS, scale=1)
    water = motes.Solid(shapes.Plane((0, -0.5, 0), (0, 1, 0)), glass=1.33)
    above: dict[str, Any] = {"camera": motes.Camera((0, 1.5, 4), (0, -0.5, 0), fov_deg=30)}
    assert np.abs(picture(ground, water, **above) - picture(ground, **above)).mean() > 0.03


def test_what_is_in_a_vessel_is_seen_in_it() -> None:
    """An opaque ball within glass is enlarged by it; glass within glass is not seen."""
    core = motes.Solid(shapes.Sphere((0, 0, 0), 0.2), (0.9, 0.1, 0.1))
    red = [
        int((one[..., 0] > 3 * one[..., 1]).sum())
        for one in (picture(core), picture(core, motes.Solid(GLASS, glass=1.5)))
    ]
    assert red[1] / red[0] == pytest.approx(1.5**2, rel=0.1)
    inner = motes.Solid(shapes.Sphere((0, 0, 0), 0.3), glass=2)
    outer = motes.Solid(GLASS, glass=1.5)
    assert (picture(BOARD, outer, inner) == picture(BOARD, outer)).all()


def test_a_hollow_vessel_hardly_bends() -> None:
    thin = motes.Solid(shapes.Cylinder((0, -3, 0), (0, 3, 0), 0.5, 0.49), glass=1.5)
    full = motes.Solid(shapes.Cylinder((0, -3, 0), (0, 3, 0), 0.5), glass=1.5)
    bare = picture(BOARD)
    apart = [np.abs(picture(BOARD, one) - bare)[:, 55:65].mean() for one in (thin, full)]
    assert apart[0] < 0.35 * apart[1]


def test_particles_in_and_behind_glass_are_seen() -> None:
    dot = motes.Sprite("disc", pixels=10, blend="opaque")
    layers: dict[str, Any] = {"sprite": dot, "smooth": False}
    for place in ((0, 0, 0), (0, 0, -1), (0, 0, 1)):
        seen = picture(motes.Solid(GLASS, glass=1.5), place=place, **layers)
        np.testing.assert_allclose(seen[45, 60], (0.9, 0.3, 0.2), atol=0.01)


def test_glass_casts_no_shadow_and_has_smooth_edges() -> None:
    floor = motes.Solid(shapes.Plane((0, -0.6, 0), (0, 1, 0)), (0.8, 0.8, 0.8))
    bare, seen = picture(floor), picture(floor, motes.Solid(GLASS, glass=1.5))
    assert (bare[:, :20] == seen[:, :20]).all()
    lit = motes.Solid(GLASS, (0.2, 0.2, 0.2), glass=1.5)
    facts: dict[str, Any] = {"background": (0.9, 0.9, 0.9), "sun": (0, 0, 0)}
    rough, smooth = (
        len(np.unique(picture(lit, smooth=on, **facts)[:, 60].round(4), axis=0)) for on in (False, True)
    )
    assert smooth > rough


def test_creases_of_glass_are_smooth() -> None:
    ends = (
        (-0.6, 0.6, 0),
        (-0.6, -0.1, 0.3),
        (-0.6, -0.6, 0),
        (0.6, 0.6, 0),
        (0.6, 0.1, 0.3),
        (0.6, -0.6, 0),
    )
    sides = [t for p, q in ((0, 1), (1, 2), (2, 0)) for t in ((p, q, q + 3), (p, q + 3, p + 3))]
    prism = motes.Solid(motes.Mesh(ends, [*sides, (0, 2, 1), (3, 4, 5)]), glass=1.5)
    facts: dict[str, Any] = {
        "background": motes.Gradient((0.9, 0.1, 0.1), (0.1, 0.2, 0.9), (0.1, 0.8, 0.1)),
        "sun": (0, 0, 0),
    }
    middle = (slice(30, 60), slice(45, 75))  # away from the outline
    fine = picture(prism, finer=8, **facts).reshape(90, 8, 120, 8, 3).mean((1, 3))[middle]
    rough, smooth = (np.abs(picture(prism, smooth=on, **facts)[middle] - fine) for on in (False, True))
    assert rough.max() > 0.02
    assert smooth.mean() < 0.5 * rough.mean()


def test_wrong_glass_is_refused() -> None:
    for given in (0, 0.9, 5, float("nan"), "clear", (1.5, 1.5)):
        with pytest.raises(ArgumentError, match="glass"):
            motes.Solid(GLASS, glass=given)  # type: ignore[arg-type]
    for facts in ({"roughness": 0.5}, {"metal": 1}, {"light": 1}, {"image": CHECKS}):
        with pytest.raises(ArgumentError, match=f"{next(iter(facts))} must be left out with `glass`"):
            motes.Solid(GLASS, glass=1.5, **facts)  # type: ignore[arg-type]
    assert motes.Solid(GLASS, glass=1.5).color == (1, 1, 1)
    assert motes.Solid(GLASS).color == (0.8, 0.8, 0.8)
