"""The effect of `curl_noise` on particles at rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import motes
from motes import actions
from motes.errors import ArgumentError

DT = 0.25


def stirred(
    x: np.ndarray,
    *recorded: actions.Action,
    frames: int = 1,
    substeps: int = 1,
    seed: int = 8,
    name: str = "",
) -> np.ndarray:
    """Return velocities after actions in the last frame, in which particles are born at rest at x."""
    world = motes.World(seed=seed, dt=DT, substeps=substeps, progress="off")
    first, system = world.system("first"), world.system("second")
    chosen = first if name == "first" else system
    with world:
        for frame in world.frames(frames):
            if frame == frames - 1:
                chosen.emit(position=x)
                chosen.apply(list(recorded))
            world.step()
        return chosen.gather().velocity.astype(np.float64)


def noise(**given: Any) -> actions.CurlNoise:
    """Make the action; strength 1 and cells of 1 m by default."""
    return actions.CurlNoise(**{"strength": 1, "scale": 1, **given})


def scattered(n: int, size: float, seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-size, size, (n, 3)).astype(np.float32)


def likeness(a: np.ndarray, b: np.ndarray) -> float:
    """Return the correlation of two fields: 1 for the same, about 0 for independent ones."""
    return float((a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()))


def test_it_is_an_acceleration_times_the_step():
    x = scattered(500, 4)
    once, twice = stirred(x, noise()), stirred(x, noise(strength=-2))
    np.testing.assert_allclose(twice, -2 * once, rtol=1e-6)
    np.testing.assert_allclose(stirred(x, noise(), substeps=5), once, atol=1e-6)


def test_scale_stretches_and_octaves_add_detail():
    x = scattered(3000, 4)
    np.testing.assert_allclose(stirred(4 * x, noise(scale=4)), stirred(x, noise()), atol=1e-6)
    one, two = stirred(x, noise()), stirred(x, noise(octaves=2))
    assert 0.8 < likeness(one, two) < 0.97  # 1 / sqrt(1 + 1/4) = 0.894


def test_it_changes_with_the_animations_time():
    x = scattered(3000, 10)
    still, flows = noise(), noise(speed=0.5)  # a new field every 2 s (8 frames)
    np.testing.assert_array_equal(stirred(x, still), stirred(x, still, frames=7))
    start = stirred(x, flows)
    near = [likeness(start, stirred(x, flows, frames=frames)) for frames in (2, 3, 5, 9)]
    assert near[0] > 0.99 and near[0] > near[1] > near[2] > near[3]
    assert abs(near[3]) < 0.1
    np.testing.assert_array_equal(start, stirred(x, noise()))  # at time 0
    # Each sub-step has its own time: the second of two starts half a frame later.
    halves = stirred(x, flows, frames=2, substeps=2)
    assert likeness(halves, stirred(x, flows, frames=2)) > 0.99
    assert (halves != stirred(x, flows, frames=2)).any()


def test_the_field_is_that_of_seed_system_and_number_alone():
    x = scattered(3000, 10)
    wanted = stirred(x, noise())
    pull = actions.Gravity(acceleration=(0, 0, 0))
    np.testing.assert_array_equal(stirred(x, pull, pull, noise()), wanted)
    np.testing.assert_array_equal(stirred(x, noise(), noise()), np.float32(wanted) * np.float32(2))
    for other in (
        stirred(x, noise(field=1)),
        stirred(x, noise(field=65535)),
        stirred(x, noise(), seed=9),
        stirred(x, noise(), name="first"),
    ):
        assert abs(likeness(wanted, other)) < 0.1
    both = stirred(x, noise(), noise(field=1))
    np.testing.assert_allclose(both, wanted + stirred(x, noise(field=1)), atol=1e-6)


def test_far_and_strange_places_stay_finite():
    x = np.float32([(1e30, 0, 0), (-3e38, 3e38, 0), (1e-40, 0, 0), (8388607, 0, 0)])
    for action in (noise(), noise(scale=1e-6, octaves=8), noise(speed=1e15), noise(scale=1e15, speed=-1e15)):
        assert np.isfinite(stirred(x, action, frames=3)).all()


WRONG = [
    ({"scale": 0}, "scale must be a finite number >= 1e-06, got 0"),
    ({"octaves": 0}, "octaves must be an integer in 1..8, got 0"),
    ({"octaves": 2.0}, "octaves must be an integer in 1..8"),
    ({"octaves": 9}, "octaves must be an integer in 1..8, got 9"),
    ({"strength": float("nan")}, "strength"),
    ({"speed": float("inf")}, "speed"),
    ({"field": -1}, "field must be an integer in 0..65535, got -1"),
]


@pytest.mark.parametrize(("given", "message"), WRONG, ids=[str(given) for given, _ in WRONG])
def test_wrong_arguments_are_named(given: dict[str, Any], message: str):
    with pytest.raises(ArgumentError, match=message):
        noise(**given)


def test_the_engine_itself_requires_whole_octaves():
    with pytest.raises(ValueError, match="octaves must be a whole number, got 1.5"):
        numbers = {"strength": 1, "scale": 1, "octaves": 1.5, "speed": 0, "field": 0}
        motes._core.Action("curl_noise", numbers, [])
