"""`Export(scene=True)`: programs see camera, lights, solids and sprites where the picture shows them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from launching import mpirun
from readers.shot_usd import Shot
from standing import on_ranks
from test_read_elsewhere import read_by

import motes
from motes import ArgumentError
from motes._shot.forms import form_of
from motes.expressions import column
from motes.shapes import Box, Cone, Cylinder, Disc, Rectangle, Sphere, Triangle

pytest.importorskip("pxr")
SCENE = Path(__file__).parents[1] / "scenes/usd_shot.py"
FRAMES = 4
CLOUDS = {"grains": "Points", "sparks_of_light": "Points", "water": "Points", "trails": "BasisCurves"}
INSTANCES = ("leaves", "flags", "darts")


@pytest.fixture(scope="module")
def shots(tmp_path_factory):
    """Make the shot on one rank and on three; return both folders."""
    folders = {}
    for ranks in (1, 3):
        folders[ranks] = tmp_path_factory.mktemp(f"ranks{ranks}")
        assert on_ranks(ranks, SCENE, folders[ranks], timeout=180).code == 0
    return folders


def validated(path: Path) -> list[str]:
    from pxr import Usd, UsdValidation

    stage = Usd.Stage.Open(str(path))
    registry = UsdValidation.ValidationRegistry()
    found = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators()).Validate(stage)
    return [f"{one.GetName()}: {one.GetMessage()}" for one in found]


def test_usd_finds_no_fault(shots):
    pytest.importorskip("pxr.UsdValidation")
    assert [validated(folder / "shot.usd") for folder in shots.values()] == [[], []]


def check_same(folder, other, frame):
    """Compare what two shots show of a frame."""
    one, other = (Shot(path / "shot.usd", frame) for path in (folder, other))
    for name, (points, corners) in one.solids().items():
        assert np.array_equal(points, other.solids()[name][0]) and (corners == other.solids()[name][1]).all()
    assert one.solids().keys() == other.solids().keys()
    for system in INSTANCES:
        (first, second) = (shot.instances(system) for shot in (one, other))
        assert first.keys() == second.keys() == set(range(12))
        assert all(np.array_equal(first[number], second[number]) for number in first)
    for system, kind in CLOUDS.items():
        rows = [cloud(shot, system, kind) for shot in (one, other)]
        assert rows[0].keys() == rows[1].keys() == set(range(12))
        assert all(np.array_equal(rows[0][number], rows[1][number]) for number in rows[0])


@pytest.mark.parametrize("frame", range(FRAMES))
def test_any_number_of_ranks_makes_the_same_shot(shots, frame):
    check_same(shots[1], shots[3], frame)


@pytest.mark.parametrize(
    "ranks, again, die",
    [(3, 2, 3), pytest.param(1, 3, 2, marks=pytest.mark.slow), pytest.param(2, 1, 1, marks=pytest.mark.slow)],
)
def test_a_killed_run_goes_on_with_the_same_shot(shots, tmp_path, ranks, again, die):
    text = SCENE.read_text()
    killed = mpirun(ranks, text, tmp_path, "--checkpoints", env={"DIE": str(die)}, timeout=120)
    assert killed.code != 0
    on = mpirun(again, text, tmp_path, "--checkpoints", timeout=120)
    assert on.code == 0 and ("continues with frame" in on.err or die == 1), on.text
    for frame in range(FRAMES):
        check_same(shots[1], tmp_path, frame)
    assert validated(tmp_path / "shot.usd") == []
    kept = [
        {path.name for path in (folder / "shot.usd.parts").iterdir() if ".r0" not in path.name}
        for folder in (shots[1], tmp_path)
    ]
    assert kept[0] == kept[1], "nothing is left behind"


def cloud(shot: Shot, system: str, kind: str) -> dict[int, np.ndarray]:
    """Return positions and widths of each particle by id."""
    found = {}
    for prim in shot.parts(system, kind):
        ids = shot.get(prim, "primvars:id")
        if len(ids) == 0:  # of a rank that only the first start had
            continue
        counts = np.ones(len(ids), int) if kind == "Points" else shot.get(prim, "curveVertexCounts")
        rows = np.column_stack([shot.get(prim, "points"), shot.get(prim, "widths")])
        found |= dict(zip(ids.tolist(), np.split(rows, np.cumsum(counts)[:-1]), strict=True))
    return found


# --- against the picture


WIDE, HIGH = 400, 240
WHERE = {
    "ball": Sphere((0.3, 0.4, 0), 0.7),
    "pipe": Cylinder((-0.8, -0.5, 0.2), (0.6, 0.9, -0.3), 0.5, 0.2),
    "cone": Cone((0.2, 1, 0.3), (-0.1, -0.8, 0), 0.6),
    "ring": Disc((0, 0, 0), (0.3, 1, 0.5), 1, 0.4),
    "card": Rectangle((-1, -0.4, 0.2), (1.8, 0.2, 0), (0.2, 1, 0.4)),
    "wedge": Triangle((-1, -0.5, 0), (1, -0.3, 0.4), (0.1, 0.9, -0.2)),
    "crate": Box((-0.7, -0.4, -0.5), (0.5, 0.6, 0.8)),
}


def camera() -> motes.Camera:
    return motes.Camera((1.5, 1.2, 3.5), (0.1, 0.1, 0), up=(0.2, 1, 0.1), fov_deg=38)


def export(folder, *, solids=(), sprite=None, **columns):
    """Export a frame of one system and return its picture and its shot."""
    renderer = motes.Renderer(WIDE, HIGH, camera=camera(), objects=solids, sun=(0, 0, 0))
    world = motes.World(seed=3, renderer=renderer, progress="off")
    system = world.system("dots", sprite=sprite)
    with world, motes.Export(folder / "shot.usd", scene=True) as files:
        for _ in world.frames(1):
            if columns:
                system.emit(**columns)
            picture = world.render()
            files.write(world)
            pixels = np.array(picture.pixels)
    return pixels, Shot(folder / "shot.usd", 0)


def box_of(pixels) -> np.ndarray:
    """Return the first and last column and row with light, px."""
    rows, columns = np.nonzero(pixels.max(axis=2) > 12)
    return np.array([columns.min(), columns.max() + 1, rows.min(), rows.max() + 1])


def bounds(points) -> np.ndarray:
    low, high = points.min(axis=0), points.max(axis=0)
    return np.array([low[0], high[0], low[1], high[1]])


@pytest.mark.parametrize("name", WHERE)
def test_a_solid_is_within_a_pixel_of_where_it_is_drawn(tmp_path, name):
    glowing = motes.Solid(WHERE[name], color=(1, 1, 1), light=1)
    pixels, shot = export(tmp_path, solids=[glowing])
    ((points, _),) = shot.solids().values()
    assert np.abs(bounds(shot.pixels(points)) - box_of(pixels)).max() < 1


@pytest.mark.parametrize("name", WHERE)
def test_solids_are_right_side_out_on_axes_at_right_angles(name):
    form = form_of(WHERE[name])
    points, triangles, normals = form.make()
    corners = points[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volume = (corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    axes = form.place[:3, :3]
    assert volume >= -1e-9 and np.linalg.det(axes) > 0
    assert axes.T @ axes == pytest.approx(np.diag(np.square(axes).sum(axis=0)), abs=1e-12), "no shear"
    if normals is not None:
        shown = (across * normals[triangles].mean(axis=1)).sum(axis=1)
        assert (shown > -1e-9).all() and shown.max() > 0


PIECE = motes.shapes.Mesh(
    [(-0.2, -0.3, 0), (0.5, 0, 0.1), (0, 0.6, -0.1), (0, 0, 0.4)],
    [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)],
)
CARD = np.full((4, 8, 4), 255, np.uint8)
TURN = dict(velocity=[(1, 2, -0.5)], up=[(0.3, 0.2, 1)], orientation=motes.euler([20], [40], [60]))
SPRITES = {
    "mesh": motes.Sprite("mesh", mesh=PIECE, blend="opaque"),
    "mesh along": motes.Sprite("mesh", mesh=PIECE, blend="opaque", facing="velocity"),
    "card": motes.Sprite("image", image=CARD, blend="opaque", facing="orientation"),
    "card along": motes.Sprite("image", image=CARD, blend="opaque", facing="velocity"),
    "card of pixels": motes.Sprite("image", image=CARD, blend="opaque", facing="orientation", pixels=60),
    "picture": motes.Sprite("image", image=CARD, pixels=50, blend="opaque"),
    "picture of metres": motes.Sprite("image", image=CARD, pixels=None, blend="opaque"),
    "picture of height": motes.Sprite("image", image=CARD, height=0.2, blend="opaque"),
}


@pytest.mark.parametrize("name", SPRITES)
def test_an_instance_is_within_a_pixel_of_where_it_is_drawn(tmp_path, name):
    columns = dict(position=[(0.3, 0.1, 0.2)], size=[(0.8, 0.8, 0.8)], **TURN)
    pixels, shot = export(tmp_path, sprite=SPRITES[name], **columns)
    (corners,) = shot.instances("dots").values()
    assert np.abs(bounds(shot.pixels(corners)) - box_of(pixels)).max() < 1.2
    centre = shot.pixels(corners).mean(axis=0)
    ((prim,),) = (shot.parts("dots", "PointInstancer"),)
    assert shot.get(prim, "primvars:displayColor").tolist() == [[1, 1, 1]]
    assert np.isfinite(centre).all()


@pytest.mark.parametrize(
    "sprite",
    [
        motes.Sprite("sphere", pixels=None, blend="opaque"),
        motes.Sprite("sphere", pixels=40, blend="opaque"),
        motes.Sprite("sphere", height=0.2, blend="opaque"),
    ],
)
def test_points_are_as_wide_as_they_are_drawn(tmp_path, sprite):
    pixels, shot = export(tmp_path, sprite=sprite, position=[(0.3, 0.1, 0.2)], size=[(0.5, 0.5, 0.5)])
    (prim,) = shot.parts("dots", "Points")
    middle, (width,) = shot.get(prim, "points"), shot.get(prim, "widths")
    right = np.array(shot.places.GetLocalToWorldTransform(shot.cameras[0]))[0, :3]
    radius = (shot.pixels(middle + right * width / 2) - shot.pixels(middle))[0, 0]
    (x, y), box = shot.pixels(middle)[0], box_of(pixels)
    assert np.abs(box - [x - radius, x + radius, y - radius, y + radius]).max() < 1


@pytest.mark.parametrize("pick", ["random", "age", column("mass")])
def test_instances_show_the_picture_that_the_film_shows(tmp_path, pick):
    colors = np.array([(255, 0, 0), (0, 255, 0), (0, 0, 255)])
    cards = [np.full((4, 4, 4), (*color, 255), np.uint8) for color in colors]
    sprite = motes.Sprite("image", image=cards, pixels=9, blend="opaque", pick=pick)
    x, y = np.meshgrid(np.linspace(-1.2, 1.2, 10), np.linspace(-0.8, 0.8, 6))
    columns = dict(position=np.stack([x, y, 0 * x], -1).reshape(-1, 3), age=np.linspace(0, 2, 60))
    pixels, shot = export(
        tmp_path, sprite=sprite, lifetime=np.full(60, 2.0), mass=np.arange(60) % 3, **columns
    )
    (prim,) = shot.parts("dots", "PointInstancer")
    at = np.floor(shot.pixels(shot.get(prim, "positions"))).astype(int)
    seen = pixels[at[:, 1], at[:, 0]].astype(int)
    shown = shot.get(prim, "protoIndices")
    _, middle, brightest = np.sort(seen, axis=1).T
    clear = brightest > middle + 30  # two pictures are not blended half and half there
    assert clear.sum() > 20 and len(set(shown[clear].tolist())) == 3
    assert (seen.argmax(axis=1) == shown)[clear].all()


def test_a_camera_with_a_lens_arrives(tmp_path):
    from pxr import UsdGeom

    eye = motes.Camera((0, 1, 5), (0, 0, 0), fov_deg=50, near=0.2, focus=4, aperture=0.05)
    world = motes.World(renderer=motes.Renderer(90, 160, camera=eye, shutter=0.5), progress="off", seed=1)
    with world, motes.Export(tmp_path / "shot.usd", scene=True) as files:
        for _ in world.frames(2):
            world.step()
            files.write(world)
    shot = Shot(tmp_path / "shot.usd", 1)
    found = UsdGeom.Camera(shot.cameras[0]).GetCamera(1)
    assert found.GetFieldOfView(type(found).FOVVertical) == pytest.approx(50, abs=1e-4)
    assert found.aspectRatio == pytest.approx(90 / 160) and found.focusDistance == 4
    # The lens is as wide as it says: focal lengths are in tenths of the stage's units.
    assert found.focalLength / 10 / found.fStop == pytest.approx(0.05)
    assert shot.get(shot.cameras[0], "shutter:open") == -0.5
    assert found.clippingRange.min == pytest.approx(0.2)


def test_a_later_start_keeps_the_scene_and_its_files(tmp_path):
    def start(frames, depth):
        renderer = motes.Renderer(64, 48, camera=camera())
        world = motes.World(
            seed=3, renderer=renderer, progress="off", checkpoint=motes.Checkpoint(tmp_path / "kept", every=2)
        )
        system = world.system("dots")
        with world, motes.Export(tmp_path / "shot.usd", scene=True) as files:
            for frame in world.frames(frames):
                renderer.objects = [
                    motes.Solid(Sphere((frame, 0, 0), 1)),
                    motes.Solid(PIECE.at((0, frame, 0))),
                ]
                if frame == 0:
                    system.emit(position=[(0, 0, 0)])
                world.step()
                files.write(world)
        return json.loads((tmp_path / "shot.usd.parts/manifest.json").read_text())

    first, again = start(3, 1), start(6, 2)
    assert [frame["frame"] for frame in again["frames"]] == list(range(6))
    assert again["frames"][0] == first["frames"][0]
    for frame in range(6):
        points, _ = Shot(tmp_path / "shot.usd", frame).solids()["Sphere_1"]
        assert points.mean(axis=0) == pytest.approx([frame, 0, 0], abs=0.02)
    assert len(motes.open_particles(tmp_path / "shot.usd")) == 6


def test_what_is_wrong_with_a_scene_is_said(tmp_path):
    with pytest.raises(ArgumentError, match="scene"):
        motes.Export(tmp_path / "shot.usd", scene="yes")
    with pytest.raises(ArgumentError, match=r"scene.*\.usd"):
        motes.Export(tmp_path / "shot", scene=True)
    with pytest.raises(ArgumentError, match="vdb"):
        motes.Export(tmp_path / "smoke.vdb")
    world = motes.World(progress="off", seed=1)
    export = motes.Export(tmp_path / "shot.usd", scene=True)
    with world:
        world.step()
        with pytest.raises(ArgumentError, match="renderer"):
            export.write(world)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("version", ["4.5", "5.0"])
def test_blender_places_the_shot_where_the_film_shows_it(shots, tmp_path, version):
    read_by(f"blender-{version}", "blender_shot.py", shots[3] / "shot.usd", tmp_path / "read.npz", 1, 2, 3)
    found: dict[str, list[np.ndarray]] = {}
    for key, points in np.load(tmp_path / "read.npz").items():
        frame, name, _ = key.split("|")
        found.setdefault(f"{frame}|{name.split('.')[0]}", []).append(points)
    for frame in (1, 2, 3):
        shot = Shot(shots[3] / "shot.usd", frame)
        for name, (points, _) in shot.solids().items():
            if name != "Plane_1":  # whose corners are behind the camera
                (read,) = found[f"{frame}|{name}"]
                assert np.abs(bounds(read) - bounds(shot.pixels(points))).max() < 1, (frame, name)
        for system in INSTANCES:
            wanted = [shot.pixels(corners).mean(axis=0) for corners in shot.instances(system).values()]
            parts = [rows for key, rows in found.items() if key.startswith(f"{frame}|{system}")]
            read = [points.mean(axis=0) for rows in parts for points in rows if len(points)]
            assert len(read) == len(wanted) == 12
            apart = np.linalg.norm(np.array(read)[:, None] - np.array(wanted), axis=2)
            assert apart.min(axis=0).max() < 1 and apart.min(axis=1).max() < 1, (frame, system)
        for system, kind in CLOUDS.items():
            wanted = shot.pixels(np.concatenate(list(cloud(shot, system, kind).values()))[:, :3])
            parts = [rows for key, rows in found.items() if key.startswith(f"{frame}|{system}")]
            read = np.concatenate([points for rows in parts for points in rows])
            apart = np.linalg.norm(read[:, None] - wanted, axis=2)
            assert len(read) == len(wanted) and apart.min(axis=0).max() < 1, (frame, system)
