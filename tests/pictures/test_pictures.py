"""The effect of a renderer's attributes on a picture."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from launching import mpirun
from standing import on_ranks

import motes
from motes import shapes
from motes.errors import ArgumentError

CAMERA = motes.Camera((0, 0, 5), (0, 0, 0))


def rendered(*, sprite: motes.Sprite | None = None, **attributes: Any) -> motes.Frame:
    """Render one particle in the middle of a picture."""
    renderer = motes.Renderer(**{"width": 96, "height": 64, "camera": CAMERA, "linear": True, **attributes})
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("a", sprite=sprite or motes.Sprite(pixels=9))
    with world:
        system.burst((0, 0, 0), count=1)
        return world.render()


# --- light

DIM = [((1, 1, 1), alpha) for alpha in (0.0005, 0.001, 0.002, 0.003, 0.006, 0.01, 0.03, 0.06, 0.07, 0.2)]
BRIGHT = [((9, 1.6, 0.2), 0.1), ((3, 0.9, 0.15), 0.2), ((40, 20, 10), 0.001), ((1.5, 1, 0.5), 0.6)]
DARK = [((0.002, 0.002, 0.002), 1), ((0.01, 0.005, 0), 0.5), ((0.5, 0.25, 0.1), 0.01)]


def light_of(color: Any, alpha: float, *, each: bool = False) -> np.ndarray:
    """Return a particle's light, as a fraction of a white one's; `each`: two colours in one system."""

    def sums(color: Any, alpha: float) -> np.ndarray:
        renderer = motes.Renderer(96, 64, camera=CAMERA, linear=True)
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("a", sprite=motes.Sprite(pixels=9))
        with world:
            places = [(0, 0, 0), (2, 0, 0)] if each else [(0, 0, 0)]
            system.emit(
                position=places, color=[color, (1, 1, 1)][: len(places)], alpha=[alpha, 1][: len(places)]
            )
            return world.render().linear[20:44, 36:60].sum(axis=(0, 1), dtype=float)

    none = sums((0, 0, 0), 0)
    return (sums(color, alpha) - none) / (sums((1, 1, 1), 1) - none)


@pytest.mark.parametrize("color, alpha", [*DIM, *BRIGHT, *DARK])
@pytest.mark.parametrize("each", [False, True])
def test_the_light_of_an_additive_particle_is_its_color_times_alpha(color, alpha, each):
    """This holds even in low light, where byte colours are coarse."""
    wanted = np.array(color) * alpha
    found = light_of(color, alpha, each=each)
    np.testing.assert_allclose(found, wanted, atol=0.03 * wanted.max() + 0.5 / 4064)


def test_light_of_one_particle_is_one_at_most():
    np.testing.assert_allclose(light_of((9, 1.6, 0.2), 0.5), (1, 0.8, 0.1), atol=0.005)


# --- bloom


def test_bloom_spreads_light_and_keeps_it():
    sharp, soft = rendered().linear, rendered(bloom=0.3).linear
    assert soft.sum() == pytest.approx(sharp.sum(), rel=1e-3)
    assert soft.max() < sharp.max()
    assert (soft > 0).sum() > 2 * (sharp > 0).sum()
    assert np.array_equal(soft, rendered(bloom=0.3).linear)


def test_pixels_with_bloom_are_the_same_whether_their_light_is_kept_or_not():
    assert rendered(bloom=0.3, linear=False).digest() == rendered(bloom=0.3).digest() != rendered().digest()


@pytest.mark.parametrize("bloom", [-0.1, 1.1, float("nan"), "much", None])
def test_bloom_is_a_part(bloom):
    with pytest.raises(ArgumentError, match="bloom must be a"):
        motes.Renderer(96, 64, camera=CAMERA, bloom=bloom)


def test_bloom_may_change_between_frames():
    renderer = motes.Renderer(96, 64, camera=CAMERA)
    renderer.bloom = 0.5
    with pytest.raises(ArgumentError, match="bloom"):
        renderer.bloom = 2
    assert renderer.bloom == 0.5


ON_RANKS = """
import json, sys
import motes
from motes import shapes

path, linear = sys.argv[1:]
renderer = motes.Renderer(
    320, 180, camera=motes.Camera((0, 0, 11), (0, 0, 0)), path=path, linear=linear == "True", bloom=0.3,
    objects=[shapes.Sphere((1, 0, 0), 1)],
)
world = motes.World(seed=3, space=(-8, 8), roles="shared", renderer=renderer, progress="off")
dust = world.system("dust")
with world:
    for _ in world.frames(2):
        dust.configure(color=(0.2, 0.5, 1), alpha=0.3)
        dust.burst(shapes.Box((-8, -4, -1), (8, 4, 1)), count=20_000)
        picture = world.render()
        if picture:
            print(json.dumps([picture.digest(), float(picture.linear.sum()) if renderer.linear else None]))
"""


@pytest.mark.parametrize("linear", [False, True])
def test_bloom_is_the_same_on_all_paths(linear: bool):
    alone = on_ranks(1, ON_RANKS, "gather", linear).lines
    assert len(set(alone)) == 2
    for path in ("gather", "tiles", "composite"):
        assert on_ranks(3, ON_RANKS, path, linear).lines == alone


# --- objects and what lights them

MESH = motes.Mesh([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [(0, 1, 2)])
RED = (1, 0, 0)


def brightness(**attributes: Any) -> np.ndarray:
    """Return the mean light of a picture without particles, by colour."""
    return rendered(sprite=motes.Sprite("point"), **attributes).linear.reshape(-1, 3).mean(axis=0)


def test_a_mesh_is_drawn_like_the_triangle_that_it_is():
    triangle = motes.shapes.Triangle(*MESH.vertices)
    assert rendered(objects=[MESH]).digest() == rendered(objects=[motes.Solid(MESH)]).digest()
    difference = rendered(objects=[MESH]).linear - rendered(objects=[triangle]).linear
    assert np.abs(difference).mean() < 1e-3
    assert rendered(objects=[MESH]).digest() != rendered().digest()


def test_lights_light_and_solids_shine():
    night = {"objects": [MESH], "sun": (0, 0, 0)}
    dark = brightness(**night)
    lit = brightness(**night, lights=[motes.Light((0, 0, 2), RED, power=3)])
    assert lit[0] > dark[0] + 0.02
    assert lit[1] == pytest.approx(dark[1])
    assert (brightness(objects=[motes.Solid(MESH, light=2)], sun=(0, 0, 0)) > dark + 0.02).all()
    assert (brightness(objects=[MESH], sun=(0, 0, 1)) > dark + 0.02).all()


def test_smooth_edges_have_colours_in_between():
    few, many = (rendered(objects=[MESH], smooth=smooth).pixels for smooth in (False, True))
    assert len(np.unique(many.reshape(-1, 3), axis=0)) > len(np.unique(few.reshape(-1, 3), axis=0))


def test_lights_and_sun_may_change_between_frames():
    renderer = motes.Renderer(96, 64, camera=CAMERA, objects=[MESH])
    world = motes.World(seed=1, renderer=renderer, progress="off")
    with world:
        first = world.render()
        renderer.lights = [motes.Light((0, 0, 2))]
        second = world.render()
        renderer.sun = (0, 0, 0)
        third = world.render()
    assert len({frame.digest() for frame in (first, second, third)}) == 3


# --- sprites, and layers

ALL_SPRITES = """
import hashlib, json, sys
import numpy as np
import motes
from motes import shapes

path, roles = sys.argv[1:]
renderer = motes.Renderer(
    320, 180, camera=motes.Camera((0, 0, 11), (0, 0, 0)), path=path, linear=True, bloom=0.2, shutter=0.5,
    layers=["depth", "alpha", "velocity"], objects=[shapes.Sphere((1, 0, 0), 1)],
)
world = motes.World(seed=3, space=(-8, 8), roles=roles, renderer=renderer, progress="off")
leaf = np.random.default_rng(1).integers(0, 255, (9, 7, 4), dtype=np.uint8)
sprites = [motes.Sprite("point"), motes.Sprite("disc", 7, "alpha", softness=0.3)]
for blend in ("add", "alpha", "opaque"):
    sprites.append(motes.Sprite("sphere", pixels=None, blend=blend))
    sprites.append(motes.Sprite("image", height=0.05, blend=blend, image=leaf))
systems = [world.system(f"s{i}", sprite=sprite) for i, sprite in enumerate(sprites)]
with world:
    for _ in world.frames(2):
        for system in systems:
            system.configure(color=(0.2, 0.5, 1), alpha=0.3, size=0.3, velocity=shapes.Sphere((0, 0, 0), 8))
            system.burst(shapes.Box((-8, -4, -1), (8, 4, 1)), count=150)
            system.move()
        picture = world.render()
        if picture:
            layers = [hashlib.sha256(picture.layer(name).tobytes()).hexdigest() for name in renderer.layers]
            print(json.dumps([picture.digest(), *layers]))
"""


def test_pictures_and_layers_are_the_same_on_all_paths_and_ranks():
    alone = on_ranks(1, ALL_SPRITES, "gather", "auto").lines
    assert len(set(alone)) == 2
    for path in ("gather", "tiles", "composite"):
        assert on_ranks(2, ALL_SPRITES, path, "shared").lines == alone
        assert on_ranks(3, ALL_SPRITES, path, "auto").lines == alone


def balls(**attributes: Any) -> motes.Frame:
    """Render a 1 m ball, 2 m in front of the centre, moving right, with smoke in front of everything."""
    renderer = motes.Renderer(96, 64, camera=CAMERA, layers=["depth", "alpha", "velocity"], **attributes)
    world = motes.World(seed=1, renderer=renderer, progress="off", dt=1e-6)
    ball = world.system("ball", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
    smoke = world.system("smoke", sprite=motes.Sprite(pixels=None, blend="alpha"))
    with world:
        ball.configure(size=1, velocity=(3, 0, 0))
        ball.burst((0, 0, 2))
        ball.move()
        smoke.configure(size=0.5, alpha=0.5)
        smoke.burst((0.9, 0, 2.5))
        return world.render()


def test_layers_hold_metres_parts_and_metres_per_second():
    frame = balls()
    depth, alpha, velocity = (frame.layer(name) for name in ("depth", "alpha", "velocity"))
    middle = (32, 48)
    assert depth[middle] == pytest.approx(2.5, abs=0.01)  # 5 m away, less 2 m and the radius
    assert np.isinf(depth[0, 0])
    assert np.isinf(depth).mean() == pytest.approx((velocity == 0).all(axis=2).mean())
    assert velocity[middle].tolist() == [3, 0, 0]
    assert velocity[0, 0].tolist() == [0, 0, 0]
    assert (alpha[middle], alpha[0, 0]) == (1, 0)
    assert alpha[np.isinf(depth)].max() == pytest.approx(0.5, abs=0.05)  # the alpha of the smoke
    pixels_per_metre = 0.5 * 64 / np.tan(np.radians(20))
    assert (~np.isinf(depth)).sum() == pytest.approx(np.pi * (0.5 * pixels_per_metre / 3) ** 2, rel=0.1)


def test_the_velocity_of_equals_does_not_depend_on_their_order():
    """It does not depend on the sign of a zero either."""

    def layer(velocities: Any) -> bytes:
        renderer = motes.Renderer(32, 32, camera=CAMERA, layers=["velocity"])
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("a", sprite=motes.Sprite(pixels=9, blend="opaque"))
        with world:
            system.emit(position=[(0, 0, 0)] * 2, velocity=velocities)
            return world.render().layer("velocity").tobytes()

    velocities = [(0.0, 1, 0), (-0.0, 1, 0)]
    assert layer(velocities) == layer(velocities[::-1])


def test_the_depth_of_solids_is_that_of_their_surfaces():
    """The small offset that hiding particles uses does not show in the depth."""
    wall, ball = shapes.Rectangle((-9, -9, -2), (18, 0, 0), (0, 18, 0)), shapes.Sphere((0, 0, 0), 1)
    depth = rendered(objects=[wall, ball, shapes.Plane((0, -2, 0), (0, 1, 0))], layers=["depth"]).layer(
        "depth"
    )
    y, x = (np.indices((64, 96)) + 0.5).astype(float)
    up, right = (32 - y) * np.tan(np.radians(20)) / 32, (x - 48) * np.tan(np.radians(20)) / 32
    to_ball = up**2 + right**2 < 1 / 24.5  # for a ray (right, up, -1) from 5 m away
    a, b = 1 + up**2 + right**2, 5
    exact = np.where(to_ball, (b - np.sqrt(np.maximum(b * b - 24 * a, 0))) / a, 7)
    ground = np.where(up < 0, -2 / np.minimum(up, -1e-9), np.inf)
    exact = np.minimum(exact, np.where(to_ball, exact, ground))
    sure = np.abs(up**2 + right**2 - 1 / 24) > 2e-3  # away from the ball's edge
    np.testing.assert_allclose(depth[sure], exact[sure], rtol=1e-4)


def test_a_layer_that_was_not_asked_for_is_refused():
    with pytest.raises(ArgumentError, match="it has none"):
        rendered().layer("depth")
    with pytest.raises(ArgumentError, match="'depth', got 'alpha'"):
        rendered(layers=["depth"]).layer("alpha")


def test_layers_stay_with_their_frame():
    renderer = motes.Renderer(96, 64, camera=CAMERA, layers=["depth"])
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("a", sprite=motes.Sprite(pixels=9, blend="opaque"))
    with world:
        system.burst((0, 0, 0))
        first = world.render()
        system.kill_old(-1)
        second = world.render()
        assert first.layer("depth").min() == pytest.approx(5)
        assert np.isinf(second.layer("depth").min())


def test_all_layers_are_in_an_exr(tmp_path):
    library = pytest.importorskip("OpenEXR")
    frame = balls(linear=True)
    frame.save(tmp_path / "a.exr")
    with library.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        read = {name: channel.pixels for name, channel in file.channels().items()}
    assert np.array_equal(read["depth.Z"], frame.layer("depth"))
    assert read["velocity.X"].max() == 3


def test_a_sprite_with_an_image_shows_it():
    image = np.zeros((8, 8, 4), np.uint8)
    image[:4] = (255, 0, 0, 255)
    image[4:] = (0, 0, 255, 255)
    sprite = motes.Sprite("image", pixels=40, blend="opaque", image=image)
    pixels = rendered(sprite=sprite).pixels
    assert pixels[22, 48, 0] > 200 > 50 > pixels[22, 48, 2]
    assert pixels[42, 48, 2] > 200 > 50 > pixels[42, 48, 0]


def test_sizes_in_metres_and_in_parts_of_the_height():
    metre = 0.5 * 64 / np.tan(np.radians(20)) / 5  # pixels at 5 m
    for sprite, size in (
        (motes.Sprite(pixels=None, blend="opaque"), metre),
        (motes.Sprite(height=0.5, blend="opaque"), 32),
    ):
        drawn = rendered(sprite=sprite).linear[:, :, 0] > 0
        assert drawn.any(axis=0).sum() == pytest.approx(size, abs=1)


def test_a_streak_keeps_the_light_of_what_stands_still():
    def streak(shutter: float) -> np.ndarray:
        renderer = motes.Renderer(96, 64, camera=CAMERA, linear=True, shutter=shutter)
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("a", sprite=motes.Sprite(pixels=5))
        with world:
            system.configure(velocity=(10, 0, 0))
            system.burst((0, 0, 0))
            system.move()
            return world.render().linear

    still, moved = streak(0), streak(1)
    assert moved.sum() == pytest.approx(still.sum(), rel=0.01)
    assert (moved > 0).any(axis=(0, 2)).sum() > 2 * (still > 0).any(axis=(0, 2)).sum()


LARGE = """
import resource
import motes

camera = motes.Camera((0, 0, 5), (0, 0, 0))
renderer = motes.Renderer(16384, 16384, camera=camera, bloom=0.1)
world = motes.World(seed=1, progress="off", renderer=renderer)
with world:
    world.step()
    resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
    world.render()
"""


def test_a_picture_larger_than_memory_says_so():
    job = subprocess.run([sys.executable, "-c", LARGE], capture_output=True, text=True, timeout=60)
    assert "MemoryError: a picture of 16384x16384 pixels" in job.stderr
    assert "does not fit into the memory" in job.stderr


LARGE_PART = """
import resource
import motes
from motes import shapes

camera = motes.Camera((0, 0, 5), (0, 0, 0))
ground = shapes.Plane((0, -1, 0), (0, 1, 0))
renderer = motes.Renderer(6144, 6144, camera=camera, path="tiles", objects=[ground])
world = motes.World(seed=1, progress="off", roles="shared", renderer=renderer)
with world:
    world.step()
    if world.rank == 1:
        with open("/proc/self/statm") as file:
            here = int(file.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (here + (64 << 20), resource.RLIM_INFINITY))
    world.render()
"""


def test_a_part_of_a_picture_larger_than_memory_says_so():
    """The image generator has memory for the whole picture, but another rank has none for its tiles."""
    job = mpirun(2, LARGE_PART, timeout=100)
    assert job.code != 0, job.text
    assert "rank 1" in job.err, job.text
    assert "a picture of 6144x6144 pixels" in job.err, job.text


@pytest.mark.parametrize("kind", ["disc", "point", "image"])
@pytest.mark.parametrize("shutter", [0, 0.5])
def test_white_particles_have_velocities_too(kind: str, shutter: float):
    renderer = motes.Renderer(64, 48, camera=CAMERA, layers=["depth", "velocity"], shutter=shutter)
    world = motes.World(seed=1, renderer=renderer, progress="off", dt=1e-6)
    shown = {
        "image": {"image": np.full((9, 9, 4), 255, dtype=np.uint8), "height": 0.2},
        "disc": {"pixels": 9},
    }
    white = world.system("white", sprite=motes.Sprite(kind, blend="opaque", **shown.get(kind, {})))
    with world:
        white.configure(velocity=(3, 0, 0))
        white.burst((0, 0, 0))
        white.move()
        frame = world.render()
    seen = np.isfinite(frame.layer("depth"))
    assert seen.any()
    assert (frame.layer("velocity")[seen] == (3, 0, 0)).all()
