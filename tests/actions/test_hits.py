"""Hits noted in columns, and surfaces of several shapes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from acting import SOLIDS, after, cloud
from standing import assert_goes_on, on_ranks

import motes
from motes import actions, shapes
from motes.errors import ArgumentError
from motes.expressions import column

GROUND = shapes.Plane((0, 0, 0), (0, 1, 0))
FALLING = {"position": [(0, 0.5, 0), (0, 9, 0)], "velocity": [(3, -10, 0), (0, -10, 0)]}


@pytest.mark.parametrize("name", SOLIDS)
def test_what_notes_hits_moves_as_without(name: str):
    state = cloud(3000, scale=2)
    state["velocity"] *= 8
    plain = after(state, actions.Bounce(SOLIDS[name], 0.8, 0.1), actions.Move(), frames=3)
    noted = after(state, actions.Bounce(SOLIDS[name], 0.8, 0.1, hits=True), actions.Move(), frames=3)
    assert noted.position.tobytes() == plain.position.tobytes()
    assert noted.velocity.tobytes() == plain.velocity.tobytes()
    assert noted.hit.any() and not plain.hit.any()
    lengths = np.linalg.norm(noted.hit_normal, axis=1)
    np.testing.assert_allclose(lengths, np.where(noted.hit > 0, 1, 0), atol=1e-5)
    assert noted.landing.any() and not noted.landing[noted.hit == 0].any()


def test_a_frame_counts_its_hits_and_knows_the_last_normal():
    p = after(FALLING, actions.Bounce(GROUND, hits=True), actions.Move())
    assert p.hit.tolist() == [1, 0] and p.hit_normal.tolist() == [[0, 1, 0], [0, 0, 0]]
    # Into a corner: the floor first, then the wall.
    corner = [GROUND, shapes.Plane((1, 0, 0), (-1, 0, 0))]
    p = after(
        {"position": [(0.5, 0.2, 0)], "velocity": [(9, -9, 0)]},
        actions.Bounce(corner, hits=True),
        actions.Move(),
    )
    assert p.hit.tolist() == [2] and p.hit_normal.tolist() == [[-1, 0, 0]]
    np.testing.assert_allclose(p.position, [(1 - 0.4, 0.9 - 0.2, 0)], atol=1e-5)
    # Between two walls, in 10 sub-steps, by two calls.
    walls = [actions.Bounce(shapes.Plane((x, 0, 0), (-x, 0, 0)), hits=True) for x in (1, -1)]
    state = {"position": [(0, 0, 0)], "velocity": [(101, 0, 0)]}
    p = after(state, *walls, actions.Move(), substeps=10)
    assert p.hit.tolist() == [5] and p.hit_normal.tolist() == [[-1, 0, 0]]


def test_a_mesh_counts_too():
    x, y, z = np.meshgrid((-1, 1), (-1, 1), (-1, 1), indexing="ij")
    corners = np.stack((x, y, z), axis=-1).reshape(-1, 3)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    box = motes.Mesh(corners, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    state = {"position": [(0, 1.5, 0.1), (0, 5, 0)], "velocity": [(0, -10, 0), (0, -10, 0)]}
    p = after(state, actions.Bounce(box, hits=True), actions.Move())
    assert p.hit.tolist() == [1, 0]
    np.testing.assert_allclose(p.hit_normal, [(0, 1, 0), (0, 0, 0)], atol=0.01)
    np.testing.assert_allclose(p.landing[0, :3], (0, 1, 0.1), atol=0.01)
    for way in ((0, 0.2, 0), (0, -0.2, 0), (0.2, 0, 0)):
        p = after(state, actions.Bounce(box.at(way, moving_from=box), hits=True), actions.Move())
        assert p.hit.tolist() == [1, 0] and p.landing[0, 3] == 0, "nothing lands on a surface that moves"


def test_hits_begin_anew_in_each_frame():
    world = motes.World(seed=1, dt=0.1, progress="off", substeps=2)
    s = world.system("all")
    with world:
        for frame in world.frames(4):
            if frame == 0:
                s.emit(**FALLING)
            before = s.gather().hit.tolist() if frame else []
            s.set(mass=10 + column("hit"))
            if frame < 3:
                s.bounce(GROUND, restitution=0, hits=True, where=column("id") == 0)
            s.gravity((0, -1, 0))
            s.move()
            world.step()
            p = s.gather()
            if frame == 0:
                assert p.hit.tolist() == [2, 0] and p.mass.tolist() == [11, 10], "of the first sub-step"
            else:
                assert before[0] > 0 or frame == 3, "what reads between frames sees the last one's"
        assert p.hit.tolist() == [0, 0] and not p.hit_normal.any(), "also without a bounce"


def test_reading_within_a_frame_changes_no_count():
    def run(*, reads: bool, substeps: int) -> str:
        world = motes.World(seed=1, dt=0.1, progress="off", substeps=substeps)
        s = world.system("all")
        with world:
            for frame in world.frames(4):
                if frame == 0:
                    s.burst(shapes.Box((-1, 0, -1), (1, 1, 1)), count=100)
                if reads:
                    with s.local() as p:
                        assert not frame or p.hit.any()
                s.gravity((0, -10, 0))
                s.bounce(GROUND, hits=True)
                if reads:
                    assert s.total(column("hit")) > 0
                s.bounce(shapes.Plane((0, 1, 0), (0, -1, 0)), hits=True)
                s.move()
                world.step()
            return world.digest()

    for substeps in (1, 3):
        assert run(reads=True, substeps=substeps) == run(reads=False, substeps=substeps)


def test_where_protects_the_columns():
    state = {"position": [(0, 0.5, 0)] * 2, "velocity": [(0, -10, 0)] * 2}
    p = after(state, actions.Bounce(GROUND, hits=True, where=column("id") == 1), actions.Move())
    assert p.hit.tolist() == [0, 1] and not p.hit_normal[0].any() and not p.landing[0].any()


def test_only_bounces_set_the_columns():
    world = motes.World(progress="off")
    s = world.system("all")
    with world:
        for name, value in (("hit", 1), ("hit_normal", (0, 1, 0)), ("landing", 1)):
            with pytest.raises(ArgumentError, match="only the engine sets"):
                s.set(**{name: value})
            with pytest.raises(ArgumentError, match="configure"):
                s.configure(**{name: value})
            with pytest.raises(ArgumentError, match="emit"):
                s.emit(position=[(0, 0, 0)], **{name: [value]})
        with pytest.raises(ArgumentError, match="attributes"):
            world.system("other", attributes={"hit": 0.0})


def test_emitted_particles_have_hit_nothing_yet():
    world = motes.World(seed=1, dt=0.1, progress="off")
    s, other = world.system("all"), world.system("other")
    with world:
        s.emit(**FALLING)
        s.bounce(GROUND, hits=True)
        s.move()
        world.step()
        p = s.gather(to="all")
        assert p.hit.any()
        other.emit(p)
        world.step()
        again = other.gather()
        assert not again.hit.any() and again.position.tolist() == p.position.tolist()


# --- several shapes


def test_a_list_is_one_surface():
    parts = [shapes.Box((-1, -1, -1), (0, 0, 1)), shapes.Sphere((0.5, 0, 0), 0.8), GROUND]
    state = cloud(2000, scale=1)
    state["velocity"] *= 10
    for kind, arguments in (
        (actions.Bounce, {}),
        (actions.Avoid, dict(magnitude=1, epsilon=0.1, look_ahead=1)),
    ):
        listed = after(state, kind(parts, **arguments), actions.Move(), frames=4)
        united = after(state, kind(shapes.Union(*parts), **arguments), actions.Move(), frames=4)
        assert listed.position.tobytes() == united.position.tobytes()
        assert kind(parts, **arguments) == kind(tuple(parts), **arguments)
        assert kind(parts[:1], **arguments) == kind(parts[0], **arguments), "of one shape: that shape"
    for inside in (True, False):
        kept = after(state, actions.Sink(parts, inside))
        held = np.any([part.contains(state["position"]) for part in parts], axis=0)
        assert kept.id.tolist() == np.flatnonzero(held != inside).tolist()


def test_nothing_leaks_through_a_corner_of_a_list():
    """Two calls leak: the second knows only the path that the first one left."""
    corner = [shapes.Plane((0, 0, 0), (0, 1, 0)), shapes.Plane((0, 0, 0), (1, 0.2, 0))]
    dice = np.random.default_rng(5)
    start = np.abs(dice.normal(0, 0.3, (5000, 3)))
    state = {"position": start, "velocity": dice.normal(0, 30, (5000, 3))}
    p = after(state, actions.Bounce(corner), actions.Move(), frames=5)
    assert not any(plane.contains(p.position).any() for plane in corner)


WRONG: list[tuple[Any, str]] = [
    (lambda: actions.Bounce([]), "shape must be a shape or 3 finite numbers"),
    (lambda: actions.Bounce([GROUND, "box"]), r"shape\[1\]"),
    (lambda: actions.Bounce([GROUND, [GROUND]]), r"shape\[1\]"),
    (lambda: actions.Bounce([GROUND, (0, 0, 0)]), "have a surface"),
    (lambda: actions.Bounce([GROUND, shapes.Blob((0, 0, 0), 1)]), "have a surface"),
    (lambda: actions.Avoid([GROUND, None], 1, 1, 1), r"shape\[1\]"),
    (lambda: actions.Sink([GROUND, 3.0]), r"shape\[1\]"),
    (lambda: actions.Bounce(GROUND, hits=1), "hits must be True or False"),
    (lambda: actions.Bounce(GROUND, exact_hit=False, hits=True), "hits"),
    (lambda: actions.Bounce([GROUND] * 70000), "65536"),
]


@pytest.mark.parametrize(("make", "message"), WRONG, ids=[message for _, message in WRONG])
def test_wrong_shapes_and_flags_are_named(make: Any, message: str):
    with pytest.raises(ArgumentError, match=message):
        make()


# --- runs


GOES_ON = """
import os, sys, motes
from motes.expressions import column
from motes.shapes import Box, Plane, Sphere

world = motes.World(seed=3, dt=0.05, progress="off", roles="shared", space=(-1, 1), substeps=2,
                    checkpoint=motes.Checkpoint(sys.argv[1], every=2))
s = world.system("all")
with world:
    for frame in world.frames(8):
        noted = s.total(column("hit")), *s.total(column("hit_normal"))  # by the last frame
        if frame >= 4 and world.rank == 0:
            print("digest before", frame, noted, flush=True)
        if os.environ.get("KILL") == str(frame):
            os._exit(9)
        if frame == 0:
            s.burst(Box((-1, 0.2, -1), (1, 1, 1)), count=400)
        s.gravity((0, -10, 0))
        ground, ball = Plane((0, 0, 0), (0, 1, 0)), Sphere((0, 0, 0), 0.5)
        s.bounce([ground, ball], restitution=0.4, friction=0.3, hits=True)
        s.rest(0.4)
        s.move()
        world.step()
        digest = world.digest()
        if frame >= 4 and world.rank == 0:
            print("digest", frame, digest, flush=True)
"""


def test_columns_of_hits_outlive_a_restart(tmp_path: Path):
    assert_goes_on(GOES_ON, tmp_path)


EXPORTED = """
import sys, motes
from motes.shapes import Box, Plane

world = motes.World(seed=3, dt=0.1, progress="off", roles="shared", space=(-1, 1))
s = world.system("all")
export = motes.Export(sys.argv[1])
with world:
    for frame in world.frames(2):
        if frame == 0:
            s.configure(velocity=(0, -10, 0))
            s.burst(Box((-1, 0.2, -1), (1, 2, 1)), count=100)
        s.bounce(Plane((0, 0, 0), (0, 1, 0)), hits=True)
        s.move()
        world.step()
        export.write(world)
        p = s.gather()
        if p:
            print(frame, p.hit.sum(), flush=True)
"""


def test_hits_are_exported(tmp_path: Path):
    lines = on_ranks(2, EXPORTED, tmp_path / "points").lines
    frames = motes.open_particles(tmp_path / "points")
    assert lines == [f"{i} {frames[i].hit.sum()}" for i in range(2)]
    assert frames[0].hit.sum() > 0 and frames[0].hit_normal.shape == (100, 3)
