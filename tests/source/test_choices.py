"""Options with a fixed set of strings: their types list them, and a misspelled one gets a suggestion."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from functools import partial
from typing import Any, get_args

import numpy as np
import pytest
from test_docstrings import PUBLIC

import motes
from motes import ArgumentError, actions, balance, replay
from motes._film.movie import Preset

CAMERA = motes.Camera((0, 0, 5), (0, 0, 0))
WORLD = ("axis", "space", "roles", "combine", "births", "clock", "on_loss", "progress")


def world(**options: Any) -> motes.World:
    return motes.World(seed=1, **options)


def balancer(kind: Any, text: str) -> None:
    required = [one for one in inspect.signature(kind).parameters.values() if one.default is one.empty]
    kind(*([1, 1] for _ in required), over=text)


def spawn(text: str) -> None:
    with world(progress="off") as own:
        s = own.system("s")
        s.spawn(s, on=text, count=1)


def gather(text: str) -> None:
    with world(progress="off") as own:
        own.system("s").gather(to=text)


MADE: dict[tuple[str, str], Callable[[str], object]] = {
    **{("motes.World", name): lambda text, name=name: world(**{name: text}) for name in WORLD},
    ("motes.World.system", "axis"): lambda text: world().system("s", axis=text),
    ("motes.World.system", "space"): lambda text: world().system("s", space=text),
    ("motes.Sprite", "kind"): motes.Sprite,
    ("motes.Sprite", "blend"): lambda text: motes.Sprite(blend=text),
    ("motes.Sprite", "facing"): lambda text: motes.Sprite(
        "image", image=np.zeros((1, 1, 4), np.uint8), facing=text
    ),
    ("motes.Sprite", "pick"): lambda text: motes.Sprite(
        "image", image=np.zeros((1, 2, 4), np.uint8), tiles=(2, 1), pick=text
    ),
    ("motes.Renderer", "path"): lambda text: motes.Renderer(8, 8, camera=CAMERA, path=text),
    ("motes.Renderer", "layers"): lambda text: motes.Renderer(8, 8, camera=CAMERA, layers=(text,)),
    ("motes.Curve", "interpolation"): lambda text: motes.Curve([(0, 1)], text),
    ("motes.Checkpoint", "every"): lambda text: motes.Checkpoint("checkpoints", every=text),
    ("motes.Movie", "preset"): lambda text: motes.Movie("a.mp4", preset=text),
    ("motes.actions.Align", "to"): lambda text: actions.Align(to=text),
    ("motes.actions.Gravitate", "far"): lambda text: actions.Gravitate(far=text),
    **{
        (f"motes.balance.{name}", "over"): partial(balancer, getattr(balance, name))
        for name in balance.BALANCERS
        if "over" in inspect.signature(getattr(balance, name)).parameters
    },
    ("motes.workloads.Pic", "distribution"): motes.workloads.Pic,
    ("motes.System.spawn", "on"): spawn,
    ("motes.System.gather", "to"): gather,
    ("motes.Runs.speedup", "layout"): lambda text: motes.Runs([]).speedup(layout=text),
    ("motes.replay.synthetic", "load"): replay.synthetic,
}
ELSEWHERE = {
    ("motes.Frame.layer", "name"),  # the layers that the renderer keeps
    ("motes.Frame.save", "bits"),
    ("motes.System.gravitate", "far"),  # checked by the action it makes
    ("motes.System.align", "to"),
    ("motes.script.options", "balancer"),  # checked by the command line
}
"""Options that other tests check, or that are not strings."""


def parameters(thing: Any) -> list[inspect.Parameter]:
    """Return the parameters of a public name; [] for exceptions with Python's constructor."""
    made_by_python = (
        inspect.isclass(thing) and issubclass(thing, BaseException) and "__init__" not in vars(thing)
    )
    if made_by_python or not callable(thing):
        return []
    return list(inspect.signature(thing).parameters.values())


def typed() -> dict[tuple[str, str], tuple[str, ...]]:
    """Return the strings that public signatures allow, by name and parameter."""
    found = {}
    for name, thing in PUBLIC.items():
        for parameter in parameters(thing):
            annotation = str(parameter.annotation)
            if annotation == "Preset":
                found[name, parameter.name] = get_args(Preset)
            for texts in re.findall(r"Literal\[(.*?)\]", annotation):
                found[name, parameter.name] = tuple(re.findall(r"[\"'](\w+)[\"']", texts))
    return found


TYPED = typed()


def test_every_option_of_a_few_texts_is_tried():
    assert set(TYPED) == set(MADE) | ELSEWHERE


@pytest.mark.parametrize("option", MADE, ids=".".join)
def test_a_text_that_is_nearly_allowed_is_answered_by_it(option: tuple[str, str]):
    for text in TYPED[option]:
        with pytest.raises(ArgumentError, match=re.escape(option[1])) as caught:
            MADE[option](text + text[-1])
        said = str(caught.value)
        assert all(f"'{one}'" in said for one in TYPED[option] if one != "world")
        meant = re.search(r"did you mean '(\w+)'\?$", said)
        assert meant is not None and meant[1] in TYPED[option]


def test_no_option_is_any_text():
    """Plain `str` parameters are only names, paths and sentences."""
    names = "attribute argument axes column extra field group name names need package student system text"
    sentences = "about action allowed description hint key line missing printed problem role size space url"
    plain = {*names.split(), *sentences.split(), "host"}
    taken = {
        f"{name}({parameter.name})"
        for name, thing in PUBLIC.items()
        for parameter in parameters(thing)
        if re.fullmatch(r"'?str( \| None)?'?", str(parameter.annotation)) and parameter.name not in plain
    }
    assert taken == set()
