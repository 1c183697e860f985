"""What a .usd stage shows at any time: particles that there were, and none where there were none."""

from __future__ import annotations

import numpy as np
import pytest

import motes
from motes._interchange import formats, usd
from motes._interchange.manifest import Column, FrameParts, Manifest, Part, SystemColumns
from motes.shapes import Disc

pytest.importorskip("pxr")
from pxr import Sdf, Usd, UsdGeom, Vt  # noqa: E402


def points_in(stage):
    return [UsdGeom.Points(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Points)]


@pytest.mark.parametrize("every", [1, 4])
def test_no_particle_is_between_two_others(tmp_path, every):
    """As many die as are born: the same row is another particle in each frame."""
    world = motes.World(seed=7, space=(-3, 3), progress="off")
    system = world.system("drops")
    system.configure(velocity=(0, -2.4, 0), size=motes.Uniform(0.1, 0.2))
    shown = {}
    with world, motes.Export(tmp_path / "a.usd", every=every) as export:
        for frame in world.frames(21):
            system.source(Disc((0, 3, 0), (0, 1, 0), 1), rate=24 * 50)
            system.kill_old(0.3)
            system.move()
            world.step()
            export.write(world)
            shown[frame] = system.gather()
    stage = Usd.Stage.Open(str(tmp_path / "a.usd"))
    (points,) = points_in(stage)
    assert len(shown[16]) == len(shown[20]) and set(shown[16].id) != set(shown[20].id)
    for time in np.arange(12, 20, 0.25):
        frame = int(time) // every * every
        wanted = shown[frame]
        assert (np.array(points.GetIdsAttr().Get(time)) == wanted.id).all(), time
        np.testing.assert_allclose(points.GetPointsAttr().Get(time), wanted.position, rtol=1e-6)
        np.testing.assert_allclose(points.GetWidthsAttr().Get(time), wanted.size[:, 0], rtol=1e-6)
        moved = points.ComputePointsAtTime(time, frame)
        np.testing.assert_allclose(moved, wanted.position + wanted.velocity * (time - frame) / 24, atol=1e-5)


def written(tmp_path, ranks_of, columns=("position", "velocity", "color"), dt=1 / 24):
    """Write a stage of one system: in frame f, each of its ranks r has r + 1 points, whose columns are f."""
    known = [Column(name, 3, (0.0,) * 3, 0) for name in columns]
    manifest = Manifest("usdc", 1, dt, 1, [SystemColumns("s", "s", known)])
    place = formats.place_of("path", tmp_path / "a.usd")
    place.folder.mkdir()
    for frame, ranks in ranks_of.items():
        parts = []
        for rank in ranks:
            arrays = {name: np.full((rank + 1, 3), frame, np.float32) for name in columns}
            arrays["id"] = np.arange(rank + 1, dtype=np.uint64)
            file = place.file("s", frame, rank)
            size = place.write_part(file, arrays, frame=frame, time=0)
            parts.append(Part(0, rank, file, rank + 1, size))
        manifest.frames.append(FrameParts(frame, 0, tuple(parts)))
    place.publish(manifest)
    return Usd.Stage.Open(str(tmp_path / "a.usd"))


def test_a_rank_shows_nothing_in_frames_that_it_did_not_write(tmp_path):
    """As after a rank was lost, or after a run went on with other ranks."""
    ranks_of = {0: [0, 1], 1: [0, 1], 2: [0], 3: [0, 2], 4: [2], 8: [0, 2]}
    stage = written(tmp_path, ranks_of)
    prims = points_in(stage)
    assert [str(prim.GetPath()) for prim in prims] == ["/World/s/s", "/World/s/s_2", "/World/s/s_3"]
    for time in (-1, 0, 0.5, 1, 1.9, 2, 2.5, 3, 3.5, 4, 5, 7.9, 8, 9):
        frame = max(number for number in ranks_of if number <= max(time, 0))
        for rank, prim in enumerate(prims):
            position = np.array(prim.GetPointsAttr().Get(time)).reshape(-1, 3)
            assert len(position) == (rank + 1 if rank in ranks_of[frame] else 0), (time, rank)
            assert (position == frame).all(), (time, rank)
            assert len(prim.GetDisplayColorAttr().Get(time)) == len(position)
            assert len(prim.GetIdsAttr().Get(time)) == len(position)
    bounds = UsdGeom.BBoxCache(2.0, ["default"]).ComputeWorldBound(prims[1].GetPrim())
    assert bounds.GetRange().IsEmpty()


@pytest.mark.parametrize("rate", [24, 49, 60, 93, 23.976, 0.5])
def test_a_stage_has_the_rate_of_the_run(tmp_path, rate):
    stage = written(tmp_path, {0: [0], 8: [0]}, dt=1 / rate)
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == pytest.approx(rate, rel=1e-9)
    assert rate % 1 or stage.GetTimeCodesPerSecond() == rate
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, 8)


def test_quaternions_are_turns_about_the_axis_that_motes_means(tmp_path):
    half = float(np.sqrt(0.5))
    columns = {"position": np.zeros((2, 3), np.float32), "id": np.arange(2, dtype=np.uint64)}
    columns["orientation"] = np.array([(0, half, 0, half), (0, 0, 0, 1)], np.float32)  # x, y, z, w
    (tmp_path / "a.usdc").touch()
    usd.write(tmp_path / "a.usdc", columns, frame=0, time=0)
    layer = Sdf.Layer.OpenAsAnonymous(str(tmp_path / "a.usdc"))
    turn, none = layer.QueryTimeSample("/particles.primvars:orientation", 0)
    assert (turn.GetReal(), tuple(turn.GetImaginary())) == (np.float32(half), (0, np.float32(half), 0))
    assert (none.GetReal(), tuple(none.GetImaginary())) == (1, (0, 0, 0))
    assert str(layer.GetAttributeAtPath("/particles.primvars:orientation").typeName) == "quatf[]"


def test_layers_of_earlier_releases_are_read(tmp_path):
    """They had orientations as float4[], and a primvar of the same name for each attribute of the user."""
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    prim = Sdf.CreatePrimInLayer(layer, "/particles")
    said = {"orientation": np.array([[1, 2, 3, 4]], np.float32), "widths": np.array([5], np.float32)}
    arrays = {"orientation": ("float4[]", Vt.Vec4fArray), "widths": ("float[]", Vt.FloatArray)}
    for name, (kind, array) in arrays.items():
        known = Sdf.AttributeSpec(prim, f"primvars:{name}", Sdf.ValueTypeNames.Find(kind))
        layer.SetTimeSample(known.path, 3.0, array.FromNumpy(said[name]))
    assert layer.Export(str(tmp_path / "a.usdc"))
    read = usd.read(tmp_path / "a.usdc", list(said), frame=3)
    assert all((read[name] == said[name]).all() and read[name].dtype == np.float32 for name in said)


@pytest.mark.parametrize(
    "name", ["displayColor", "displayOpacity", "widths", "normals", "velocities", "points"]
)
def test_attributes_of_the_user_hide_none_of_usds(tmp_path, name):
    world = motes.World(seed=2, progress="off")
    system = world.system("s", attributes={name: (1, 2, 3)})
    with world, motes.Export(tmp_path / "a.usd") as export:
        for _ in world.frames(2):
            system.configure(color=(1, 0, 0), alpha=0.5, size=4, velocity=(7, 8, 9))
            system.burst((5, 5, 5))
            world.step()
            export.write(world)
        shown = system.gather()
    assert (motes.open_particles(tmp_path / "a.usd")[1].columns(name)[name] == (1, 2, 3)).all()
    stage = Usd.Stage.Open(str(tmp_path / "a.usd"))
    (points,) = points_in(stage)
    primvars = UsdGeom.PrimvarsAPI(points)
    assert np.array(points.GetPointsAttr().Get(1)).tolist() == shown.position.tolist()
    assert np.array(points.GetVelocitiesAttr().Get(1)).tolist() == shown.velocity.tolist()
    assert not primvars.HasPrimvar("widths") and not primvars.HasPrimvar("normals")
    assert points.GetWidthsAttr().Get(1)[0] == 4
    assert primvars.GetPrimvar("displayColor").Get(1)[0] == (1, 0, 0)
    assert primvars.GetPrimvar("displayOpacity").Get(1)[0] == 0.5
