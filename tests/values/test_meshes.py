"""Meshes as shapes: what they contain, samples, bounces, placement, and the same bits on any ranks."""

from __future__ import annotations

import math
import pickle
from pathlib import Path

import numpy as np
import pytest
from acting import after, length
from hypothesis import given, settings
from hypothesis import strategies as st
from launching import command, python
from made_meshes import block, globe, torus
from standing import COMMAND_LINE, on_ranks

import motes
from motes import actions, shapes
from motes._launch import starting
from motes.errors import ArgumentError

pytestmark = pytest.mark.usefixtures("children_import_tests")

SCENE = Path(__file__).parents[1] / "scenes" / "on_meshes.py"
BALL = motes.Mesh(*globe())
RING = motes.Mesh(*torus(), resolution=64)
# --- containment, measure, samples


def test_unions_conditions_and_births_take_meshes():
    pair = BALL.at((-3, 0, 0)) | shapes.Sphere((3, 0, 0), 1) | RING
    assert pair.contains([(-3, 0, 0), (3, 0, 0), (0, 0, 0), (1, 0, 0)]).tolist() == [True, True, False, True]
    assert pair.measure == pytest.approx(BALL.measure + 4 / 3 * np.pi + RING.measure)
    state = {"position": [(0, 0, 0), (2, 0, 0)]}
    fallen = after(state, actions.Gravity(acceleration=(0, -9, 0), where=~BALL)).velocity[:, 1] < 0
    assert fallen.tolist() == [False, True]
    assert len(after(state, actions.Sink(shape=BALL))) == 1
    world = motes.World(seed=1, progress="off")
    system = world.system("born")
    with world:
        system.configure(velocity=motes.Mesh(*globe(), solid=True))
        system.burst(RING, count=500)
        world.step()
        born = system.gather()
    across = np.hypot(born.position[:, 0], born.position[:, 2]) - 1
    assert np.abs(np.hypot(across, born.position[:, 1]) - 0.4).max() < 0.01
    assert 0.4 < length(born.velocity).mean() < 0.9 and length(born.velocity).max() <= 1


# --- bounces


WALLS = shapes.Box((-1.7, -1.7, -1.7), (1.7, 1.7, 1.7))
PLACED = BALL.at((0.3, -0.2, 0), axis=(1, 2, 0), angle_deg=77)


@pytest.mark.parametrize("shape", [RING, PLACED, RING | WALLS, PLACED | WALLS])
def test_particles_stay_on_their_side_however_fast(shape: shapes.Shape):
    dice = np.random.default_rng(6)
    state = {"position": dice.uniform(-1.6, 1.6, (1500, 3)), "velocity": dice.normal(0, 12, (1500, 3))}
    mesh = shape.shapes[0] if isinstance(shape, shapes.Union) else shape
    start = np.array(mesh.contains(np.float32(state["position"])))
    recorded = [
        actions.OrbitPoint(center=(0.4, 0, 0), magnitude=30, epsilon=0.5),
        actions.Bounce(shape=shape, restitution=0.7, friction=0.05),
        actions.Move(),
    ]
    end = after(state, *recorded, dt=1 / 24, frames=500)
    np.testing.assert_array_equal(mesh.contains(end.position), start)
    assert 50 < start.sum() < 1400 and np.isfinite(end.position).all()
    assert (length(end.velocity) > 0.5).mean() > 0.1, "they still move"
    assert mesh is shape or WALLS.contains(end.position).all()


def test_fast_particles_bounce_off_a_mesh_as_off_the_ball_that_it_shows():
    dice = np.random.default_rng(7)
    way = dice.normal(0, 1, (2000, 3))
    way /= length(way)[:, None]
    state = {"position": -3 * way + dice.uniform(-0.5, 0.5, (2000, 3)), "velocity": 300 * way}
    ball, mesh = (
        after(state, actions.Bounce(shape=shape, restitution=1), actions.Move(), dt=1 / 24)
        for shape in (shapes.Sphere((0, 0, 0), 1), BALL)
    )
    turned = np.einsum("ij,ij->i", ball.velocity, mesh.velocity) / 300**2
    assert np.median(turned) > 0.98, "facets turn the directions a little"
    assert turned.min() > 0.5, "all of them bounce"
    np.testing.assert_allclose(length(mesh.velocity), 300, rtol=1e-4)
    assert (length(mesh.position) > 1).all()


def test_a_particle_comes_to_rest_on_a_mesh():
    table = motes.Mesh(*block((-1, -1, -1), (1, 0, 1)))
    fall = [
        actions.Gravity(acceleration=(0, -10, 0)),
        actions.Bounce(shape=table, restitution=0, friction=0.5),
        actions.Move(),
    ]
    end = after({"position": [(0, 1, 0)], "velocity": [(0.5, 0, 0)]}, *fall, dt=1 / 24, frames=200)
    assert 0 < end.position[0, 1] < 1e-3
    assert length(end.velocity)[0] < 0.1


def test_a_mesh_that_moves_gives_particles_its_velocity():
    plate = motes.Mesh(*block((-1, -0.1, -1), (1, 0.1, 1)), resolution=60)
    world = motes.World(seed=1, dt=0.1, substeps=4, progress="off")
    system = world.system("all")
    with world:
        system.emit(position=[(0.05, 0.35, 0.02), (5, 0, 0)])
        system.bounce(plate.at((0, 0.5, 0), moving_from=plate), restitution=0.5)
        system.move()
        world.step()
        p = system.gather()
    # The top starts at 0.1 and moves at 5 m/s: it hits after half the step; the rebound is 5 + 0.5 * 5 m/s.
    np.testing.assert_allclose(p.velocity, [(0, 7.5, 0), (0, 0, 0)], atol=1e-3)
    np.testing.assert_allclose(p.position[0], (0.05, 0.35 + 7.5 * 0.05, 0.02), atol=2e-3)


def test_a_mesh_that_turns_pushes_by_the_velocity_of_the_place_that_hits():
    bar = motes.Mesh(*block((-2, -0.1, -0.1), (2, 0.1, 0.1)), resolution=120)
    turned = bar.at(axis=(0, 0, 1), angle_deg=6)
    world = motes.World(seed=1, dt=0.01, progress="off")
    system = world.system("all")
    with world:
        system.emit(position=[(1.5, 0.15, 0), (0.5, 0.12, 0), (-1.5, 0.15, 0)])
        system.bounce(turned.at(axis=(0, 0, 1), angle_deg=6, moving_from=bar), restitution=0)
        system.move()
        world.step()
        p = system.gather()
    spin = math.radians(6) / 0.01
    np.testing.assert_allclose(p.velocity[:2, 1], (1.5 * spin, 0.5 * spin), rtol=0.05)
    np.testing.assert_array_equal(p.velocity[2], (0, 0, 0))


def test_a_mesh_that_turns_meets_who_is_on_its_way_alone_or_beside_others():
    """The mesh moves along an arc that leaves the bounding boxes of its start and end."""
    far = motes.Mesh(*block((9.5, -0.3, -0.5), (10.5, 0.3, 0.5)))
    before = far.at(axis=(0, 0, 1), angle_deg=-7.5)
    moved = far.at(axis=(0, 0, 1), angle_deg=7.5, moving_from=before)
    waiting = [(10.48, 0, z) for z in np.linspace(-0.3, 0.3, 16)]
    met = (10.3, 1.2, 0)  # where the arc ends
    speeds = []
    for positions in (waiting, [*waiting[:5], met, *waiting[5:]]):
        world = motes.World(seed=1, progress="off")
        system = world.system("all")
        with world:
            system.emit(position=positions)
            system.bounce(moved, restitution=0.2)
            system.move()
            world.step()
            speeds.append(length(system.gather().velocity))
    assert speeds[0].min() > 70
    np.testing.assert_array_equal(np.delete(speeds[1], 5), speeds[0])


def test_nothing_gets_into_a_mesh_that_moves_through_a_crowd():
    dice = np.random.default_rng(9)
    world = motes.World(seed=1, dt=1 / 24, substeps=2, progress="off")
    system = world.system("all")

    def place(frame: int, before: motes.Mesh | None = None) -> motes.Mesh:
        at = (1.5 * math.sin(frame / 3), 0, 0.7 * math.cos(frame / 5))
        return RING.at(at, axis=(1, 1, 0), angle_deg=21 * frame, moving_from=before)

    with world:
        for frame in world.frames(150):
            if frame == 0:
                start = dice.uniform(-3, 3, (4000, 3))
                system.emit(position=start[~place(0).contains(start)])
            system.bounce(shapes.Sphere((0, 0, 0), 6), restitution=0.5)
            system.bounce(place(frame + 1, place(frame)), restitution=0.5)
            system.move()
            world.step()
        p = system.gather()
    assert len(p) > 2000 and not place(150).contains(p.position).any()
    assert (length(p.velocity) > 0.1).sum() > 500


# --- placement


@settings(max_examples=30, deadline=None)
@given(
    place=st.tuples(*[st.floats(-5, 5)] * 3),
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: sum(x * x for x in v) > 0.01),
    angle=st.floats(-720, 720),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_placed_mesh_is_the_mesh_of_moved_vertices(place, axis, angle, seed):
    moved = RING.at(place, axis=axis, angle_deg=angle)
    unit, turn = np.array(axis) / np.linalg.norm(axis), math.radians(angle)
    skew = np.cross(unit, np.eye(3)).T
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) + math.sin(turn) * skew + (1 - math.cos(turn)) * skew @ skew
    matrix[:3, 3] = place
    points = np.random.default_rng(seed).uniform(-1.5, 1.5, (200, 3))
    near = RING.contains(points) != RING.contains(points * 1.0001)
    there = points @ matrix[:3, :3].T + place
    for mesh in (moved, RING.at(matrix)):
        assert (mesh.contains(there) == RING.contains(points))[~near].mean() > 0.99
        samples = mesh.sample(50, seed)
        wanted = RING.sample(50, seed) @ matrix[:3, :3].T + place
        np.testing.assert_allclose(samples, wanted, atol=2e-5)
        assert mesh.measure == RING.measure
    assert moved.at() == RING and hash(moved.at()) == hash(RING)


def test_placed_meshes_are_values():
    assert shapes.Mesh is motes.Mesh and isinstance(RING, shapes.Shape)
    moved = RING.at((1, 2, 3), axis=(0, 0, 1), angle_deg=90, moving_from=RING)
    copy = pickle.loads(pickle.dumps(moved))
    assert copy == moved != RING.at((1, 2, 3), axis=(0, 0, 1), angle_deg=90)
    assert RING.at(axis=(0, 1e300, 0), angle_deg=90) == RING.at(axis=(0, 1e-300, 0), angle_deg=90)
    assert copy._native == moved._native and hash(copy) == hash(moved)
    assert motes.Mesh(*torus(), resolution=32) != RING != motes.Mesh(*torus(), solid=True, resolution=64)
    assert "solid" in repr(motes.Mesh(*torus(), solid=True))
    half = RING.at(axis=(0, 0, 1), angle_deg=350, moving_from=RING.at(axis=(0, 0, 1), angle_deg=10))
    assert (
        sum(a * b for a, b in zip(half._native.numbers[3:7], half._native.numbers[10:14], strict=True)) > 0.9
    )


# --- refusals


def opened() -> motes.Mesh:
    vertices, triangles = block((0, 0, 0), (1, 1, 1))
    return motes.Mesh(vertices, triangles[:-1])


USES = {
    "contains": lambda mesh: mesh.contains((0, 0, 0)),
    "bounce": lambda mesh: actions.Bounce(shape=mesh),
    "avoid": lambda mesh: actions.Avoid(shape=mesh, magnitude=1, epsilon=1, look_ahead=1),
    "sink": lambda mesh: actions.Sink(shape=mesh),
    "jet": lambda mesh: actions.Jet(shape=mesh, acceleration=(0, 1, 0)),
    "a union": lambda mesh: actions.Bounce(shape=mesh | BALL),
    "solid": lambda mesh: motes.Mesh(mesh.vertices, mesh.triangles, solid=True),
}


@pytest.mark.parametrize("use", USES)
def test_an_open_mesh_is_refused_where_an_inside_is_needed(use: str):
    wrong = r"closed.*got 3 open edges, the first from \(1, 0, 0\) to \(1, 0, 1\)"
    with pytest.raises(ArgumentError, match=wrong):
        USES[use](opened())


def test_an_open_mesh_may_be_sampled_and_drawn():
    points = opened().sample(5000)
    assert opened().measure == 5.5 and ((points >= 0) & (points <= 1)).all()
    actions.RandomVelocity(shape=opened())
    actions.Jet(shape=BALL, acceleration=opened())
    renderer = motes.Renderer(32, 32, camera=motes.Camera((0, 0, 5), (0, 0, 0)), objects=[opened()])
    world = motes.World(seed=1, renderer=renderer, progress="off")
    with world:
        system = world.system("all")
        system.burst(opened(), count=10)
        assert world.render().pixels.max() > 50


def test_an_open_mesh_in_a_condition_is_refused_at_the_call():
    world = motes.World(seed=1, progress="off")
    system = world.system("all")
    with world:
        with pytest.raises(ArgumentError, match="3 open edges"):
            system.gravity((0, -1, 0), where=~opened())
        with pytest.raises(ArgumentError, match="3 open edges"):
            system.spawn(into=system, on="death", count=1, where=opened())
        world.step()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: motes.Mesh(*globe(), resolution=7), "^resolution must be"),
        (lambda: motes.Mesh(*globe(), resolution=513), "^resolution must be"),
        (lambda: motes.Mesh(*globe(), resolution=20.5), "^resolution must be"),
        (lambda: motes.Mesh(*globe(), solid=1), "^solid must be"),
        (lambda: BALL.at("there"), "^place must be"),
        (lambda: BALL.at((0, 0, math.inf)), "^place must be"),
        (lambda: BALL.at((1e13, 0, 0)), "^place must be"),
        (lambda: BALL.at([[1, 2, 3], [4, 5]]), "^place must be"),
        (lambda: BALL.at(np.diag([1, 1, 2, 1])), "^place must be.*only rotates and translates"),
        (lambda: BALL.at(np.diag([1, 1, -1, 1])), "^place must be.*only rotates and translates"),
        (lambda: BALL.at(axis=(0, 0, 0)), "^axis must be"),
        (lambda: BALL.at(angle_deg=math.nan), "^angle_deg must be"),
        (lambda: BALL.at(moving_from=RING), "^moving_from must be this mesh"),
        (lambda: BALL.at(moving_from=(0, 0, 0)), "^moving_from must be this mesh"),
        (
            lambda: actions.Bounce(shape=BALL.at((1, 0, 0), moving_from=BALL) | RING),
            "a mesh that moves: it cannot be part of a union",
        ),
        (lambda: motes.Mesh([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2)]).sample(1), "must have an area"),
    ],
)
def test_what_makes_no_sense_is_refused_at_the_call(make, message):
    with pytest.raises(ArgumentError, match=message):
        make()


# --- pictures, ranks, files


def test_a_placed_mesh_is_drawn_where_it_is():
    vertices, triangles = torus(30, 15)
    turn = math.radians(60)
    matrix = np.array([[math.cos(turn), -math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]])
    there = motes.Mesh(vertices @ matrix.T + (0.3, 0.2, -1), triangles)
    placed = motes.Mesh(vertices, triangles).at((0.3, 0.2, -1), axis=(0, 0, 1), angle_deg=60)
    ground = motes.Solid(shapes.Plane((0, -2, 0), (0, 1, 0)))
    pictures = []
    for mesh in (there, placed, motes.Mesh(vertices, triangles)):
        camera = motes.Camera((0, 1, 5), (0, 0, 0))
        renderer = motes.Renderer(160, 120, camera=camera, objects=[motes.Solid(mesh), ground])
        with motes.World(seed=1, renderer=renderer, progress="off") as world:
            pictures.append(world.render().pixels.astype(int))
    apart = np.abs(pictures[0] - pictures[1]).max(axis=2)
    assert (apart > 8).mean() < 0.01
    assert (np.abs(pictures[0] - pictures[2]).max(axis=2) > 8).mean() > 0.1


@pytest.fixture(scope="module")
def alone() -> list[str]:
    """Return what the scene prints on one rank."""
    lines = on_ranks(1, SCENE, "--digest").lines
    assert len({line.split()[1] for line in lines}) == len({line.split()[2] for line in lines}) == 8
    return lines


def test_the_same_bits_on_any_ranks(alone: list[str]):
    assert on_ranks(3, SCENE, "--digest").lines == alone


@pytest.mark.parametrize("env", [{"MOTES_SIMD": "sse2"}, {"MOTES_SIMD": "avx2"}, {"MOTES_THREADS": "3"}])
def test_the_same_bits_in_any_build_and_on_any_threads(env: dict[str, str], alone: list[str]):
    result = on_ranks(1, SCENE, "--digest", env=env)
    if result.code != 0 and "this processor supports" in result.err:
        pytest.skip("not on this processor")
    assert result.lines == alone


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_recorded_scene_brings_its_meshes(ranks: int, alone: list[str], motes_replay: Path, tmp_path: Path):
    scene = tmp_path / "x.motes"
    on_ranks(1, COMMAND_LINE, "record", "-o", scene, SCENE)
    argv = [str(motes_replay), str(scene), "--digest"]
    assert command(argv if ranks == 1 else starting.command(ranks, argv)).lines == alone
    assert scene.stat().st_size < 400_000, "each mesh is there once"


def test_ranks_with_different_meshes_are_told():
    script = """
import motes
from made_meshes import globe
world = motes.World(seed=1, progress="off")
dust = world.system("dust")
with world:
    dust.bounce(motes.Mesh(*globe(10, 10 + world.rank), resolution=10))
    world.step()
"""
    result = on_ranks(3, script)
    assert result.code != 0 and "ScriptMismatchError" in result.err
    assert "bounce with different arguments" in result.err, result.text


UNITED = """
import motes
from made_meshes import globe
from motes import shapes
world = motes.World(seed=1, progress="off", digest=True, checkpoint=CHECKPOINT)
world.renderer = motes.Renderer(16, 16, camera=motes.Camera((0, 0, 5), (0, 0, 0)))
dust = world.system("dust")
with world:
    for frame in world.frames(6):
        if frame == 0:
            ball = motes.Mesh(*globe(9, 9), solid=True, resolution=16)
            dust.configure(velocity=ball | shapes.Box((1, 1, 1), (2, 2, 2)))
        dust.burst(motes.Mesh(*globe(7, 7), solid=True, resolution=16) | shapes.Point((2, 0, 0)), count=300)
        dust.move()
        motes.script.print_digest(world, world.render())
        END
"""


def test_a_union_with_a_solid_mesh_is_the_same_in_a_run_that_goes_on(tmp_path: Path):
    script = tmp_path / "script.py"
    place = 'motes.Checkpoint(os.environ["PLACE"], every=2)'
    stop = 'frame == int(os.environ["STOP"]) and os._exit(3)'
    script.write_text("import os" + UNITED.replace("CHECKPOINT", place).replace("END", stop))
    whole = on_ranks(1, script, env={"PLACE": str(tmp_path / "whole"), "STOP": "99"}).lines
    part = {"PLACE": str(tmp_path / "part")}
    assert python(script, env={**part, "STOP": "4"}).code == 3
    rest = on_ranks(1, script, env={**part, "STOP": "99"}).lines
    assert 0 < len(rest) < 6 and rest == whole[-len(rest) :]
