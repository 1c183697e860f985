"""Shadows with edges, of opaque particles, against ray tracing; and what is dark where things touch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from same_bits import on_all_paths

import motes
from motes.shapes import Plane, Sphere

Light = NDArray[np.float64]
GROUND = motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (0.8, 0.8, 0.8))
LEAF = motes.Mesh([(0, 0, 0), (0.25, 0.1, 0.4), (0, 0, 0.9), (-0.25, 0.1, 0.4)], [(0, 1, 2), (0, 2, 3)])
ABOVE = motes.Camera((0, 2.2, 0.01), (0, 0, 0), fov_deg=60, up=(0, 0, -1))
HOLED = np.full((16, 16, 4), 255, np.uint8)
HOLED[4:12, 4:12, 3] = 0
LIGHTS: dict[str, dict[str, Any]] = {
    "sun": {"sun": (1, 1.5, 0.4)},
    "wide sun": {"sun": (1, 1.5, 0.4), "sun_size": 4},
    "lamp": {"sun": (0, 0, 0), "lights": [motes.Light((1.5, 5, 1), (1, 1, 1), 30)]},
    "wide lamp": {"sun": (0, 0, 0), "lights": [motes.Light((1.5, 5, 1), (1, 1, 1), 30, radius=0.15)]},
    "cone": {"sun": (0, 0, 0), "lights": [motes.Light((0, 5, 1), power=30, spot=((0, -1, -0.2), 60))]},
}


def shot(
    sprite: motes.Sprite | None,
    objects: tuple[motes.Solid, ...] = (),
    camera: motes.Camera = ABOVE,
    pixels: tuple[int, int] = (480, 360),
    light: dict[str, Any] | None = None,
    **state: Any,
) -> Light:
    """Return the light of a picture of the ground, solids and particles."""
    facts: dict[str, Any] = {"camera": camera, "linear": True, "objects": [GROUND, *objects], **(light or {})}
    world = motes.World(seed=1, progress="off", renderer=motes.Renderer(*pixels, **facts))
    system = world.system("one", sprite=sprite)
    with world:
        if sprite is not None:
            system.emit(**state)
        return np.asarray(world.render().linear[..., 1], float)


def opaque(kind: Any, **facts: Any) -> motes.Sprite:
    return motes.Sprite(kind, **{"pixels": None, "blend": "opaque", "lit": True, "shadow": 1.0} | facts)


def places(count: int, light: dict[str, Any]) -> Light:
    """Return places 2.5 m above the ground, behind the camera, whose shadows are in the picture."""
    base = np.random.default_rng(2).uniform(-0.7, 0.7, (count, 2)) if count > 1 else np.zeros((1, 2))
    high = np.full(count, 2.5)
    if "lights" not in light:
        return np.stack([base[:, 0] + 2.5 / 1.5, high, base[:, 1] + 1 / 1.5], axis=1)
    lamp = np.array(light["lights"][0].position)[[0, 2]]
    return np.stack([(base + lamp)[:, 0] / 2, high, (base + lamp)[:, 1] / 2], axis=1)


@pytest.mark.parametrize("count", [1, 2, 10])
@pytest.mark.parametrize("name", LIGHTS)
@pytest.mark.parametrize("kind", ["sphere", "disc", "mesh"])
def test_a_shadow_is_that_of_ray_tracing(kind: str, name: str, count: int) -> None:
    light = LIGHTS[name]
    at = places(count, light)
    sprite = opaque("mesh", mesh=LEAF) if kind == "mesh" else opaque(kind)
    solids = [motes.Solid(LEAF.at(p) if kind == "mesh" else Sphere(p, 0.25)) for p in at.tolist()]
    size = np.tile((1.0 if kind == "mesh" else 0.5, 1, 1), (count, 1))
    bare = shot(None, light=light)
    with pytest.warns(motes.MotesWarning, match="behind the camera"):
        seen = shot(sprite, light=light, position=at, size=size)
    traced = shot(None, tuple(solids), light=light)
    area = (bare - traced).sum()
    assert (bare - seen).sum() == pytest.approx(area, rel=0.02)
    soft = "wide" in name
    assert np.abs(seen - traced).sum() < (0.06 if soft else 0.02) * area


@pytest.mark.parametrize("name", ["sun", "lamp"])
def test_a_leaf_and_its_shadow_touch(name: str) -> None:
    """A leaf that stands on the ground, seen edge-on from above, leaves all of its shadow in view."""
    light = LIGHTS[name]
    leaf = motes.Mesh([(0, 0, 0), (0.3, 0.4, 0), (0, 0.9, 0), (-0.3, 0.4, 0)], [(0, 1, 2), (0, 2, 3)])
    camera = motes.Camera((0, 4, 0), (0, 0, 0), fov_deg=30, up=(0, 0, -1))
    bare, traced = (
        shot(None, camera=camera, light=light),
        shot(None, (motes.Solid(leaf),), camera, light=light),
    )
    seen = shot(opaque("mesh", mesh=leaf), camera=camera, light=light, position=[(0, 0, 0)])
    dark = bare - traced > 0.5 * (bare - traced).max()
    rows, columns = np.nonzero(dark)
    near = np.hypot(rows - 179.5, columns - 239.5) < 25
    assert near.sum() > 50
    assert ((bare - seen)[rows[near], columns[near]] > 0.3 * (bare - traced).max()).mean() > 0.9
    assert (bare - seen).sum() == pytest.approx((bare - traced).sum(), rel=0.03)


def test_light_falls_through_the_holes_of_a_card() -> None:
    flat = [(-(0.5**0.5), 0, 0, 0.5**0.5)]
    facts: dict[str, Any] = {"light": LIGHTS["sun"], "orientation": flat, "size": [(0.8, 1, 1)]}
    at = places(1, LIGHTS["sun"])
    full = np.full((16, 16, 4), 255, np.uint8)
    bare = shot(None, light=LIGHTS["sun"])
    with pytest.warns(motes.MotesWarning, match="behind the camera"):
        whole, holed = (
            (bare - shot(opaque("image", image=image, facing="orientation"), position=at, **facts)).sum()
            for image in (full, HOLED)
        )
    assert holed == pytest.approx(0.75 * whole, rel=0.02)


def test_one_particle_leaves_and_no_other_pixel_changes() -> None:
    rng = np.random.default_rng(4)
    at = np.c_[rng.uniform(-0.8, 0.8, 60), rng.uniform(0.05, 0.5, 60), rng.uniform(-0.6, 0.6, 60)]
    at[0] = (0.6, 0.05, 0.4)
    far = np.concatenate([at, [(900.0, 5, -3000)]])
    for name in ("sun", "lamp", "wide lamp"):
        light = LIGHTS[name]
        pictures = [
            shot(opaque("sphere"), light=light, position=p, size=np.tile((0.1, 1, 1), (len(p), 1)))
            for p in (at, far, at[1:])
        ]
        np.testing.assert_array_equal(pictures[0], pictures[1])
        rows, columns = np.nonzero(pictures[0] != pictures[2])
        assert len(rows) > 50
        assert np.ptp(rows) < 90
        assert np.ptp(columns) < 90


@pytest.mark.parametrize("name", ["sun", "lamp", "wide lamp"])
@pytest.mark.parametrize("kind", ["sphere", "mesh", "image", "disc"])
def test_a_particle_does_not_shade_itself(kind: str, name: str) -> None:
    facts: dict[str, Any] = {"mesh": {"mesh": LEAF}, "image": {"image": HOLED, "facing": "orientation"}}.get(
        kind, {}
    )
    camera = motes.Camera((0, 2, 3), (0, 2, 0))
    state: dict[str, Any] = {
        "position": [(0, 2, 0)],
        "orientation": [(0.5, 0.2, 0, 0.8)],
        "size": [(0.8, 1, 1)],
    }
    with_shadow, without = (
        shot(opaque(kind, shadow=shadow, **facts), camera=camera, light=LIGHTS[name], **state)[:200]
        for shadow in (1.0, 0.0)
    )
    np.testing.assert_array_equal(with_shadow, without)


def test_particles_shade_particles() -> None:
    state: dict[str, Any] = {"position": [(0, 1, 0), (0, 2, 0)], "size": [(0.5, 1, 1), (1, 1, 1)]}
    camera = motes.Camera((0, 1, 3), (0, 1, 0))
    light: dict[str, Any] = {"sun": (0, 1, 0)}
    free, shaded = (shot(opaque("sphere", shadow=s), camera=camera, light=light, **state) for s in (0, 1.0))
    assert shaded[150:170, 230:250].mean() < 0.6 * free[150:170, 230:250].mean()


EVERYWHERE = """
import sys
import numpy as np
import motes
from motes.shapes import Box, Plane

leaf = (np.arange(9 * 7 * 4).reshape(9, 7, 4) * 37 % 256).astype(np.uint8)
quad = motes.Mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2), (0, 2, 3)])
path, roles = sys.argv[1:]
renderer = motes.Renderer(
    230, 150, camera=motes.Camera((0, 2, 7), (0, 0, 0)), path=path, sun_size=3, occlusion=0.8,
    lights=[motes.Light((1, 2, 1), power=4), motes.Light((-2, 3, 0), power=4, radius=0.2)],
    objects=[motes.Solid(Plane((0, -1.2, 0), (0, 1, 0)), (0.4, 0.5, 0.3))],
)
world = motes.World(seed=4, roles=roles, renderer=renderer, progress="off")
looks = [
    ("sphere", {"pixels": None}), ("mesh", {"mesh": quad}), ("disc", {"pixels": 9}),
    ("image", {"image": leaf, "pixels": None, "facing": "orientation"}),
    ("image", {"image": leaf, "pixels": None, "facing": "velocity"}),
    ("disc", {"pixels": None, "blend": "alpha", "shadow": 0.5}),
]
systems = [
    world.system(f"s{n}", sprite=motes.Sprite(kind, **{"blend": "opaque", "shadow": 1, "lit": True} | facts))
    for n, (kind, facts) in enumerate(looks)
]
with world:
    for frame in world.frames(3):
        for system in systems:
            system.configure(velocity=motes.Normal((0, 0, 0), (3, 3, 3)), size=0.2)
            system.configure(orientation="random")
            system.burst(Box((-2, -1, -2), (2, 1, 2)), count=40)
            system.move()
        picture = world.render()
        if picture:
            print(picture.digest())
"""


def test_sharp_shadows_are_the_same_on_all_ranks_and_paths() -> None:
    assert len(set(on_all_paths(EVERYWHERE))) == 3


@pytest.mark.parametrize("ball", ["solid", "particle"])
def test_occlusion_darkens_the_ground_at_contact_only(ball: str) -> None:
    light: dict[str, Any] = {"sun": (0, 0, 0), "background": (0.5, 0.5, 0.5)}
    camera = motes.Camera((0, 4, 6), (0, 0, 0), fov_deg=40)

    def picture(occlusion: float, sprite: motes.Sprite | None) -> Light:
        objects = (motes.Solid(Sphere((0, 0.4, 0), 0.4)),) if ball == "solid" else ()
        state: dict[str, Any] = {"position": [(0, 0.4, 0)], "size": [(0.8, 1, 1)]} if sprite else {}
        facts = light | {"occlusion": occlusion}
        return shot(sprite, objects, camera, light=facts, **state)

    sprite = opaque("sphere", shadow=0.0) if ball == "particle" else None
    bright, dark = picture(0, sprite), picture(1, sprite)
    half = picture(0.5, sprite)
    left = (dark / bright)[:, 240]
    assert left[190:200].min() < 0.92  # 0.2 to 0.5 m from where they touch
    assert left[280:] == pytest.approx(1, abs=0.02)
    assert (dark / bright)[300, 20] == pytest.approx(1, abs=0.02)
    ground = slice(190, 360)
    assert (bright - half)[ground] == pytest.approx(0.5 * (bright - dark)[ground], abs=0.01)


@pytest.mark.parametrize("wrong", [-0.1, 1.1, float("nan"), "much", (1, 1)])
def test_wrong_occlusion_is_refused(wrong: Any) -> None:
    with pytest.raises(motes.errors.ArgumentError, match="occlusion"):
        motes.Renderer(10, 10, camera=ABOVE, occlusion=wrong)
