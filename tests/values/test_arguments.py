"""Bad arguments: an ArgumentError at the call, naming argument, value and what is allowed; never a crash."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import motes
from motes import expressions as ex
from motes import shapes
from motes.errors import ArgumentError

NAN, INF = math.nan, math.inf
VIEW = ((0, 0, 5), (0, 0, 0))
CAMERA = motes.Camera(*VIEW)
BALL = shapes.Sphere((0, 0, 0), 1)


def world_of(**arguments: Any) -> motes.World:
    """Make a world without progress output."""
    return motes.World(**{"seed": 1, "progress": "off", **arguments})


@pytest.fixture(scope="module")
def system():
    """Return a system of an open world; its calls are recorded, never run."""
    world = world_of()
    made = world.system("a", attributes={"heat": 0.0, "wind": (0, 0, 0)})
    with world:
        yield made


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"seed": -1}, "seed"),
        ({"seed": 2**64}, "seed"),
        ({"seed": 1.5}, "seed"),
        ({"seed": True}, "seed"),
        ({"seed": "1"}, "seed"),
        ({"dt": 0}, "dt"),
        ({"dt": -1}, "dt"),
        ({"dt": NAN}, "dt"),
        ({"dt": INF}, "dt"),
        ({"dt": None}, "dt"),
        ({"substeps": 0}, "substeps"),
        ({"substeps": 1.0}, "substeps"),
        ({"axis": "w"}, "axis"),
        ({"axis": 0}, "axis"),
        ({"space": (1, 1)}, "space"),
        ({"space": (2, 1)}, "space"),
        ({"space": (0, NAN)}, "space"),
        ({"space": (0, INF)}, "space"),
        ({"space": (0, 1, 2)}, "space"),
        ({"space": "all"}, "space"),
        ({"space": 5}, "space"),
        ({"roles": "all"}, "roles"),
        ({"roles": None}, "roles"),
        ({"roles": motes.Roles(manager=0, image_generator=0, calculators=[])}, "calculators"),
        ({"roles": motes.Roles(manager=0, image_generator=0, calculators=[0, 0])}, "calculators"),
        ({"roles": motes.Roles(manager=1, image_generator=0, calculators=[0])}, "manager"),
        ({"roles": motes.Roles(manager=0, image_generator=7, calculators=[0])}, "image_generator"),
        ({"balancer": "pairwise"}, "balancer"),
        ({"renderer": CAMERA}, "renderer"),
        ({"combine": "apart"}, "combine"),
        ({"log": 5}, "log"),
        ({"digest": 1}, "digest"),
        ({"progress": "loud"}, "progress"),
        ({"progress": None}, "progress"),
        ({"comm": 0}, "comm"),
    ],
    ids=str,
)
def test_worlds(arguments, name):
    with pytest.raises(ArgumentError) as caught:
        world_of(**arguments)
    assert name in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"capacity": -1}, "capacity"),
        ({"capacity": 1.5}, "capacity"),
        ({"capacity": True}, "capacity"),
        ({"axis": "q"}, "axis"),
        ({"space": (3, 2)}, "space"),
        ({"sprite": "disc"}, "sprite"),
        ({"attributes": ["heat"]}, "attributes"),
        ({"attributes": {"id": 0}}, "id"),
        ({"attributes": {"position": 0}}, "position"),
        ({"attributes": {"two words": 0}}, "two words"),
        ({"attributes": {"": 0}}, "attributes"),
        ({"attributes": {"1st": 0}}, "1st"),
        ({"attributes": {"heat": (1, 2, 3, 4)}}, "heat"),
        ({"attributes": {"heat": NAN}}, "heat"),
        ({"attributes": {"heat": "hot"}}, "heat"),
        ({"attributes": {"heat": None}}, "heat"),
    ],
    ids=str,
)
def test_systems(arguments, name):
    with pytest.raises(ArgumentError) as caught:
        world_of().system("a", **arguments)
    assert name in str(caught.value)


@pytest.mark.parametrize("name", ["", None, 5])
def test_names_of_systems(name):
    with pytest.raises(ArgumentError, match="name"):
        world_of().system(name)


def test_a_name_is_taken_once():
    world = world_of()
    world.system("a")
    with pytest.raises(ArgumentError, match="a system named 'a' already exists; names are unique"):
        world.system("a")


CALLS: list[tuple[Callable[[motes.System], Any], str]] = [
    (lambda s: s.source(BALL, rate=-1), "rate must be a finite number in 0..1e\\+12, got -1"),
    (lambda s: s.source(BALL, rate=NAN), "rate must be .* got nan"),
    (lambda s: s.source(BALL, rate=True), "rate must be a number, got True"),
    (lambda s: s.source(BALL, rate="9"), "rate must be a number, got '9'"),
    (lambda s: s.source(BALL, rate=1, jitter=1), "jitter must be True or False, got 1"),
    (lambda s: s.source("here", rate=1), "shape must be a shape or 3 finite numbers, got 'here'"),
    (lambda s: s.source((0, NAN, 0), rate=1), "shape must be"),
    (lambda s: s.burst(BALL, count=-1), "count must be an integer in 0"),
    (lambda s: s.burst(BALL, count=1.0), "count must be an integer"),
    (lambda s: s.burst(BALL, count=10**10), "count must be an integer"),
    (lambda s: s.burst(None, count=1), "shape must be"),
    (lambda s: s.burst((0,)), "shape must be a shape or 3 finite numbers, got \\(0,\\); 2 numbers stand for"),
    (lambda s: s.burst((0, 0, INF)), "shape must be"),
    (lambda s: s.emit(position=[(0,)]), "position must be finite numbers of shape \\(n, 3\\)"),
    (lambda s: s.emit(position=[(0, 0, NAN)]), "position must be finite"),
    (lambda s: s.emit(position=[(0, 0, 0)], velocity=[(0, 0, 0)] * 2), "velocity must be of 1 rows"),
    (
        lambda s: s.emit(position=[(0, 0, 0)], mass=[(1, 1, 1)]),
        "mass must be finite numbers of shape \\(n,\\)",
    ),
    (lambda s: s.emit(position=[(0, 0, 0)], nonsense=[1]), "nonsense"),
    (lambda s: s.emit(position="abc"), "position must be"),
    (lambda s: s.configure(nonsense=1), "configure must be an attribute of 'a': velocity, .* got 'nonsense'"),
    (lambda s: s.configure(position=(0, 0, 0)), "got 'position'"),
    (lambda s: s.configure(velocity=1), "velocity must be 3 numbers, got 1"),
    (lambda s: s.configure(velocity=(0, 0, NAN)), "velocity must be 3 finite numbers"),
    (lambda s: s.configure(mass=BALL), "mass must be a number, Uniform or Normal"),
    (lambda s: s.configure(mass=(1, 1, 1)), "mass must be a number"),
    (lambda s: s.configure(mass=INF), "mass must be a finite number"),
    (lambda s: s.configure(lifetime=NAN), "lifetime must be"),
    (lambda s: s.configure(lifetime=-INF), "lifetime must be within 1e\\+37, got -inf"),
    (lambda s: s.emit(position=[(0, 0, 0)], lifetime=[-INF]), "lifetime must be finite numbers"),
    (lambda s: s.set(heat=1e300), "heat must be within the range of float32"),
    (lambda s: s.gravity(np.array([1j, 0, 0])), "acceleration must be 3 numbers"),
    (lambda s: s.gravity(("1", "2", "3")), "acceleration must be 3 numbers"),
    (lambda s: s.kill_old(np.timedelta64(3, "s")), "age_limit must be a number"),
    (lambda s: s.kill_old(10**5000), "age_limit must be .* got a value of type int"),
    (lambda s: s.configure(mass=motes.Uniform(2, 1)), "mass must be drawn from lo <= hi"),
    (lambda s: s.configure(mass=motes.Normal(2, -1)), "mass must be drawn with sigma >= 0"),
    (lambda s: s.configure(color=motes.Uniform((0, 0, 0), (1, 1))), "color must be 3 numbers"),
    (lambda s: s.configure(alpha=1e39), "alpha must be within 1e\\+37, got 1e\\+39"),
    (lambda s: s.gravity(9.8), "acceleration must be 3 numbers, got 9.8"),
    (lambda s: s.gravity((0, NAN, 0)), "acceleration must be 3 finite numbers"),
    (lambda s: s.gravity((0, 1e30, 0)), "acceleration must be"),
    (lambda s: s.damping((-1, 1, 1)), "damping must be 3 finite numbers >= 0"),
    (lambda s: s.damping((1, 1, 1), min_speed=5, max_speed=4), "min_speed must not be above max_speed"),
    (lambda s: s.damping((1, 1, 1), min_speed=-1), "min_speed must be"),
    (lambda s: s.bounce((0, 0, 0)), "shape must .*got a Point"),
    (lambda s: s.bounce(shapes.Line((0, 0, 0), (1, 0, 0))), "shape must .*got a Line"),
    (lambda s: s.bounce(BALL, restitution=-0.1), "restitution must be"),
    (lambda s: s.bounce(BALL, friction=1.1), "friction must be a finite number in 0..1, got 1.1"),
    (lambda s: s.bounce(BALL, friction=None), "friction must be a number, got None"),
    (lambda s: s.sink(BALL, inside="no"), "inside must be True or False"),
    (lambda s: s.kill_old("1"), "age_limit must be a number"),
    (lambda s: s.kill_old(NAN), "age_limit must be"),
    (lambda s: s.move(rotational=1), "rotational must be True or False"),
    (lambda s: s.apply("gravity"), "action must be an action of motes.actions"),
    (lambda s: s.apply(None), "action must be"),
    (lambda s: s.gather(to=1), "to must be 0 or 'all', got 1"),
    (lambda s: s.gather(to=True), "to must be 0 or 'all'"),
    (lambda s: s.total("age"), "expression must be 3 numbers, got 'age'"),
    (lambda s: s.total(ex.column("age") > 1), "expression must be a number, 3 numbers or an expression"),
    (lambda s: s.total(ex.column("heta")), "column must be one of .* got 'heta'; did you mean 'heat'"),
    (lambda s: s.total(ex.column("heat"), where=1), "where must be a shape or a comparison"),
    (lambda s: s.total(NAN), "expression must be a finite number, got nan"),
    (lambda s: s.histogram(ex.column("heat"), [1]), "edges must be ascending numbers, at least 2"),
    (lambda s: s.histogram(ex.column("heat"), 10), "edges must be ascending numbers"),
    (lambda s: s.histogram(ex.column("heat"), [0, 2, 1]), "edges must be ascending numbers"),
    (lambda s: s.histogram(ex.column("heat"), [0, 1, 1]), "edges must be ascending numbers"),
    (lambda s: s.histogram(ex.column("heat"), [0, NAN]), "edges must be ascending numbers"),
    (lambda s: s.histogram(ex.column("heat"), [0, INF, INF]), "edges must be ascending numbers"),
    (lambda s: s.histogram(ex.column("heat"), "abc"), "edges must be ascending numbers"),
    (lambda s: s.histogram(ex.column("heat"), range(2**24 + 2)), "edges must be of at most 16777216"),
    (lambda s: s.histogram(ex.column("wind"), [0, 1]), "expression must be .* one number per particle"),
    (
        lambda s: s.histogram(ex.column("heat"), [0, 1], weights=BALL),
        "weights must be a number, 3 numbers",
    ),
    (lambda s: s.histogram(ex.column("heat"), [0, 1], weights=(1, 2, 3)), "weights must be .* one number"),
    (lambda s: s.tally((0, 0, 0), (1, 1, 1), 9), "shape must be 3 integers, got 9"),
    (lambda s: s.tally((0, 0, 0), (1, 1, 1), (9, 9)), "shape must be 3 integers"),
    (lambda s: s.tally((0, 0, 0), (1, 1, 1), (9, 0, 9)), "shape must be an integer >= 1, got 0"),
    (lambda s: s.tally((0, 0, 0), (1, 1, 1), (9, 2.0, 9)), "shape must be an integer"),
    (lambda s: s.tally((0, 0, 0), (1, 1, 1), (1024, 1024, 1024)), "shape must be of at most 16777216 cells"),
    (lambda s: s.tally((0, 0, 0), (1, 1, 1), (10**400, 1, 1)), "shape must be of at most 16777216 cells"),
    (lambda s: s.tally((0, 0, 0), (1, 0, 1), (1, 1, 1)), "high must be above low"),
    (lambda s: s.tally((0, 0, 0), (1, 1), (1, 1, 1)), "high must be 3 numbers"),
    (lambda s: s.tally((0, 0, 0), (1, INF, 1), (1, 1, 1)), "high must be 3 finite numbers"),
    (lambda s: s.tally((1e9, 0, 0), (1e9 + 1e-6, 1, 1), (64, 1, 1)), "high must be above low"),
    (lambda s: setattr(s, "sprite", "disc"), "sprite must be a motes.Sprite"),
    (lambda s: list(s.world.frames(-1)), "n must be an integer >= 0"),
    (lambda s: list(s.world.frames(2.0)), "n must be an integer"),
]


@pytest.mark.parametrize(("call", "message"), CALLS, ids=[message[:40] for _, message in CALLS])
def test_calls(system, call, message):
    before = len(system.recorded)
    with pytest.raises(ArgumentError, match=message):
        call(system)
    assert len(system.recorded) == before, "nothing was recorded"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: shapes.Box((1, 0, 0), (0, 1, 1)), "low must not be above high"),
        (lambda: shapes.Box((0, 0, 0), (1, 1, NAN)), "high must be 3 finite numbers"),
        (lambda: shapes.Box((0, 0, 0), (1, 1, 1e20)), "1e12"),
        (lambda: shapes.Sphere((0, 0, 0), 0), "radius must be > 0"),
        (lambda: shapes.Sphere((0, 0, 0), -1), "radius must be"),
        (lambda: shapes.Sphere((0, 0, 0), 1, 2), "inner_radius must be"),
        (lambda: shapes.Sphere((0, 0, 0), "1"), "radius must be a number"),
        (lambda: shapes.Disc((0, 0, 0), (0, 0, 0), 1), "normal must not be zero"),
        (lambda: shapes.Disc((0, 0, 0), (0, 1, 0), 1, -1), "inner_radius must be"),
        (lambda: shapes.Plane((0, 0, 0), (0, 0, 0)), "normal must not be zero"),
        (lambda: shapes.Plane((0, 0, 0, 0), (0, 1, 0)), "point must be 3 numbers"),
        (lambda: shapes.Rectangle((0, 0, 0), (1, 0, 0), (2, 0, 0)), "u and v must span an area"),
        (lambda: shapes.Point("abc"), "p must be 3 numbers"),
        (lambda: BALL.contains([1, 2, 3, 4]), "points must be an array of shape"),
        (lambda: BALL.sample(-1), "n must be an integer"),
        (lambda: BALL.sample(1, seed=-1), "seed must be an integer"),
        (lambda: motes.Camera((0, 0, 0, 0), (0, 0, 0)), "position must be 3 numbers"),
        (lambda: motes.Camera((1e300, 0, 0), (0, 0, 0)), r"position must be 3 finite numbers in -1e\+15"),
        (lambda: motes.Camera(*VIEW, up=(0, 0, -2)), "up must be not parallel"),
        (lambda: motes.Camera(VIEW[0], VIEW[0]), "look_at must be different from camera.position"),
        (lambda: motes.Camera(*VIEW, fov_deg=0), "fov_deg must be a number above 0 and below 180"),
        (lambda: motes.Camera(*VIEW, fov_deg=180), "fov_deg must be a number above 0 and below 180"),
        (lambda: motes.Camera(*VIEW, near=0), "near must be a number above 0"),
        (lambda: setattr(motes.Camera(*VIEW), "fov_deg", 200), "fov_deg must be a number above 0"),
        (lambda: motes.Light((1e300, 0, 0)), r"position must be 3 finite numbers in -1e\+15"),
        (lambda: motes.Light((0, 0, 0), (1e300, 0, 0)), r"color must be 3 finite numbers in 0..1e\+15"),
        (lambda: motes.Sprite("square"), "kind must be"),
        (lambda: motes.Sprite(pixels=999), "pixels must be an integer in"),
        (lambda: motes.Sprite(blend="multiply"), "blend must be"),
        (lambda: motes.Renderer(0, 10, camera=CAMERA), "width must be an integer in"),
        (lambda: motes.Renderer(10, 10**6, camera=CAMERA), "height must be an integer in"),
        (lambda: motes.Renderer(10, 10, camera=(0, 0, 5)), "camera must be a motes.Camera"),
        (lambda: motes.Renderer(10, 10, camera=CAMERA, exposure=-1), "exposure must be"),
        (lambda: motes.Renderer(10, 10, camera=CAMERA, objects=[5]), "objects must be"),
        (lambda: motes.Renderer(10, 10, camera=CAMERA, path="magic"), "path must be"),
        (lambda: motes.Solid("ball"), "shape must be"),
        (lambda: motes.Solid((0, 0, 0)), "shape must be"),
        (lambda: motes.Solid(BALL | shapes.Line((0, 0, 0), (1, 0, 0))), "not a Point, Line or Blob"),
        (lambda: motes.Solid(BALL, (-1, 0, 0)), "color must be"),
        (lambda: motes.Solid(BALL, (1e300, 0, 0)), r"color must be 3 finite numbers in 0..1e\+15"),
        (lambda: setattr(motes.Renderer(9, 9, camera=CAMERA), "sun", (0, 1e300, 0)), "sun must be"),
        (lambda: motes.Roles(manager=0.5, image_generator=0, calculators=[0]), "manager must be an integer"),
    ],
)
def test_values(make, message):
    with pytest.raises(ArgumentError, match=message):
        make()


def test_an_error_carries_its_parts():
    with pytest.raises(ArgumentError) as caught:
        shapes.Sphere((0, 0, 0), -2)
    assert isinstance(caught.value, ValueError)
    assert (caught.value.argument, caught.value.value) == ("radius", -2)
    with pytest.raises(ArgumentError) as caught:  # raised by the engine
        shapes.Sphere((0, 0, 0), 1, 2)
    assert caught.value.argument == "inner_radius"


def test_what_numpy_makes_of_it_is_taken(system):
    for vector in ([1, 2, 3], np.arange(3), np.float32([1, 2, 3]), (np.int64(1), 2.5, 3), range(3)):
        system.gravity(vector)
    system.source(BALL, rate=np.float32(3))
    system.burst(np.zeros(3), count=np.int32(3))
    system.configure(mass=np.float64(2), size=2, velocity=np.zeros(3))
    system.emit(position=np.zeros((0, 3)))
    system.emit(position=np.asfortranarray(np.ones((2, 3), np.int64)))


@pytest.mark.parametrize("seed", range(4))
def test_ordinary_scripts_give_finite_particles(seed):
    """Random calls with numbers of ordinary size run, and all particles stay finite."""
    dice = random.Random(seed)

    def vector(scale: float = 5) -> tuple[float, float, float]:
        return (dice.uniform(-scale, scale), dice.uniform(-scale, scale), dice.uniform(-scale, scale))

    world = world_of(seed=seed, substeps=1 + seed)
    s = world.system("a", capacity=3000)
    regions: list[Callable[[], shapes.Shape]] = [
        lambda: shapes.Sphere(vector(), dice.uniform(0.1, 5)),
        lambda: shapes.Box((-1, -2, -3), vector(1) + np.array(1.0)),
        lambda: shapes.Disc(vector(), (0, 1, dice.random()), dice.uniform(0.1, 5)),
        lambda: shapes.Rectangle(vector(), (1, 0, 0), (0, 1, dice.random())),
        lambda: shapes.Plane(vector(1), (dice.random(), 1, 0)),
    ]
    with world:
        for _ in world.frames(25):
            s.configure(velocity=motes.Normal(vector(), (1, 2, 3)), lifetime=motes.Uniform(0.2, 0.5))
            s.source(dice.choice(regions)(), rate=dice.uniform(0, 9000), jitter=dice.random() < 0.5)
            s.gravity(vector(20))
            s.damping((0.5, 0.9, 1), max_speed=dice.uniform(1, 10))
            s.random_acceleration(dice.choice(regions)())
            for _ in range(3):
                s.bounce(dice.choice(regions)(), restitution=dice.random(), friction=dice.random())
            s.move()
            s.kill_expired()
            world.step()
        p = s.gather()
    assert len(p) > 100
    for column in (p.position, p.velocity, p.up, p.age):
        assert np.isfinite(column).all()
    assert np.abs(p.position).max() < 1e4
