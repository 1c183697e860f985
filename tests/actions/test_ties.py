"""Ties, followers, pairs read by a script, far cells: the same bits however the world is divided."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes import ArgumentError, shapes

SCENE = Path(__file__).parents[1] / "scenes" / "tied.py"


def frames_of(lines: list[str]) -> dict[tuple[int, int], list[str]]:
    """Return the scene's columns by variant and frame."""
    rows = [line.split() for line in lines if not line.startswith("torn")]
    return {(int(row[0]), int(row[1])): row[2:] for row in rows}


@cache
def alone() -> tuple[str, ...]:
    """Return what one rank prints."""
    return tuple(on_ranks(1, SCENE, json.dumps([{}])).lines)


def test_the_scene_lives():
    frames = frames_of(list(alone()))
    assert len({tuple(row) for row in frames.values()}) == len(frames)
    torn, fastest = alone()[-1].split()[1:]
    assert int(torn) > 0, "the cloth tears"
    assert float(fastest) < 30, "nothing explodes"
    counts = [row[1].split(",") for row in frames.values()]
    assert int(counts[-1][0]) < int(counts[0][0]), "particles of the cloth die"


@pytest.mark.parametrize("size", [1, 2, 3, 5])
def test_the_same_bits(size: int):
    wanted = frames_of(list(alone()))
    variants: list[dict[str, Any]] = [{"axis": axis} for axis in ("x", "y", "z", "xyz", None)]
    variants += [{"roles": "shared"}, {"threads": 3}, {"space": (0.3, 0.35)}, {"births": "calculators"}]
    found = frames_of(on_ranks(size, SCENE, json.dumps(variants), timeout=180).lines)
    for (variant, frame), row in found.items():
        assert row == wanted[0, frame], f"{variants[variant]}, frame {frame}"
    assert len(found) == len(variants) * len(wanted)


@pytest.mark.parametrize("simd", ["sse2", "avx2"])
def test_the_same_bits_in_other_builds(simd: str):
    found = on_ranks(1, SCENE, json.dumps([{}]), env={"MOTES_SIMD": simd})
    if "MOTES_SIMD" in found.err:
        pytest.skip(f"no {simd} here")
    assert found.lines == list(alone())


def world(**settings: Any) -> motes.World:
    """Make a world for one rank."""
    return motes.World(seed=1, progress="off", **settings)


def test_a_rope_of_200_hangs_as_a_catenary():
    count, span, length = 200, 1.0, 1.25
    with world(dt=1 / 24, substeps=250) as w:
        s = w.system("rope")
        s.rope((0, 0, 0), (length, 0, 0), count)
        ids = np.arange(count)
        pairs = np.stack([ids[:-1], ids[1:]], -1)
        ties = motes.Ties(pairs, length / (count - 1), pinned=[0, count - 1])
        x = np.linspace(0, span, count)
        w.step()
        with s.local() as p:
            order = np.argsort(p.id)
            p.position[order, 0] = x
            p.position[order, 1] = -2.2 * x * (span - x)
        for _ in range(24 * 4):
            s.gravity((0, -9.81, 0))
            s.tie(ties)
            s.wind((0, 0, 0), drag=4)
            s.move()
            w.step()
        p = s.gather()
    a = 0.5
    for _ in range(60):  # Newton's method for sinh(1 / (2a)) 2a = 1.25
        a -= (2 * a * np.sinh(span / (2 * a)) - length) / (
            2 * np.sinh(span / (2 * a)) - span / a * np.cosh(span / (2 * a))
        )
    wanted = a * np.cosh((p.position[:, 0] - span / 2) / a) - a * np.cosh(span / (2 * a))
    assert np.abs(p.position[:, 1] - wanted).max() < 0.02 * span


def test_pinned_particles_stand_still_and_others_hang_within_their_tethers():
    with world(dt=1 / 24, substeps=20) as w:
        s = w.system("cloth")
        ties = s.cloth(12, 12, (0, 0, 0), (1, 0, 0), (0, 0, 1), pinned=[(0, 0), (0, 11)])
        for _ in range(48):
            s.gravity((0, -9.81, 0))
            s.tie(ties)
            s.move()
            w.step()
        p = s.gather()
    at = p.position.reshape(12, 12, 3)
    np.testing.assert_array_equal(at[0, 0], (0, 0, 0))
    np.testing.assert_array_equal(at[0, 11], (0, 0, 1))
    far = np.linalg.norm(at - at[0, 0], axis=2)
    side = np.linspace(0, 1, 12)
    rest = np.hypot(side[:, None], side[None])
    assert (far <= rest * 1.02 + 1e-3).all()
    assert at[-1, :, 1].max() < -0.3, "it has swung down"


def test_ties_tear_and_both_ends_know():
    with world(dt=0.1) as w:
        s = w.system("two")
        s.emit(position=[(0, 0, 0), (1, 0, 0), (1.5, 0, 0)])
        ties = motes.Ties([(0, 1), (1, 2)], [0.5, 0.5])
        s.tie(ties, break_at=1.5)
        w.step()
        p = s.gather()
        assert p.torn.tolist() == [1, 1, 0]
        np.testing.assert_array_equal(p.velocity, 0)
        s.tie(ties, break_at=1.5)
        s.set(velocity=(1, 2, 3))
        s.move()
        w.step()
        assert s.gather().torn.tolist() == [1, 1, 0], "what is torn stays so"


def test_ties_that_tear_share_no_particle_with_others_of_the_list():
    first, second = motes.Ties([(5, 0), (0, 1)], 1), motes.Ties([(2, 1), (1, 7)], 1)
    apart, pinned = motes.Ties([(2, 7)], 1), motes.Ties([(3, 4)], 1, pinned=[0, 1])
    wrong = r"^break_at must be infinite if two Ties of a list share a particle, and both tie 1 "
    with world(dt=0.1) as w:
        s, other = w.system("some"), w.system("other")
        s.emit(position=[(i, 0, 0) for i in range(8)])
        for earlier, later in ((1.5, math.inf), (math.inf, 1.5), (1.5, 2)):
            s.tie(first, break_at=earlier)
            with pytest.raises(ArgumentError, match=wrong) as caught:
                s.tie(second, break_at=later)
            assert (caught.value.argument, float(caught.value.value)) == ("break_at", 1.5)
            s.tie(first, break_at=3)  # the same Ties again
            s.tie(apart, break_at=1.5)
            s.tie(pinned, break_at=1.5)  # pins 0 and 1, but ties neither
            other.tie(second, break_at=1.5)
            w.step()
        s.tie(first)
        s.tie(second)
        w.step()
        s.tie(second, break_at=1.5)  # `first` is not in this frame's list
        w.step()
        assert s.count == 8


def test_a_dead_partner_does_not_pull():
    with world(dt=0.1) as w:
        s = w.system("two")
        s.emit(position=[(0, 0, 0), (1, 0, 0)], age=[0, 5])
        ties = motes.Ties([(0, 1)], 0.5)
        s.kill_old(2)
        s.tie(ties)
        w.step()
        np.testing.assert_array_equal(s.gather().velocity, [(0, 0, 0)])


def test_follow_goes_to_the_next_that_lives():
    with world(dt=0.5) as w:
        s = w.system("chain")
        s.emit(position=[(0, 0, 0), (5, 5, 5), (2, 0, 0), (2, 3, 0)], age=[0, 9, 0, 0])
        s.kill_old(2)
        s.follow(magnitude=4, epsilon=0.0)
        w.step()
        v = s.gather().velocity
    np.testing.assert_allclose(v, [(4 * 0.5 / 4, 0, 0), (0, 4 * 0.5 / 9, 0), (0, 0, 0)], rtol=1e-6)


def test_far_cells_are_near_the_sum_over_all_pairs():
    rng = np.random.default_rng(3)
    position = rng.normal(size=(6000, 3)).astype(np.float32)
    found = []
    for far in ("exact", "cells"):
        with world(dt=1) as w:
            s = w.system("stars")
            s.emit(position=position)
            s.gravitate(magnitude=1e-3, epsilon=1e-3, far=far)
            w.step()
            found.append(s.gather().velocity.astype(np.float64))
    error = np.linalg.norm(found[1] - found[0]) / np.linalg.norm(found[0])
    assert error < 0.005


def test_pairs_are_all_those_within_reach():
    rng = np.random.default_rng(3)
    position = rng.uniform(-1, 1, (300, 3)).astype(np.float32)
    seen: list[tuple[int, int]] = []

    def note(pairs: Any) -> None:
        assert not pairs.position.flags.writeable
        np.testing.assert_array_equal(pairs.position, position[pairs.id])
        np.testing.assert_array_equal(pairs.other_position, position[pairs.other_id])
        seen.extend(zip(pairs.id.tolist(), pairs.other_id.tolist(), strict=True))

    with world() as w:
        s = w.system("some")
        s.emit(position=position)
        s.pairs(note, 0.3)
        w.step()
    far = np.linalg.norm(position[:, None].astype(np.float64) - position[None], axis=2)
    wanted = {(i, j) for i, j in np.argwhere(far < 0.3).tolist() if i != j}
    assert len(seen) == len(set(seen)) and set(seen) == wanted


FLYING = """
import sys
import motes
from motes.expressions import column
log = sys.argv[1]
world = motes.World(seed=1, roles="shared", substeps=2, dt=0.01, space=(0, 1), progress="off", log=log)
sheet = world.system("sheet")
with world:
    for frame in world.frames(12):
        if frame == 0:
            sheet.configure(velocity=(0.5, 0, 0))
            cloth = sheet.cloth(20, 60, (0, 0, 0), (1, 0, 0), (0, 0.3, 0))
        if frame == 8:  # far away, and back
            here = column("position")
            sheet.set(position=here + (5, 0, 0), where=here.y < 0.1)
        sheet.tie(cloth)
        sheet.move()
        world.step()
"""


def test_ghosts_are_those_within_reach_of_the_ties(tmp_path: Path):
    log = tmp_path / "log"
    assert on_ranks(4, FLYING, log).code == 0
    load = motes.open_run(log).load
    ghosts = load.groupby("frame")["ghosts"].sum()
    assert load.groupby("frame")["neighbour_ranks"].max()[[0, 1]].tolist() == [3, 2]
    assert ghosts[0] >= 3 * 1200, "nobody knows how long the ties are: all become ghosts once"
    # The longest ties span two of the 20 rows (60 particles each); moving by 1/20 row widens the reach.
    sides = 2 * 3 * 2  # of three cuts, in two sub-steps
    assert all(sides * 2 * 60 <= ghosts[frame] <= sides * 3 * 60 for frame in range(1, 8))
    assert ghosts[8] > 4 * ghosts[7], "a jump is a long way"


def test_wrong_input():
    with world() as w:
        s = w.system("some", capacity=100)
        for wrong in (
            lambda: s.cloth(1, 5, (0, 0, 0), (1, 0, 0), (0, 0, 1)),
            lambda: s.cloth(5, 5, (0, 0, 0), (1, 0, 0), (2, 0, 0)),
            lambda: s.cloth(5, 5, (0, 0, 0), (1, 0, 0), (0, 0, 1), pinned=[(5, 0)]),
            lambda: s.cloth(20, 20, (0, 0, 0), (1, 0, 0), (0, 0, 1)),
            lambda: s.rope((0, 0, 0), (0, 0, 0), 10),
            lambda: s.rope((0, 0, 0), (1, 0, 0), 1),
            lambda: motes.Ties([(1, 1)], 1),
            lambda: motes.Ties([(0, 1), (1, 0)], 1),
            lambda: motes.Ties([(0, 1)], -1),
            lambda: motes.Ties([(0, 1)], [1, 2]),
            lambda: motes.Ties([(0, -1)], 1),
            lambda: motes.Ties([(0, 1)], 1, kinds=[3]),
            lambda: s.tie("nothing"),
            lambda: s.pairs(None, 1),
            lambda: s.pairs(print, -1),
            lambda: s.gravitate(max_radius=1, far="cells"),
            lambda: s.gravitate(far="near"),
        ):
            with pytest.raises((ArgumentError, ValueError)):
                wrong()


def test_a_fabric_that_is_refused_leaves_no_particles():
    with world() as w:
        s = w.system("some", capacity=100)
        for wrong in (
            lambda: s.cloth(5, 5, (0, 0, 0), (1, 0, 0), (0, 0, 1), pinned=[(5, 0)]),
            lambda: s.cloth(20, 20, (0, 0, 0), (1, 0, 0), (0, 0, 1)),
            lambda: s.rope((0, 0, 0), (1, 0, 0), 10, pinned=[10]),
        ):
            with pytest.raises(ArgumentError):
                wrong()
        assert s.rope((0, 0, 0), (1, 0, 0), 3).pairs.tolist() == [[0, 1], [1, 2], [0, 2]]
        w.step()
        assert s.count == 3


def test_a_procedure_of_pairs_that_returns_nonsense_is_named():
    with pytest.raises(ArgumentError, match=r"pairs.*\(12, 3\)|\(12, 3\)"), world() as w:
        s = w.system("some")
        s.burst(shapes.Point((0, 0, 0)), 4)
        s.pairs(lambda pairs: np.zeros(3), 1)
        w.step()


def test_newborn_particles_that_are_in_the_way_are_cleared():
    with world(dt=1e-3) as w:
        s = w.system("balls")
        s.emit(position=[(0, 0, 0), (3, 0, 0)])
        s.collide(radius=0.5, clear=0.1)
        w.step()
        assert s.count == 2
        # 2 overlaps an old particle, 3 is free, 4 overlaps 3 slightly, 5 overlaps 3 deeply.
        s.emit(position=[(0.5, 0, 0), (6, 0, 0), (6.97, 0, 0), (6, 0.5, 0)])
        s.collide(radius=0.5, clear=0.1)
        w.step()
        p = s.gather()
        assert p.id.tolist() == [0, 1, 3, 4]
        np.testing.assert_array_equal(p.velocity, 0)  # newborn particles have pushed nothing
        s.collide(radius=0.5, clear=0.1)
        w.step()
        p = s.gather()
        assert p.id.tolist() == [0, 1, 3, 4] and p.contacts.tolist() == [0, 0, 1, 1]


def test_contacts_are_those_of_all_collisions_of_a_sub_step():
    with world(dt=1e-3) as w:
        a, b = w.system("a"), w.system("b")
        a.emit(position=[(0, 0, 0), (0.9, 0, 0)])
        b.emit(position=[(0, 0.9, 0)])
        a.collide(radius=0.5)
        a.collide(radius=0.5, other=b, other_radius=0.5)
        w.step()
        assert a.gather().contacts.tolist() == [2, 1]
        assert b.gather().contacts.tolist() == [1]


def stretch(substeps: int, falls: bool) -> tuple[float, float]:
    """Hang a cloth of 100 x 100 particles by two corners, or drop it over a ball, for 3 s.

    Returns the strain of edges between neighbours: the mean of its absolute value, and the largest.
    """
    side = 0.02 * 99
    with world(dt=1 / 24, substeps=substeps) as w:
        s = w.system("cloth")
        if falls:
            ties = s.cloth(100, 100, (0.013 - side / 2, 0.62, 0.007 - side / 2), (side, 0, 0), (0, 0, side))
        else:
            ties = s.cloth(100, 100, (-side / 2, 0, 0), (0, 0, side), (side, 0, 0), pinned=[(0, 0), (0, 99)])
        for _ in range(72):
            s.gravity((0, -9.81, 0))
            s.damping(damping=(0.7, 0.7, 0.7))
            s.tie(ties, bend=1e-3)
            for solid in (shapes.Sphere((0, 0, 0), 0.51), shapes.Plane((0, -0.89, 0), (0, 1, 0))):
                if falls:
                    s.bounce(solid, restitution=0, friction=0.4, exact_hit=False)
            s.move()
            w.step()
        at = s.gather().position.astype(np.float64).reshape(100, 100, 3)
    edges = np.concatenate([np.linalg.norm(np.diff(at, axis=axis), axis=2).ravel() for axis in (0, 1)])
    off = edges / 0.02 - 1
    return float(np.abs(off).mean()), float(off.max())


def test_a_cloth_that_hangs_is_as_stiff_as_its_sub_steps():
    mean, longest = stretch(20, falls=False)
    assert mean == pytest.approx(0.068, rel=0.1)
    assert longest == pytest.approx(0.37, rel=0.1)


@pytest.mark.slow
def test_a_cloth_over_a_ball_is_as_stiff_as_its_sub_steps():
    assert stretch(40, falls=True)[0] == pytest.approx(0.064, rel=0.1)
    assert stretch(80, falls=True)[0] == pytest.approx(0.019, rel=0.1)
