"""Orientations: how they start, turn and are aligned, against rotations in double precision."""

from __future__ import annotations

import math

import numpy as np
import pytest
from acting import after, cloud
from numpy.typing import NDArray

import motes
from motes import actions, shapes
from motes.errors import ArgumentError

Array = NDArray[np.float64]
AXES = np.eye(3)


def turned(q: Array, v: Array) -> Array:
    """Rotate vectors by unit quaternions of shape (n, 4)."""
    q = np.asarray(q, np.float64)
    u, w = q[:, :3], q[:, 3:]
    v = np.broadcast_to(v, u.shape)
    across = 2 * np.cross(u, v)
    return v + w * across + np.cross(u, across)


def rotated(v: Array, way: Array) -> Array:
    """Rotate `v` about the axes `way`, by their lengths in radians (Rodrigues)."""
    angle = np.linalg.norm(way, axis=1, keepdims=True)
    axis = way / angle
    along = axis * (axis * v).sum(axis=1, keepdims=True)
    return along + np.cos(angle) * (v - along) + np.sin(angle) * np.cross(axis, v)


def born(n: int = 20000, **state: object) -> motes.Particles:
    world = motes.World(seed=5, progress="off")
    system = world.system("all")
    with world:
        for _ in world.frames(1):
            system.configure(**state)
            system.burst((0, 0, 0), count=n)
            world.step()
        return system.gather()


@pytest.mark.parametrize("steps", [1, 7, 60])
def test_spin_turns_about_the_axes_of_the_world(steps: int) -> None:
    dice = np.random.default_rng(1)
    q = dice.normal(size=(200, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    spin = dice.normal(0, 4, (200, 3))
    state = {"position": np.zeros((200, 3)), "orientation": q, "spin": spin}
    p = after(state, actions.Move(), dt=1.0, substeps=steps)
    for axis in AXES:
        np.testing.assert_allclose(turned(p.orientation, axis), rotated(turned(q, axis), spin), atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(p.orientation, axis=1), 1, atol=2e-7)
    still = after(state, actions.Move(rotational=False))
    np.testing.assert_array_equal(still.orientation, np.float32(q))


def test_random_orientations_point_everywhere_alike() -> None:
    p = born(orientation="random")
    np.testing.assert_allclose(np.linalg.norm(p.orientation, axis=1), 1, atol=2e-7)
    for axis in AXES:
        front = turned(p.orientation, axis)
        np.testing.assert_allclose(front.mean(axis=0), 0, atol=0.02)
        np.testing.assert_allclose(front.T @ front / len(p), AXES / 3, atol=0.02)
    angle = 2 * np.arccos(np.abs(np.float64(p.orientation[:, 3])))
    assert abs(angle.mean() - (math.pi / 2 + 2 / math.pi)) < 0.02, "of the uniform measure"


def test_orientation_is_given_or_none() -> None:
    np.testing.assert_array_equal(born(3).orientation, [(0, 0, 0, 1)] * 3)
    np.testing.assert_allclose(born(3, orientation=(0, 3, 0, 4)).orientation, [(0, 0.6, 0, 0.8)] * 3)
    for wrong in ("upright", (0, 0, 0, 0), (0, 0, 1), 1.0, (0, 0, 0, math.nan), shapes.Sphere((0, 0, 0), 1)):
        with pytest.raises(ArgumentError, match="orientation"):
            born(1, orientation=wrong)


@pytest.mark.parametrize("rate", [math.inf, 2.0, 0.0])
def test_align_turns_the_front_by_the_shortest_way(rate: float) -> None:
    state = cloud(300)
    state["velocity"][0] = 0
    q = np.random.default_rng(2).normal(size=(300, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    state["orientation"] = q
    p = after(state, actions.Align(rate=rate), dt=0.25)
    wanted = np.float64(state["velocity"][1:])
    wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
    before, now = turned(q, AXES[2])[1:], turned(p.orientation, AXES[2])[1:]
    angle = np.arccos(np.clip((before * wanted).sum(axis=1), -1, 1))
    left = np.arccos(np.clip((now * wanted).sum(axis=1), -1, 1))
    np.testing.assert_allclose(left, np.maximum(angle - 0.25 * rate, 0) if rate else angle, atol=2e-3)
    across = np.cross(before, wanted)
    np.testing.assert_allclose((across * now).sum(axis=1), 0, atol=1e-5)
    np.testing.assert_array_equal(p.orientation[0], np.float32(q[0]), "at rest")


def test_align_to_a_vector_also_from_behind() -> None:
    state = {"position": np.zeros((2, 3)), "orientation": [(0, 0, 0, 1), (1, 0, 0, 0)]}
    p = after(state, actions.Align(to=(0, 0, -2)))
    np.testing.assert_allclose(turned(p.orientation, AXES[2]), [(0, 0, -1)] * 2, atol=1e-6)
    np.testing.assert_allclose(turned(p.orientation[:1], AXES[1]), [(0, 1, 0)], atol=1e-6)
    for wrong in ("forward", (0, 0, 0), 3.0):
        with pytest.raises(ArgumentError, match="to must"):
            actions.Align(to=wrong)  # type: ignore[arg-type]
    assert actions.Align() == actions.Align(to="velocity")
