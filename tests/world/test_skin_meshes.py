"""Surfaces of particles as meshes: closed, in their place, the same for any ranks, threads and widths."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from same_bits import widths
from standing import on_ranks

import motes
from motes import ArgumentError, Mesh

SCENE = Path(__file__).parents[1] / "scenes" / "surfaces.py"


@cache
def alone() -> list[str]:
    """Return the surfaces on one rank."""
    lines = on_ranks(1, SCENE, "{}").lines
    assert len(set(lines)) == len(lines) == 3
    return lines


@pytest.mark.parametrize("ranks", [2, 3, 5])
@pytest.mark.parametrize("settings", [{"roles": "shared", "space": (-2, 2)}, {"fan_out": 2}], ids=str)
def test_any_ranks(ranks: int, settings: dict[str, Any]):
    assert on_ranks(ranks, SCENE, json.dumps(settings)).lines == alone()


def test_any_threads():
    env = {"MOTES_THREADS": "3", "MOTES_GRAIN": "100"}
    assert on_ranks(1, SCENE, "{}", env=env).lines == alone()


@pytest.mark.parametrize("width", widths())
def test_any_vector_width(width: str):
    assert on_ranks(1, SCENE, "{}", env={"MOTES_SIMD": width}).lines == alone()


def surface(positions: ArrayLike, cell: float, radius: float | None = None, **world: Any) -> Mesh:
    """Return the surface of particles at these positions."""
    scene = motes.World(progress="off", **world)
    water = scene.system("water")
    with scene:
        water.emit(position=positions)
        scene.step()
        return water.surface(cell, radius=radius)


def volume(mesh: Mesh) -> float:
    """Return the volume inside, m^3."""
    corners = mesh.vertices.astype(np.float64)[mesh.triangles]
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6


def is_closed(mesh: Mesh) -> bool:
    """Return whether each edge belongs to two triangles of the same orientation."""
    corners = mesh.triangles.astype(np.int64)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    there, back = edges @ (1 << 32, 1), edges @ (1, 1 << 32)
    return len(np.unique(there)) == len(there) and np.array_equal(np.sort(there), np.sort(back))


def lattice(*counts: int) -> NDArray[np.float64]:
    """Return places 1 m apart."""
    return np.stack(np.meshgrid(*map(np.arange, counts)), -1).reshape(-1, 3).astype(float)


def test_a_particle_alone_is_a_ball():
    mesh = surface([(0.3, -0.2, 0.1)], 0.1, 1)
    away = np.linalg.norm(mesh.vertices - np.float32((0.3, -0.2, 0.1)), axis=1)
    assert away.max() < 1.005 and away.min() > 0.98
    assert is_closed(mesh)
    assert abs(volume(mesh) / (4 / 3 * np.pi) - 1) < 0.02


def test_a_block_is_flat_half_a_spacing_outside():
    mesh = surface(lattice(9, 9, 9), 0.25, 0.5)
    inner = (mesh.vertices[:, :2] > 1).all(axis=1) & (mesh.vertices[:, :2] < 7).all(axis=1)
    top = mesh.vertices[inner & (mesh.vertices[:, 2] > 4), 2]
    assert len(top) > 100 and (abs(top - 8.5) < 0.1).all()
    assert is_closed(mesh)
    assert abs(volume(mesh) / 9**3 - 1) < 0.02


@pytest.mark.parametrize("cell", [0.5, 0.25])
def test_a_ball_of_particles_has_its_volume(cell: float):
    places = lattice(25, 25, 25) - 12
    ball = places[np.linalg.norm(places, axis=1) < 10.5]
    mesh = surface(ball, cell, 0.5)
    assert is_closed(mesh)
    assert abs(volume(mesh) / (4 / 3 * np.pi * 10.5**3) - 1) < 0.02


def test_random_particles_have_a_closed_surface():
    rng = np.random.default_rng(3)
    mesh = surface(rng.normal(size=(2000, 3)) * 3, 0.4)
    assert is_closed(mesh) and volume(mesh) > 0
    assert mesh.contains([(0, 0, 0), (50, 0, 0)]).tolist() == [True, False]


def test_a_periodic_border_closes_the_surface():
    places = [(0.1, 0, 0), (9.9, 0, 0)]
    mesh = surface(places, 0.1, 0.4, periodic={"x": (0, 10)})
    assert is_closed(mesh)
    assert abs(volume(mesh) / (2 * 4 / 3 * np.pi * 0.4**3) - 1) < 0.06


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"cell": "fine"}, "cell must be a number"),
    ({"cell": np.nan}, "cell must be a finite number"),
    ({"cell": 0}, "radius must be 1e-09..1e.09"),
    ({"cell": 0.1, "radius": "big"}, "radius must be a number"),
    ({"cell": 0.1, "radius": -1}, "radius must be"),
    ({"cell": 0.1, "radius": 4}, r"cell must be 0.25..8, got 0.1"),
    ({"cell": 3, "radius": 1}, r"cell must be 0.0625..2, got 3"),
    ({"cell": 1e-6, "radius": 1e-6}, r"cell must be large enough for a grid of at most 536870912 nodes"),
]


@pytest.mark.parametrize(("arguments", "message"), WRONG, ids=str)
def test_wrong_arguments(arguments: dict[str, Any], message: str):
    with pytest.raises(ArgumentError, match=message):
        surface([(20, 0, 0)], **arguments)


def test_a_grid_that_would_not_fit_is_refused():
    rng = np.random.default_rng(4)
    with pytest.raises(ArgumentError, match=r"cell must be large enough .* \(2 GB\).*, got 0.01"):
        surface(rng.uniform(-50, 50, (40_000, 3)), 0.01, 0.1)


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_a_saved_surface_is_read_back(tmp_path: Path, suffix: str):
    mesh = surface(lattice(3, 3, 3), 0.5)
    mesh.save(tmp_path / f"water{suffix}")
    again = Mesh.load(tmp_path / f"water{suffix}")
    assert np.array_equal(again.vertices, mesh.vertices) and np.array_equal(again.triangles, mesh.triangles)
    mesh.at((1, 2, 3), axis=(0, 0, 1), angle_deg=90).save(tmp_path / f"turned{suffix}")
    turned = Mesh.load(tmp_path / f"turned{suffix}").vertices
    assert np.allclose(turned, mesh.vertices[:, [1, 0, 2]] * (-1, 1, 1) + (1, 2, 3), atol=1e-5)


def test_a_saved_surface_is_a_usd_mesh(tmp_path: Path):
    usd = pytest.importorskip("pxr.Usd")
    geometry = pytest.importorskip("pxr.UsdGeom")
    mesh = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], colors="red", uv=[(0, 0), (1, 0), (0, 1)])
    mesh.save(tmp_path / "mesh.usd")
    stage = usd.Stage.Open(str(tmp_path / "mesh.usd"))
    read = geometry.Mesh(stage.GetDefaultPrim())
    assert np.array_equal(read.GetPointsAttr().Get(), mesh.vertices)
    assert list(read.GetFaceVertexIndicesAttr().Get()) == [0, 1, 2]
    assert np.allclose(read.GetDisplayColorAttr().Get(), mesh.colors)


def test_a_mesh_is_saved_whole_or_not_at_all(tmp_path: Path):
    mesh = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    with pytest.raises(ArgumentError, match=r"path must be a name ending in .obj, .glb, .usd, got"):
        mesh.save(tmp_path / "mesh.stl")
    (tmp_path / "target").write_text("kept")
    (tmp_path / "mesh.obj").symlink_to(tmp_path / "target")
    mesh.save(tmp_path / "mesh.obj")
    assert (tmp_path / "target").read_text() == "kept"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mesh.obj", "target"]


def test_no_particles_have_no_surface():
    with pytest.raises(ArgumentError, match="system must be one with particles: without any"):
        surface(np.zeros((0, 3)), 0.1)
