"""Lamps and shadows on cards and on instances of meshes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import motes
from motes import shapes

WHITE = np.full((4, 4, 3), 255, np.uint8)
POINTS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = motes.Mesh(POINTS, [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])


def light(
    sprite: motes.Sprite, *, smoke: float = 0, facts: dict[str, Any] | None = None, **state: Any
) -> float:
    """Return the light at the centre of a picture of one particle, with the camera 5 m away along z."""
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    renderer = motes.Renderer(48, 48, camera=camera, linear=True, **(facts or {}))
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("one", sprite=sprite)
    clouds = world.system("smoke", sprite=motes.Sprite("disc", None, shadow=1))
    with world:
        system.emit(position=[(0, 0, 0)], color=[(0.5, 0.5, 0.5)], **state)
        if smoke > 0:  # black and above the view: it is in no picture
            clouds.configure(color=(0, 0, 0), size=0.3, alpha=smoke)
            clouds.burst(shapes.Box((-2, 2.5, -2), (2, 3, 2)), count=2000)
        return float(world.render().linear[24, 24].mean())


ALL_KINDS: list[dict[str, Any]] = [
    {"kind": "point", "pixels": 1},
    {"kind": "disc", "pixels": 9},
    {"kind": "sphere", "pixels": 30},
    {"kind": "image", "pixels": 9, "image": WHITE},
    {"kind": "image", "pixels": None, "image": WHITE, "facing": "orientation"},
    {"kind": "mesh", "mesh": CUBE},
    {"kind": "ribbon", "width": 0.3, "length": 1},
]


@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
@pytest.mark.parametrize("kind", ALL_KINDS)
def test_bright_light_leaves_the_hue(kind: dict[str, Any], blend: Any) -> None:
    """Brightness is clipped at white, and an orange particle stays orange."""
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    lamps = [motes.Light((0, 0, 1), (1, 1, 1), 20)]
    renderer = motes.Renderer(48, 48, camera=camera, linear=True, sun=(0, 0, 0), lights=lamps)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("one", sprite=motes.Sprite(**kind, blend=blend, lit=True))
    with world:
        system.emit(position=[(-0.1, 0, 0)], color=[(0.9, 0.3, 0.02)], velocity=[(6, 0, 0)])
        system.move()
        pixels = world.render().linear.astype(float).reshape(-1, 3)
    red, green, blue = pixels[pixels.sum(axis=1).argmax()]
    assert red > 0.1
    assert (green / red, blue / red) == pytest.approx((1 / 3, 1 / 45), abs=0.015)


def turned(angle_deg: float) -> list[tuple[float, ...]]:
    """Return a rotation about the x axis: a front along z turns to face down, or up."""
    half = np.radians(angle_deg) / 2
    return [(float(np.sin(half)), 0.0, 0.0, float(np.cos(half)))]


def test_a_card_is_lit_by_the_side_that_it_shows() -> None:
    card = motes.Sprite("image", image=WHITE, blend="opaque", facing="orientation", lit=True)
    flying = motes.Sprite("image", image=WHITE, blend="opaque", facing="velocity", lit=True)
    lamp = {"sun": (0, 0, 0), "lights": [motes.Light((0, 0, 4), (1, 1, 1), 8)]}
    alone = {"sun": (0, 0, 0)}
    for angle in (0.0, 40.0, -60.0, 180.0):
        at = {"orientation": turned(angle)}
        added = light(card, facts=lamp, **at) - light(card, facts=alone, **at)
        assert added == pytest.approx(0.5 * 8 / 16 * abs(np.cos(np.radians(angle))), rel=0.06)
    way = {"velocity": [(0, -np.sin(np.radians(40)), np.cos(np.radians(40)))]}
    added = light(flying, facts=lamp, **way) - light(flying, facts=alone, **way)
    assert added == pytest.approx(0.25 * np.cos(np.radians(40)), rel=0.06)
    up, down = (light(card, facts=alone, orientation=turned(angle)) for angle in (-60, 60))
    assert up > 1.2 * down > 0, "the sky is brighter than the ground"


@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
def test_lamps_and_shadows_fall_on_meshes(blend: Any) -> None:
    unlit, lit = (motes.Sprite("mesh", mesh=CUBE, blend=blend, lit=on) for on in (False, True))
    sun = {"sun": (0, 1, 0.8)}
    plain = light(unlit, facts=sun)
    assert light(lit, facts=sun) == pytest.approx(plain, rel=0.02), "the sun and the sky alone"
    lamp = sun | {"lights": [motes.Light((0, 0, 3), (1, 1, 1), 2)]}
    assert light(unlit, facts=lamp) == pytest.approx(plain, rel=0.01)
    assert light(lit, facts=lamp) > 1.1 * plain
    assert light(lit, facts={"sun": (0, 1, 0)}, smoke=0.9) < 0.95 * light(lit, facts={"sun": (0, 1, 0)})
    assert light(lit, facts={"sun": (0, 1, 0.01)}, smoke=0.9) > 0.2 * light(lit, facts={"sun": (0, 1, 0.01)})


@pytest.mark.parametrize("blend", ["opaque", "alpha", "add"])
@pytest.mark.parametrize(
    "sky", [{"background": (0.02, 0.05, 0.12)}, {"background": motes.Gradient("#102040", "#204010")}]
)
def test_small_spheres_have_the_colors_of_large_ones(blend: Any, sky: dict[str, Any]) -> None:
    """Spheres of few pixels are painted from tables, larger ones pixel by pixel."""

    def color(pixels: int | None) -> Any:
        camera = motes.Camera((0, 0, 5), (0, 0, 0))
        facts: dict[str, Any] = {"sun_color": (1, 0.6, 0.3), "linear": True, **sky}
        renderer = motes.Renderer(64, 64, camera=camera, **facts)
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("one", sprite=motes.Sprite("sphere", pixels, blend=blend, lit=True))
        with world:
            dark = world.render().linear.astype(float)
            system.emit(position=[(0, 0, 0)], color=[(0.9, 0.8, 0.7)], size=[(0.79, 1, 1)])
            return (world.render().linear - dark).sum((0, 1))

    table, pixels = color(14), color(None)
    assert table / table.sum() == pytest.approx(pixels / pixels.sum(), abs=0.01)
    assert pixels[0] > 1.3 * pixels[1]
