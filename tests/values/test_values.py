"""Actions, shapes, sprites, solids, distributions and cameras as values; only cameras are mutable."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import math
import pickle
import pydoc
import re
from typing import Any

import numpy as np
import pytest

import motes
from motes import actions, shapes
from motes._values.values import Value
from motes.actions import Action
from motes.errors import NotAssignableError
from motes.expressions import column, maximum

BALL = shapes.Sphere((0, 1, 2), 3, 0.5)
FLOOR = shapes.Plane((0, 0, 0), (0, 1, 0))
NAMES: dict[str, Any] = {
    **vars(motes.expressions),
    **{name: getattr(motes, name) for name in motes.__all__},
    **vars(shapes),
    **vars(actions),
}

VALUES: list[Any] = [
    shapes.Point((1, 2, 3)),
    shapes.Line((0, 0, 0), (1, 0, 0)),
    shapes.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0)),
    shapes.Rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)),
    shapes.Disc((0, 0, 0), (0, 1, 0), 2, 1),
    FLOOR,
    shapes.Box((0, 0, 0), (1, 1, 1)),
    shapes.Cylinder((0, 0, 0), (0, 1, 0), 1),
    shapes.Cone((0, 0, 0), (0, 1, 0), 1),
    BALL,
    shapes.Blob((0, 0, 0), 1),
    BALL | FLOOR | (1, 2, 3),
    actions.Gravity(acceleration=(0, -9.8, 0)),
    actions.Gravity(acceleration=(0, -9.8, 0), where=BALL),
    actions.Gravity(acceleration=(0, -9.8, 0), where=(column("age") > 2) & ~BALL | (column("mass") == 1)),
    actions.OrbitPoint(center=(0, 0, 0), magnitude=1, epsilon=0.1, max_radius=math.inf),
    actions.KillOld(age_limit=-math.inf),
    actions.Jet(shape=BALL, acceleration=shapes.Box((0, 0, 0), (1, 1, 1))),
    actions.Bounce(shape=BALL | FLOOR, restitution=0.5, exact_hit=False),
    actions.CurlNoise(strength=1, scale=2, octaves=3),
    actions.ColorOverLife(ramp=[(0, (1, 0, 0)), (1, (0, 0, 1))]),
    actions.AlphaOverLife(ramp=[(0, 1), (1, 0)]),
    actions.SizeOverLife(ramp=[(0, 1), (1, (1, 2, 3))]),
    actions.KillExpired(),
    actions.Set(attribute="mass", value=2),
    actions.Set(attribute="velocity", value=-column("velocity") * 0.5 + (0, 1, 0)),
    actions.Set(attribute="mass", value=maximum(column("velocity").length(), column("up").y), where=BALL),
    motes.Sprite("point"),
    motes.Sprite(pixels=9),
    motes.Solid(BALL, (1, 0.5, 0)),
    motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=50),
    motes.Uniform(0, 1),
    motes.Uniform((0, 0, 0), (1, 1, 1)),
    motes.Normal(0, 2.5),
]


@pytest.mark.parametrize("index", range(len(VALUES)))
def test_a_value_equals_its_copies_and_no_other(index):
    value = VALUES[index]
    again = [
        copy.copy(value),
        copy.deepcopy(value),
        pickle.loads(pickle.dumps(value)),
        eval(repr(value), NAMES),
    ]
    for other in again:
        assert type(other) is type(value)
        assert other == value
        assert hash(other) == hash(value)
        assert repr(other) == repr(value)
    assert [i for i, other in enumerate(VALUES) if other == value] == [index]
    assert value != "something else"


def test_what_was_unpickled_runs():
    recorded = [value for value in VALUES if isinstance(value, actions.Action)]
    world = motes.World(seed=1, progress="off")
    systems = [world.system(name) for name in "ab"]
    with world:
        for _ in world.frames(3):
            for system, list_ in zip(systems, (recorded, pickle.loads(pickle.dumps(recorded))), strict=True):
                system.configure(lifetime=1)
                system.emit(position=[(0.1, 1, 2), (5, 5, 5)], velocity=[(1, -2, 3), (0, 0, 0)])
                system.apply(list_)
                system.move()
            world.step()
        a, b = (system.gather() for system in systems)
    np.testing.assert_array_equal(a.position, b.position)


def test_fields_are_numbers_and_tuples():
    ball = shapes.Sphere(np.float32([0, 1, 2]), np.int64(3))
    assert (ball.center, ball.radius, ball.inner_radius) == ((0, 1, 2), 3, 0)
    assert {type(number) for number in (*ball.center, ball.radius, ball.inner_radius)} == {float}
    gravity = actions.Gravity(acceleration=np.array([0, -1, 0]))
    assert gravity.acceleration == (0.0, -1.0, 0.0)
    assert repr(gravity) == "Gravity(acceleration=(0.0, -1.0, 0.0))"
    assert motes.Solid(BALL, [1, 0, 0]).color == (1.0, 0.0, 0.0)
    assert dataclasses.replace(BALL, radius=4).radius == 4
    assert dataclasses.replace(motes.Sprite(), pixels=9) == motes.Sprite(pixels=9)


def test_values_are_dataclasses_with_the_signature_of_their_fields():
    bounce, uniform = actions.Bounce, motes.Uniform
    assert str(inspect.signature(bounce)) == (
        "(shape: 'Shape | Sequence[Shape]', restitution: 'Number' = 1, friction: 'Number' = 0, "
        "min_tangential_speed: 'Number' = 0, exact_hit: 'bool' = True, hits: 'bool' = False, "
        "*, where: 'Where' = None) -> None"
    )
    assert str(inspect.signature(uniform)) == "(lo: 'ArrayLike | Curve', hi: 'ArrayLike | Curve') -> None"
    assert list(inspect.signature(shapes.Sphere).parameters) == ["center", "radius", "inner_radius"]
    assert uniform.__match_args__ == ("lo", "hi")
    assert (actions.Jet.__match_args__, actions.Law.__match_args__) == (("shape", "acceleration"), ())
    # Cameras are mutable: excluded here.
    for kind in {type(value) for value in VALUES if not isinstance(value, motes.Camera)}:
        fields = dataclasses.fields(kind)
        assert [field.name for field in fields] == list(kind._fields)
        assert {f.name: f.default for f in fields if f.default is not dataclasses.MISSING} == kind._defaults
    assert not dataclasses.is_dataclass(shapes.Shape)

    class Mine(bounce):
        def __init__(self, restitution: float) -> None:
            super().__init__(shape=FLOOR, restitution=restitution)

    assert list(inspect.signature(Mine).parameters) == ["restitution"]
    assert [field.name for field in dataclasses.fields(Mine)] == list(bounce._fields)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: motes.Wall(1), "Wall.*takes 1 positional argument but 2 were given"),
        (lambda: motes.Uniform(1, 2, 3), "Uniform.*takes 3 positional arguments but 4 were given"),
        (lambda: motes.Uniform(1, lo=2), "Uniform.*got multiple values for argument 'lo'"),
        (lambda: motes.Uniform(1), "Uniform.*missing 1 required argument: 'hi'"),
        (lambda: actions.Explosion(center=(0, 0, 0)), "missing 4 required arguments: 'radius', 'magnitude'"),
        (lambda: actions.Bounce(restitutoin=1), "unexpected keyword argument 'restitutoin'; did you mean"),
    ],
)
def test_arguments_that_do_not_fit_are_named(make, message):
    with pytest.raises(TypeError, match=message):
        make()


def test_what_the_caller_does_to_an_array_afterwards_changes_nothing():
    vector = np.array([0.0, -1.0, 0.0])
    color = [1.0, 0.0, 0.0]
    made = [
        actions.Gravity(acceleration=vector),
        shapes.Plane((0, 0, 0), -vector),
        shapes.Sphere(vector, 1),
        actions.Set(attribute="velocity", value=vector),
        motes.Uniform(vector, vector + 1),
        motes.Camera(vector + 9, vector),
        motes.Solid(BALL, color),
        actions.ColorOverLife(ramp=[(0, color)]),
    ]
    shown, hashes = list(map(repr, made)), list(map(hash, made))
    vector[:] = 7
    color[:] = [0, 0, 1]
    assert list(map(repr, made)) == shown
    assert list(map(hash, made)) == hashes


@pytest.mark.parametrize(
    ("value", "name", "message"),
    [
        (BALL, "radius", r"Sphere.radius cannot be assigned: values do not change; make a new Sphere"),
        (BALL, "raduis", "Sphere has no attribute 'raduis'; did you mean 'radius'"),
        (actions.Move(), "rotational", "Move.rotational cannot be assigned"),
        (motes.Sprite(), "pixels", "Sprite.pixels cannot be assigned"),
        (motes.Sprite(), "colour", "Sprite has no attribute 'colour'"),
        (motes.Solid(BALL), "color", "Solid.color cannot be assigned"),
        (motes.Uniform(0, 1), "lo", "Uniform.lo cannot be assigned"),
        (motes.Camera((0, 0, 5), (0, 0, 0)), "fov", "Camera has no attribute 'fov'; did you mean 'fov_deg'"),
        (column("age") > 1, "size", "are immutable"),
        (column("age"), "x", "are immutable"),
    ],
)
def test_assigning_to_a_value_raises_and_says_how(value, name, message):
    with pytest.raises(AttributeError, match=message):
        setattr(value, name, 1)


def test_attributes_of_cameras_and_renderers_are_checked_when_they_are_set():
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    renderer = motes.Renderer(16, 12, camera=camera, objects=[BALL])
    camera.position = np.array([1, 2])
    assert camera.position == (1.0, 2.0, 0.0)
    camera.position += np.array([0, 0, 3])
    assert camera == motes.Camera((1, 2, 3), (0, 0, 0))
    renderer.exposure = 2
    renderer.objects = [motes.Solid(FLOOR)]
    for name, value in (("exposure", -1), ("width", 0), ("camera", None), ("objects", [5]), ("path", "x")):
        before = getattr(renderer, name)
        with pytest.raises(motes.ArgumentError, match=name):
            setattr(renderer, name, value)
        assert getattr(renderer, name) is before
    with pytest.raises(NotAssignableError, match="did you mean 'exposure'"):
        renderer.exposre = 2
    with pytest.raises(NotAssignableError, match="linear is fixed"):
        renderer.linear = True


def test_two_numbers_stand_for_x_y_0():
    world = motes.World(seed=1, progress="off")
    s = world.system("a", attributes={"wind": (1, 2)})
    with world:
        s.configure(velocity=(1, 2), rotational_velocity=motes.Uniform((0, 0), (1, 1)))
        s.burst((3, 4))
        s.emit(position=[(1, 1), (2, 2)], velocity=np.ones((2, 2)))
        s.burst((5, 6), count=1)
        s.gravity((24, 24))
        s.set(up=(1, 0))
        world.step()
        p = s.gather()
    assert p.position.tolist() == [[3, 4, 0], [1, 1, 0], [2, 2, 0], [5, 6, 0]]
    assert p.velocity.tolist() == [[2, 3, 0], [2, 2, 0], [2, 2, 0], [2, 3, 0]]
    assert p.wind.tolist() == [[1, 2, 0]] * 4
    assert p.up.tolist() == [[1, 0, 0]] * 4
    assert (p.rotational_velocity[:, 2] == 0).all()
    assert shapes.Box((0, 0), (1, 1)) == shapes.Box((0, 0, 0), (1, 1, 0))
    assert BALL.contains([(0, 1), (9, 9)]).tolist() == BALL.contains([(0, 1, 0), (9, 9, 0)]).tolist()
    assert motes.Camera((0, 5), (1, 0)).position == (0, 5, 0)
    assert actions.Sink(shape=(1, 2)).shape == shapes.Point((1, 2, 0))
    for wrong in (
        lambda: s.configure(color=(1, 0)),
        lambda: motes.Solid(BALL, (1, 0)),
        lambda: actions.TargetColor(color=(1, 0), alpha=1, scale=1),
    ):
        with pytest.raises(motes.ArgumentError, match="color must be 3 numbers"):
            wrong()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: shapes.Spheer, "motes.shapes has no attribute 'Spheer'; did you mean 'Sphere'"),
        (lambda: actions.Gravty, "did you mean 'Gravity'"),
        (lambda: motes.balance.Pairwize, "did you mean 'Pairwise'"),
    ],
)
def test_names_of_modules_are_suggested(make, message):
    with pytest.raises(AttributeError, match=message):
        make()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: motes.World(balancer="Pairwis"), "did you mean 'Pairwise'"),
        (lambda: motes.World(combine="togehter"), "did you mean 'together'"),
        (lambda: motes.Sprite("dics"), "did you mean 'disc'"),
    ],
)
def test_allowed_texts_are_suggested(make, message):
    with pytest.raises(motes.ArgumentError, match=message):
        make()
    with pytest.raises(TypeError, match="'radus'; did you mean 'radius'"):
        shapes.Sphere((0, 0, 0), radus=1)
    with pytest.raises(TypeError, match="'acelleration'; did you mean 'acceleration'"):
        actions.Gravity(acelleration=(0, 0, 0))


PUBLIC = [getattr(motes, name) for name in motes.__all__ if name in ("Camera", "Renderer")] + [
    kind
    for module in (motes, motes.shapes)
    for name in module.__all__
    if isinstance(kind := getattr(module, name), type)
    and issubclass(kind, Value)
    and not issubclass(kind, Action)
]


@pytest.mark.parametrize("kind", PUBLIC, ids=lambda kind: kind.__name__)
def test_help_says_what_each_field_is(kind):
    text = pydoc.plain(pydoc.render_doc(kind)).partition("Method resolution order")[0]
    for name in (name for name in getattr(kind, "__annotations__", {}) if not name.startswith("_")):
        assert re.search(rf"\b{name}: [^'\s]|`{name}`", text), name


@pytest.mark.parametrize(
    ("call", "meant"),
    [
        (lambda: motes.World(fps=24), "dt=1/fps"),
        (lambda: motes.Sprite(size=3), "pixels"),
        (lambda: motes.Sprite(texture=3), "image"),
        (lambda: motes.shapes.Sphere((0, 0, 0), size=2), "radius"),
        (lambda: motes.Camera((0, 0, 1), target=(0, 0, 0)), "look_at"),
        (lambda: motes.Renderer(1, 1, camera=None, bg=0), "background"),
        (lambda: motes.actions.Gravity(acceleraton=1), "acceleration"),
    ],
)
def test_names_of_other_programs_are_answered_with_ours(call, meant):
    with pytest.raises(TypeError, match=f"did you mean '{meant}'"):
        call()
