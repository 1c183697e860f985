"""position_b, velocity_b and up_b are the birth values, whenever a script first asks for them."""

from __future__ import annotations

import pytest
from standing import on_ranks

SCENE = """
import sys
import numpy as np
import motes
from motes import shapes
from motes.expressions import column

first, frames = int(sys.argv[1]), 12
world = motes.World(seed=5, space=(-2, 2), substeps=2, progress="off")
s, children = world.system("s", capacity=900), world.system("children")
rng = np.random.default_rng(1)
home = {}
with world:
    for frame in world.frames(frames):
        s.configure(velocity=motes.Normal((0, 0, 0), (2, 2, 2)), up=shapes.Sphere((0, 0, 0), 1))
        before = s.recorded
        if frame % 2 == 0:
            s.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=1000, jitter=frame > 4)
        if frame == 3:
            s.emit(position=rng.normal(size=(50, 3)), velocity=rng.normal(size=(50, 3)))
        if frame < 2:
            s.burst(shapes.Sphere((0, 0, 0), 1), count=70000 if len(sys.argv) > 2 else 70)
        s.random_acceleration(shapes.Sphere((0, 0, 0), 30))
        s.sink(shapes.Sphere((3, 0, 0), 1.5))
        s.spawn(into=children, on="death", count=1)
        s.move()
        if frame >= first:
            s.set(color=column("position_b"), alpha=column("velocity_b").x)
        children.move()
        if frame >= 10:
            children.set(color=column("position_b"))
        world.step()
    p = s.gather()
    if p:
        for row in zip(p.id, p.position_b.tolist(), p.velocity_b.tolist(), p.up_b.tolist(), p.color.tolist()):
            print(*row)
    p = children.gather()
    if p:
        for row in zip(p.id, p.position_b.tolist(), p.color.tolist()):
            print("child", *row)
"""


@pytest.fixture(scope="module")
def from_the_start():
    """Return the output of the scene that reads birth values from its first frame on."""
    return on_ranks(1, SCENE, 0).lines


@pytest.mark.parametrize("ranks", [1, 3, 5])
@pytest.mark.parametrize("first", [7, 11])
def test_targets_are_birth_values_however_late_they_are_named(first, ranks, from_the_start):
    lines = on_ranks(ranks, SCENE, first).lines
    assert len(lines) > 300
    assert any(line.startswith("child") for line in lines)
    assert lines == from_the_start


def test_many_births_at_once_are_made_again_in_parts():
    assert on_ranks(3, SCENE, 9, "many").lines == on_ranks(1, SCENE, 0, "many").lines


RETURN = """
import numpy as np
import motes
from motes import shapes

world = motes.World(seed=2, progress="off")
s = world.system("s")
with world:
    for frame in world.frames(40):
        if frame == 0:
            s.burst(shapes.Sphere((0, 0, 0), 1), count=500)
            born = s.gather(to="all").position
        if frame < 10:
            s.explosion((0, 0, 0), radius=frame * 0.2, magnitude=50, sigma=0.5, epsilon=0.5)
        else:
            s.restore((39 - frame) * world.dt)
        s.move()
        if frame == 10:
            away = np.abs(s.gather(to="all").position - born).max()
        world.step()
    back = np.abs(s.gather(to="all").position - born).max()
    world.say(f"{away} {back}")
"""


def test_particles_return_to_where_they_were_born():
    away, back = map(float, on_ranks(3, RETURN).lines[-1].split())
    assert away > 0.5
    assert back < 1e-5


LATE = """
import sys
import numpy as np
import motes
from motes.expressions import column

roles, calls = sys.argv[1], int(sys.argv[2])
world = motes.World(seed=1, dt=1.0, roles=roles, progress="off")
s = world.system("a")
rng = np.random.default_rng(1)
born = []
with world:
    for frame in world.frames(8):
        if frame < 4:
            for _ in range(calls):
                place = rng.uniform(-19, -18, 3).astype("f4")
                born.append(place)
                s.burst(place)
            rows = rng.uniform(-19, -18, (60_000, 3)).astype("f4")
            born += list(rows)
            s.configure(velocity=(7, 0, 0))
            s.emit(position=rows, velocity=np.full((60_000, 3), (7, 0, 0), "f4"))
        if frame == 6:
            s.restore(time_left=10.0, where=column("position_b").x > 100)
        s.kill_old(5, where=column("position").y > -18.5)
        s.move()
        world.step()
    p = s.gather()
    if p:
        print(len(p), (p.position_b == np.array(born)[p.id.astype(int)]).all())
"""


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_targets_are_right_where_particles_arrive_after_their_call_was_noted(ranks):
    count, right = on_ranks(ranks, LATE, "shared", 40).lines[-1].split()
    assert int(count) > 1000
    assert right == "True"


DEAD = """
import sys
import numpy as np
import motes
from motes.expressions import column
from motes.shapes import Box

world = motes.World(dt=0.1, seed=1, progress="off")
s = world.system("a")
with world:
    s.emit(position=np.zeros((6000, 3), "f4"), velocity=np.ones((6000, 3), "f4"))
    s.sink(Box((-1, -1, -1), (1, 1, 1)))
    s.collide(radius=0.001)
    world.step()
    s.configure(velocity=(1, 2, 3))
    s.burst(Box((5, 0, 0), (6, 1, 1)), count=100)
    if sys.argv[1] == "read":
        s.total(1)
    s.set(velocity=column("velocity_b"))
    world.step()
    p = s.gather()
    if p:
        print(p.velocity.sum(axis=0).tolist())
"""


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("read", ["no", "read"])
def test_a_read_in_a_frame_forgets_no_births(ranks, read):
    assert on_ranks(ranks, DEAD, read).lines == ["[100.0, 200.0, 300.0]"]
