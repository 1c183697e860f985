"""Make the pictures of docs/pictures.md: `python docs/scripts/make_pictures.py [NAMES]`.

Each is a small scene that shows one thing. A test makes them again and compares all pixels: they are the same
on every machine.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import motes
from motes.shapes import Box, Cylinder, Plane, Sphere

FOLDER = Path(__file__).resolve().parents[1] / "pictures"
SIZE = (240, 150)
KINDS = ("point", "disc", "sphere", "image")
BLENDS = ("add", "alpha", "opaque")

GROUND = motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (0.10, 0.11, 0.13))
PILLAR = motes.Solid(Cylinder((0, 0, 0), (0, 2, 0), 0.22), (0.35, 0.33, 0.3))
CAMERA = motes.Camera((0, 1.15, 5.2), (0, 0.85, 0), fov_deg=27)
SKY = (0.10, 0.15, 0.24)


def leaf(pixels: int = 96) -> NDArray[np.uint8]:
    """Draw a leaf with its veins, as RGBA."""
    y, x = np.mgrid[-1 : 1 : pixels * 1j, -1 : 1 : pixels * 1j]
    along = (y + 1) / 2  # 0 at the tip
    half = 0.62 * np.sin(np.pi * along**0.8) ** 1.2
    inside = (np.abs(x) < half) & (along < 0.93) | (np.abs(x) < 0.035) & (along >= 0.9)
    veins = (np.abs(x) < 0.03) | (np.abs((along - 0.45 * np.abs(x)) * 9 % 1 - 0.5) > 0.44)
    shade = (1 - 0.35 * np.minimum(np.abs(x) / np.maximum(half, 0.03), 1)) * np.where(veins, 0.72, 1)
    color = np.stack([shade, shade * 0.96, shade * 0.9, inside], axis=2)
    return (color * 255 + 0.5).astype(np.uint8)


def picture(
    sprite: motes.Sprite, fill: Callable[[motes.System], None], *, frames: int = 1, **attributes: Any
) -> motes.Frame:
    """Run one system for some frames, and render the last one."""
    attributes = {"camera": CAMERA, "background": SKY, "objects": [GROUND, PILLAR], **attributes}
    world = motes.World(seed=11, progress="off", renderer=motes.Renderer(*SIZE, **attributes))
    system = world.system("particles", sprite=sprite)
    with world:
        for _ in range(frames - 1):
            fill(system)
            world.step()
        fill(system)
        return world.render()


def cloud(count: int, alpha: float, size: Any) -> Callable[[motes.System], None]:
    """Emit particles of three colours around the pillar, each as wide as `size`, m."""

    def fill(system: motes.System) -> None:
        system.configure(up=Sphere((0, 0, 0), 1), size=size, alpha=alpha)
        for color in ((0.9, 0.22, 0.08), (0.95, 0.62, 0.12), (0.2, 0.42, 0.75)):
            system.configure(color=color)
            system.burst(Box((-1.5, 0.25, -0.9), (1.5, 1.6, 0.9)), count=count // 3)

    return fill


def of_kind(kind: str, blend: str) -> motes.Frame:
    """Render a cloud of particles of this kind and blend."""
    if kind == "point":
        return picture(motes.Sprite("point", blend=blend), cloud(9000, 0.8, 1))
    image = leaf() if kind == "image" else None
    sprite = motes.Sprite(kind, pixels=None, blend=blend, image=image)
    return picture(sprite, cloud(90, 1 if blend == "opaque" else 0.75, 0.34))


def near_and_far(sprite: motes.Sprite) -> motes.Frame:
    """Render balls of 20 cm in two rows that lead away from the camera."""

    def fill(system: motes.System) -> None:
        system.configure(size=0.2, color=(0.9, 0.5, 0.15))
        for step in range(14):
            for x in (-0.5, 0.5):
                system.burst((x, 0.1, 3 - 1.1 * step))

    return picture(sprite, fill, objects=[GROUND])


def mist(softness: float) -> motes.Frame:
    """Render large puffs that touch the ground and the pillar."""

    def fill(system: motes.System) -> None:
        system.configure(size=0.9, color=(0.75, 0.8, 0.85), alpha=0.22)
        system.burst(Box((-1.5, 0, -0.8), (1.5, 0.3, 0.8)), count=70)

    return picture(motes.Sprite(pixels=None, blend="alpha", softness=softness), fill)


def sparks(**attributes: Any) -> motes.Frame:
    """Render sparks that fly apart in the dark."""

    def fill(system: motes.System) -> None:
        system.configure(velocity=Sphere((0, 2.2, 0), 2.6), color=(1, 0.5, 0.14), alpha=1, size=0.04)
        system.source(Sphere((0, 0.7, 0), 0.05), rate=900, jitter=True)
        system.gravity((0, -6, 0))
        system.move()

    dark = {"background": (0.004, 0.005, 0.01), "objects": [], "exposure": 4}
    return picture(motes.Sprite(pixels=None), fill, frames=8, **(dark | attributes))


def lamps(*, smooth: bool = True, lit: bool = True, only: bool = False) -> motes.Frame:
    """Render spheres, a lamp, and a mesh, in moonlight."""
    corners = [(0, 0.9, 0), (0.35, 0, 0.35), (0.35, 0, -0.35), (-0.35, 0, -0.35), (-0.35, 0, 0.35)]
    faces = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1)]
    pyramid = motes.Mesh(np.array(corners) + (0.75, 0, 0.1), faces)
    balls = [Sphere((-0.9, 0.35, 0.2), 0.35), Sphere((-0.2, 0.2, -0.6), 0.2)]
    bulb = motes.Solid(Sphere((0, 0.75, 0.3), 0.06), (1, 0.6, 0.25), light=6)
    light = motes.Light((0, 0.75, 0.3), (1, 0.6, 0.25), power=0.5)
    return picture(
        motes.Sprite(),
        lambda _: None,
        objects=[GROUND, *balls, pyramid, *([bulb] if lit else [])],
        lights=[light] if lit else [],
        background=(0.015, 0.02, 0.035),
        exposure=0.6,
        smooth=smooth,
        bloom=0.1 if lit else 0,
    )


def finish(kind: str) -> motes.Frame:
    """Render brass, wet stones, paper or glass under a cloudy sky."""
    dice = np.random.default_rng(4)
    sky = np.zeros((64, 128, 3), np.float32)
    height = np.linspace(1, -1, 64)[:, None, None]
    sky[:] = np.where(height > 0, (0.75, 0.82, 0.95) - height * (0.5, 0.45, 0.35), (0.2, 0.18, 0.16))
    for _ in range(40):
        x, y = dice.integers(0, 120), dice.integers(4, 28)
        sky[y : y + 2, x : x + dice.integers(4, 20)] += 0.35
    ground = motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (0.24, 0.22, 0.2))
    facts: dict[str, Any] = {"background": sky, "sun": (-0.7, 0.8, 0.5), "objects": [ground]}

    def place(system: motes.System) -> None:
        if kind == "stones":
            greys = motes.Uniform(0.06, 0.2)
            system.configure(size=motes.Uniform(0.25, 0.55), color=greys, orientation="random")
            system.burst(Box((-1.7, 0.1, -1.2), (1.7, 0.16, 1.5)), count=70)
        if kind == "paper":
            tints = motes.Uniform((0.5, 0.45, 0.3), (0.9, 0.85, 0.8))
            system.configure(size=0.42, color=tints, orientation="random")
            system.burst(Box((-1.6, 0.2, -0.8), (1.6, 1.7, 0.8)), count=60)

    sprite = motes.Sprite()
    if kind == "brass":
        bell = [(0.02, 1.5), (0.25, 1.45), (0.36, 1.2), (0.42, 0.8), (0.55, 0.5), (0.72, 0.36)]
        facts["objects"] += [motes.Solid(turned(bell), (0.9, 0.62, 0.25), roughness=0.22, metal=1)]
        balls = [((-1.1, 0.3, 0.4), 0.3, 0.05), ((1.15, 0.36, 0), 0.36, 0.5)]
        facts["objects"] += [
            motes.Solid(Sphere(at, r), (0.9, 0.62, 0.25), roughness=rough, metal=1) for at, r, rough in balls
        ]
    if kind == "stones":
        pebble = turned([(0.01, 0.3), (0.25, 0.26), (0.42, 0.12), (0.5, 0), (0.42, -0.12), (0.01, -0.25)])
        sprite = motes.Sprite("mesh", mesh=pebble, blend="opaque", lit=True, roughness=0.25)
    if kind == "paper":
        white = np.full((8, 12, 4), 255, np.uint8)
        glossy = 0.3
        sprite = motes.Sprite(
            "image", None, "opaque", image=white, facing="orientation", lit=True, roughness=glossy
        )
    if kind == "glass":
        wall = [(0.3, 0.02), (0.34, 0.5), (0.42, 1.3), (0.39, 1.3), (0.31, 0.5), (0.27, 0.08), (0.01, 0.08)]
        facts["objects"] += [
            motes.Solid(Box((-1.6, 0, -1.3), (-0.5, 1.2, -1)), (0.8, 0.25, 0.15)),
            motes.Solid(Box((0.2, 0, -1.4), (1.7, 0.8, -1.1)), (0.2, 0.4, 0.7)),
            motes.Solid(turned([(0.01, 0.02), *wall]).at((-0.75, 0, 0.2)), glass=1.5),
            motes.Solid(Sphere((0.7, 0.5, 0.3), 0.5), glass=1.5),
        ]
    return picture(sprite, place, **facts)


def shadows(*, shadow: float = 1, occlusion: float = 0) -> motes.Frame:
    """Render leaves that hang over a heap of balls beside a block, in sunlight."""
    ground = motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (0.6, 0.58, 0.54))
    block = motes.Solid(Box((-1.7, 0, -0.9), (-0.7, 0.9, 0)), (0.55, 0.5, 0.42))
    camera = motes.Camera((1.8, 1.9, 4.6), (0.25, 0.45, 0.1), fov_deg=25)
    renderer = motes.Renderer(
        *SIZE,
        camera=camera,
        background=(0.25, 0.3, 0.4),
        objects=[ground, block],
        sun=(-0.6, 0.9, 0.5),
        sun_size=1,
        occlusion=occlusion,
    )
    world = motes.World(seed=11, progress="off", renderer=renderer)
    ball = motes.Sprite("sphere", None, "opaque", lit=True, shadow=shadow)
    card = motes.Sprite("image", None, "opaque", image=leaf(), facing="orientation", lit=True, shadow=shadow)
    balls, leaves = world.system("balls", sprite=ball), world.system("leaves", sprite=card)
    with world:
        balls.configure(size=0.22, color=motes.Uniform((0.3, 0.3, 0.3), (0.9, 0.8, 0.7)))
        balls.burst(Box((-0.5, 0.11, -0.3), (1.3, 0.11, 0.9)), count=34)
        leaves.configure(size=0.5, color=motes.Uniform((0.5, 0.1, 0.02), (0.9, 0.4, 0.05)))
        leaves.configure(orientation="random")
        leaves.burst(Box((-0.9, 0.5, 0.2), (1.2, 1.2, 1.3)), count=9)
        return world.render()


def turned(outline: list[tuple[float, float]]) -> motes.Mesh:
    """Turn an outline of radii and heights, m, around the vertical axis."""
    high, around = len(outline), 48
    angles = np.arange(around) * (2 * np.pi / around)
    points = [(r * np.cos(a), y, r * np.sin(a)) for a in angles for r, y in outline]
    corners = [(i * high + k, (i + 1) % around * high + k) for i in range(around) for k in range(high - 1)]
    faces = [t for a, b in corners for t in ((a, b, a + 1), (b, b + 1, a + 1))]
    return motes.Mesh(np.round(points, 6), faces, smooth=True)


def layer(name: str) -> NDArray[np.uint8]:
    """Return a layer of balls that fly past the pillar, and of smoke in front of them, as grey or colours."""
    renderer = motes.Renderer(*SIZE, camera=CAMERA, objects=[GROUND, PILLAR], layers=[name])
    world = motes.World(seed=11, progress="off", renderer=renderer)
    balls = world.system("balls", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
    puffs = world.system("puffs", sprite=motes.Sprite(pixels=None, blend="alpha"))
    with world:
        balls.configure(size=0.4, velocity=Sphere((0, 0, 0), 2))
        balls.burst(Box((-1.5, 0.25, -0.9), (1.5, 1.6, 0.9)), count=25)
        balls.move()
        puffs.configure(size=0.8, alpha=0.4)
        puffs.burst(Box((-1.5, 0.3, 1), (1.5, 1.4, 1.2)), count=12)
        values = world.render().layer(name)
    if name == "depth":
        values = 1 - np.clip((values - 3.5) / 6, 0, 1)
    if name == "velocity":
        values = 0.5 + values / 5
    shown = (np.clip(values, 0, 1) * 255 + 0.5).astype(np.uint8)
    return shown if shown.ndim == 3 else np.repeat(shown[:, :, None], 3, axis=2)


def pictures() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield the name of each picture and the function that makes it: a frame, or an array of pixels."""
    for kind in KINDS:
        for blend in BLENDS:
            yield f"{kind}-{blend}", partial(of_kind, kind, blend)
    yield "size-pixels", partial(near_and_far, motes.Sprite("sphere", pixels=9, blend="opaque"))
    yield "size-metres", partial(near_and_far, motes.Sprite("sphere", pixels=None, blend="opaque"))
    yield "size-height", partial(near_and_far, motes.Sprite("sphere", height=0.06, blend="opaque"))
    yield "softness-0", partial(mist, 0)
    yield "softness-40cm", partial(mist, 0.4)
    yield "shutter-0", partial(sparks, shutter=0)
    yield "shutter-80", partial(sparks, shutter=0.8)
    yield "bloom-0", partial(sparks, bloom=0)
    yield "bloom-20", partial(sparks, bloom=0.2)
    yield "shadow-0", partial(shadows, shadow=0)
    yield "shadow-1", shadows
    yield "occlusion-1", partial(shadows, occlusion=1)
    yield "light-sun", partial(lamps, lit=False)
    yield "light-lamp", lamps
    yield "smooth-off", partial(lamps, smooth=False, lit=False)
    for kind in ("brass", "stones", "paper", "glass"):
        yield f"finish-{kind}", partial(finish, kind)
    for name in ("depth", "alpha", "velocity"):
        yield f"layer-{name}", partial(layer, name)


def main() -> None:
    """Write the pictures whose names contain one of the arguments, or all."""
    FOLDER.mkdir(exist_ok=True)
    for name, make in pictures():
        if len(sys.argv) == 1 or any(word in name for word in sys.argv[1:]):
            motes.Frame(0, 0.0, np.asarray(make())).save(FOLDER / f"{name}.png")


if __name__ == "__main__":
    main()
