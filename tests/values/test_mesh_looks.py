"""What `Mesh.load` keeps besides triangles: normals, texture coordinates, colours and materials."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from written_meshes import CUBE, QUADS, TRIANGLES, Glb

import motes
from motes._values.colors import LINEAR
from motes.errors import ArgumentError

SIDES = np.array([(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)], float)
PLACES = [(0, 0), (1, 0), (1, 1), (0, 1)]
CORNERS = np.array([CUBE[i] for quad in QUADS for i in quad])
OF_SIDES = np.array([t for k in range(0, 24, 4) for t in ((k, k + 1, k + 2), (k, k + 2, k + 3))])
NORMALS = np.repeat(SIDES, 4, axis=0)
PIXELS = np.random.default_rng(5).integers(0, 256, (4, 6, 3), dtype=np.uint8)


def loaded(tmp_path: Path, suffix: str, content: bytes, **options: Any) -> motes.Mesh:
    path = tmp_path / f"mesh{suffix}"
    path.write_bytes(content)
    return motes.Mesh.load(path, **options)


def linear(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    return np.array(LINEAR)[pixels].astype(np.float32)


def cube_obj(vertex: str = "") -> bytes:
    lines = [f"v {x} {y} {z}{vertex}" for x, y, z in CUBE]
    lines += [f"vt {u} {v}" for u, v in PLACES] + [f"vn {x} {y} {z}" for x, y, z in SIDES]
    for side, quad in enumerate(QUADS, 1):
        lines.append("f " + " ".join(f"{i + 1}/{k}/{side}" for k, i in enumerate(quad, 1)))
    return "\n".join(lines).encode()


def check_cube(mesh: motes.Mesh) -> None:
    """Each side has its own normals and the whole picture; together they enclose a cube."""
    assert mesh.normals is not None
    assert mesh.uv is not None
    corners = mesh.vertices[mesh.triangles]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for k in range(3):
        np.testing.assert_allclose(mesh.normals[mesh.triangles[:, k]], facing, atol=1e-6)
    at = mesh.uv[mesh.triangles]
    one, other = at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]
    np.testing.assert_allclose(np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]), 1, atol=1e-6)
    assert motes.Mesh(mesh.vertices, mesh.triangles, solid=True, resolution=16).measure == pytest.approx(1)


def test_an_obj_repeats_vertices_with_several_normals(tmp_path: Path) -> None:
    mesh = loaded(tmp_path, ".obj", cube_obj())
    assert mesh.vertices.shape == (24, 3)
    np.testing.assert_array_equal(mesh.vertices[:8], CUBE)  # vertices keep their numbers
    check_cube(mesh)
    assert mesh.colors is None
    tinted = loaded(tmp_path, ".obj", cube_obj(" 1 0.5 0"))
    np.testing.assert_allclose(tinted.colors, np.tile((1, LINEAR[128], 0), (24, 1)), rtol=1e-6)
    plain = loaded(tmp_path, ".obj", cube_obj(), smooth=True)
    assert plain.normals is None
    assert plain.smooth


def test_an_obj_is_read_in_spite_of_wrong_normals(tmp_path: Path) -> None:
    text = cube_obj().replace(b"vn 1.0 0.0 0.0", b"vn nan 0 0").replace(b"f 1/1/1", b"f 1/99/-77")
    mesh = loaded(tmp_path, ".obj", text)
    assert mesh.measure == pytest.approx(6)
    assert mesh.normals is not None
    assert np.isfinite(mesh.normals).all()
    assert loaded(tmp_path, ".obj", cube_obj().replace(b"vn 1.0", b"vn one")).normals is None


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_a_ply_keeps_what_its_vertices_have(tmp_path: Path, order: str) -> None:
    tints = np.random.default_rng(1).integers(0, 256, (24, 3))
    head = ["ply", f"format {order} 1.0", "element vertex 24"]
    head += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz", "s", "t")]
    head += [f"property uchar {name}" for name in ("red", "green", "blue")]
    head += ["element face 6", "property list uchar int vertex_indices", "end_header", ""]
    floats = np.concatenate([CORNERS, NORMALS, np.tile(PLACES, (6, 1))], axis=1)
    faces = np.arange(24).reshape(6, 4).tolist()
    body: bytes
    if order == "ascii":
        rows = [" ".join(map(str, (*a, *b))) for a, b in zip(floats.tolist(), tints.tolist(), strict=True)]
        body = "\n".join([*rows, *("4 " + " ".join(map(str, face)) for face in faces)]).encode()
    else:
        mark = "<" if "little" in order else ">"
        pairs = zip(floats.tolist(), tints.tolist(), strict=True)
        body = b"".join(struct.pack(f"{mark}8f3B", *a, *b) for a, b in pairs)
        body += b"".join(struct.pack(f"{mark}B4i", 4, *face) for face in faces)
    mesh = loaded(tmp_path, ".ply", "\n".join(head).encode() + body)
    check_cube(mesh)
    np.testing.assert_array_equal(mesh.colors, linear(tints.astype(np.uint8)))


def png(pixels: NDArray[np.uint8]) -> bytes:
    image = pytest.importorskip("PIL.Image")
    stream = io.BytesIO()
    image.fromarray(pixels).save(stream, "PNG")
    return stream.getvalue()


def cube_glb(
    materials: list[dict[str, Any]], images: Any = (), *, nodes: Any = None, split: int = 0
) -> bytes:
    """Return a cube with normals and places; triangles from number `split` on have the second material."""
    file = Glb()
    shared = {
        "POSITION": file.array(CORNERS),
        "NORMAL": file.array(NORMALS),
        "TEXCOORD_0": file.array([(u, 1 - v) for u, v in PLACES] * 6),
    }
    parts = [OF_SIDES[: split or None], *([OF_SIDES[split:]] if split else [])]
    primitives = [
        {"attributes": shared, "indices": file.array(part.reshape(-1), "u2"), "material": number}
        for number, part in enumerate(parts)
    ]
    views = [file.view(png(pixels)) for pixels in images]
    more: dict[str, Any] = {
        "materials": [{"pbrMetallicRoughness": facts} for facts in materials],
        "textures": [{"source": number} for number in range(len(views))],
        "images": [{"bufferView": view, "mimeType": "image/png"} for view in views],
    }
    return file.bytes(primitives, nodes, **more)


def test_a_glb_keeps_its_material(tmp_path: Path) -> None:
    facts = {
        "baseColorFactor": (0.9, 0.6, 0.3, 1),
        "metallicFactor": 0.5,
        "roughnessFactor": 0.25,
        "baseColorTexture": {"index": 0},
        "metallicRoughnessTexture": {"index": 1},
    }
    mesh = loaded(tmp_path, ".glb", cube_glb([facts], [PIXELS, PIXELS[::-1]]))
    check_cube(mesh)
    np.testing.assert_array_equal(mesh.uv, np.tile(PLACES, (6, 1)))
    look = mesh.material
    assert look is not None
    assert (look.color, look.metal, look.roughness) == ((0.9, 0.6, 0.3), 0.5, 0.25)
    np.testing.assert_array_equal(look.image, linear(PIXELS))
    np.testing.assert_allclose(look.finish_image, PIXELS[::-1] / 255, atol=1e-6)
    solid = motes.Solid(mesh)
    assert (solid.color, solid.metal, solid.roughness) == ((0.9, 0.6, 0.3), 0.5, 0.25)
    np.testing.assert_array_equal(solid.image, linear(PIXELS))
    own = motes.Solid(mesh.at((1, 2, 3)), "white")
    assert (own.color, own.metal, own.roughness, own.image) == ((1, 1, 1), 0, 1, None)
    assert motes.Solid(mesh, roughness=0.75).metal == 0.5
    sprite = motes.Sprite("mesh", mesh=mesh)
    assert (sprite.metal, sprite.roughness) == (0.5, 0.25)
    assert motes.Sprite("mesh", mesh=mesh, metal=0, roughness=1).image is not None
    assert solid != motes.Solid(motes.Mesh(mesh.vertices, mesh.triangles, material=look))
    defaults = loaded(tmp_path, ".glb", cube_glb([{}])).material
    assert defaults is not None
    assert (defaults.color, defaults.metal, defaults.roughness) == ((1, 1, 1), 1, 1)


def test_several_materials_become_colours(tmp_path: Path) -> None:
    red = {"baseColorFactor": (1, 0.2, 0.1, 1), "metallicFactor": 0.25, "roughnessFactor": 0.5}
    painted = {"baseColorTexture": {"index": 0}, "metallicFactor": 1}
    green = np.zeros((2, 2, 3), np.uint8)
    green[:] = (0, 255, 0)
    mesh = loaded(tmp_path, ".glb", cube_glb([red, painted], [green], split=8))
    assert mesh.material == motes.shapes.Material((1, 1, 1), 0.5, 0.25)
    assert mesh.colors is not None
    tints = mesh.colors[mesh.triangles]
    np.testing.assert_allclose(tints[:8], np.broadcast_to((1, 0.2, 0.1), (8, 3, 3)), rtol=1e-6)
    np.testing.assert_allclose(tints[8:], np.broadcast_to((0, 1, 0), (4, 3, 3)), atol=1e-6)


def test_normals_of_a_glb_follow_its_nodes(tmp_path: Path) -> None:
    turned = {"mesh": 0, "rotation": [0, np.sqrt(0.5), 0, np.sqrt(0.5)], "translation": [1, 2, 3]}
    for node in (turned, turned | {"scale": [-1, 1, 1]}, turned | {"scale": [1, 3, 1]}):
        mesh = loaded(tmp_path, ".glb", cube_glb([{}], nodes=[node]))
        assert mesh.normals is not None
        corners = mesh.vertices[mesh.triangles].astype(float)
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        facing /= np.linalg.norm(facing, axis=1, keepdims=True)
        np.testing.assert_allclose(mesh.normals[mesh.triangles[:, 0]], facing, atol=1e-5)


def test_damaged_pictures_name_the_file(tmp_path: Path) -> None:
    whole = cube_glb([{"baseColorTexture": {"index": 0}}], [PIXELS])
    start = whole.index(b"\x89PNG")
    with pytest.raises(ArgumentError, match=r"image 0 cannot be read.*mesh\.glb'"):
        loaded(tmp_path, ".glb", whole[:start] + b"\0" * 60 + whole[start + 60 :])


def test_wrong_materials_are_refused() -> None:
    for material in ("brass", 1, {"metal": 1}):
        with pytest.raises(ArgumentError, match=r"material must be a motes\.shapes\.Material"):
            motes.Mesh(CUBE, TRIANGLES, material=material)  # type: ignore[arg-type]
    for facts in (
        {"metal": 2},
        {"roughness": -1},
        {"color": (-1, 0, 0)},
        {"image": 7},
        {"finish_image": PIXELS + 0.5},
    ):
        with pytest.raises(ArgumentError, match=next(iter(facts))):
            motes.shapes.Material(**facts)  # type: ignore[arg-type]


def test_a_material_travels_with_its_mesh() -> None:
    import copy
    import pickle

    look = motes.shapes.Material((0.5, 0.4, 0.3), 0.2, 1, PIXELS)
    mesh = motes.Mesh(CORNERS, OF_SIDES, uv=np.tile(PLACES, (6, 1)), material=look)
    for other in (
        mesh.at((1, 0, 0)),
        mesh.at(vertices=2 * CORNERS),
        copy.copy(mesh),
        pickle.loads(pickle.dumps(mesh)),
    ):
        assert other.material == look
    assert mesh != motes.Mesh(CORNERS, OF_SIDES, uv=np.tile(PLACES, (6, 1)))
    assert pickle.loads(pickle.dumps(look)) == look
