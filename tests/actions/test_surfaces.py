"""Bounce and avoid, on every shape that has a surface."""

from __future__ import annotations

import numpy as np
import pytest
from acting import SOLIDS, after, cloud, length

import motes
from motes import actions, shapes


@pytest.mark.parametrize("name", SOLIDS)
def test_bounce_as_mcallister_turns_velocities_alone(name: str):
    state = cloud(2000, scale=2)
    p = after(state, actions.Bounce(shape=SOLIDS[name], restitution=0.5, exact_hit=False), dt=0.2)
    np.testing.assert_array_equal(p.position, np.float32(state["position"]))
    turned = (p.velocity != np.float32(state["velocity"])).any(axis=1)
    assert 20 < turned.sum() < 1500
    assert (length(p.velocity) <= length(np.float32(state["velocity"])) * (1 + 1e-5))[turned].mean() > 0.99
    crossing = actions.Bounce(shape=SOLIDS[name], exact_hit=True)
    met = (after(state, crossing, dt=0.2).velocity != np.float32(state["velocity"])).any(axis=1)
    if name == "Plane":  # McAllister's planes act on both sides
        height = np.float32(state["position"])[:, 1]
        change = np.float32(state["velocity"])[:, 1] * np.float32(0.2)
        np.testing.assert_array_equal(turned, height * (height + change) < 0)
    elif name != "Sphere":
        np.testing.assert_array_equal(turned, met)


@pytest.mark.parametrize("name", SOLIDS)
def test_avoid_turns_away_without_changing_speed(name: str):
    shape = SOLIDS[name]
    state = cloud(3000)
    start = np.float32(state["velocity"])
    v = after(state, actions.Avoid(shape=shape, magnitude=3, epsilon=0.2, look_ahead=0.8)).velocity
    np.testing.assert_allclose(length(v), length(start), rtol=1e-5)
    turned = (v != start).any(axis=1)
    assert 10 < turned.sum() < 2900
    far = after(state, actions.Avoid(shape=shape, magnitude=3, epsilon=0.2, look_ahead=1e-6)).velocity
    assert (far != start).any(axis=1).sum() < 5, "nothing is met so soon"
    none = after(state, actions.Avoid(shape=shape, magnitude=0, epsilon=0.2, look_ahead=0.8)).velocity
    np.testing.assert_allclose(none, start, atol=1e-5)


@pytest.mark.parametrize("name", ["Sphere", "Box", "Cylinder", "Cone", "Union"])
def test_particles_that_avoid_a_shape_do_not_hit_it(name: str):
    dice = np.random.default_rng(2)
    n = 400
    start = np.stack([np.full(n, -6.0), dice.uniform(-0.8, 0.8, n), dice.uniform(-0.8, 0.8, n)], axis=1)
    state = {"position": start, "velocity": np.tile((3.0, 0.0, 0.0), (n, 1))}
    look = actions.Avoid(shape=SOLIDS[name], magnitude=60, epsilon=0.01, look_ahead=1.5)
    hits = []
    for steering in ([], [look]):
        world = motes.World(seed=3, dt=1 / 48, progress="off")
        system = world.system("all")
        entered = np.zeros(n, bool)
        with world:
            for frame in world.frames(150):
                if frame == 0:
                    system.emit(**state)
                system.apply([*steering, actions.Move()])
                world.step()
                entered |= SOLIDS[name].contains(system.gather().position)
        hits.append(entered.sum())
    assert hits[0] > 0.5 * n
    assert hits[1] <= 0.05 * hits[0]


def test_avoid_a_union_as_its_first_part():
    state = cloud(2000)
    options = {"magnitude": 3, "epsilon": 0.2, "look_ahead": 0.8}
    for name in ("Rectangle", "Sphere", "Cone"):
        alone = after(state, actions.Avoid(shape=SOLIDS[name], **options)).velocity
        in_union = after(state, actions.Avoid(shape=shapes.Union(SOLIDS[name]), **options)).velocity
        np.testing.assert_array_equal(alone, in_union)
    near, far = shapes.Rectangle((1, -9, -9), (0, 18, 0), (0, 0, 30)), shapes.Plane((2, 0, 0), (1, 1, 0))
    ahead = {"position": np.zeros((9, 3)), "velocity": np.tile((5.0, 1.0, 0.5), (9, 1))}
    both = after(ahead, actions.Avoid(shape=far | near, **options)).velocity
    np.testing.assert_array_equal(both, after(ahead, actions.Avoid(shape=near, **options)).velocity)
