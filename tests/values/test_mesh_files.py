"""Mesh files: each feature yields the right area, volume and bounds, or is refused by name."""

from __future__ import annotations

import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from written_meshes import CUBE, QUADS, SOLID_L, TRIANGLES, Glb, obj, ply, stl

import motes
from motes._meshes import polygons
from motes.errors import ArgumentError, MissingExtraError

ONE = (6, 1, (0, 0, 0), (1, 1, 1))
"""A cube: area, volume, bounds."""
L_SHAPE = (14, 3, (0, 0, -2), (2, 1, 0))
THREE_CUBES = (18, 3, (0, 0, 0), (7, 1, 1))
Wanted = tuple[float, float | None, Any, Any] | str

# --- text and binary formats

SQUARE = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0), (1, 1, 0), (1, 3, 0), (3, 3, 0), (3, 1, 0)]
KEYHOLE = [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)]
STRAIGHT = ([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (3, 3, 0), (0, 3, 0)], [(0, 1, 2, 3, 4, 5)])
STAR = [
    (np.sin(k * np.pi / 5) * r, np.cos(k * np.pi / 5) * r, 0.25)
    for k in range(10)
    for r in ((1, 0.4)[k % 2],)
]
STAR_AREA = 10 * np.sin(np.pi / 5) * 0.4 / 2
FAR = np.array(SOLID_L[0]) @ np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]) + (100, 200, 300)
SPLIT = (
    "v 0 0 0\nv 1 0 0 # a corner\nv 1 1 \\\n0\nv 0 1 0 0.5 0.5 0.5\n"
    "f 1/1/1 2//2 \\\n  3/3 -1\nl 1 2\np 1\ng part\n"
)
STRIPS = (
    b"ply\r\nformat ascii 1.0\r\nelement vertex 5\r\n"
    b"property double x\r\nproperty double y\r\nproperty double z\r\n"
    b"element tristrips 1\r\nproperty list int int vertex_indices\r\nend_header\r\n"
    b"0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 0\n9 0 1 2 3 -1 2 3 4 -1\n"
)


def three_cubes(*, relative: bool) -> bytes:
    """Return three cubes, each with its faces after its vertices, as programs append them."""
    if relative:
        return b"\n".join(obj(CUBE + (3 * k, 0, 0), QUADS, relative=True) for k in range(3))
    rows = [(CUBE + (3 * k, 0, 0), [[i + 8 * k for i in quad] for quad in QUADS]) for k in range(3)]
    return b"\n".join(obj(points, faces) for points, faces in rows)


TEXTS: dict[str, tuple[str, bytes, Wanted]] = {
    "quads": (".obj", obj(CUBE, QUADS), ONE),
    "appended parts": (".obj", three_cubes(relative=False), THREE_CUBES),
    "appended parts, relative": (".obj", three_cubes(relative=True), THREE_CUBES),
    "concave faces": (".obj", obj(*SOLID_L), L_SHAPE),
    "concave faces, relative": (".obj", obj(*SOLID_L, relative=True), L_SHAPE),
    "concave faces, far away and turned": (".obj", obj(FAR, SOLID_L[1]), (14, 3, None, None)),
    "a face with a hole": (".obj", obj(SQUARE, KEYHOLE), (12, None, (0, 0, 0), (4, 4, 0))),
    "a star": (".obj", obj(STAR, [range(10)]), (STAR_AREA, None, None, None)),
    "a concave quad": (
        *(".obj", obj([(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)], [(0, 1, 2, 3)])),
        (1, None, (0, 0, 0), (2, 2, 0)),
    ),
    "corners on straight edges": (".obj", obj(*STRAIGHT), (9, None, (0, 0, 0), (3, 3, 0))),
    "lines that go on, colours, comments": (".obj", SPLIT.encode(), (1, None, (0, 0, 0), (1, 1, 0))),
    "a face without area": (".obj", obj(CUBE, [*QUADS, (0, 0, 1), (2, 3), (4, 5, 5, 4)]), ONE),
    "vertex 0": (
        ".obj",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
        "line 4: vertex 0 does not exist; vertices are 1 to 3",
    ),
    "a vertex too many": (
        ".obj",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
        "line 4: the face uses vertex 3, counted from 0, of 3",
    ),
    "a vertex too far back": (".obj", b"v 0 0 0\nf -1 -2 -3\n", "line 2: vertex -2 does not exist"),
    "a face that crosses itself": (".obj", obj(CUBE, [(0, 1, 2, 3)]), "line 9: the face crosses itself"),
    "a free-form surface": (
        ".obj",
        obj(CUBE, QUADS) + b"\nsurf 0 1 0 1 1 2\n",
        "free-form surfaces .surf. are not supported",
    ),
    "no number": (".obj", b"v 0 0 0\nv 1,5 0 0\n", "vertex 2, '1,5 0 0', is not 3 numbers"),
    "no face": (".obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n", "it has 2 vertices but no triangles"),
    "text": (".ply", ply(CUBE, QUADS), ONE),
    "little endian, double": (".ply", ply(CUBE, TRIANGLES, "binary_little_endian", kinds="double"), ONE),
    "big endian": (".ply", ply(CUBE, QUADS, "binary_big_endian", name="index"), ONE),
    "faces of different sizes": (".ply", ply(*SOLID_L, "binary_big_endian"), L_SHAPE),
    "concave faces, text": (".ply", ply(*SOLID_L), L_SHAPE),
    "strips": (".ply", STRIPS, (1.5, None, (0, 0, 0), (2, 1, 0))),
    "points alone": (".ply", ply(CUBE, []), "it has 8 vertices but no triangles"),
    "cut off": (".ply", ply(CUBE, QUADS, "binary_little_endian")[:-3], "it is cut off"),
    "a negative vertex": (".ply", ply(CUBE, [(0, 1, -1)]), "face 0 uses vertex -1, counted from 0, of 8"),
    "no format": (".ply", b"ply\nformat binary_mixed 1.0\nend_header\n", "its format is not one of ascii"),
    "binary facets": (".stl", stl(CUBE, TRIANGLES), ONE),
    "binary facets, other name": (".stl", stl(CUBE, TRIANGLES, begin=b"\0made"), ONE),
    "text facets": (".stl", stl(CUBE, TRIANGLES, binary=False), ONE),
    "facets cut off": (".stl", stl(CUBE, TRIANGLES, begin=b"\0made")[:-9], "it holds 11 of 12 triangles"),
    "facets of four": (".stl", stl(CUBE, QUADS, binary=False), "facet 1 has 4 vertices, not 3"),
}

# --- .glb


def glb(**feature: Any) -> bytes:
    """Return a cube as .glb; `feature` sets how vertices and indices are stored, or other entries."""
    file = Glb()
    given = dict(feature)
    points = file.array(given.pop("points", CUBE), given.pop("kind", "f4"), **given.pop("stored", {}))
    corners = file.array(TRIANGLES.reshape(-1), given.pop("corners", "u2"))
    primitive = {"attributes": {"POSITION": points}, "indices": corners}
    more = given.pop("more", None)
    return file.bytes([primitive, *(more(file, primitive) if more else [])], **given)


def square(mode: int, order: tuple[int, ...]) -> Any:
    """Add a square of 1 m2 beside the cube, as a triangle fan or strip."""

    def made(file: Glb, _: Any) -> list[Any]:
        points = file.array([(5, 0, 0), (6, 0, 0), (6, 1, 0), (5, 1, 0)])
        return [{"attributes": {"POSITION": points}, "indices": file.array(order, "u1"), "mode": mode}]

    return made


def sparse(file: Glb, primitive: Any) -> list[Any]:
    where = {"bufferView": file.view(b"\7\0"), "componentType": 5123}
    values = {"bufferView": file.view(np.float32([2, 2, 2]).tobytes())}
    file.accessors[primitive["attributes"]["POSITION"]]["sparse"] = {
        "count": 1,
        "indices": where,
        "values": values,
    }
    return []


def morph(file: Glb, primitive: Any) -> list[Any]:
    primitive["targets"] = [{"POSITION": file.array(CUBE)}, {"NORMAL": 0}]
    return []


def lines(file: Glb, _: Any) -> list[Any]:
    points = file.array([(9, 9, 9), (8, 8, 8)])
    return [{"attributes": {"POSITION": points}, "mode": mode} for mode in (0, 1, 3)]


def skin(file: Glb, primitive: Any) -> list[Any]:
    primitive["attributes"]["JOINTS_0"] = file.array([(0, 1, 0, 0)] * 8, "u1")
    primitive["attributes"]["WEIGHTS_0"] = file.array([(128, 127, 0, 0)] * 8, "u1", normalized=True)
    back = np.eye(4)
    back[3, :3] = (-1, 0, 0)
    file.array(np.stack([back.reshape(-1)] * 2))
    return []


def uncompressed(name: str) -> Any:
    """Add a compression extension to the primitive, which also has uncompressed data."""

    def made(file: Glb, primitive: Any) -> list[Any]:
        primitive["extensions"] = {name: {"bufferView": file.view(bytes(40)), "attributes": {"POSITION": 0}}}
        return []

    return made


def meshopt(file: Glb, primitive: Any) -> list[Any]:
    """Move the positions to a buffer without bytes, like the fallback of compressed data."""
    view = file.views[file.accessors[primitive["attributes"]["POSITION"]]["bufferView"]]
    view.update(buffer=1, byteOffset=0)
    return []


def draco(*, kind: str = "f4") -> bytes:
    library = pytest.importorskip("DracoPy")
    file = Glb()
    packed = library.encode(CUBE.astype(np.float32), TRIANGLES.astype(np.uint32), quantization_bits=14)
    stored = {"componentType": Glb.TYPES[kind], "count": 8, "type": "VEC3"}
    file.accessors = [stored, {"componentType": 5125, "count": 36, "type": "SCALAR"}]
    extension = {
        "KHR_draco_mesh_compression": {"bufferView": file.view(packed), "attributes": {"POSITION": 0}}
    }
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "extensions": extension}
    return file.bytes([primitive], extensionsRequired=["KHR_draco_mesh_compression"])


def instanced() -> bytes:
    def three(file: Glb, _: Any) -> list[Any]:
        file.array([(0, 0, 0), (3, 0, 0), (6, 0, 0)])
        return []

    node = {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}}
    return glb(more=three, nodes=[node], extensionsRequired=["EXT_mesh_gpu_instancing"])


MOVED = (6, 1, (1, 1, 1), (2, 2, 2))
TURNED = {
    "rotation": [0, 0, np.sin(np.pi / 4), np.cos(np.pi / 4)],
    "scale": [2, 1, 1],
    "translation": [5, 0, 0],
}
MATRIX = [0, 2, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]
LONG = (10, 2, (4, 0, 0), (5, 2, 1))
CHARS = np.rint(CUBE * 127)
MESHOPT = {"EXT_meshopt_compression": {"fallback": True}}
JOINTS = [
    {"mesh": 0, "skin": 0, "translation": [50, 0, 0]},
    {"translation": [1, 0, 0]},
    {"translation": [3, 0, 0]},
]
OTHER_SCENE = {
    "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [50, 0, 0]}],
    "scenes": [{"nodes": [0]}, {"nodes": [1]}],
}
GLBS: dict[str, tuple[Any, Wanted]] = {
    "floats": (glb, ONE),
    "32-bit indices": (lambda: glb(corners="u4"), ONE),
    "strides": (lambda: glb(stored={"stride": 32}), ONE),
    "normalised shorts": (
        lambda: glb(points=CUBE * 32767, kind="i2", stored={"stride": 8, "normalized": True}),
        ONE,
    ),
    "normalised chars": (lambda: glb(points=CHARS, kind="i1", stored={"stride": 4, "normalized": True}), ONE),
    "normalised bytes": (
        lambda: glb(points=CUBE * 255, kind="u1", stored={"stride": 4, "normalized": True}),
        ONE,
    ),
    "plain shorts, scaled": (
        lambda: glb(
            points=CUBE * 1000,
            kind="u2",
            stored={"stride": 8},
            nodes=[{"mesh": 0, "scale": [0.001] * 3}],
            extensionsRequired=["KHR_mesh_quantization"],
        ),
        ONE,
    ),
    "sparse": (lambda: glb(more=sparse), (9.708204, None, (0, 0, 0), (2, 2, 2))),
    "weights of a node": (
        lambda: glb(points=CUBE * 0 + 1, more=morph, nodes=[{"mesh": 0, "weights": [1.0, 1.0]}]),
        MOVED,
    ),
    "a fan": (lambda: glb(more=square(6, (0, 1, 2, 3))), (7, None, (0, 0, 0), (6, 1, 1))),
    "a strip": (lambda: glb(more=square(5, (0, 1, 3, 2))), (7, None, (0, 0, 0), (6, 1, 1))),
    "lines and points": (lambda: glb(more=lines), ONE),
    "instances": (instanced, THREE_CUBES),
    "rotation and scale": (lambda: glb(nodes=[{"mesh": 0, **TURNED}]), LONG),
    "a matrix": (lambda: glb(nodes=[{"mesh": 0, "matrix": MATRIX}]), LONG),
    "a mirror": (lambda: glb(nodes=[{"mesh": 0, "scale": [-1, 1, 1]}]), (6, 1, (-1, 0, 0), (0, 1, 1))),
    "children": (
        lambda: glb(nodes=[{"children": [1], **TURNED}, {"mesh": 0}], scenes=[{"nodes": [0]}]),
        LONG,
    ),
    "another scene": (lambda: glb(**OTHER_SCENE), ONE),
    "a skin": (
        lambda: glb(more=skin, nodes=JOINTS, skins=[{"joints": [1, 2], "inverseBindMatrices": 4}]),
        (6, 1, (127 * 2 / 255, 0, 0), (127 * 2 / 255 + 1, 1, 1)),
    ),
    "Draco": (draco, ONE),
    "Draco beside the same without": (lambda: glb(more=uncompressed("KHR_draco_mesh_compression")), ONE),
    "damaged Draco": (
        lambda: draco().replace(b"DRACO", b"DRAC0"),
        "its KHR_draco_mesh_compression is damaged",
    ),
    "meshopt": (
        lambda: glb(extensionsRequired=["EXT_meshopt_compression"]),
        "it requires EXT_meshopt_compression",
    ),
    "meshopt without other bytes": (
        lambda: glb(more=meshopt, buffers=[{"byteLength": 999}, {"byteLength": 96, "extensions": MESHOPT}]),
        "compressed by EXT_meshopt_compression, which is not supported",
    ),
    "an unknown extension": (
        lambda: glb(extensionsRequired=["KHR_any", "ACME_x"]),
        "requires KHR_any, ACME_x, which is not",
    ),
    "an index too large": (lambda: glb(points=CUBE[:7]), "a triangle uses vertex 7, counted from 0, of 7"),
    "version 1": (lambda: glb()[:4] + struct.pack("<I", 1) + glb()[8:], "it is glTF of version 1"),
    "a buffer too short": (lambda: glb()[:-40], "it is cut off"),
    "a circle of nodes": (
        lambda: glb(nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}]),
        "node 0 is part of itself",
    ),
    "a file elsewhere": (
        lambda: glb(buffers=[{"byteLength": 9, "uri": "file:///etc/passwd"}]),
        "only files in the same folder",
    ),
}


def check(path: Path, content: bytes, wanted: Wanted) -> None:
    path.write_bytes(content)
    if isinstance(wanted, str):
        with pytest.raises(
            ArgumentError, match=f"path must be a mesh that can be read .*{wanted}.*got '.*{path.name}'"
        ):
            motes.Mesh.load(path)
        return
    area, volume, low, high = wanted
    mesh = motes.Mesh.load(path)
    assert mesh.measure == pytest.approx(area, rel=1e-4)
    if low is not None:
        np.testing.assert_allclose(
            [mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)], [low, high], atol=1e-4
        )
    if volume is not None:  # given only for closed surfaces with consistent winding
        assert motes.Mesh.load(path, solid=True, resolution=16).measure == pytest.approx(volume, rel=1e-4)


@pytest.mark.parametrize("name", TEXTS)
def test_text_and_binary_files_are_read_right_or_refused(tmp_path, name):
    suffix, content, wanted = TEXTS[name]
    check(tmp_path / f"mesh{suffix}", content, wanted)


@pytest.mark.parametrize("name", GLBS)
def test_glb_files_are_read_right_or_refused(tmp_path, name):
    make, wanted = GLBS[name]
    check(tmp_path / "mesh.glb", make(), wanted)


def test_draco_needs_its_package(tmp_path, monkeypatch):
    (tmp_path / "a.glb").write_bytes(draco())
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(MissingExtraError, match=r"KHR_draco_mesh_compression needs DracoPy.*\.\[mesh\]"):
        motes.Mesh.load(tmp_path / "a.glb")


def test_numbers_that_are_not_finite_name_the_file(tmp_path):
    (tmp_path / "a.obj").write_bytes(b"v 0 0 0\nv 1e400 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(ArgumentError, match=r"vertices\[1\] must be finite.*a\.obj'"):
        motes.Mesh.load(tmp_path / "a.obj")


def test_random_polygons_are_covered_once():
    """A random point lies in one triangle if the polygon contains it, otherwise in none."""
    dice = np.random.default_rng(3)
    for _ in range(60):
        n = int(dice.integers(4, 40))
        angles = np.sort(dice.uniform(0, 2 * np.pi, n))
        if np.diff([*angles, angles[0] + 2 * np.pi]).max() > 3 or np.diff(angles).min() < 1e-3:
            continue
        flat = np.stack([np.cos(angles), np.sin(angles)], axis=1) * dice.uniform(0.2, 1, (n, 1))
        axes = np.linalg.qr(dice.normal(size=(3, 3)))[0]
        points = np.c_[flat, np.zeros(n)] @ axes + dice.normal(0, 5, 3)
        triangles = polygons.triangulate(points, np.array([n]), np.arange(n))
        assert len(triangles) == n - 2
        tries = dice.uniform(-1, 1, (300, 2))
        inside = np.zeros(len(tries), bool)
        for a, b in zip(flat, np.roll(flat, -1, axis=0), strict=True):
            above = (a[1] > tries[:, 1]) != (b[1] > tries[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                inside ^= above & (tries[:, 0] < (b[0] - a[0]) * (tries[:, 1] - a[1]) / (b[1] - a[1]) + a[0])
        corners = [flat[triangles[:, k]][:, None] for k in range(3)]
        sides = [
            (q - p)[..., 0] * (tries - p)[..., 1] - (q - p)[..., 1] * (tries - p)[..., 0]
            for p, q in zip(corners, [*corners[1:], corners[0]], strict=True)
        ]
        covered = np.all([side > 0 for side in sides], axis=0).sum(axis=0)
        np.testing.assert_array_equal(covered, inside.astype(int))
