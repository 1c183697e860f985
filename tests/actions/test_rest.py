"""`rest`: what lies down, how, and what frees it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import motes
from motes import actions, shapes
from motes.errors import ArgumentError
from motes.expressions import column, time

G = (0, -9.8, 0)
GROUND = shapes.Plane((0, 0, 0), (0, 1, 0))
AT_REST = actions.Rest(0.5)


def fronts(p: motes.Particles) -> np.ndarray:
    """Return the particles' own z axes."""
    x, y, z, w = np.float64(p.orientation).T
    return np.stack((2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)), axis=1)


def fallen(
    surface: Any,
    *more: actions.Action,
    rest: actions.Rest = AT_REST,
    frames: int = 40,
    substeps: int = 1,
    **state: Any,
) -> list[motes.Particles]:
    """Let 200 cards fall onto a surface with friction; return them after each frame."""
    world = motes.World(seed=2, dt=1 / 24, substeps=substeps, progress="off")
    s = world.system("cards")
    seen = []
    with world:
        for frame in world.frames(frames):
            if frame == 0:
                s.configure(orientation="random", spin=(1, 2, 3), rotational_velocity=(0, 1, 0), **state)
                s.burst(shapes.Box((-1, 2, -1), (1, 2.5, 1)), count=200)
            s.gravity(G)
            s.apply(list(more))
            s.bounce(surface, restitution=0.2, friction=0.6, hits=True)
            s.apply(rest)
            s.move()
            world.step()
            seen.append(s.gather())
    return seen


SURFACES = {
    "ground": GROUND,
    "roof": [shapes.Plane((0, 0, 0), (1, 1.8, 0)), shapes.Plane((0, 0, 0), (-1, 1.8, 0))],
    "table": shapes.Box((-3, -1, -3), (3, 0.3, 3)),
    "hill": shapes.Sphere((0, -30, 0), 30.5),
}


@pytest.mark.parametrize("substeps", [1, 4])
@pytest.mark.parametrize("name", SURFACES)
def test_what_comes_to_rest_lies_flat_and_stays_to_the_last_bit(name: str, substeps: int):
    seen = fallen(SURFACES[name], substeps=substeps)
    before, p = seen[-6], seen[-1]
    assert (p.hit > 0).all() and not p.velocity.any() and not p.spin.any() and not p.rotational_velocity.any()
    assert p.position.tobytes() == before.position.tobytes()
    assert p.orientation.tobytes() == before.orientation.tobytes()
    flat = np.abs((fronts(p) * p.hit_normal).sum(axis=1))
    np.testing.assert_allclose(flat, 1, atol=1e-5)
    surface = SURFACES[name]
    parts = surface if isinstance(surface, list) else [surface]
    for offset, inside in ((0, False), (2e-3, True)):  # on it, not in it
        below = p.position - np.float32(offset) * p.hit_normal
        assert np.any([part.contains(below) for part in parts], axis=0).all() == inside


def test_a_mesh_holds_what_a_box_does():
    x, y, z = np.meshgrid((-3, 3), (-1, 0.3), (-3, 3), indexing="ij")
    corners = np.stack((x, y, z), axis=-1).reshape(-1, 3)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = motes.Mesh(corners, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    for surface in (mesh, [mesh, shapes.Sphere((9, 0, 0), 1)]):
        seen = fallen(surface)
        p = seen[-1]
        assert not p.velocity.any() and p.position.tobytes() == seen[-6].position.tobytes()
        np.testing.assert_allclose(p.position[:, 1], 0.3, atol=1e-3)
        assert (p.position[:, 1] > 0.3 - 1e-6).all(), "not in it"


def test_cards_turn_the_shortest_way_and_keep_the_angle_that_is_allowed():
    start = fallen(GROUND, frames=1)[0]
    steep = np.arccos(np.abs(fronts(start)[:, 1]))
    for allowed in (0.0, 20.0, 90.0):
        p = fallen(GROUND, actions.Set("spin", (0, 0, 0)), rest=actions.Rest(0.5, allowed))[-1]
        angle = np.arccos(np.clip(np.abs(fronts(p)[:, 1]), 0, 1))
        spun = math.radians(1.1 * math.sqrt(14) * 24)  # by at most one frame's spin before it is set to 0
        wanted = np.minimum(steep, math.radians(allowed))
        assert (np.abs(angle - wanted) < max(spun, 2e-3)).all()
        assert (angle <= math.radians(allowed) + 2e-3).all()
    assert (angle > math.radians(30)).any(), "90 degrees turn nothing"


@pytest.mark.parametrize(("pull", "moves"), [(2.0, False), (30.0, True)])
def test_a_push_frees_it_if_friction_leaves_more_than_the_speed(pull: float, moves: bool):
    push = actions.Gravity((pull, 0, 0), where=time() > 2)
    seen = fallen(GROUND, push, frames=60)
    moved = seen[-1].position - seen[46].position
    assert (moved[:, 0] > 0.1).all() if moves else not moved.any()


def test_what_lifts_it_frees_it_and_it_lies_down_again():
    lift = actions.Gravity((0, 20, 0), where=(time() > 2) & (time() < 2.5))
    seen = fallen(GROUND, lift, frames=120)
    assert not seen[46].velocity.any()
    assert (seen[59].position[:, 1] > 0.5).all() and not seen[59].hit.any()
    assert not seen[-1].velocity.any() and (seen[-1].position[:, 1] < 1e-5).all()


@pytest.mark.parametrize("how", ["moves", "is gone"])
def test_it_is_free_when_what_holds_it_moves_or_is_gone(how: str):
    x, y, z = np.meshgrid((-3, 3), (-1, 0), (-3, 3), indexing="ij")
    corners = np.stack((x, y, z), axis=-1).reshape(-1, 3)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    table = motes.Mesh(corners, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    world = motes.World(seed=2, dt=1 / 24, progress="off")
    s = world.system("cards")
    place = table
    with world:
        for frame in world.frames(60):
            if frame == 0:
                s.burst(shapes.Box((-1, 0.5, -1), (1, 1, 1)), count=100)
            s.gravity(G)
            if frame >= 30 and how == "moves":
                now = table.at((0, 0.01 * (frame - 29), 0))
                place = table.at((0, 0.01 * (frame - 29), 0), moving_from=place)
                s.bounce(place, restitution=0, friction=1, hits=True)
                place = now
            elif frame < 30:
                s.bounce(table, restitution=0, friction=1, hits=True)
            else:
                s.bounce(GROUND if how == "moves" else shapes.Plane((0, -9, 0), (0, 1, 0)), hits=True)
            s.rest(0.3)
            s.move()
            world.step()
            if frame == 29:
                held = s.gather()
                assert not held.velocity.any()
        p = s.gather()
    if how == "moves":
        lifted = p.position - held.position
        np.testing.assert_allclose(lifted, np.broadcast_to((0, 0.3, 0), lifted.shape), atol=5e-3)
        assert (p.position[:, 1] > 0.3 - 1e-5).all(), "carried, and not passed through"
    else:
        assert (p.position[:, 1] < -1).all()


def test_where_chooses_who_rests():
    seen = fallen(GROUND, actions.Gravity((6, 0, 0)), rest=actions.Rest(0.5, where=column("id") % 2 == 0))
    p = seen[-1]
    assert not p.velocity[::2].any() and p.velocity[1::2].any(axis=1).all()


def test_it_needs_a_bounce_that_notes_hits():
    world = motes.World(progress="off")
    s = world.system("all")
    with world:
        for _ in world.frames(2):
            with pytest.raises(ArgumentError, match="recorded after bounce"):
                s.rest(0.1)
            s.bounce(GROUND)
            with pytest.raises(ArgumentError, match="recorded after bounce"):
                s.apply(actions.Rest(0.1))
            s.bounce(GROUND, hits=True)
            s.rest(0.1)
            world.step()


WRONG: list[tuple[Any, str]] = [
    (lambda: actions.Rest(-1), "speed"),
    (lambda: actions.Rest("slow"), "speed"),
    (lambda: actions.Rest(math.nan), "speed"),
    (lambda: actions.Rest(1, 91), "angle_deg"),
    (lambda: actions.Rest(1, -1), "angle_deg"),
    (lambda: actions.Rest(1, angle_deg=(1, 2, 3)), "angle_deg"),
    (lambda: actions.Rest(column("size").x), "speed"),
    (lambda: motes._core.Action("rest", {"speed": -1.0, "angle_deg": 0.0}, []), "speed"),
]


@pytest.mark.parametrize(("make", "message"), WRONG)
def test_wrong_arguments_are_named(make: Any, message: str):
    with pytest.raises(ArgumentError, match=message):
        make()


def test_columns_that_nothing_turns_take_no_memory():
    world = motes.World(progress="off", seed=1)
    s = world.system("flakes")
    with world:
        s.burst((0, 1, 0), count=10)
        s.bounce(GROUND, hits=True)
        s.rest(0.1)
        s.move()
        world.step()
        used = dict(zip(s._state.attributes, s._session.engine.used_attributes(s._state.index), strict=True))
    assert not used["spin"] and not used["rotational_velocity"] and not used["up"]
