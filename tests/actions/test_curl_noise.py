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
    periodic: dict[str, Any] | None = None,
) -> np.ndarray:
    """Return velocities after actions in the last frame, in which particles are born at rest at x."""
    world = motes.World(seed=seed, dt=DT, substeps=substeps, periodic=periodic, progress="off")
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


LOW, HIGH = (-1.5, 0, -7), (2.5, 6, 93)  # of the periods, m


def around_ends(
    count: int, spread: float, axis: int, axes: str
) -> tuple[tuple[np.ndarray, np.ndarray], dict[str, Any]]:
    """Return points `spread` before and beyond the end of an axis, and the periods."""
    points = np.random.default_rng(5).uniform(LOW, HIGH, (count, 3)).astype(np.float32)
    before, beyond = points.copy(), points
    before[:, axis] = np.float32(HIGH[axis] - spread)
    beyond[:, axis] = np.float32(LOW[axis] + spread)
    return (before, beyond), {name: (LOW["xyz".index(name)], HIGH["xyz".index(name)]) for name in axes}


@pytest.mark.parametrize("axes", ["x", "z", "xyz"])
@pytest.mark.parametrize(
    "given",
    [{"scale": 1}, {"scale": 0.83, "octaves": 3, "speed": 0.7}, {"scale": 5.5, "octaves": 8}, {"scale": 900}],
    ids=str,
)
def test_it_is_the_same_at_both_ends_of_periodic_space(axes: str, given: dict[str, Any]):
    for name in axes:
        axis = "xyz".index(name)
        steps = []
        for spread in (0, 1e-4, 2e-4):
            (before, beyond), periods = around_ends(300, spread, axis, axes)
            flow = [stirred(x, noise(**given), frames=3, periodic=periods) for x in (before, beyond)]
            steps.append(np.abs(flow[0] - flow[1]).max())
        assert steps[0] == 0, "the same place"
        assert steps[1] < 0.02 and steps[2] < 2.2 * steps[1] + 1e-3, "smooth across the end"
        inside, periods = around_ends(300, 0.5 * (HIGH[axis] - LOW[axis]), axis, axes)
        middle = stirred(inside[0], noise(**given), frames=3, periodic=periods)
        assert np.abs(flow[0] - middle).max() > 0.01, "but not the same everywhere"


@pytest.mark.parametrize("scale", [0.9, 2.7, 7.0])
def test_it_stays_free_of_divergence_and_as_strong_in_periodic_space(scale: float):
    periods = {"x": (0, 1), "y": (0, 4), "z": (-2, 5)}
    places = np.random.default_rng(1).uniform((0.01, 0.01, -1.9), (0.9, 3.9, 4.9), (4000, 3))
    h, rate = 2e-3, np.zeros((3, 4000))
    for axis in range(3):
        step = h * np.eye(3)[axis]
        ahead, back = (
            stirred(np.float32(places + s), noise(scale=scale), periodic=periods) for s in (step, -step)
        )
        rate[axis] = (ahead - back)[:, axis] / (2 * h)
    assert np.abs(rate.sum(axis=0)).max() < 0.02 * max(np.abs(rate).max(), 0.05)
    if scale < 1:  # enough cells for a mean
        flow = stirred(np.float32(places), noise(scale=scale), periodic=periods)
        assert 0.8 < np.sqrt((flow**2).sum(axis=1).mean()) / DT < 1.2


def test_it_repeats_whole_cells_nearest_to_the_scale():
    """4 m hold 4, 3 and 1 cells of about 1.03, 1.25 and 9 m: the fields of the scales that fit exactly."""
    x = np.random.default_rng(2).uniform(0, 4, (500, 3)).astype(np.float32)
    cube = {name: (0, 4) for name in "xyz"}
    for near, exact in ((1.03, 1), (1.25, 4 / 3), (9, 4)):
        np.testing.assert_allclose(
            stirred(x, noise(scale=near), periodic=cube),
            stirred(x, noise(scale=exact), periodic=cube),
            atol=1e-6,
        )
    # The lattice of open space repeats nowhere, but its first cells are the same.
    open_space, first = stirred(x, noise()), (x < 3).all(axis=1)
    periodic = stirred(x, noise(), periodic=cube)
    np.testing.assert_array_equal(periodic[first], open_space[first])
    assert abs(likeness(periodic[~first], open_space[~first])) < 0.9


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
