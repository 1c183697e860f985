"""What a lens, an open shutter and eight bits do to a picture: the same to all kinds, on all paths."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from made_meshes import globe
from numpy.typing import NDArray
from same_bits import on_all_paths

import motes
from motes import shapes


def film(drawn_from: int, shutter: float | motes.Curve = 1, opens_at: int = 0) -> str:
    """Return the digest of a panning film's sixth picture, with pictures from a frame on."""
    camera = motes.Camera(motes.Curve([(0, (-3, 1, 5)), (0.25, (3, 1, 5))]), (0, 0, 0))
    renderer = motes.Renderer(160, 90, camera=camera, background=(0.02, 0.02, 0.05))
    world = motes.World(seed=1, progress="off", renderer=renderer)
    system = world.system("s", sprite=motes.Sprite("disc", pixels=5))
    with world:
        for frame in world.frames(6):
            renderer.shutter = shutter if frame >= opens_at else 0
            if frame == 0:
                system.burst(shapes.Sphere((0, 0, 0), 1.2), count=100)
            system.move()
            picture = world.render() if frame >= drawn_from else world.step()
        if drawn_from == 6:
            picture = world.redraw()
        return picture.digest()


def test_streaks_after_frames_without_a_picture_begin_at_the_camera_of_the_frame_before() -> None:
    assert film(5) == film(3) == film(0)
    assert film(5) != film(5, 0)


def test_a_shutter_that_moves_or_opens_late_needs_no_earlier_picture() -> None:
    curve = motes.Curve([(0, 0), (0.25, 1)])
    assert film(5, curve) == film(0, curve) != film(5)
    assert film(5, opens_at=5) == film(0, opens_at=5) == film(5)


def test_a_frame_without_a_picture_is_redrawn_with_its_streaks() -> None:
    assert film(6) == film(5)


def test_a_dark_gradient_is_dithered_on_average_as_the_light_says() -> None:
    sky = motes.Gradient((0.02, 0.03, 0.07), (0.002, 0.003, 0.01), (0.01, 0.01, 0.015))
    camera = motes.Camera((0, 1, 5), (0, 1.2, 0))
    renderer = motes.Renderer(320, 180, camera=camera, background=sky, linear=True)
    world = motes.World(seed=1, progress="off", renderer=renderer)
    world.system("s")
    with world:
        picture = world.render()
    light = picture.linear.astype(float)
    wanted = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055) * 255
    error = picture.pixels - wanted
    assert np.abs(error).max() < 1
    blocks = error[:176].reshape(11, 16, 20, 16, 3).mean((1, 3))  # rounding alone is off by up to half a step
    assert np.abs(blocks).max() < 0.12


# --- opaque things through a lens

SHEET = np.full((8, 8, 4), 255, np.uint8)
QUAD = motes.Mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2), (0, 2, 3)])
KINDS: dict[str, dict[str, Any]] = {
    "disc": {"kind": "disc", "pixels": None},
    "wide disc": {"kind": "disc", "pixels": 25},
    "point": {"kind": "point"},
    "sphere": {"kind": "sphere", "pixels": None},
    "image": {"kind": "image", "pixels": None, "image": SHEET},
    "card": {"kind": "image", "image": SHEET, "facing": "orientation"},
    "mesh": {"kind": "mesh", "mesh": QUAD},
}


def one(sprite: motes.Sprite, size: float = 0.6, alpha: float = 1, **facts: Any) -> motes.Frame:
    """Return a picture of one particle, 10 m away, through a lens of `aperture` that is sharp at `focus`."""
    lens = {name: facts.pop(name) for name in ("focus", "aperture") if name in facts}
    camera = motes.Camera((0, 0, 10), (0, 0, 0), **lens)
    renderer = motes.Renderer(400, 300, camera=camera, linear=True, **facts)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("s", sprite=sprite)
    with world:
        system.emit(position=[(0.05, 0, 0)], size=[(size, 1, 1)], alpha=[alpha])
        system.move()
        return world.render()


def light_of(frame: motes.Frame) -> float:
    assert frame.linear is not None
    return float(frame.linear.astype(float).sum())


@pytest.mark.parametrize("name", KINDS)
def test_a_lens_only_blurs_opaque_particles(name: str) -> None:
    sprite = motes.Sprite(blend="opaque", **KINDS[name])
    # Sharp squares cover whole pixels, so their light is not quite that of their area.
    covered, exact = {"image": (24**2, 24.73**2), "card": (24**2, 24.73**2), "mesh": (50**2, 49.46**2)}.get(
        name, (1, 1)
    )
    sharp = light_of(one(sprite)) * exact / covered
    for lens in ({"focus": 10, "aperture": 0.2}, {"focus": 5, "aperture": 0.2}, {"focus": 5, "aperture": 1}):
        assert light_of(one(sprite, **lens)) == pytest.approx(sharp, rel=0.02)
        assert light_of(one(sprite, alpha=0.5, **lens)) == light_of(one(sprite, **lens))
    focused, blurred = one(sprite, focus=10, aperture=0.2).linear, one(sprite, focus=5, aperture=1).linear
    assert focused is not None and blurred is not None
    middle = one(sprite).linear
    assert middle is not None and np.abs(focused - middle).mean() < 0.1 * middle.mean()
    assert (blurred > 0).sum() > 2 * (focused > 0).sum()


@pytest.mark.parametrize("layer", ["depth", "velocity", "alpha"])
def test_layers_are_those_of_a_pinhole(layer: str) -> None:
    sprite = motes.Sprite("sphere", pixels=None, blend="opaque")
    sharp, seen = (one(sprite, 2, layers=[layer], **lens) for lens in ({}, {"focus": 10, "aperture": 0.2}))
    same = np.isclose(seen.layer(layer), sharp.layer(layer), rtol=2e-3)
    assert (~same).sum() < 5  # records have other sizes, rounded to 1/64 pixel


# --- blended things through a lens


@pytest.mark.parametrize("blend", ["add", "alpha"])
@pytest.mark.parametrize("size", [0.2, 0.4, 2])
@pytest.mark.parametrize("name", ["disc", "sphere", "image", "card", "mesh"])
def test_out_of_focus_particles_keep_their_light(name: str, size: float, blend: Any) -> None:
    sprite = motes.Sprite(blend=blend, **KINDS[name])
    sharp = light_of(one(sprite, size))
    for focus, aperture in ((10, 0.3), (5, 0.1), (5, 0.4)):
        seen = one(sprite, size, focus=focus, aperture=aperture)
        assert light_of(seen) == pytest.approx(sharp, rel=0.02)


@pytest.mark.parametrize("name", ["sphere", "image"])
def test_large_sprites_are_blurred_instead_of_larger(name: str) -> None:
    sprite = motes.Sprite(blend="alpha", **KINDS[name])
    rows = [one(sprite, 2, **lens).linear for lens in ({}, {"focus": 5, "aperture": 0.4})]
    sharp, seen = (row[150, :, 0].astype(float) for row in rows if row is not None)
    assert seen[200] == pytest.approx(sharp[200], rel=0.1)  # its middle stays as bright
    assert np.abs(np.diff(seen)).max() < 0.2 * np.abs(np.diff(sharp)).max()  # and its edge is soft


@pytest.mark.parametrize("width", [0.02, 0.1])
@pytest.mark.parametrize("frames", [4, 12])
def test_a_ribbon_keeps_its_light(width: float, frames: int) -> None:
    def light(aside: float = 0, **lens: float) -> float:
        camera = motes.Camera((0, 0, 10), (0, 0, 0), **lens)
        renderer = motes.Renderer(400, 300, camera=camera, linear=True)
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("s", sprite=motes.Sprite("ribbon", width=width, length=1))
        with world:
            for frame in world.frames(frames):
                if frame == 0:
                    system.emit(position=[(-0.5 + aside, aside / 2, 0)], velocity=[(1, 0, 0)], alpha=[0.5])
                system.move()
                picture = world.render()
            return light_of(picture)

    # That of a sharp one depends a little on where its ends are in their pixels.
    sharp = np.mean([light(k / 330) for k in range(8)])  # 1/8 pixel to the right and 1/16 pixel up each
    for aperture in (0.2, 0.5, 1, 2):
        assert light(focus=5, aperture=aperture) == pytest.approx(sharp, rel=0.03)


# --- what is opaque and moves


def column_light(
    shutter: float, objects: Any = (), sprite: motes.Sprite | None = None
) -> NDArray[np.float64]:
    """Return the light of each column, relative to all, of a ball that a panning camera passes."""
    camera = motes.Camera((0, 0, 8), (0, 0, 0))
    renderer = motes.Renderer(320, 180, camera=camera, shutter=shutter, objects=list(objects), linear=True)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("s", sprite=sprite)
    with world:
        if sprite is not None:
            system.emit(position=[(0, 0, 0)], size=[(1, 1, 1)], color=[(0.8, 0.8, 0.8)])
        world.render()
        camera.position, camera.look_at = (1, 0, 8), (1, 0, 0)
        picture = world.render().linear
        assert picture is not None
    light = picture.astype(float)[:, :, 0].sum(0)
    return light / light.sum()


@pytest.mark.parametrize("shutter", [0, 0.5, 1])
def test_a_pan_shows_a_solid_a_particle_and_a_mesh_alike(shutter: float) -> None:
    ball = motes.Mesh(*globe(24, 48, 0.5))
    facts = {"blend": "opaque", "pixels": None}
    solid = column_light(shutter, [motes.Solid(shapes.Sphere((0, 0, 0), 0.5), (0.8, 0.8, 0.8))])
    of_mesh = column_light(shutter, [motes.Solid(ball, (0.8, 0.8, 0.8))])
    particle = column_light(shutter, sprite=motes.Sprite("sphere", **facts))
    mesh = column_light(shutter, sprite=motes.Sprite("mesh", mesh=ball, blend="opaque"))
    blended = column_light(shutter, sprite=motes.Sprite("sphere", blend="alpha", pixels=None))
    for other in (of_mesh, particle, mesh, blended):
        assert np.abs(other - solid).sum() < 0.08  # they are not lit quite alike
    assert (solid > 0).sum() > 40 * shutter


def test_a_solid_that_moves_is_blurred_along_its_way() -> None:
    def lit(mesh: motes.Mesh, shutter: float) -> NDArray[np.float32]:
        renderer = motes.Renderer(
            200, 100, camera=motes.Camera((0, 0, 8), (0, 0, 0)), shutter=shutter, linear=True, sun=(0, 0, 0),
            objects=[motes.Solid(mesh, (1, 1, 1), light=1)],
        )  # fmt: skip
        world = motes.World(seed=1, renderer=renderer, progress="off")
        world.system("s")
        with world:
            picture = world.render().linear
        assert picture is not None
        return picture[:, :, 0]

    here = QUAD.at((1, 0, 0))
    sharp, still = lit(here, 0), lit(here, 1)
    np.testing.assert_array_equal(sharp, still)
    moving = lit(QUAD.at((1, 0, 0), moving_from=QUAD.at((-1, 0, 0))), 1)
    assert moving.sum() == pytest.approx(sharp.sum(), rel=0.01)
    pixel = 2 * np.tan(np.radians(20)) * 8 / 100  # m
    row = moving[50] / sharp[50].max()
    across = (np.arange(200) - 99.5) * pixel
    wanted = np.clip(np.minimum(across + 2, 2 - across) / 2, 0, 1)  # a box over a box
    assert np.abs(row - wanted).max() < 1 / 14
    blocks = (row - wanted).reshape(100, 2).mean(1)
    assert np.abs(blocks).max() < 1 / 20


EVERYWHERE = """
import sys
import numpy as np
import motes
from motes.shapes import Box, Plane, Sphere

leaf = (np.arange(9 * 7 * 4).reshape(9, 7, 4) * 37 % 256).astype(np.uint8)
corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
quad = motes.Mesh(corners, [(0, 1, 2), (0, 2, 3)], uv=[(0, 0), (1, 0), (1, 1), (0, 1)], smooth=True)
path, roles = sys.argv[1:]
renderer = motes.Renderer(
    230, 150, camera=motes.Camera((0, 1, 7), (0, 0, 0)), path=path, shutter=0.7,
    background=motes.Gradient("#89a", "navy"), lights=[motes.Light((1, 3, 2), power=4)],
)
world = motes.World(seed=4, roles=roles, renderer=renderer, progress="off")
looks = [
    ("sphere", "opaque", {}), ("image", "opaque", {"image": leaf}), ("mesh", "opaque", {"mesh": quad}),
    ("point", "opaque", {}), ("ribbon", "opaque", {"width": 0.1, "length": 1}),
    ("disc", "add", {"pixels": 9}),
    ("sphere", "alpha", {"softness": 0.3}), ("image", "alpha", {"image": leaf}), ("disc", "opaque", {}),
    ("image", "opaque", {"image": leaf, "facing": "orientation"}),
]
systems = []
for n, (kind, blend, facts) in enumerate(looks):
    facts = {"pixels": None, **facts} if kind not in ("mesh", "ribbon", "point") else facts
    sprite = motes.Sprite(kind, blend=blend, lit=kind != "ribbon", **facts)
    systems.append(world.system(f"s{n}", sprite=sprite))
with world:
    for frame in world.frames(3):
        x = 0.2 * frame
        before = quad.at((x - 0.2, 0, -1), angle_deg=20 * frame - 20)
        mesh = quad.at((x, 0, -1), angle_deg=20 * frame, moving_from=before)
        ground = motes.Solid(Plane((0, -1.2, 0), (0, 1, 0)), (0.4, 0.5, 0.3))
        renderer.objects = [ground, motes.Solid(mesh, image=leaf[:, :, :3])]
        renderer.camera = motes.Camera((0.4 * frame, 1, 7), (0, 0, 0), focus=6, aperture=0.2 * (frame == 2))
        renderer.shutter = 0.7 if frame != 2 else 0.0
        for system in systems:
            system.configure(velocity=motes.Normal((0, 0, 0), (3, 3, 3)), spin=(0, 9, 4), size=0.3)
            system.configure(orientation="random")
            system.burst(Box((-2, -1, -2), (2, 1, 2)), count=30)
            system.move()
        picture = world.render()
        if picture:
            print(picture.digest())
"""


def test_exposures_are_the_same_on_all_ranks_and_paths() -> None:
    assert len(set(on_all_paths(EVERYWHERE))) == 3


def test_a_lens_blurs_a_solid_like_a_particle() -> None:
    def row(aperture: float, objects: Any = (), sprite: motes.Sprite | None = None) -> NDArray[np.float64]:
        camera = motes.Camera((0, 0, 6), (0, 0, 0), focus=3, aperture=aperture)
        renderer = motes.Renderer(200, 150, camera=camera, objects=list(objects), linear=True)
        world = motes.World(seed=1, renderer=renderer, progress="off")
        system = world.system("s", sprite=sprite)
        with world:
            if sprite is not None:
                system.emit(position=[(0, 0, 0)], size=[(1, 1, 1)], color=[(0.8, 0.8, 0.8)])
            picture = world.render().linear
        assert picture is not None
        light = picture.astype(float)[:, :, 0].sum(0)
        return light / light.sum()

    for aperture in (0.1, 0.5):
        solid = row(aperture, [motes.Solid(shapes.Sphere((0, 0, 0), 0.5), (0.8, 0.8, 0.8))])
        assert (solid > 0).sum() > (row(0, [shapes.Sphere((0, 0, 0), 0.5)]) > 0).sum() + 10 * aperture
        for blend in ("opaque", "alpha"):
            sprite = motes.Sprite("sphere", blend=blend, pixels=None)  # type: ignore[arg-type]
            assert np.abs(row(aperture, sprite=sprite) - solid).sum() < 0.1


@pytest.mark.parametrize("distance", [-1, 1])
def test_smoke_behind_a_moving_ball_is_hidden_for_a_part_of_the_time(distance: float) -> None:
    renderer = motes.Renderer(160, 90, camera=motes.Camera((0, 0, 8), (0, 0, 0)), shutter=1, linear=True)
    world = motes.World(seed=1, dt=1 / 24, renderer=renderer, progress="off")
    ball = world.system("ball", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
    smoke = world.system("smoke", sprite=motes.Sprite("sphere", pixels=None, blend="add"))
    with world:
        ball.emit(position=[(-1, 0, 0)], velocity=[(48, 0, 0)], size=[(1, 1, 1)], color=[(0, 0, 0)])
        smoke.emit(position=[(0, 0, distance)], size=[(0.2, 1, 1)], alpha=[0.5])
        ball.move()
        picture = world.render().linear
    assert picture is not None
    light = float(picture.sum())
    world = motes.World(seed=1, renderer=renderer, progress="off")
    smoke = world.system("smoke", sprite=motes.Sprite("sphere", pixels=None, blend="add"))
    with world:
        smoke.emit(position=[(0, 0, distance)], size=[(0.2, 1, 1)], alpha=[0.5])
        alone = world.render().linear
    assert alone is not None
    # The ball, 1 m wide, passes it in half of the time in which it moves 2 m.
    part = 0.5 if distance < 0 else 1
    assert light == pytest.approx(part * float(alone.sum()), rel=0.05)


def test_blended_cards_and_meshes_are_hidden_as_from_each_point_of_the_lens() -> None:
    """A picture through a lens is the mean of sharp ones, blended things included."""
    around = [(np.sqrt((i + 0.5) / 48), 2.399963 * i) for i in range(48)]
    still = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=45)
    pinholes = [
        motes.Camera((x, y, 5), (0, 0, 0), fov_deg=45)
        for x, y in ((0.2 * r * np.cos(a), 0.2 * r * np.sin(a)) for r, a in around)
    ]

    def picture(camera: motes.Camera, kind: str) -> NDArray[np.float64]:
        facts: dict[str, Any] = {"camera": camera, "linear": True, "sun": (0, 0, 0)}
        world = motes.World(seed=1, progress="off", renderer=motes.Renderer(160, 120, **facts))
        opaque = world.system("opaque", sprite=motes.Sprite("mesh", mesh=QUAD, blend="opaque"))
        look = {"mesh": QUAD} if kind == "mesh" else {"image": SHEET, "facing": "orientation"}
        blended = world.system("blended", sprite=motes.Sprite(kind, blend="alpha", **look))
        with world:
            opaque.emit(position=[(-0.6, 0, 2), (0.9, 0, 0)], size=[(0.5, 1, 1)] * 2)
            blended.emit(
                position=[(-0.5, 0, 0), (0.5, 0.2, -2), (0, -0.3, 1)],
                size=[((1 if kind == "mesh" else 2) * side, 1, 1) for side in (0.8, 0.6, 0.2)],
                alpha=[0.7] * 3,
                color=[(1, 0.2, 0.1), (0.1, 1, 0.2), (0.2, 0.1, 1)],
            )
            return np.asarray(world.render().linear, float)

    for kind in ("mesh", "image"):
        wanted = np.mean([picture(p, kind) for p in pinholes], axis=0)
        lens = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=45, focus=5, aperture=0.4)
        seen = picture(lens, kind)
        blur = np.abs(picture(still, kind) - wanted).mean()
        assert blur > 0.002
        assert np.abs(seen - wanted).mean() < 0.25 * blur
