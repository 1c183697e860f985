"""Lit particles, their shadows, focus: double-precision references, and the same pixels everywhere."""

from __future__ import annotations

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes.errors import ArgumentError
from motes.shapes import Blob, Box, Plane

SUN, SKY, BOUNCE = 0.70, 0.24, 0.10  # fractions of daylight


def shown(renderer: motes.Renderer, *systems) -> np.ndarray:
    """Render systems given as (sprite, state, births)."""
    world = motes.World(seed=7, renderer=renderer, progress="off")
    made = [world.system(f"s{i}", sprite=sprite) for i, (sprite, _, _) in enumerate(systems)]
    with world:
        for s, (_, state, births) in zip(made, systems, strict=True):
            s.configure(**state)
            births(s)
        return world.render().linear.astype(float)


def burst(shape, count):
    return lambda s: s.burst(shape, count=count)


@pytest.mark.parametrize("lamp", [False, True])
def test_the_shadow_of_a_known_cloud_on_the_ground(lamp: bool):
    """The cloud has a normal distribution, so its column density is known."""
    count, sigma, wide, opacity, height = 300_000, 1.0, 0.03, 0.05, 6.0
    camera = motes.Camera((0, 40, 0), (0, 0, 0), up=(0, 0, -1), fov_deg=14)
    floor = [motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (1, 1, 1))]
    far = 1000.0
    sources = {
        "sun": (0, 0, 0) if lamp else (0, 1, 0),
        "lights": [motes.Light((0, far, 0), (1, 1, 1), SUN * far**2)] if lamp else [],
    }
    unseen = {"color": (0, 0, 0), "size": wide, "alpha": 0.5}  # black light adds nothing to the picture

    def picture(shadow: float, **lights) -> np.ndarray:
        renderer = motes.Renderer(
            160, 160, camera=camera, objects=floor, linear=True, fog=("black", 1e9), **lights
        )
        sprite = motes.Sprite("disc", None, shadow=shadow)
        return shown(renderer, (sprite, unseen, burst(Blob((0, height, 0), sigma), count)))[:, :, 0]

    dark, bright, shaded = picture(0, sun=(0, 0, 0)), picture(0, **sources), picture(2 * opacity, **sources)
    left = (shaded - dark) / (bright - dark)
    metres = 80 * np.tan(np.radians(7)) / 160
    x, z = np.meshgrid(*[(np.arange(160) - 79.5) * metres] * 2)
    radius = np.hypot(x, z)
    column = count / (2 * np.pi * sigma**2) * np.exp(-(radius**2) / (2 * sigma**2))
    expected = np.exp(-column * opacity * np.pi * wide**2 / 4)
    assert expected.min() < 0.25
    for low in np.arange(0, 4, 0.4):
        ring = (radius >= low) & (radius < low + 0.4)
        assert left[ring].mean() == pytest.approx(expected[ring].mean(), rel=0.02), low


def test_smoke_shades_what_is_in_it():
    """Probes in a uniform cloud get less sun the deeper they are."""
    count, wide, opacity = 400_000, 0.03, 0.1
    cloud = Box((-3, 0, -3), (3, 2, 3))
    dice = np.random.default_rng(1)
    found = []
    for depth in (0.0, 0.5, 1.0, 1.5, 2.0):
        places = np.stack(
            [dice.uniform(-2, 2, 400), np.full(400, 2 - depth), dice.uniform(-2, 2, 400)], axis=1
        )
        for shadow in (0.0, opacity):
            camera = motes.Camera((0, 30, 0.001), (0, 0, 0), fov_deg=16)
            renderer = motes.Renderer(200, 200, camera=camera, linear=True, sun=(0, 1, 0))
            probes = motes.Sprite("disc", 3, lit=True)
            smoke = motes.Sprite("disc", None, shadow=shadow)
            unseen = {"color": (0, 0, 0), "size": wide}
            picture = shown(
                renderer,
                (probes, {"alpha": 0.5}, lambda s, places=places: s.emit(position=places)),
                (smoke, unseen, burst(cloud, count)),
            )
            found.append((depth, shadow, picture.sum()))
    density = count / 72 * np.pi * wide**2 / 4 * opacity
    sky = BOUNCE + (SKY - BOUNCE) * (0.5 + 1 / 3)
    sun = SUN * 2 / 3
    for (depth, _, bright), (_, _, dark) in zip(found[::2], found[1::2], strict=True):
        expected = (sky + sun * np.exp(-density * depth)) / (sky + sun)
        assert dark / bright == pytest.approx(expected, rel=0.02), depth


@pytest.mark.parametrize("behind", [0, 60, 120, 180])
def test_discs_are_lit_as_small_spheres(behind: int):
    """Their light follows Lambert's law for a sphere, by the angle between the sun and the eye."""
    camera = motes.Camera((0, 0, 9), (0, 0, 0))
    angle = np.radians(behind)
    sun = (np.sin(angle), 0, np.cos(angle))
    plain, lit = (
        shown(
            motes.Renderer(32, 32, camera=camera, sun=sun, linear=True),
            (motes.Sprite("disc", 9, lit=flag), {"alpha": 0.5}, lambda s: s.emit(position=[(0, 0, 0)])),
        ).sum()
        for flag in (False, True)
    )
    phase = 2 / (3 * np.pi) * (np.sin(angle) + (np.pi - angle) * np.cos(angle))
    assert lit / plain == pytest.approx((BOUNCE + SKY) / 2 + SUN * phase, rel=0.02)


def test_lights_fall_off_with_the_square_of_the_distance():
    camera = motes.Camera((0, 0, 9), (0, 0, 0))

    def red(power: float, distance: float) -> float:
        lights = [motes.Light((0, 0, distance), (1, 0, 0), power)]
        renderer = motes.Renderer(32, 32, camera=camera, sun=(0, 0, 0), lights=lights, linear=True)
        one = (motes.Sprite("disc", 9, lit=True), {"alpha": 0.25}, lambda s: s.emit(position=[(0, 0, 0)]))
        picture = shown(renderer, one)
        return picture[:, :, 0].sum() - picture[:, :, 1].sum()

    assert red(4, 2) == pytest.approx(red(16, 4), rel=0.02)
    assert red(8, 2) == pytest.approx(2 * red(4, 2), rel=0.02)


# --- focus


@pytest.mark.parametrize("kind", ["point", "disc", "sphere", "image"])
@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
@pytest.mark.parametrize("shutter", [0, 0.5])
def test_blurred_sprites_keep_their_light(kind: str, blend: str, shutter: float):
    image = np.full((8, 8, 4), 255, np.uint8) if kind == "image" else None
    sprite = motes.Sprite(kind, 12 if kind != "point" else None, blend, image=image)
    light, spread = {}, {}
    for depth in (0.0, 3.0, -6.0):
        camera = motes.Camera((0, 0, 6), (0, 0, 0), focus=6, aperture=0.3)
        renderer = motes.Renderer(240, 240, camera=camera, linear=True, shutter=shutter)
        state = {"color": (0.6, 0.6, 0.6), "velocity": (3, 0, 0)}
        picture = shown(renderer, (sprite, state, lambda s, z=depth: s.emit(position=[(0, 0, z)])))[:, :, 0]
        light[depth] = picture.sum()
        spread[depth] = (picture > 0).sum()
    for depth in (3.0, -6.0):
        assert light[depth] == pytest.approx(light[0.0], rel=0.04)
        assert spread[depth] > 1.15 * spread[0.0]


def test_the_circle_of_confusion_is_that_of_a_thin_lens():
    aperture, focus, depth = 0.2, 5.0, 9.0
    camera = motes.Camera((0, 0, 0), (0, 0, -1), fov_deg=50, focus=focus, aperture=aperture)
    renderer = motes.Renderer(401, 401, camera=camera, linear=True)
    one = (motes.Sprite("point"), {}, lambda s: s.emit(position=[(0, 0, -depth)]))
    picture = shown(renderer, one)[:, :, 0]
    focal = 200.5 / np.tan(np.radians(25))
    expected = aperture * focal / focus * abs(1 - focus / depth)
    y, x = np.nonzero(picture)
    assert np.ptp(x) + 1 == pytest.approx(expected, abs=3)
    assert np.ptp(y) + 1 == pytest.approx(expected, abs=3)


def test_a_pinhole_is_what_it_was():
    camera = {"position": (0, 0, 6), "look_at": (0, 0, 0)}
    one = (motes.Sprite("disc", 7), {}, burst(Box((-1, -1, -1), (1, 1, 1)), 400))
    pictures = [
        shown(motes.Renderer(90, 90, camera=motes.Camera(**camera, **lens), linear=True), one)
        for lens in ({}, {"focus": 3}, {"aperture": 0, "focus": 6})
    ]
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])


@pytest.mark.parametrize(
    "lens", [{"focus": 0}, {"focus": -2}, {"focus": float("nan")}, {"aperture": -1}, {"aperture": 0.1}]
)
def test_wrong_lenses_are_refused(lens):
    with pytest.raises(ArgumentError):
        motes.Camera((0, 0, 1), (0, 0, 0), **lens)


@pytest.mark.parametrize("wrong", [{"shadow": -0.1}, {"shadow": 1.1}, {"shadow": "dark"}, {"lit": 1}])
def test_wrong_light_is_refused(wrong):
    with pytest.raises(ArgumentError):
        motes.Sprite("disc", **wrong)


# --- the same pixels everywhere

SCRIPT = """
import sys
import numpy as np
import motes
from motes.shapes import Box, Plane, Sphere

path, roles, threads = sys.argv[1:]
camera = motes.Camera((3, 3, 9), (0, 1, 0), focus=9, aperture=0.05)
solids = [motes.Solid(Plane((0, -1, 0), (0, 1, 0)), "tan"), motes.Solid(Sphere((-2, 0, 0), 0.8))]
world = motes.World(
    seed=3, space=(-3, 3), roles=roles, threads=int(threads), progress="off",
    renderer=motes.Renderer(200, 140, camera=camera, path=path, objects=solids, fog=("silver", 30),
        background=motes.Gradient("white", "steelblue", "#443"),
        lights=[motes.Light((2, 3, 2), "orange", 9, radius=0.4)], sun_size=5, shutter=0.6),
)
smoke = world.system("smoke", sprite=motes.Sprite("disc", None, "alpha", lit=True, shadow=0.4))
sparks = world.system("sparks", sprite=motes.Sprite("sphere", 7, "opaque", lit=True, shadow=1))
flap = motes.Mesh([(-1, -1, -1), (1, -1, -0.5), (0, 1, -1), (0, 0, 1.5)], [(0, 1, 2), (1, 3, 2)])
leaf = [[(200, 90, 30, 255), (90, 120, 30, 180)], [(120, 40, 20, 255), (0, 0, 0, 0)]]
sprites = [
    motes.Sprite("mesh", mesh=flap, blend="opaque", lit=True),
    motes.Sprite("image", image=np.array(leaf, np.uint8), blend="alpha", facing="orientation", lit=True),
    motes.Sprite("ribbon", width=0.1, length=0.5, blend="opaque"),
]
forms = [world.system(f"form {i}", sprite=sprite) for i, sprite in enumerate(sprites)]
with world:
    for frame in world.frames(3):
        smoke.configure(size=motes.Uniform(0.02, 0.6), alpha=0.3, velocity=motes.shapes.Sphere((0, 2, 0), 1))
        smoke.burst(Box((-2, 0, -1), (2, 2, 1)), count=3000)
        sparks.configure(velocity=motes.shapes.Sphere((0, 0, 0), 9))
        sparks.burst(Sphere((0, 1, 0), 2), count=200)
        for s in forms:
            s.configure(velocity=motes.shapes.Sphere((0, 0, 0), 4), size=motes.Uniform(0.05, 0.5))
            s.configure(orientation="random", spin=motes.Uniform((-40, -40, -40), (40, 40, 40)))
            s.burst(Box((-2, 0, -6), (2, 2, 4)), count=60)
        for s in (smoke, sparks, *forms):
            s.gravity((0, -1, 0))
            s.move()
        picture = world.render()
        if picture:
            print(picture.digest())
"""


def test_all_ranks_paths_roles_and_threads_give_the_same_pixels():
    cases = [
        (1, "gather", "auto", 1),
        (1, "tiles", "auto", 2),
        (2, "tiles", "auto", 1),
        (3, "gather", "auto", 1),
    ]
    cases += [(3, "tiles", "shared", 2), (3, "composite", "auto", 1), (5, "tiles", "auto", 1)]
    pictures = {tuple(on_ranks(n, SCRIPT, *how).lines) for n, *how in cases}
    assert len(pictures) == 1 and len(set(*pictures)) == 3
