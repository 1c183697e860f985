"""Particles of every kind have the light of the `Solid` of the same shape and colour."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from made_meshes import globe
from numpy.typing import NDArray
from one_thing import AWAY, CARD, CENTER, COLOR, HALF, LAMPS, WHITE, Picture, inside, picture, smooth

import motes
from motes import shapes
from motes.errors import ArgumentError

BALL = motes.Mesh(*globe(24, 48, 0.5))  # of many flat triangles
CUBE_POINTS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
CUBE_SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = motes.Mesh(CUBE_POINTS, [t for a, b, c, d in CUBE_SIDES for t in ((a, b, c), (a, c, d))])
LEFT = tuple(np.subtract(CENTER, (HALF, 0.5, HALF)))
KINDS: dict[str, tuple[dict[str, Any], Any]] = {
    "sphere": ({"kind": "sphere", "pixels": None}, shapes.Sphere(CENTER, 0.5)),
    "mesh": ({"kind": "mesh", "mesh": BALL}, BALL.at(CENTER, angle_deg=45)),
    "cube": ({"kind": "mesh", "mesh": CUBE}, CUBE.at(CENTER, angle_deg=45)),
    "card": ({"kind": "image", "pixels": None, "image": WHITE, "facing": "orientation"}, CARD),
}
SKY = np.zeros((16, 32, 3), np.float32)
SKY[:, 20:28] = (0.9, 0.5, 0.2)
SKY[:5] += 0.4
LIGHTS: dict[str, dict[str, Any]] = {
    "sun": {"sun": (0.5, 0.6, 0.7)},
    "colored sun": {"sun": (0.5, 0.6, 0.7), "sun_color": "orange", "sun_power": 1.3},
    "picture": {"sun": (0.5, 0.6, 0.7), "background": SKY},
    **LAMPS,
}


def form(solid: Any) -> NDArray[np.bool_]:
    """Return the pixels that a solid covers."""
    dark = {"sun": (0, 0, 0), "background": (0, 0, 0), "smooth": False}
    return picture(None, motes.Solid(solid, COLOR), **dark).max(axis=2) > 0


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("blend", ["opaque", "alpha"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_light_of_a_solid(kind: str, blend: Any, light: str) -> None:
    members, solid = KINDS[kind]
    expected = picture(None, motes.Solid(solid, COLOR), **LIGHTS[light])
    found = picture(motes.Sprite(**members, blend=blend, lit=True), None, **LIGHTS[light])
    there = inside(form(solid)) & smooth(expected) & smooth(found)
    assert there.sum() > (30 if kind == "mesh" else 300)
    differs = np.abs(found - expected)[there] / np.maximum(expected[there].max(axis=1), 0.02)[:, None]
    assert np.quantile(differs, 0.8 if kind == "mesh" else 0.98) < 0.02
    assert np.median(differs) < 0.006


@pytest.mark.parametrize("kind", KINDS)
def test_light_above_white(kind: str) -> None:
    """Opaque surfaces are as bright as a solid under a sun of any strength."""
    members, solid = KINDS[kind]
    for power in (6, 300):
        facts = {"sun": (0.5, 0.6, 0.7), "sun_power": power, "sun_color": (1, 0.5, 0.1)}
        expected = picture(None, motes.Solid(solid, COLOR), **facts)
        found = picture(motes.Sprite(**members, blend="opaque", lit=True), None, **facts)
        there = inside(form(solid)) & smooth(expected / power) & smooth(found / power)
        assert expected[there].max() > 0.5 * power * 0.75 * 0.7
        differs = np.abs(found - expected)[there] / np.maximum(expected[there].max(axis=1), 0.02)[:, None]
        assert np.quantile(differs, 0.9) < 0.02


@pytest.mark.parametrize("light", ["sun", "colored sun", "gradient", "picture"])
def test_a_lit_disc_has_the_mean_light_of_a_ball(light: str) -> None:
    solid = shapes.Sphere(CENTER, 0.5)
    there = form(solid)
    expected = picture(None, motes.Solid(solid, COLOR), smooth=False, **LIGHTS[light])[there].mean(axis=0)
    sprite = motes.Sprite("disc", None, "opaque", lit=True)
    found = picture(sprite, None, **LIGHTS[light])[inside(there)].mean(axis=0)
    assert found == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("kind", ["sphere", "mesh", "image", "disc", "card", "ribbon"])
@pytest.mark.parametrize("blend", ["opaque", "alpha"])
def test_fog_has_its_own_color(kind: str, blend: Any) -> None:
    """After ten lengths of the fog, everything shows its colour, whatever its shade or picture."""
    brown = np.broadcast_to(np.array((60, 30, 0), np.uint8), (4, 4, 3)).copy()
    given: dict[str, Any] = {
        "sphere": {"kind": "sphere", "pixels": None},
        "mesh": {"kind": "mesh", "mesh": BALL},
        "image": {"kind": "image", "pixels": None, "image": brown},
        "disc": {"kind": "disc", "pixels": None},
        "card": {"kind": "image", "pixels": None, "image": brown, "facing": "orientation"},
        "ribbon": {"kind": "ribbon", "width": 1.0, "length": 1.0},
    }[kind]
    for lit in (False, True):
        for fog in ((0.6, 0.7, 0.8), (0.1, 0.05, 0.02)):
            sprite = motes.Sprite(**given, blend=blend, lit=lit)
            found = picture(sprite, None, fog=(fog, 0.3), sun=(0, -1, -1))
            assert found[45, 73] == pytest.approx(fog, abs=0.012)


WIDE = motes.Camera((0, 0, 6), (0, 0, 0), fov_deg=60)
OFF_AXIS = [(0.2, 0.3), (1.7, 0.8), (-2.9, 2.2), (3.8, -2.7), (-4.2, -1.2), (2.4, 3.0)]


def apart(sprite: motes.Sprite | None, pixels: int, **facts: Any) -> list[NDArray[np.float64]]:
    """Return the light of balls of a width, px, in many directions: of particles, or else of solids.

    Each is a list of the pixels around the ball's middle that it covers. Tables know places to a quarter of a
    pixel: all are in the middle of one.
    """
    width, height = 400, 300
    focal = height / 2 / np.tan(np.radians(30))
    middles = [(int(200 + x * focal / 6), int(150 - y * focal / 6)) for x, y in OFF_AXIS]
    places = [((x + 0.625 - 200) / focal * 6, (150 - y - 0.625) / focal * 6, 0.0) for x, y in middles]
    wide = 6 * pixels / focal
    solids = [] if sprite else [motes.Solid(shapes.Sphere(place, wide / 2), COLOR) for place in places]
    renderer = motes.Renderer(width, height, camera=WIDE, linear=True, objects=solids, **(AWAY | facts))
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("balls", **({"sprite": sprite} if sprite else {}))
    with world:
        if sprite:
            color = np.tile(COLOR, (len(places), 1))
            system.emit(position=places, color=color, size=np.full((len(places), 3), wide))
            system.move()
        light = world.render().linear.astype(float)
    rows, columns = np.indices(light.shape[:2])
    return [light[np.hypot(columns - x, rows - y) < pixels / 2 - 1.5] for x, y in middles]


SIDEWAYS: dict[str, dict[str, Any]] = {
    "sun": {"sun": (0.5, 0.6, 0.7), "fog": None},
    "low sun": {"sun": (-0.8, 0.1, 0.3), "fog": None},
    "colored sun": {"sun": (0.5, 0.6, 0.7), "sun_color": "orange", "fog": None},
    "fog": {"sun": (0.5, 0.6, 0.7), "fog": ((0.2, 0.4, 0.9), 6)},
    "gradient": {
        "sun": (0, 0, 0),
        "background": motes.Gradient((0.9, 0.5, 0.3), (0.3, 0.5, 1), (0.2, 0.2, 0.1)),
    },
    "lamp": {"sun": (0, 0, 0), "lights": [motes.Light((1.5, 1, 3), (1, 0.8, 0.6), 6)]},
}


@pytest.mark.parametrize("light", SIDEWAYS)
@pytest.mark.parametrize("blend", ["opaque", "alpha", "add"])
@pytest.mark.parametrize("pixels", [7, 11, 15])
@pytest.mark.parametrize("sized", [False, True])
def test_small_spheres_have_the_light_of_solids_in_all_directions(
    sized: bool, pixels: int, blend: Any, light: str
) -> None:
    """Those of a fixed number of pixels are drawn from tables, others pixel by pixel.

    The weights of those that are blended are scaled, so that their sum does not depend on the place in a
    pixel: they are up to a hundredth fainter, or brighter, and let as much of the background through.
    """
    near = {"rel": 0.02, "abs": 0.003} if blend == "opaque" else {"rel": 0.03, "abs": 0.006}
    facts = SIDEWAYS[light]
    if blend == "add":
        if light in ("fog", "gradient"):
            pytest.skip("what is added has light of its own before what is behind")
        facts = facts | {"background": (0, 0, 0)}
    for lit in (True, False):
        if not lit and light not in ("sun", "low sun", "fog"):
            continue
        # Only solids fade into the background without fog.
        unfaded = facts | ({} if facts.get("fog", AWAY) else {"fog": AWAY["fog"]})
        expected = apart(None, pixels, **unfaded)
        found = apart(motes.Sprite("sphere", None if sized else pixels, blend, lit=lit), pixels, **facts)
        for one, other in zip(found, expected, strict=True):
            assert len(one) > 8
            assert one.mean(axis=0) == pytest.approx(other.mean(axis=0), **near)


@pytest.mark.parametrize("blend", ["opaque", "alpha", "add"])
def test_small_spheres_follow_the_sun(blend: Any) -> None:
    """What is kept from picture to picture is that of the same light."""
    suns = [(1, 0.5, 0.5), (1, 0.5, 0.5), (-1, 0.5, 0.5), (1, 0.5, 0.5)]

    def drawn(suns: list[tuple[float, float, float]]) -> list[NDArray[np.float64]]:
        renderer = motes.Renderer(160, 120, camera=WIDE, linear=True)
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("balls", sprite=motes.Sprite("sphere", 9, blend, lit=True))
        pictures = []
        with world:
            system.emit(position=[(x, y, 0) for x, y in OFF_AXIS])
            for sun in suns:
                renderer.sun = sun
                pictures.append(world.render().linear.astype(float))
        return pictures

    found = drawn(suns)
    for sun, one in zip(suns, found, strict=True):
        assert np.array_equal(one, drawn([sun])[0])
    assert not np.array_equal(found[1], found[2])


def test_small_spheres_are_seen_through_fog_as_any_others_are() -> None:
    """Those of a fixed number of pixels are painted from tables."""
    camera = motes.Camera((0, 0, 6), (0, 0, 0), fov_deg=40)
    focal = 90 / np.tan(np.radians(20))
    places = np.array(
        [(x - z / 40, y, z) for z in (0, -6, -12) for x in (-1.4, -0.3, 0.8) for y in (-0.4, 0.5)]
    )
    places[:, :2] *= (6 - places[:, 2:]) / 6  # side by side in the picture

    def drawn(pixels: int | None, fog: Any) -> Picture:
        renderer = motes.Renderer(240, 180, camera=camera, linear=True, fog=fog, background=(0.1, 0.1, 0.1))
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("balls", sprite=motes.Sprite("sphere", pixels, "opaque"))
        with world:
            wide = 7 * (6 - places[:, 2]) / focal
            system.emit(position=places, color=np.tile(COLOR, (len(places), 1)), size=np.tile(wide, (3, 1)).T)
            return world.render().linear.astype(float)

    for fog in (((0.2, 0.4, 0.9), 6), ((0.02, 0.01, 0.3), 30)):
        small, any_size = drawn(7, fog), drawn(None, fog)
        there = inside(np.abs(any_size - 0.1).max(axis=2) > 1e-3, 1)
        assert there.sum() > 200
        # Tables know places to a quarter of a pixel, and directions to a degree.
        differs = np.abs(small - any_size)[there].max(axis=1) / any_size[there].max(axis=1)
        assert np.median(differs) < 0.02
        assert small[there].mean(axis=0) == pytest.approx(any_size[there].mean(axis=0), rel=0.03)


def test_a_spot_shines_in_its_cone_only() -> None:
    """Its degrees are the angle between opposite sides of the cone."""
    floor = shapes.Plane((0, 0, 0), (0, 1, 0))

    def profile(spot: Any) -> Picture:
        camera = motes.Camera((0, 4, 0), (0, 0, 0), up=(0, 0, -1), fov_deg=90)
        lamp = motes.Light((0, 2, 0), (1, 1, 1), 4, spot=spot)
        renderer = motes.Renderer(
            161,
            161,
            camera=camera,
            linear=True,
            objects=[motes.Solid(floor)],
            sun=(0, 0, 0),
            lights=[lamp],
            **AWAY,
        )
        with motes.World(seed=1, renderer=renderer, progress="off") as world:
            return world.render().linear[80, :, 0].astype(float)

    everywhere, cone = profile(None), profile(((0, -1, 0), 60))
    none = everywhere.copy()
    x = (np.arange(161) - 80) / 80.5 * 4
    angle = np.degrees(np.arctan2(np.abs(x), 2))
    none = profile(((0, 1, 0), 60))
    assert np.allclose(cone[angle < 26.5], everywhere[angle < 26.5], rtol=1e-3)
    assert np.allclose(cone[angle > 30.5], none[angle > 30.5], rtol=1e-3)
    assert np.all(np.diff(cone[80:]) <= 1e-6)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("sun_color", (1, 1)),
        ("sun_color", (-1, 1, 1)),
        ("sun_color", "no such colour"),
        ("sun_power", -1),
        ("sun_power", float("nan")),
        ("sun_power", "bright"),
    ],
)
def test_wrong_suns_are_refused(name: str, wrong: Any) -> None:
    with pytest.raises(ArgumentError, match=name if wrong != "no such colour" else "colour"):
        motes.Renderer(8, 8, camera=motes.Camera((0, 0, 1), (0, 0, 0)), **{name: wrong})


@pytest.mark.parametrize(
    "wrong",
    [
        1,
        "down",
        ((0, 0, 0), 30),
        ((0, 1, 0),),
        ((0, 1, 0), 0),
        ((0, 1, 0), 361),
        ((0, 1, 0), "wide"),
    ],
)
def test_wrong_spots_are_refused(wrong: Any) -> None:
    with pytest.raises(ArgumentError, match="spot"):
        motes.Light((0, 1, 0), spot=wrong)
