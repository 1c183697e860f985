"""Methods that record actions: one per action, with its parameters and its documentation."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import itertools
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import motes
from motes import actions, shapes
from motes._system import action_methods
from motes._system.system import state_of

KINDS: dict[str, Any] = {
    re.sub("(?<!^)(?=[A-Z])", "_", name).lower(): getattr(actions, name)
    for name in actions.__all__
    if name not in ("Action", "Set", "Where")
}
"""The class of each method."""
BY_NAME = {"law": ["acceleration", "velocity", "set"]}
BY_NAME["interact"] = ["acceleration", "velocity", "spin", "set", "state", "other"]
"""Fields beside `where` that only a name can pass."""


def parameters(name: str) -> list[inspect.Parameter]:
    return list(inspect.signature(getattr(motes.System, name)).parameters.values())


def described(docstring: str | None) -> dict[str, str]:
    """Return what a docstring says of each parameter or field."""
    sections = re.split("(?:Args|Attributes):\n", inspect.cleandoc(docstring or ""))
    found = re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", "".join(sections[1:]).split("\n\n")[0], re.MULTILINE)
    return {name: " ".join(text.split()) for name, text in found}


def test_each_action_has_a_method():
    methods = inspect.getmembers(action_methods.ActionMethods, inspect.isfunction)
    assert {name for name, _ in methods} == {*KINDS, "__init__", "apply", "set"}
    assert len(KINDS) > 40


@pytest.mark.parametrize("name", KINDS)
def test_a_methods_parameters_are_the_fields_of_its_action(name: str):
    own, *taken = parameters(name)
    assert (own.name, own.kind) == ("self", own.POSITIONAL_OR_KEYWORD)
    fields = {field.name: field for field in dataclasses.fields(KINDS[name])}
    in_order = [*(field for field in fields if field != "where"), "where"]
    assert [p.name for p in taken] == in_order
    by_name = [*BY_NAME.get(name, []), "where"]
    assert [p.name for p in taken if p.kind is p.KEYWORD_ONLY] == by_name
    assert all(p.kind is p.POSITIONAL_OR_KEYWORD for p in taken if p.name not in by_name)
    assert {field.name for field in fields.values() if field.kw_only} == set(by_name)
    for p in taken:
        default = dataclasses.MISSING if p.default is p.empty else p.default
        assert (p.annotation, default) == (fields[p.name].type, fields[p.name].default)
    of_class = inspect.signature(KINDS[name]).parameters
    assert {p.name: p for p in taken} == dict(of_class), "a class takes its fields as the method does"


@pytest.mark.parametrize("name", KINDS)
def test_a_methods_documentation_is_that_of_its_action(name: str):
    method, kind = getattr(motes.System, name), KINDS[name]
    assert (method.__name__, method.__qualname__) == (name, f"System.{name}")
    lines = (inspect.getdoc(method) or "").splitlines()
    assert lines[0] == inspect.cleandoc(kind.__doc__).splitlines()[0]
    assert lines[1:5] == ["", f"Records `actions.{kind.__name__}`.", "", "Args:"]
    where = described(actions.Action.__doc__)
    assert described(method.__doc__) == described(kind.__doc__) | where
    assert list(described(method.__doc__)) == [p.name for p in parameters(name)[1:]]


def test_editors_show_the_first_sentence_of_each_action():
    tree = ast.parse(inspect.getsource(action_methods.ActionMethods))
    shown = {}
    for node, below in itertools.pairwise(tree.body[0].body):  # type: ignore[attr-defined]
        if isinstance(node, ast.Assign):
            assert isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
            shown[ast.unparse(node.targets[0])] = (ast.unparse(node.value), below.value.value)
    assert shown == {
        name: (f"recorded(actions.{kind.__name__})", inspect.cleandoc(kind.__doc__).splitlines()[0])
        for name, kind in KINDS.items()
    }


RIGHT = """
s.gravity((0, -9.81, 0))
s.gravity(acceleration=(0, -9.81, 0), where=Sphere((0, 0, 0), 1))
s.wind((1, 0, 0), 0.5)
s.wind((1, 0, 0), drag=motes.Curve([(0, 1), (2, 0)]))
s.follow()
s.gravitate(1, 1e-3, far="cells")
s.contact(1e4, walls=[Sphere((0, 0, 0), 1)], other=world.system("other"))
s.interact(0.5, acceleration=(0, 1, 0), state={"slip": 3})
s.law(velocity=(0, 1, 0), where=column("age") > 1)
s.kill_expired()
s.apply(actions.Wind((1, 0, 0), 0.5))
"""
WRONG = """
s.gravity()
s.gravity((0, 0, 0), Sphere((0, 0, 0), 1))
s.wind((1, 0, 0), drag="much")
s.wind((1, 0, 0), drag=0.5, gust=1)
s.gravitate(far="near")
s.contact(1e4, other="other")
s.interact(0.5, (0, 1, 0))
s.law((0, 1, 0))
s.kill_expired(3)
s.move(rotational="yes")
s.gravity((0, 0, 0)).x
"""
SCRIPT = """import motes
from motes import actions
from motes.expressions import column
from motes.shapes import Sphere

world = motes.World(seed=1)
s = world.system("s")
"""


@pytest.mark.slow
def test_a_type_checker_knows_the_parameters(tmp_path: Path):
    pytest.importorskip("mypy", reason="it comes with the group lint")
    (tmp_path / "script.py").write_text(f"{SCRIPT}{RIGHT}{WRONG}")
    package = Path(motes.__file__).parent.parent
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", "script.py"],
        cwd=tmp_path,
        env={"MYPYPATH": str(package), "PATH": ""},
        capture_output=True,
        text=True,
        timeout=250,
    )
    refused = re.findall(r"^script.py:(\d+): error", checked.stdout, re.MULTILINE)
    first = (SCRIPT + RIGHT).count("\n") + 2
    assert sorted(set(map(int, refused))) == [first + i for i in range(len(WRONG.split("\n")) - 2)], (
        checked.stdout
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.gravity(), r"System.gravity\(\) missing 1 required argument: 'acceleration'"),
        (lambda s: s.gravity((0, 1, 0), 2), r"System.gravity\(\) takes 2 positional arguments but 3 were"),
        (lambda s: s.gravity((0, 1, 0), acceleration=2), "System.gravity.*multiple values for argument 'acc"),
        (lambda s: s.interact(1, (0, 1, 0)), r"System.interact\(\) takes 2 positional arguments but 3"),
        (lambda s: s.law((0, 1, 0)), r"System.law\(\) takes 1 positional argument but 2 were given"),
        (
            lambda s: s.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitutoin=0.5),
            r"System.bounce\(\) got .*'restitutoin'; did you mean 'restitution'",
        ),
    ],
)
def test_arguments_that_do_not_fit_are_named_as_the_methods(call, message):
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        with pytest.raises(TypeError, match=message):
            call(s)
        assert s.recorded == [] and state_of(s).lines == []


def test_a_misspelt_argument_is_reported_with_the_near_name():
    world = motes.World(seed=1, progress="off")
    with world, pytest.raises(TypeError, match="'hight'"):
        world.system("t", hight=3)
    with pytest.raises(TypeError, match="'sead'; did you mean 'seed'"):
        motes.World(sead=3)


def test_values_may_stand_without_names_in_the_order_of_the_docs():
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        for _ in world.frames(1):
            s.source((0, 0, 0), 24.0)
            s.burst((0, 0, 0), 3)
            s.curl_noise(1.5, 0.5, 2, 0.25)
            s.orbit_line((0, 0, 0), (0, 1, 0), 2.0, 0.1, 5.0)
            s.kill_old(3, True)
            s.sink(shapes.Sphere((0, 0, 0), 9), False)
            assert s.recorded[2:] == [
                actions.CurlNoise(strength=1.5, scale=0.5, octaves=2, speed=0.25),
                actions.OrbitLine(point=(0, 0, 0), axis=(0, 1, 0), magnitude=2, epsilon=0.1, max_radius=5),
                actions.KillOld(age_limit=3, younger=True),
                actions.Sink(shape=shapes.Sphere((0, 0, 0), 9), inside=False),
            ]
            assert s.recorded[2] == actions.CurlNoise(1.5, 0.5, 2, 0.25)
            world.step()
