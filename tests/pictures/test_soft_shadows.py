"""Soft shadows of solids, compared with the visible part of the sun's or a lamp's disc."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import motes
from motes import shapes
from motes.errors import ArgumentError

GROUND = motes.Solid(shapes.Plane((0, 0, 0), (0, 1, 0)), (0.5, 0.5, 0.5))
ROOF = motes.Solid(shapes.Box((-40, 1, -40), (0, 1.001, 40)), (0, 0, 0))
SIDE = motes.Mesh([(-40, 1, -40), (-40, 1, 40), (0, 1, 40), (0, 1, -40)], [(0, 1, 2), (0, 2, 3)])
CAMERA = motes.Camera((0, 0.9, 0), (0, 0, 0), up=(0, 0, -1), fov_deg=60)


def profile(solids: list[Any], **facts: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places on the ground along x, in m, and the light there, seen from below the roof."""
    renderer = motes.Renderer(
        120, 90, camera=CAMERA, objects=solids, linear=True, background=(0, 0, 0), **facts
    )
    with motes.World(seed=1, renderer=renderer, progress="off") as world:
        light = world.render().linear[45, :, 0].astype(float)
    place = (np.arange(120) + 0.5 - 60) * 0.9 * np.tan(np.radians(30)) / 45
    return place, light


def in_sight(edge: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the fraction of a unit disc to the right of a line at distance `edge` left of its centre."""
    u = np.clip(edge, -1, 1)
    return 0.5 + (np.arcsin(u) + u * np.sqrt(1 - u * u)) / np.pi


@pytest.mark.parametrize("roof", [ROOF, motes.Solid(SIDE, (0, 0, 0))])
def test_the_penumbra_of_the_sun_is_the_part_of_its_disc_in_sight(roof: motes.Solid) -> None:
    sun: dict[str, Any] = {"sun": (0, 1, 0), "sun_size": 30}
    place, light = profile([GROUND, roof], **sun)
    _, open_ = profile([GROUND], **sun)
    _, sharp = profile([GROUND, roof], sun=(0, 1, 0))
    dark = sharp.min()
    wanted = in_sight(place / np.tan(np.radians(15)))
    part = (light - dark) / (open_ - dark)
    assert np.abs(part - wanted).max() < 0.03
    assert np.all(np.diff(light) > -0.004)


def test_the_penumbra_of_a_lamp_grows_with_its_radius_and_the_distance() -> None:
    def lamp(radius: float) -> dict[str, Any]:
        return {"sun": (0, 0, 0), "lights": [motes.Light((0, 3, 0), (1, 1, 1), 4, radius=radius)]}

    _, open_ = profile([GROUND], **lamp(0))
    _, dark = profile([GROUND, ROOF], sun=(0, 0, 0))
    for radius in (0.3, 0.6):
        place, light = profile([GROUND, ROOF], **lamp(radius))
        part = (light - dark) / (open_ - dark)
        # The roof's edge is one third of the way from the ground to the lamp.
        assert np.abs(part - in_sight(place * 2 / radius)).max() < 0.05


def test_solids_shade_lit_particles_where_lights_have_a_size() -> None:
    def light(**facts: Any) -> float:
        camera = motes.Camera((3, 0.3, 0.3), (-0.5, 0.3, 0.3))
        renderer = motes.Renderer(40, 30, camera=camera, linear=True, objects=[ROOF], **facts)
        world = motes.World(seed=1, renderer=renderer, progress="off")
        motes_ = world.system("one", sprite=motes.Sprite("disc", 9, "alpha", lit=True))
        with world:
            motes_.emit(position=[(-0.5, 0.3, 0.3)])
            return float(world.render().linear[15, 20].sum())

    plain = light(sun=(0, 1, 0))
    assert light(sun=(0, 1, 0), sun_size=0.5) < 0.7 * plain
    half = light(sun=(1, 1, 0), sun_size=60)
    assert light(sun=(-0.2, 1, 0), sun_size=0.5) < half < light(sun=(1.5, 1, 0), sun_size=0.5)
    lamp = [motes.Light((-0.5, 3, 0), (1, 1, 1), 9, radius=radius) for radius in (0, 0.1)]
    assert light(sun=(0, 0, 0), lights=lamp[1:]) < 0.5 * light(sun=(0, 0, 0), lights=lamp[:1])


def test_each_particle_sees_the_part_of_the_sun_beside_a_ball() -> None:
    """Whichever particles are beside it, and whichever balls stand aside of its way to the sun."""
    places = np.linspace(-2.4, 2.4, 17)
    beside = [motes.Solid(shapes.Sphere((x, 0.4, z), 0.3), (0, 0, 0)) for x in (-3, 0, 3) for z in (-2, 2)]
    ball = motes.Solid(shapes.Sphere((0, 2, 0), 0.7), (0, 0, 0))
    camera = motes.Camera((0, 0, 6), (0, 0, 0), fov_deg=8)
    lamp = motes.Light((0, 4, 1), power=20, radius=0.5)
    columns = np.rint(200 + places / 6 / np.tan(np.radians(4)) * 30 - 0.5).astype(int)

    def row(*solids: motes.Solid, of: Any = places, lights: Any = ()) -> NDArray[np.float64]:
        renderer = motes.Renderer(
            400, 60, camera=camera, linear=True, background=(0, 0, 0), sun=(0, 1, 0), sun_size=40,
            objects=solids, lights=lights,
        )  # fmt: skip
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("row", sprite=motes.Sprite("disc", 7, "alpha", lit=True))
        with world:
            system.emit(position=[(x, 0, 0) for x in of])
            return world.render().linear[:, :, 0].astype(float).max(axis=0)[columns]

    at = np.linspace(-1, 1, 201)
    u, v = (plane[np.hypot(*np.meshgrid(at, at)) <= 1] for plane in np.meshgrid(at, at))
    way = np.stack([u * np.tan(np.radians(20)), 0 * u + 1, v * np.tan(np.radians(20))])
    way /= np.linalg.norm(way, axis=0)
    lit, plain = row(ball, *beside), row()
    for x, part in zip(places, (lit - lit.min()) / (plain - lit.min()), strict=True):
        to = np.array([-x, 2, 0.0])
        assert abs(part - ((to @ to) - (to @ way) ** 2 > 0.7**2).mean()) < 0.05, x
    together = row(ball, *beside, lights=[lamp])
    for i, x in enumerate(places):
        assert row(ball, *beside, of=[x], lights=[lamp])[i] == together[i]


def test_sizes_of_lights_are_checked() -> None:
    for wrong in (-1, 91, float("nan"), "wide"):
        with pytest.raises(ArgumentError, match="sun_size"):
            motes.Renderer(8, 8, camera=CAMERA, sun_size=wrong)
        with pytest.raises(ArgumentError, match="radius"):
            motes.Light((0, 1, 0), radius=-1 if wrong == 91 else wrong)
