"""where=, set, spawn, callback: what they do, and that results do not depend on ranks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from standing import alike, on_ranks

import motes
from motes.expressions import column, maximum
from motes.shapes import Box, Plane, Sphere

RULES = Path(__file__).parents[1] / "scenes" / "rules.py"
DT = 0.125


def run(record: Any, frames: int = 1, **attributes: Any) -> tuple[motes.Particles, motes.Particles]:
    """Call `record(system, frame)` in each frame; return 400 particles before and after."""
    world = motes.World(seed=5, dt=DT, progress="off")
    system = world.system("only", attributes=attributes)
    with world:
        system.configure(velocity=Sphere((0, 0, 0), 2), age=motes.Uniform(0, 3))
        system.burst(Box((-1, -1, -1), (1, 1, 1)), count=400)
        world.step()
        before = system.gather()
        for frame in range(frames):
            record(system, frame)
            world.step()
        return before, system.gather()


def test_one_two_three_and_five_ranks_obey_the_rules_alike():
    alone = alike(RULES, ranks=(1, 2, 3, 5))
    assert len({line.split()[1] for line in alone}) == len(alone) == 12
    assert int(alone[-1].split()[3]) > 500, "rockets have burst"


@pytest.mark.parametrize("isa", ["sse2", "avx2"])
def test_the_width_of_vectors_does_not_show(isa: str):
    result = on_ranks(2, RULES, timeout=60, env={"MOTES_SIMD": isa})
    if "this processor supports" in result.err:
        pytest.skip(f"no {isa} here")
    assert result.lines == on_ranks(1, RULES).lines


def test_where_limits_an_action_and_leaves_the_rest_bit_by_bit():
    chosen = (column("age") > 1) & ~Box((0, -2, -2), (2, 2, 2)) | (column("position").y.floor() == -1)
    before, after = run(lambda s, _: s.gravity((0, -8, 0), where=chosen))
    p = before.position
    mask = ((before.age > 1) & ~(p[:, 0] >= 0)) | (np.floor(p[:, 1]) == -1)
    assert 0 < mask.sum() < 400
    expected = before.velocity.copy()
    expected[mask, 1] += np.float32(-8) * np.float32(DT)
    np.testing.assert_array_equal(after.velocity, expected)


def test_where_limits_deaths():
    before, after = run(lambda s, _: s.kill_old(1, where=Sphere((0, 0, 0), 0.9)))
    dies = (before.age >= 1) & (np.linalg.norm(before.position, axis=1) <= 0.9)
    assert 0 < dies.sum() < 400
    np.testing.assert_array_equal(after.id, before.id[~dies])


def test_set_computes_from_the_particle_before_it():
    before, after = run(
        lambda s, _: s.set(
            heat=column("velocity").length() / 2 + abs(column("position")[0]),
            velocity=maximum(-column("velocity"), 0.25),
            color=(column("age") * 0.1 + (0, 0.5, 1)),
        ),
        heat=0.0,
    )
    v = before.velocity
    length = np.sqrt(v[:, 0] * v[:, 0] + v[:, 1] * v[:, 1] + v[:, 2] * v[:, 2])
    np.testing.assert_array_equal(after.heat, length / np.float32(2) + np.abs(before.position[:, 0]))
    np.testing.assert_array_equal(after.velocity, np.maximum(-v, np.float32(0.25)))
    blue = before.age * np.float32(0.1) + np.float32(1)
    np.testing.assert_array_equal(after.color[:, 2], blue)


def test_expressions_refuse_what_they_cannot_say():
    world = motes.World(seed=1, progress="off")
    s = world.system("s", attributes={"heat": 1.0})
    v = column("velocity")
    with world:
        for wrong in (
            lambda: s.set(foo=1),
            lambda: s.set(heat=(1, 2, 3)),
            lambda: s.set(heat=v),
            lambda: s.set(heat=v > 1),
            lambda: s.set(heat="hot"),
            lambda: s.set(heat=float("nan")),
            lambda: s.gravity((0, 0, 0), where=3),
            lambda: s.gravity((0, 0, 0), where=v > 1),
            lambda: s.gravity((0, 0, 0), where=column("nothing") > 1),
            lambda: s.gravity((0, 0, 0), where=column("age")[1] > 1),
            lambda: s.gravity((0, 0, 0), where=column("age") > 1 and column("age") < 2),
            lambda: s.spawn("s", on="death", count=1),
            lambda: s.spawn(s, on="death", count=0),
            lambda: s.spawn(into=s, count=1, on="lunch"),
            lambda: s.spawn(s, on="death", count=1, inherit_velocity=float("inf")),
            lambda: s.callback(3),
            lambda: s.callback(print, where=3),
            lambda: s.callback(print, where=column("nothing") > 1),
            lambda: s.spawn(s, on="death", count=1, where=column("age")),
            lambda: sum([column("age")] * 500),
        ):
            with pytest.raises(motes.ArgumentError):
                wrong()
        assert s.recorded == []


def spawn(on: str, count: int, **keywords: Any) -> tuple[motes.Particles, motes.Particles, int]:
    """Return parents and children at the end of the events' frame, and the number of dropped children."""
    world = motes.World(seed=9, dt=DT, progress="off")
    parents = world.system("parents")
    children = world.system("children", capacity=keywords.pop("capacity", None))
    with world:
        parents.configure(velocity=Sphere((0, -3, 0), 1), lifetime=motes.Uniform(0.05, 0.3))
        parents.burst(Box((-1, 0.2, -1), (1, 2, 1)), count=200)
        children.configure(velocity=(0, 1, 0), age=0.5)
        parents.spawn(into=children, on=on, count=count, **keywords)
        parents.bounce(Plane((0, 0, 0), (0, 1, 0)))
        parents.move()
        world.step()
        assert children.count == children.born
        return parents.gather(), children.gather(), children.dropped


def test_births_have_children_in_the_order_of_their_parents():
    parents, children, _ = spawn("birth", 3, inherit_velocity=0.5)
    assert len(children) == 600
    np.testing.assert_array_equal(children.id, np.arange(600))
    np.testing.assert_array_equal(children.position, np.repeat(parents.position, 3, axis=0))
    inherited = np.float32([0, 1, 0]) + np.float32(0.5) * parents.velocity
    np.testing.assert_array_equal(children.velocity, np.repeat(inherited, 3, axis=0))
    assert (children.age == 0.5).all()


def test_collisions_have_children_where_the_condition_holds():
    parents, children, _ = spawn("collision", 1, where=column("position").x > 0)
    rises = parents.velocity[:, 1] > 0
    assert 0 < rises.sum() < 200
    wanted = parents.position[rises & (parents.position[:, 0] > 0)]
    np.testing.assert_array_equal(children.position, wanted)


def test_children_above_the_capacity_are_dropped_and_counted():
    _, children, dropped = spawn("birth", 3, capacity=100)
    assert (len(children), dropped) == (100, 500)
    np.testing.assert_array_equal(children.id, np.arange(100))


def test_the_dead_have_children_at_the_end_of_the_same_frame():
    world = motes.World(seed=9, dt=DT, progress="off")
    parents, children = world.system("parents"), world.system("children")
    with world:
        parents.burst(Sphere((0, 0, 0), 1), count=50)
        world.step()
        parents.spawn(into=children, on="death", count=4)
        parents.kill_old(0, where=column("position").z > 0)
        world.step()
        dead = 50 - parents.count
        assert 0 < dead < 50
        assert (children.count, children.born) == (4 * dead, 4 * dead)


def test_children_have_children():
    world = motes.World(seed=9, dt=DT, progress="off")
    shells, stars, sparks = (world.system(name) for name in ("shells", "stars", "sparks"))
    with world:
        for frame in world.frames(6):
            shells.burst((0, 1, 0), count=2 if frame == 0 else 0)
            shells.spawn(into=stars, on="birth", count=5)
            stars.spawn(into=sparks, on="birth", count=7)
            stars.burst((0, 2, 0), count=3 if frame == 2 else 0)
            for system in (shells, stars, sparks):
                system.move()
            world.step()
        assert (stars.born, sparks.born) == (13, 91)


def test_children_keep_the_target_that_they_were_given():
    world = motes.World(seed=9, dt=DT, progress="off")
    parents, children = world.system("parents"), world.system("children")
    with world:
        parents.configure(velocity=(1, 0, 0))
        parents.burst((0, 0, 0), count=1)
        children.configure(velocity_b=(7, 8, 9))
        parents.spawn(into=children, on="birth", count=2, inherit_velocity=0.5)
        world.step()
        p = children.gather()
    np.testing.assert_array_equal(p.velocity, [[0.5, 0, 0]] * 2)
    np.testing.assert_array_equal(p.velocity_b, [[7, 8, 9]] * 2)


def test_a_callback_stands_in_its_place_of_the_list():
    seen = []

    def halve(particles: Any) -> None:
        seen.append(len(particles))
        particles.velocity[:] *= np.float32(0.5)

    def record(s: motes.System, _: int) -> None:
        s.gravity((0, -8, 0))
        s.callback(halve)
        s.gravity((0, -4, 0))

    before, after = run(record)
    expected = before.velocity.copy()
    expected[:, 1] += np.float32(-1)
    expected *= np.float32(0.5)
    expected[:, 1] += np.float32(-0.5)
    np.testing.assert_array_equal(after.velocity, expected)
    assert seen == [400]


def test_a_callback_sees_and_changes_only_particles_where_a_condition_holds():
    seen: dict[str, Any] = {}

    def mark(particles: Any) -> None:
        seen.update(n=len(particles), id=particles.id.copy(), x=particles.position[:, 0].copy())
        particles.heat[:] = 7
        particles.velocity[particles.age > 2] = (1, 2, 3)
        assert (particles.alpha == 1).all()
        with pytest.raises(ValueError, match="read-only"):
            particles.id[:] = 0
        seen["kept"] = particles.heat

    chosen = Box((0, -2, -2), (2, 2, 2)) & (column("age") > 1)
    before, after = run(lambda s, _: s.callback(mark, where=chosen), heat=0.5)
    mask = (before.position[:, 0] >= 0) & (before.age > 1)
    assert 0 < mask.sum() == seen["n"] < 400
    np.testing.assert_array_equal(np.sort(seen["id"]), before.id[mask])
    np.testing.assert_array_equal(np.sort(seen["x"]), np.sort(before.position[mask, 0]))
    np.testing.assert_array_equal(after.heat, np.where(mask, np.float32(7), np.float32(0.5)))
    expected = before.velocity.copy()
    expected[mask & (before.age > 2)] = (1, 2, 3)
    np.testing.assert_array_equal(after.velocity, expected)
    with pytest.raises(ValueError, match="read-only"):
        seen["kept"][:] = 0


def test_a_callback_is_not_called_where_no_particle_fulfils_its_condition():
    calls: list[int] = []
    run(lambda s, _: s.callback(lambda p: calls.append(len(p)), where=column("age") > 99))
    assert calls == []


def test_a_failing_callback_ends_the_run_and_is_named():
    script = """
import motes
world = motes.World(seed=1, space=(-1, 1), progress="off")
s = world.system("s")
def fail(particles):
    if world.rank == 2 and world.frame == 3:
        raise ValueError("no such colour")
with world:
    for frame in world.frames(6):
        s.source(motes.shapes.Box((-1, 0, 0), (1, 1, 1)), rate=240)
        s.callback(fail)
        s.move()
        world.step()
"""
    result = on_ranks(4, script, timeout=30)
    assert result.code != 0
    assert result.err.count("*** motes:") == 1, result.text
    assert "rank 2 (calculator 0), frame 3" in result.err
    assert "no such colour" in result.err and "in fail" in result.err, result.text
