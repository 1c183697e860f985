"""Camera.load and Mesh.load(at=): what other programs animate, at a time."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import motes
from motes import ArgumentError
from motes._values.materials import Material
from motes.shapes import Mesh

FLOAT = 5126
PIECE = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def glb(path, nodes, *, meshes=(), cameras=(), arrays=(), animations=()):
    """Write a file; `arrays`: what accessors hold, float32 or uint32."""
    binary, views, accessors = b"", [], []
    for array in arrays:
        rows = np.asarray(array)
        rows = rows.astype(np.uint32 if rows.dtype.kind in "iu" else np.float32)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": rows.nbytes})
        wide = 1 if rows.ndim == 1 else rows.shape[1]
        kind = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[wide]
        number = 5125 if rows.dtype == np.uint32 else FLOAT
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": number, "type": kind, "count": len(rows)}
        )
        binary += rows.tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "buffers": [{"byteLength": len(binary)}],
    }
    document |= {"bufferViews": views, "accessors": accessors}
    document |= {
        name: list(one)
        for name, one in (("meshes", meshes), ("cameras", cameras), ("animations", animations))
        if one
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        len(text).to_bytes(4, "little")
        + b"JSON"
        + text
        + len(binary).to_bytes(4, "little")
        + b"BIN\0"
        + binary
    )
    path.write_bytes(b"glTF" + (2).to_bytes(4, "little") + (12 + len(chunks)).to_bytes(4, "little") + chunks)
    return path


CORNERS = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0)])
TURN = [(0.0, 0, 0, 1), (0, 0, math.sin(math.pi / 4), math.cos(math.pi / 4))]  # 90 degrees about z


def moving_glb(path, interpolation="LINEAR", target="translation", rows=((0.0, 0, 0), (2, 0, 0))):
    animation = {
        "channels": [{"sampler": 0, "target": {"node": 1, "path": target}}],
        "samplers": [{"input": 2, "output": 3, "interpolation": interpolation}],
    }
    nodes = [{"children": [1]}, {"mesh": 0}]
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    return glb(
        path, nodes, meshes=meshes, arrays=[CORNERS, np.arange(3), [1.0, 3.0], rows], animations=[animation]
    )


@pytest.mark.parametrize(
    ("interpolation", "time", "x"),
    [("LINEAR", 2, 1), ("LINEAR", 0, 0), ("LINEAR", 9, 2), ("STEP", 2.9, 0), ("LINEAR", 1.5, 0.5)],
)
def test_a_node_of_a_glb_is_where_it_is_at_a_time(tmp_path, interpolation, time, x):
    path = moving_glb(tmp_path / "a.glb", interpolation)
    assert Mesh.load(path, at=time).vertices == pytest.approx(CORNERS + (x, 0, 0))
    assert Mesh.load(path).vertices == pytest.approx(CORNERS), "without a time, as it stands"


def test_a_turn_of_a_glb_has_constant_speed(tmp_path):
    path = moving_glb(tmp_path / "a.glb", target="rotation", rows=TURN)
    third = math.radians(30)
    wanted = (math.cos(third), math.sin(third), 0)
    assert Mesh.load(path, at=1 + 2 / 3).vertices[1] == pytest.approx(wanted, abs=1e-6)


def test_a_spline_of_a_glb_follows_its_tangents(tmp_path):
    rows = [(0.0, 0, 0), (0, 0, 0), (3, 0, 0), (0, 0, 0), (2, 0, 0), (0, 0, 0)]
    path = moving_glb(tmp_path / "a.glb", "CUBICSPLINE", rows=rows)
    t = 0.25  # of 2 s: Hermite's polynomial
    x = 2 * (3 * t**2 - 2 * t**3) + 2 * 3 * (t**3 - 2 * t**2 + t)
    assert Mesh.load(path, at=1.5).vertices[0] == pytest.approx((x, 0, 0))


def test_a_camera_of_a_glb_moves_with_its_node(tmp_path):
    animation = {
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}],
        "samplers": [{"input": 0, "output": 1}],
    }
    about_y = [(0.0, 0, 0, 1), (0, math.sin(math.pi / 4), 0, math.cos(math.pi / 4))]
    camera = {"type": "perspective", "perspective": {"yfov": math.radians(50), "znear": 0.2}}
    nodes = [{"children": [1]}, {"camera": 0, "translation": [0, 1, 4]}]
    path = glb(
        tmp_path / "c.glb", nodes, cameras=[camera], arrays=[[0.0, 2.0], about_y], animations=[animation]
    )
    found = motes.Camera.load(path)
    assert found.fov_deg == pytest.approx(50) and found.near == pytest.approx(0.2)
    for time in (0, 0.5, 1, 2, 5):
        angle = math.radians(45 * min(time, 2))
        assert found.position(time) == pytest.approx((4 * math.sin(angle), 1, 4 * math.cos(angle)), abs=2e-4)
        ahead = np.subtract(found.look_at(time), found.position(time))
        assert ahead == pytest.approx((-math.sin(angle), 0, -math.cos(angle)), abs=2e-4)


USD = """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Z"
    startTimeCode = 101
    timeCodesPerSecond = 10
)
def Xform "Top"
{
    double3 xformOp:translate.timeSamples = { 101: (0, 0, 0), 121: (200, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "Sheet"
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points.timeSamples = {
            101: [(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)],
            121: [(0, 0, 100), (100, 0, 100), (100, 100, 100), (0, 100, 100)],
        }
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "faceVarying" )
        color3f[] primvars:displayColor = [(1, 0.5, 0)] ( interpolation = "constant" )
    }
    def Mesh "Hidden"
    {
        token visibility = "invisible"
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (9, 0, 0), (0, 9, 0)]
    }
    def Camera "Eye"
    {
        float focalLength = 5
        float horizontalAperture = 4
        float verticalAperture = 2
        float fStop = 2
        float focusDistance = 300
        float2 clippingRange = (10, 1000)
    }
}
"""


def test_a_usd_is_read_at_a_time_in_metres_with_y_up(tmp_path):
    pytest.importorskip("pxr")
    path = tmp_path / "a.usda"
    path.write_text(USD)
    for time, (x, up) in {0: (0, 0), 1: (1, 0.5), 2: (2, 1)}.items():
        mesh = Mesh.load(path, at=time)
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        assert low == pytest.approx((x, up, -1), abs=1e-6) and high == pytest.approx((x + 1, up, 0), abs=1e-6)
        assert len(mesh.triangles) == 2 and mesh.colors is not None and mesh.uv is not None
        assert mesh.colors == pytest.approx(np.tile((1, 0.5, 0), (4, 1)))
        normal = np.cross(
            *(mesh.vertices[mesh.triangles[0, k]] - mesh.vertices[mesh.triangles[0, 0]] for k in (1, 2))
        )
        assert normal[1] > 0
    assert Mesh.load(path).vertices[:, 1] == pytest.approx(0), "without a time, its first one"


def test_a_camera_of_a_usd_keeps_its_lens(tmp_path):
    pytest.importorskip("pxr")
    path = tmp_path / "a.usda"
    path.write_text(USD)
    found = motes.Camera.load(path)
    assert found.fov_deg == pytest.approx(2 * math.degrees(math.atan(0.2))) and found.focus == pytest.approx(
        3
    )
    assert found.aperture == pytest.approx(0.005 / 2) and found.near == pytest.approx(0.1)
    assert found.position(1) == pytest.approx((1, 0, 0), abs=1e-6)
    assert found.look_at(1) == pytest.approx((1, -3, 0), abs=1e-6) and found.up == pytest.approx((0, 0, -1))


def test_what_was_exported_comes_back(tmp_path):
    pytest.importorskip("pxr")
    way = motes.Curve([(0, (3, 2, 5)), (1, (-2, 3, 6))])
    camera = motes.Camera(way, (0, 0.5, 0), fov_deg=motes.Curve([(0, 30), (1, 50)]), focus=5, aperture=0.1)
    piece = Mesh(PIECE, FACES)
    renderer = motes.Renderer(160, 90, camera=camera)
    world = motes.World(renderer=renderer, progress="off", seed=1)
    with world, motes.Export(tmp_path / "shot.usd", scene=True) as files:
        for frame in world.frames(13):
            renderer.objects = [
                motes.Solid(piece.at((0, frame / 24, 0)), color=(0.5, 0.2, 0.1), roughness=0.25)
            ]
            world.step()
            files.write(world)
    found = motes.Camera.load(tmp_path / "shot.usd")
    for time in (0, 1 / 24, 0.25, 0.5):
        assert found.position(time) == pytest.approx(way(time), abs=1e-5)
        assert found.fov_deg(time) == pytest.approx(camera.fov_deg(time), abs=1e-4)
        ahead = np.subtract(found.look_at(time), found.position(time))
        wanted = np.subtract((0, 0.5, 0), way(time))
        assert ahead / 5 == pytest.approx(wanted / np.linalg.norm(wanted), abs=1e-5)
        mesh = Mesh.load(tmp_path / "shot.usd", at=time)
        assert mesh.vertices == pytest.approx(piece.vertices + np.float32([0, time, 0]), abs=1e-6)
    assert found.focus == pytest.approx(5) and found.aperture(0.25) == pytest.approx(0.1, rel=1e-5)
    assert mesh.material.color == pytest.approx((0.5, 0.2, 0.1)) and mesh.material.roughness == 0.25


SKINNED = """#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
    startTimeCode = 10
    timeCodesPerSecond = 10
)
def SkelRoot "Body"
{
    double3 xformOp:translate = (0, 0, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Skeleton "Bones" ( prepend apiSchemas = ["SkelBindingAPI"] )
    {
        uniform token[] joints = ["root", "root/arm"]
        uniform matrix4d[] bindTransforms = [
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (1, 0, 0, 1)),
        ]
        uniform matrix4d[] restTransforms = [
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (1, 0, 0, 1)),
        ]
        rel skel:animationSource = </Body/Bones/Walk>
        def SkelAnimation "Walk"
        {
            uniform token[] joints = ["root/arm"]
            float3[] translations = [(1, 0, 0)]
            half3[] scales = [(1, 1, 1)]
            quatf[] rotations.timeSamples = { 10: [(1, 0, 0, 0)], 20: [(0.70710678, 0, 0, 0.70710678)] }
        }
    }
    def Mesh "Skin" ( prepend apiSchemas = ["SkelBindingAPI"] )
    {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (2, 0, 0), (1.5, 0, 1)]
        int[] primvars:skel:jointIndices = [0, 0, 1, 1, 0, 1] (
            elementSize = 2
            interpolation = "vertex"
        )
        float[] primvars:skel:jointWeights = [1, 0, 1, 0, 0.5, 0.5] (
            elementSize = 2
            interpolation = "vertex"
        )
        matrix4d primvars:skel:geomBindTransform = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))
        rel skel:skeleton = </Body/Bones>
    }
}
"""


def test_bones_of_a_usd_move_its_skin(tmp_path):
    pytest.importorskip("pxr.UsdSkel")
    path = tmp_path / "walk.usda"
    path.write_text(SKINNED)
    rest = np.array([(0, 0, 3), (2, 0, 3), (1.5, 0, 4)])
    assert Mesh.load(path).vertices == pytest.approx(rest)
    assert Mesh.load(path, at=0).vertices == pytest.approx(rest)
    # The arm is turned by 90 degrees about z at (1, 0); the last corner is half the arm's.
    turned = np.array([(0, 0, 3), (1, 1, 3), (1.25, 0.25, 4)])
    assert Mesh.load(path, at=1).vertices == pytest.approx(turned, abs=1e-5)
    assert Mesh.load(path, at=9).vertices == pytest.approx(turned, abs=1e-5)
    half = math.sqrt(0.5)
    assert Mesh.load(path, at=0.5).vertices[1] == pytest.approx((1 + half, half, 3), abs=1e-3)
    assert path.read_text() == SKINNED


def test_pictures_of_a_surface_come_back(tmp_path):
    pytest.importorskip("pxr")
    numbers = np.random.default_rng(1).integers(1, 256, (4, 8, 3), np.uint8)
    finish = np.random.default_rng(2).integers(0, 256, (2, 4, 3), np.uint8)
    look = Material((0.9, 0.8, 0.7), 0.75, 0.5, numbers, finish)
    uv = [(0, 0), (1, 0), (0, 1), (0.25, 0.75)]
    piece = Mesh(PIECE, FACES, uv=uv, material=look)
    eye = motes.Camera((0, 1, 5), (0, 0, 0))
    renderer = motes.Renderer(160, 90, camera=eye, objects=[motes.Solid(piece)])
    world = motes.World(renderer=renderer, progress="off", seed=1)
    with world, motes.Export(tmp_path / "shot.usd", scene=True) as files:
        for _ in world.frames(2):
            world.step()
            files.write(world)
    found = Mesh.load(tmp_path / "shot.usd", at=0)
    assert found.material.color == pytest.approx(look.color) and found.material.metal == 0.5
    assert found.material.roughness == 0.75
    assert found.material.image == pytest.approx(look.image, abs=2e-3)
    assert found.material.finish_image[:, :, 1:] == pytest.approx(look.finish_image[:, :, 1:], abs=1e-6)
    corners = {(*place, *st) for place, st in zip(PIECE, uv, strict=True)}
    assert {
        (*place, *st) for place, st in zip(found.vertices.tolist(), found.uv.tolist(), strict=True)
    } == corners


def test_what_cannot_be_read_is_said(tmp_path):
    still = moving_glb(tmp_path / "a.glb")
    with pytest.raises(ArgumentError, match="it has no camera"):
        motes.Camera.load(still)
    with pytest.raises(ArgumentError, match="at must"):
        Mesh.load(still, at="now")
    with pytest.raises(ArgumentError, match="path"):
        motes.Camera.load(tmp_path / "none.glb")
    with pytest.raises(ArgumentError, match=r"\.glb, \.usd"):
        motes.Camera.load(tmp_path / "a.fbx")
    triangle = tmp_path / "a.obj"
    triangle.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(ArgumentError, match="at must be left out"):
        Mesh.load(triangle, at=0)
    damaged = tmp_path / "b.glb"
    damaged.write_bytes(still.read_bytes()[:-40])
    with pytest.raises(ArgumentError, match="cut off"):
        motes.Camera.load(damaged)
    flat = {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 0.1}}
    with pytest.raises(ArgumentError, match="orthographic"):
        motes.Camera.load(glb(tmp_path / "c.glb", [{"camera": 0}], cameras=[flat]))
    pytest.importorskip("pxr")
    nothing = tmp_path / "a.usda"
    nothing.write_text("#usda 1.0\ndef Nothing")
    for load in (motes.Camera.load, Mesh.load):
        with pytest.raises(ArgumentError, match="path"):
            load(nothing)
