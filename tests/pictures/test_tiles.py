"""Sprites with several images: which one each particle shows, blends, levels of detail, invalid sheets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from standing import on_ranks

import motes
from motes import expressions as ex
from motes.errors import ArgumentError
from motes.expressions import column

COLORS = np.array([(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255), (255, 255, 0), (0, 255, 255)])
PICTURES = [np.full((8, 6, 3), color, np.uint8) for color in COLORS]
SHEET = np.concatenate([np.concatenate(PICTURES[:3], axis=1), np.concatenate(PICTURES[3:], axis=1)])


def seen(
    places: Any, *, frames: int = 1, state: dict[str, Any] | None = None, shutter: float = 0, **sprite: Any
) -> NDArray[np.float32]:
    """Return the light of a picture of some particles, after some frames."""
    renderer = motes.Renderer(
        96, 64, camera=motes.Camera((0, 0, 5), (0, 0, 0)), linear=True, shutter=shutter, exposure=0.5
    )
    world = motes.World(seed=1, dt=0.25, renderer=renderer, progress="off")
    given: dict[str, Any] = {"pixels": 24, "image": SHEET, "tiles": (3, 2)} | sprite
    system = world.system("all", sprite=motes.Sprite("image", blend="alpha", **given))
    with world:
        system.emit(position=places, **(state or {}))
        for _ in range(frames):
            system.move()
            picture = world.render()
    return picture.linear.copy()


def middle(**facts: Any) -> NDArray[np.float32]:
    """Return the colour of a single particle at the centre."""
    return seen([(0, 0, 0)], **facts)[32, 48]


@pytest.mark.parametrize("facing", ["camera", "orientation"])
def test_a_number_picks_a_tile(facing: Any) -> None:
    size = {"pixels": None, "state": {"size": [(2, 1, 1)]}} if facing == "orientation" else {}
    for number, color in enumerate(COLORS / 255):
        np.testing.assert_allclose(middle(pick=number, facing=facing, **size), color, atol=0.002)
        listed = middle(image=PICTURES, tiles=None, pick=number, facing=facing, **size)
        np.testing.assert_allclose(listed, color, atol=0.002)
    for number, same in ((6, 0), (-1, 5), (6e7 + 12, 0), (5.9999, 0)):
        np.testing.assert_allclose(middle(pick=number, facing=facing, **size), COLORS[same] / 255, atol=0.002)
    undefined = middle(pick=column("mass") / (column("mass") - 1))
    np.testing.assert_allclose(undefined, COLORS[0] / 255, atol=0.002)


def test_a_number_is_of_its_particle_among_many() -> None:
    many = 70_000
    place, mass = np.full((many, 3), (0, 0, 99.0)), np.zeros(many)
    place[-1], mass[-1] = 0, 3
    shown = seen(place, pick=column("mass"), state={"mass": mass})[32, 48]
    np.testing.assert_allclose(shown, COLORS[3] / 255, atol=0.002)


@pytest.mark.parametrize("pixels", [24, 6])
def test_between_two_numbers_stands_a_mixture_of_both(pixels: int) -> None:
    for number, weights in ((0.5, {0: 0.5, 1: 0.5}), (2.25, {2: 0.75, 3: 0.25}), (5.75, {5: 0.25, 0: 0.75})):
        wanted = sum(part * COLORS[tile] / 255 for tile, part in weights.items())
        np.testing.assert_allclose(middle(pick=number, pixels=pixels), wanted, atol=0.005)


def test_tiles_follow_age_and_expressions_of_each_particle() -> None:
    ages = [middle(pick="age", frames=n, state={"lifetime": [1.01]}) for n in (1, 3)]
    for n, light in zip((1, 3), ages, strict=True):
        at = 5 * n * 0.25 / 1.01
        below, part = int(at), at - int(at)
        wanted = (COLORS[below] * (1 - part) + COLORS[below + 1] * part) / 255
        np.testing.assert_allclose(light, wanted, atol=0.006)
    np.testing.assert_allclose(middle(pick="age"), COLORS[0] / 255, atol=0.002), "without an end"
    places = [(-1, 0, 0), (1, 0, 0)]
    light = seen(places, pick=column("position")[0] + 1 + ex.time() * 4)
    np.testing.assert_allclose(light[32, [31, 64]], COLORS[[1, 3]] / 255, atol=0.002)


def test_tiles_at_random_are_a_particles_own_for_life() -> None:
    x, y = np.meshgrid(np.arange(16), np.arange(10))
    places = np.stack([(x.ravel() - 7.5) * 0.3, (y.ravel() - 4.5) * 0.3, 0 * x.ravel()], axis=1)
    first, later = (seen(places, pixels=3, frames=n) for n in (1, 3))
    np.testing.assert_array_equal(first, later)
    at = np.rint(np.stack([32 - places[:, 1] * 17.58, 48 + places[:, 0] * 17.58]) - 0.5).astype(int)
    colors = first[at[0], at[1]]
    shares = [(np.abs(colors / colors.max(axis=1, keepdims=True) - c / 255) < 0.1).all(axis=1).mean()
              for c in COLORS]  # fmt: skip
    assert min(shares) > 0.08 and sum(shares) > 0.9


@pytest.mark.parametrize("pixels", [2, 3, 5, 9, 40])
@pytest.mark.parametrize("facing", ["camera", "orientation"])
def test_no_tile_shines_into_its_neighbours(pixels: int, facing: Any) -> None:
    dark = np.zeros((33, 35, 4), np.uint8)
    dark[:, :, 3] = 255
    sheet = np.full((3 * 33, 3 * 35, 4), 255, np.uint8)
    sheet[33:66, 35:70] = dark
    places = [(0.013, 0.021, 0), (1.007, 0.5, 0), (-1.2, -0.7, 0)]
    light = seen(places, image=sheet, tiles=(3, 3), pick=4, pixels=pixels, facing=facing)
    assert light.max() == 0


def test_a_tile_looks_like_a_picture_of_its_own() -> None:
    dice = np.random.default_rng(4)
    pictures = dice.integers(0, 256, (7, 20, 12, 4), dtype=np.uint8)
    state = {"up": dice.normal(size=(40, 3)), "color": dice.uniform(size=(40, 3))}
    places = dice.uniform(-2, 2, (40, 3))
    for pixels in (4, 15):
        alone = seen(places, state=state, image=pictures[3], tiles=None, pixels=pixels)
        listed = seen(places, state=state, image=list(pictures), tiles=None, pick=3, pixels=pixels)
        np.testing.assert_array_equal(alone, listed)
        cut = seen(
            places, state=state, image=pictures.reshape(1, 140, 12, 4), tiles=(1, 7), pick=3, pixels=pixels
        )
        np.testing.assert_array_equal(alone, cut)


EVERYWHERE = """
import sys
import numpy as np
import motes
from motes import expressions as ex
from motes import shapes
from motes.expressions import column

path, roles = sys.argv[1:]
camera = motes.Camera((0, 0, 9), (0, 0, 0))
facts = {"path": path, "shutter": 0.5, "objects": [shapes.Sphere((1, 0, 0), 1)]}
renderer = motes.Renderer(160, 90, camera=camera, **facts)
world = motes.World(seed=3, space=(-8, 8), roles=roles, renderer=renderer, progress="off")
sheet = np.random.default_rng(1).integers(0, 255, (18, 14, 4), dtype=np.uint8)
inside = ex.where(shapes.Sphere((0, 0, 0), 3), 1, 2.5)
picks = ("random", "age", column("position")[0] * 2 + ex.time(), inside)
systems = []
for i, blend in enumerate(("add", "alpha", "opaque", "alpha")):
    facing = "orientation" if i % 2 else "camera"
    facts = {"image": sheet, "tiles": (2, 3), "pick": picks[i], "facing": facing}
    look = motes.Sprite("image", 5 + 9 * (i % 2), blend, **facts)
    systems.append(world.system(f"s{i}", sprite=look))
with world:
    for _ in world.frames(2):
        for system in systems:
            system.configure(color=(0.2, 0.5, 1), alpha=0.5, velocity=shapes.Sphere((0, 0, 0), 4), lifetime=1)
            system.configure(orientation="random", up=shapes.Sphere((0, 0, 0), 1))
            system.burst(shapes.Box((-8, -4, -1), (8, 4, 8)), count=60)
            system.move()
        picture = world.render()
        if picture:
            print(picture.digest())
"""


def test_tiles_are_the_same_on_all_paths_and_ranks() -> None:
    alone = on_ranks(1, EVERYWHERE, "gather", "auto").lines
    assert len(set(alone)) == 2
    for path in ("gather", "tiles", "composite"):
        assert on_ranks(3, EVERYWHERE, path, "auto").lines == alone
    assert on_ranks(2, EVERYWHERE, "auto", "shared").lines == alone


def test_wrong_sheets_and_picks_are_refused(tmp_path: Path) -> None:
    image = {"image": SHEET}
    for wrong, argument, value in (
        ({**image, "tiles": (4, 2)}, "tiles", "18x16"),
        ({**image, "tiles": (3, 3)}, "tiles", "18x16"),
        ({**image, "tiles": (0, 2)}, "tiles", "0"),
        ({**image, "tiles": (3, 257)}, "tiles", "257"),
        ({**image, "tiles": 3}, "tiles", "3"),
        ({**image, "tiles": (3,)}, "tiles", "columns, rows"),
        ({**image, "tiles": (3, 2.0)}, "tiles", "2.0"),
        ({**image, "pick": "random"}, "pick", "tiles"),
        ({**image, "tiles": (3, 2), "pick": "rnadom"}, "pick", "random"),
        ({**image, "tiles": (3, 2), "pick": (1, 2, 3)}, "pick", "number"),
        ({**image, "tiles": (3, 2), "pick": object()}, "pick", "'age' or an expression of one"),
        ({**image, "tiles": (3, 2), "pick": column("age") > 1}, "pick", "number"),
        ({"image": [SHEET, SHEET[:8]]}, "image", "18x8"),
        ({"image": []}, "image", "0 pictures"),
        ({"image": [SHEET, tmp_path / "none.png"]}, "image", "none.png"),
        ({"image": [np.zeros((5000, 5000, 3), np.uint8)] * 2}, "image", "8192"),
        ({"kind": "disc", "tiles": (2, 2)}, "tiles", "image"),
    ):
        with pytest.raises(ArgumentError, match=value) as caught:
            motes.Sprite(**({"kind": "image"} | wrong))
        assert argument in str(caught.value)
    world = motes.World(
        renderer=motes.Renderer(8, 8, camera=motes.Camera((0, 0, 5), (0, 0, 0))), progress="off"
    )
    system = world.system("right", attributes={"kind": 1}, sprite=tiled(column("kind")))
    for pick, name in (
        (column("kidn"), "kidn"),
        (column("velocity"), "number"),
        (column("position_b")[0], "_b"),
    ):
        with pytest.raises(ArgumentError, match=name):
            world.system("wrong", sprite=tiled(pick))
        with pytest.raises(ArgumentError, match=name):
            system.sprite = tiled(pick)
    assert repr(tiled(2.5)) == "Sprite(kind='image', image=<18x16 pixels>, tiles=(3, 2), pick=2.5)"
    assert tiled("age") == tiled("age") != tiled("random")


def tiled(pick: Any) -> motes.Sprite:
    """Return a sprite of six tiles."""
    return motes.Sprite("image", image=SHEET, tiles=(3, 2), pick=pick)
