"""Ramps, curves of a per-particle number: shifted, chosen and mixed per particle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes.errors import ArgumentError
from motes.expressions import choose, column, mix, ramp

FIRE = [
    (0, (1, 0.9, 0.2)),
    (0.5, (0.9, 0.2, 0)),
    (0.5, (0.5, 0.2, 0)),
    (0.8, (0.2, 0.1, 0.4)),
    (1, (0, 0, 0)),
]
PLACES = [(float(x), 0, 0) for x in np.linspace(-0.2, 1.3, 61)]


def computed(**values: Any) -> motes.Particles:
    """Return particles along x after setting these values."""
    world = motes.World(seed=1, progress="off")
    system = world.system("one")
    with world:
        system.emit(position=PLACES)
        system.set(**values)
        world.step()
        return system.gather()


@pytest.mark.parametrize("interpolation", ["linear", "smooth", "hold", "spline"])
def test_a_ramp_has_the_values_of_its_curve(interpolation: Any) -> None:
    """At, between, before and after its keys, at jumps, and for combined curves."""
    fire = motes.Curve(FIRE, interpolation)
    fade = motes.Curve([(0.1, 0.3), (0.4, 0.9), (2, 0.1)], interpolation)
    both = 1 - fade * 0.5 * fade
    found = computed(color=ramp(fire, column("position").x), alpha=ramp(both, column("position").x))
    x = found.position[:, 0].astype(float)
    assert found.color == pytest.approx(np.array([fire(v) for v in x]), abs=1e-6)
    assert found.alpha == pytest.approx(np.array([both(v) for v in x]), abs=1e-6)


def test_ramps_are_shifted_chosen_and_mixed_per_particle() -> None:
    x, fire, ash = column("position").x, motes.Curve(FIRE), motes.Curve([(0, 0.1), (1, 0.6)])
    shifted = (x + column("position").y) / 2 + 0.1
    found = computed(
        color=choose(x > 0.5, ramp(fire, shifted), mix(ramp(fire, x), ramp(ash, x), 0.25)),
    )
    at = found.position[:, 0].astype(float)
    expected = [
        np.array(fire(v / 2 + 0.1)) if v > 0.5 else 0.75 * np.array(fire(v)) + 0.25 * ash(v) for v in at
    ]
    assert found.color == pytest.approx(np.array(expected), abs=1e-6)


def test_nan_shows_the_first_value() -> None:
    assert (
        computed(alpha=ramp(motes.Curve([(0, 0.25), (1, 1)]), column("age") / column("age"))).alpha[0] == 0.25
    )


def test_wrong_ramps_are_refused() -> None:
    with pytest.raises(ArgumentError, match="curve"):
        ramp(0.5, column("age"))  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="operations"):
        ramp(motes.Curve([(i, i * i % 7) for i in range(200)]), column("age"))


RANKS = """
import motes
from motes import shapes
from motes.expressions import column, ramp
fire = motes.Curve([(0, (1, 0.9, 0.2)), (0.4, (0.9, 0.2, 0)), (1, (0, 0, 0))], "spline")
world = motes.World(seed=5, progress="off")
sparks = world.system("sparks", attributes={"shift": 0.0})
sparks.configure(velocity=shapes.Sphere((0, 0, 0), 2), shift=motes.Uniform(0, 0.4))
with world:
    for frame in world.frames(4):
        sparks.burst(shapes.Sphere((0, 0, 0), 1), count=500)
        sparks.set(color=ramp(fire, column("age") * 4 + column("shift")))
        sparks.move()
        world.step()
    digest = world.digest()
    if world.rank == 0:
        print(digest)
"""


def test_ramps_give_the_same_bits_on_all_ranks() -> None:
    digests = {tuple(on_ranks(ranks, RANKS).lines) for ranks in (1, 2, 3)}
    assert len(digests) == 1 and len(*digests) == 1


def test_ramps_of_actions_may_be_linear_curves_of_the_life():
    """A curve replaces the knots; it is not evaluated at the film's time."""
    knots = [(0, "gold"), (0.25, (0, 1, 0)), (1, (0, 0, 2))]
    assert motes.actions.ColorOverLife(ramp=motes.Curve(knots)) == motes.actions.ColorOverLife(ramp=knots)
    fade = motes.Curve([(0, 1), (1, 0.5)])
    assert motes.actions.AlphaOverLife(ramp=fade) == motes.actions.AlphaOverLife(ramp=[(0, 1), (1, 0.5)])
    assert motes.actions.SizeOverLife(ramp=fade) == motes.actions.SizeOverLife(ramp=[(0, 1), (1, 0.5)])
    for wrong in (motes.Curve(knots, "spline"), fade * 2):
        with pytest.raises(ArgumentError, match="ramp must be a list of .*, or a linear Curve of them"):
            motes.actions.ColorOverLife(ramp=wrong)
    with pytest.raises(ArgumentError, match="ramp must be .* 0..1, got 2"):
        motes.actions.AlphaOverLife(ramp=motes.Curve([(0, 1), (2, 0)]))


def test_a_ramp_curve_acts_as_its_knots_do():
    found = []
    for ramp_of in (lambda knots: knots, motes.Curve):
        world = motes.World(seed=1, dt=0.1, progress="off")
        s = world.system("s")
        s.configure(lifetime=1)
        with world:
            for frame in world.frames(6):
                if frame == 0:
                    s.burst((0, 0, 0), count=1)
                s.color_over_life(ramp_of([(0, (1, 0, 0)), (1, (0, 0, 1))]))
                s.move()
                world.step()
            found.append(s.gather().color[0])
    np.testing.assert_array_equal(*found)
