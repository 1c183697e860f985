"""Meshes, solids, lights and renderer arguments: what is accepted, and what is refused at the call."""

from __future__ import annotations

import numpy as np
import pytest
from plain_values import CORNERS, FACES, INF, LEAF, NAN, equal_and_immutable

import motes
from motes import shapes
from motes.errors import ArgumentError

CAMERA = motes.Camera((0, 0, 5), (0, 0, 0))


# --- meshes


def test_meshes_are_values():
    mesh = motes.Mesh(CORNERS, FACES)
    equal_and_immutable(mesh, motes.Mesh(np.array(CORNERS, float), np.array(FACES)))
    assert mesh != motes.Mesh(CORNERS, FACES[:3])
    assert (mesh.vertices.dtype, mesh.triangles.dtype) == (np.float32, np.uint32)
    assert repr(mesh) == "<Mesh of 4 vertices, 4 triangles>"
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 1


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (CORNERS, [(0, 1, 4)], r"triangles\[0\] must be indices of the 4 vertices, 0..3, got \[0, 1, 4\]"),
        (CORNERS, [(0, 1, 2), (0, -1, 2)], r"triangles\[1\] must be indices"),
        (CORNERS, [], "triangles must be"),
        (CORNERS, [(0, 1)], "triangles must be"),
        (CORNERS, [0, 1, 2], "triangles must be"),
        (CORNERS, [(0.0, 1.0, 2.0)], "triangles must be"),
        (CORNERS, [(True, False, True)], "triangles must be"),
        (CORNERS, "triangles", "triangles must be"),
        (CORNERS, [(0, 1, 2**40)], r"triangles\[0\] must be"),
        ([(0, 0, 0), (1, 0, 0), (0, NAN, 0)], [(0, 1, 2)], r"vertices\[2\] must be finite"),
        ([(0, 0, 0), (1e300, 0, 0), (0, 1, 0)], [(0, 1, 2)], r"vertices\[1\] must be finite"),
        ([(0, 0), (1, 0), (0, 1)], [(0, 1, 2)], "vertices must be"),
        ([], [(0, 1, 2)], "vertices must be"),
        (None, [(0, 1, 2)], "vertices must be"),
    ],
)
def test_a_broken_mesh_is_refused_at_the_call(vertices, triangles, message):
    with pytest.raises(ArgumentError, match=message):
        motes.Mesh(vertices, triangles)


def test_a_file_is_read_by_text_or_path_with_a_scale(tmp_path):
    path = tmp_path / "box.OBJ"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 3 0\nf 1 2 3\n")
    assert motes.Mesh.load(path).measure == 1.5
    mesh = motes.Mesh.load(str(path), scale=2, resolution=16)
    assert mesh.vertices.max(axis=0).tolist() == [2, 6, 0] and mesh.resolution == 16


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("rock.fbx", b"", "a name ending in .obj, .ply, .stl, .glb"),
        ("rock.obj", None, "an existing file"),
        ("rock.ply", b"no mesh", "a mesh that can be read"),
        ("rock.glb", b"glTF", "a mesh that can be read"),
        ("rock.obj", b"v 0 0 0\n", "must be"),
    ],
)
def test_a_file_without_a_mesh_is_refused(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(ArgumentError, match=message):
        motes.Mesh.load(tmp_path / name)


# --- solids, lights, and the renderer's arguments


def test_solids_and_lights_are_values():
    mesh = motes.Mesh(CORNERS, FACES)
    equal_and_immutable(motes.Solid(mesh, (1, 0, 0), light=2), motes.Solid(mesh, (1, 0, 0), 2))
    equal_and_immutable(motes.Light((0, 1, 0), power=3), motes.Light((0, 1), (1, 1, 1), 3))
    assert repr(motes.Light((0, 1, 0))) == "Light(position=(0.0, 1.0, 0.0))"
    assert motes.Light((0, 1, 0)) != motes.Light((0, 1, 0), power=2)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: motes.Solid("rock"), "shape"),
        (lambda: motes.Solid(motes.shapes.Point((0, 0, 0))), "shape"),
        (lambda: motes.Solid(motes.Mesh(CORNERS, FACES), light=-1), "light"),
        (lambda: motes.Solid(motes.Mesh(CORNERS, FACES), light=NAN), "light"),
        (lambda: motes.Light((0, NAN, 0)), "position"),
        (lambda: motes.Light((0, 1, 0), (1, -1, 0)), "color"),
        (lambda: motes.Light((0, 1, 0), power=-1), "power"),
        (lambda: motes.Light((0, 1, 0), power=INF), "power"),
    ],
)
def test_what_is_no_solid_or_light_is_refused_at_the_call(make, name):
    with pytest.raises(ArgumentError, match=f"^{name} must be"):
        make()


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"shutter": 4.1}, "shutter"),
        ({"shutter": -0.1}, "shutter"),
        ({"shutter": NAN}, "shutter"),
        ({"sun": (0, NAN, 0)}, "sun"),
        ({"lights": [(0, 1, 0)]}, "lights"),
        ({"lights": motes.Light((0, 1, 0))}, "lights"),
        ({"objects": [LEAF]}, "objects"),
        ({"path": "tile"}, "path"),
        ({"smooth": 1}, "smooth"),
        ({"layers": "depth"}, "layers"),
        ({"layers": ["depht"]}, "layers"),
        ({"layers": [1]}, "layers"),
        ({"layers": 7}, "layers"),
    ],
)
def test_what_a_renderer_cannot_use_is_refused_at_the_call(arguments, name):
    with pytest.raises(ArgumentError, match=f"^{name} must be"):
        motes.Renderer(64, 48, camera=CAMERA, **arguments)
    renderer = motes.Renderer(64, 48, camera=CAMERA)
    with pytest.raises(ArgumentError, match=f"^{name} must be"):
        setattr(renderer, name, arguments[name])


def test_layers_have_one_order_and_suggest_near_names():
    renderer = motes.Renderer(64, 48, camera=CAMERA, layers=["velocity", "depth", "depth"])
    assert renderer.layers == ("depth", "velocity")
    with pytest.raises(ArgumentError, match="did you mean 'velocity'"):
        renderer.layers = ["velocty"]


def test_a_plane_is_hidden_by_its_own_distance_at_the_horizon():
    # The middle row meets the plane beyond 1e18 m.
    camera = motes.Camera((0, 1000, 1e5), (0, 1000 - 1.2e-13, 0))
    background = (0.1, 0.2, 0.3)
    renderer = motes.Renderer(
        33,
        65,
        camera=camera,
        objects=[shapes.Plane((0, 0, 0), (0, 1, 0))],
        background=background,
        linear=True,
        smooth=False,
    )
    world = motes.World(seed=1, renderer=renderer, progress="off")
    with world:
        light = world.render().linear
    assert light[32] == pytest.approx(np.broadcast_to(background, light[32].shape), abs=1e-3)
