"""Grains against published values: docs/lab/scripts/make_grains.py with small vessels, for some seconds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from docs_scripts import script_of_docs


@pytest.fixture(scope="module")
def cases() -> Any:
    return script_of_docs("make_grains")


def test_the_walls_of_a_silo_carry_most_of_what_is_poured(cases: Any):
    """Janssen (1895): the load on the ground saturates."""
    radius = 3 * cases.DIAMETER
    poured, carried, top = cases.pour(radius, 80, 5, 0.35)
    assert carried[0] > 0.85 * poured[0]
    assert carried[-1] < 0.6 * poured[-1]
    assert abs(carried[-2:] - carried[-3]).max() < 0.2 * poured[0]
    depth = cases.saturation(poured, carried) / poured[-1] * (top - 2 * cases.DIAMETER)
    across = radius / (2 * cases.LAW["friction"] * depth)  # lateral stress / axial stress
    assert 0.25 < across < 0.8, "between Rankine's active state, and almost as a liquid"


def test_a_hopper_runs_out_as_fast_as_its_hole_is_wide(cases: Any):
    """Beverloo et al. (1961): flow grows with (hole - 1.4 diameters)^2.5."""
    narrow, wide = flows = cases.flows(6, 900, [4.5, 6.5], 0.5, filling=0.35, after=0.15)
    holes = np.array([4.5, 6.5]) - 1.4
    assert math.log(wide / narrow) / math.log(holes[1] / holes[0]) == pytest.approx(2.5, abs=0.35)
    bulk = 0.6 * cases.DENSITY
    parts = flows / (0.58 * bulk * math.sqrt(9.81) * (holes * cases.DIAMETER) ** 2.5)
    assert (parts > 0.75).all() and (parts < 1).all(), "small holes stay below the law: docs/lab/grains.md"


def test_heaps_are_steeper_the_more_their_grains_resist(cases: Any):
    """Zhou et al. (2002): a heap needs both sliding and rolling friction."""

    def slope(**law: float) -> float:
        return float(cases.repose(6 * cases.DIAMETER, 400, 1.3, **law))

    assert abs(slope(friction=0, rolling_friction=0.2)) < 3
    assert 1 < slope(rolling_friction=0.05) < 12
    assert 18 < slope(rolling_friction=0.2) < 32


def test_the_surface_in_a_drum_that_turns_is_steep_and_steady(cases: Any):
    slopes = cases.turned(8 * cases.DIAMETER, 4 * cases.DIAMETER, 0.01, 2.0)
    assert min(slopes) > 30 and max(slopes) < 45
    assert np.mean(slopes[:8]) == pytest.approx(np.mean(slopes[8:]), abs=3)
