"""Meshes that deform between frames are swept from shape to shape: as walls of `bounce` and of `contact`."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_meshes import TETRAHEDRON, block, globe
from standing import assert_goes_on, on_ranks

import motes
from motes.errors import ArgumentError

FRAMES = 12


def wing(thickness: float) -> motes.Mesh:
    """A thin plate across the plane z = 0, finely divided along x."""
    xs = np.linspace(-1, 1, 21)
    rim = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    points = np.array([(x, y * thickness / 2, z) for x in xs for z, y in rim])
    first = 4 * np.arange(len(xs) - 1)[:, None, None]
    sides = np.array([[(k, 4 + k, (k + 1) % 4), ((k + 1) % 4, 4 + k, 4 + (k + 1) % 4)] for k in range(4)])
    ends = [(0, 1, 2), (0, 2, 3), *(4 * (len(xs) - 1) + np.array([(0, 2, 1), (0, 3, 2)]))]
    triangles = np.concatenate([(first + sides.reshape(1, -1, 3)).reshape(-1, 3), ends])
    return motes.Mesh(points, triangles, resolution=40)


def flapping(mesh: motes.Mesh, frame: float, amplitude: float, period: float) -> np.ndarray:
    """The vertices of a wing whose tips swing up and down around its middle."""
    angle = amplitude * np.sin(2 * np.pi * frame / period) * np.abs(mesh.vertices[:, 0])
    up = mesh.vertices[:, 1] + angle
    return np.stack([mesh.vertices[:, 0], up, mesh.vertices[:, 2]], axis=1)


@settings(max_examples=12, deadline=None)
@given(
    amplitude=st.floats(0.1, 1.5),
    period=st.floats(5, 24),
    substeps=st.sampled_from([1, 3]),
    restitution=st.sampled_from([0.0, 0.5, 1.0]),
    seed=st.integers(0, 999),
)
def test_nobody_passes_a_wing_however_thin_and_fast(amplitude, period, substeps, restitution, seed):
    """The tips move by many times the wing's thickness in a frame."""
    mesh = wing(0.1)
    world = motes.World(seed=seed, substeps=substeps, progress="off")
    s = world.system("s")
    s.configure(velocity=motes.shapes.Sphere((0, 0, 0), 3))
    with world:
        for frame in world.frames(FRAMES):
            now = mesh.at(vertices=flapping(mesh, frame, amplitude, period))
            if frame == 1:  # the wall of frame 0 is where it moves from
                s.burst(motes.shapes.Box((-0.5, 0.06, -0.3), (0.5, 0.5, 0.3)), 200)
            s.bounce(now, restitution=restitution)
            s.move()
            world.step()
            p = s.gather()
            assert not now.contains(p.position).any()
            if frame == 1:  # nobody has had the time to go around the edges
                x, y, z = p.position.astype(float).T
                below = y < flapping_height(x, frame, amplitude, period)
                assert not (below & (abs(x) < 0.9) & (abs(z) < 0.9)).any()


def flapping_height(x: np.ndarray, frame: float, amplitude: float, period: float) -> np.ndarray:
    return amplitude * np.sin(2 * np.pi * frame / period) * np.abs(x) - 0.05


@pytest.mark.parametrize("substeps", [1, 4])
def test_a_shrinking_vessel_keeps_what_is_inside(substeps):
    points, triangles = globe(20, 30)
    vessel = motes.Mesh(points, triangles, resolution=32)
    world = motes.World(seed=2, substeps=substeps, progress="off")
    s = world.system("s")
    s.configure(velocity=motes.shapes.Sphere((0, 0, 0), 4))
    with world:
        for frame in world.frames(FRAMES):
            if frame == 0:
                s.burst(motes.shapes.Sphere((0, 0, 0), 0.8), 300)
            scale = 1 - 0.05 * frame, 1 + 0.1 * np.sin(frame), 1 - 0.04 * frame
            now = vessel.at(vertices=points * scale)
            s.bounce(now, restitution=0.5, friction=0.2)
            s.move()
            world.step()
            assert now.contains(s.gather().position).all()


@pytest.mark.parametrize("law", ["bounce", "contact"])
def test_a_floor_that_rises_by_its_vertices_is_one_that_moves(law):
    """A translation may be given as a pose or as vertices: particles are carried alike."""
    found = []
    points, triangles = block((-2, -2, -2), (2, 0, 2))
    floor = motes.Mesh(points, triangles, resolution=40)
    for deforms in (False, True):
        world = motes.World(seed=1, substeps=10 if law == "bounce" else 200, progress="off")
        s = world.system("s")
        with world:
            for frame in world.frames(8):
                before, after = (0.3 * np.sin(2 * np.pi * n / 24) for n in (frame, frame + 1))
                place = floor.at((0, after, 0), moving_from=floor.at((0, before, 0)))
                now = floor.at(vertices=points + (0, after, 0)) if deforms else place
                if frame == 1:
                    s.emit(position=[(x, 0.15, z) for x in (-1, 0, 1) for z in (-1, 0, 1)])
                s.gravity((0, -9.81, 0))
                s.bounce(now, restitution=0.2) if law == "bounce" else s.contact(2e4, radius=0.1, walls=[now])
                s.move()
                world.step()
            p = s.gather()
        found.append(np.concatenate([p.position, p.velocity], axis=1))
    rigid, deformed = found
    assert rigid[:, 1].min() > 0.2
    np.testing.assert_allclose(deformed, rigid, atol=0.02)


def test_what_a_wall_moves_from_can_be_said():
    points, triangles = block((-1, -1, -1), (1, 0, 1))
    floor = motes.Mesh(points, triangles)
    before, now = (floor.at(vertices=points + (0, y, 0)) for y in (0, 0.4))
    ends = []
    for wall in (floor.at(vertices=points + (0, 0.4, 0), moving_from=before), now):
        world = motes.World(seed=1, progress="off")
        s = world.system("s")
        with world:
            s.emit(position=[(0, 0.1, 0)])
            s.bounce(wall)
            s.move()
            world.step()
            ends.append(s.gather().position[0, 1])
    assert ends[0] > 0.4  # swept away
    assert ends[1] == np.float32(0.1)  # there was no wall before this one: it appears around the particle


def test_deformed_walls_compare_and_travel():
    points, triangles = block((-1, -1, -1), (1, 0, 1))
    floor = motes.Mesh(points, triangles)
    before = floor.at(vertices=points * 0.9)
    wall = floor.at((0, 1, 0), vertices=points * 1.1, moving_from=before)
    assert wall != floor.at((0, 1, 0), vertices=points * 1.1)
    assert pickle.loads(pickle.dumps(wall)) == wall
    for wrong in (motes.Mesh(*TETRAHEDRON), motes.Mesh(points * 0.9, triangles), "floor", 3):
        with pytest.raises(ArgumentError, match="moving_from.*this mesh at another place"):
            floor.at(vertices=points, moving_from=wrong)
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world, pytest.raises(ArgumentError, match="moving_from.*the same mesh at another place"):
        s.source(wall, 10, moving_from=floor)


SCRIPT = """
import os, sys
import numpy as np
import motes

points = np.array([(x, y, z) for x in (-2, 2) for y in (-1, 0) for z in (-2, 2)], float)
sides = ["023", "031", "457", "476", "015", "054", "267", "273", "046", "062", "137", "175"]
floor = motes.Mesh(points, [[int(digit) for digit in side] for side in sides], resolution=24)
where = motes.Checkpoint(sys.argv[1], every=2) if len(sys.argv) > 1 else None
world = motes.World(seed=4, space=(-2, 2), substeps=4, checkpoint=where, progress="off")
s, grains = world.system("s"), world.system("grains")
with world:
    for frame in world.frames(8):
        if frame == int(os.environ.get("KILL", -1)):
            os._exit(9)
        bend = 0.3 * np.sin(frame + points[:, :1])
        now = floor.at(vertices=points + bend * (0, 1, 0))
        for system in (s, grains):
            if frame == 0:
                system.configure(size=0.05)
                system.burst(motes.shapes.Box((-1, -0.3, -1), (1, 1, 1)), 300)
            system.gravity((0, -9.81, 0))
        s.bounce(now, restitution=0.4)
        grains.contact(500, walls=[now])
        for system in (s, grains):
            system.move()
        world.step()
    world.say("digest " + world.digest())
"""


def test_the_same_bits_on_any_ranks():
    said = {line for n in (1, 2, 3, 5) for line in on_ranks(n, SCRIPT).lines if line.startswith("digest")}
    assert len(said) == 1


def test_a_continued_run_knows_the_last_vertices(tmp_path):
    assert_goes_on(SCRIPT, tmp_path)


def test_the_force_on_a_deforming_wall_is_known_by_its_mesh():
    """A grain at rest on a floor whose vertices do not move any more presses with its weight."""
    points, triangles = block((-1, -1, -1), (1, 0, 1))
    floor = motes.Mesh(points, triangles, resolution=24)
    world = motes.World(seed=1, substeps=400, progress="off")
    s = world.system("s")
    with world:
        for frame in world.frames(30):
            if frame == 0:
                s.emit(position=[(0, 0.1, 0)], mass=[2.0])
            sinks = 0.01 * min(frame, 3)
            s.gravity((0, -9.81, 0))
            s.contact(1e5, restitution=0, radius=0.1, walls=[floor.at(vertices=points - (0, sinks, 0))])
            s.move()
            world.step()
        force = world.force(floor)
    np.testing.assert_allclose(force.force, (0, -2 * 9.81, 0), rtol=1e-3, atol=0.02)
