"""Signatures of the recording calls: parameters, their order, and which may be positional."""

from __future__ import annotations

import dataclasses
import inspect
import runpy
from pathlib import Path

import pytest

import motes
from motes import actions, shapes
from motes._system.recorder import Recorder

ROOT = Path(__file__).resolve().parents[2]


def recorders() -> list[str]:
    return [
        name
        for name, call in inspect.getmembers(Recorder, inspect.isfunction)
        if name not in ("apply", "__init__")
    ]


@pytest.mark.parametrize("name", recorders())
def test_parameters_of_a_call_are_the_actions_fields_in_order_with_their_defaults(name):
    parameters = list(inspect.signature(getattr(Recorder, name)).parameters.values())[1:]
    kind = getattr(actions, "".join(part.capitalize() for part in name.split("_")))
    if name == "set":
        assert [p.name for p in parameters] == ["where", "attributes"]
        return
    fields = {field.name: field.default for field in dataclasses.fields(kind) if field.name != "where"}
    by_place = [p.name for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD]
    assert by_place == list(fields)[: getattr(kind, "_by_name", None)]
    defaults = {
        p.name: dataclasses.MISSING if p.default is p.empty else p.default for p in parameters[: len(fields)]
    }
    assert list(defaults) == list(fields)
    assert defaults == fields
    assert parameters[-1].name == "where"
    assert parameters[-1].kind is parameters[-1].KEYWORD_ONLY


def test_the_files_of_the_calls_are_written_from_the_actions():
    script = ROOT / ".ci" / "recorder"
    if not script.is_file():
        pytest.skip("the script stands in the source tree")
    writer = runpy.run_path(str(script))
    for file, text in writer["pages"]().items():
        assert file.read_text() == text, "run `python .ci/recorder`"


def test_a_misspelt_argument_is_reported_with_the_near_name():
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        with pytest.raises(TypeError, match="'restitutoin'; did you mean 'restitution'"):
            s.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitutoin=0.5)
        with pytest.raises(TypeError, match="'hight'"):
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
            world.step()
