"""Calls with random nonsense, over the whole public interface as Python's introspection describes it.

Only values are listed by hand: callables and their arguments come from signatures.
"""

from __future__ import annotations

import inspect
import math
import random
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

import motes
from motes import actions, shapes
from motes import expressions as ex

__all__ = ["NONSENSE", "constructors", "drawn", "methods", "shown"]

NAN, INF = math.nan, math.inf
BALL = shapes.Sphere((0, 0, 0), 1)
CAMERA = motes.Camera((0, 0, 5), (0, 0, 0))
Dice = random.Random


class Failing:
    """An object whose every method fails."""

    def _fail(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("of no consequence")

    __float__ = __int__ = __index__ = __array__ = __iter__ = __len__ = __getitem__ = _fail
    __repr__ = __str__ = __bool__ = __eq__ = __hash__ = _fail  # type: ignore[assignment]


class Odd(np.ndarray):
    """An array of a subclass."""


NONSENSE: list[Any] = [
    *(
        None,
        True,
        False,
        0,
        1,
        -1,
        2,
        0.5,
        -0.5,
        1e-40,
        1e20,
        1e300,
        -1e300,
        10**400,
        10**5000,
        NAN,
        INF,
        -INF,
        1j,
    ),
    *(
        "",
        "x",
        "nan",
        "1",
        b"1",
        "\ud800",
        "a\0b",
        [],
        (),
        {},
        set(),
        object(),
        int,
        len,
        lambda: 0,
        Ellipsis,
    ),
    *((1, 2), (1, 2, 3), (1, 2, 3, 4), (NAN, 0, 0), (INF, 0, 0), (None, 0, 0), ("a", 0, 0), (10**400, 0, 0)),
    *(
        (1e11, 0, 0),
        (1e15, 0, 0),
        (1e16, 0, 0),
        (1e30, 0, 0),
        (1e300, 0, 0),
        (True, False, True),
        [[1, 2, 3]],
    ),
    *(
        (1j, 0, 0),
        (1e-30, 0, 0),
        (1e-45, 0, 0),
        ("1", "2", "3"),
        [1, [2, 3]],
        (10**5000, 0, 0),
        -0.0,
        1e15,
        3e38,
    ),
    *(np.zeros(3), np.zeros((2, 3)), np.zeros((0, 3)), np.array([NAN, 0, 0]), np.float32(2), np.int64(-3)),
    *(np.zeros(0), np.array("text"), np.array(None), np.bool_(True), np.datetime64("2020"), np.ma.masked),
    *(
        np.timedelta64(3, "s"),
        np.longdouble("1e4000"),
        np.array([1j, 0, 0]),
        np.arange(3, dtype=">i2"),
        np.float16(2),
    ),
    *(np.ma.masked_array([1, 2, 3], [0, 1, 0]), np.array(["1", "2", "3"]), np.zeros(3, [("a", "f4")])),
    *(
        np.array([1, 2, 3], object),
        np.array([1, 2, 3], "m8[s]"),
        np.zeros(6)[::2],
        np.zeros((3, 3)).view(Odd),
    ),
    *(
        Fraction(1, 3),
        Decimal("0.5"),
        Decimal("sNaN"),
        [Fraction(1, 3), 0, 1],
        [Decimal("NaN"), 0, 0],
        range(3),
    ),
    *(
        bytearray(b"abc"),
        memoryview(b"abc"),
        Failing(),
        [Failing(), 0, 0],
        Path("x"),
        Path("x.png"),
        (-1, -1, -1),
    ),
    *(shapes.Point((0, 0, 0)), shapes.Line((0, 0, 0), (1, 0, 0)), shapes.Plane((0, 0, 0), (0, 1, 0)), BALL),
    *(shapes.Box((0, 0, 0), (0, 0, 0)), shapes.Disc((0, 0, 0), (0, 1, 0), 1), shapes.Sphere((0, 0, 0), 1e12)),
    *(
        shapes.Cone((0, 0, 0), (0, 1e11, 0), 1e-6),
        shapes.Cylinder((0, 0, 0), (0, 1e-6, 0), 1e11),
        ~BALL,
        BALL | BALL,
    ),
    *(shapes.Line((-1e12, 0, 0), (1e12, 0, 0)), shapes.Triangle((0, 0, 0), (1e-6, 0, 0), (0, 1e-6, 0))),
    *(shapes.Blob((0, 0, 0), 1e12), shapes.Rectangle((1e12, 0, 0), (1e-6, 0, 0), (0, 1e7, 0))),
    *(motes.Uniform(0, 1), motes.Uniform(1, 0), motes.Uniform((0, 0, 0), (1, 1, 1)), motes.Normal(0, 1)),
    *(
        motes.Normal((0, 0, 0), NAN),
        motes.Uniform(None, "x"),
        motes.Uniform(-3e38, 3e38),
        motes.Normal(0, 3e38),
    ),
    *(motes.Normal((0, 0, 0), (3e38, 1e20, 0)), motes.Sprite(), CAMERA, actions.Move(), [actions.Move(), 5]),
    *(ex.column("age"), ex.column("velocity"), ex.column("nothing"), ex.column("age") > 1),
    *(
        ex.column("velocity") > 1,
        ex.column("heat") / 0,
        ex.column("velocity") / ex.column("velocity"),
    ),
    *(
        motes.Curve([(0, 1)]),
        motes.Curve([(0, (0, 1, 0)), (0.01, (2, 0, 0))]),
        motes.Curve([(0, -1), (0, 1e30)]),
    ),
    *(
        ex.time(),
        ex.noise(ex.column("position")),
        np.sin(ex.column("age")) ** ex.time(),
    ),
    *([(0, 1)], [(0, (1, 1, 1))], [(1, 1), (0, 1)], [(NAN, 1)], [(0, 1), (0, 2)], {"heat": 0}, {"x y": 1}),
]

BASES = (shapes.Shape, actions.Action, motes.balance.Balancer)
BINARY = ("add", "sub", "mul", "truediv", "and", "or")
OTHERS = ("lt", "le", "gt", "ge", "eq", "ne", "invert", "neg", "abs", "getitem")
OPERATORS = [f"__{name}__" for name in (*BINARY, *(f"r{name}" for name in BINARY), *OTHERS)]
SENSE: dict[str, list[Any]] = {
    "Shape": [
        BALL,
        shapes.Plane((0, 0, 0), (0, 1, 0)),
        shapes.Box((-1, -1, -1), (1, 1, 1)),
        BALL | shapes.Cone((0, 0, 0), (0, 1, 0), 1),
    ],
    "ArrayLike": [(0, 1, 0), (1, 2, 3), (0.5, 0, 0)],
    "float": [0.5, 1, 2.5],
    "Vector": [(0, 1, 0), (1, 2, 3), (0.5, 0, 0), motes.Curve([(0, (0, 0, 0)), (0.1, (1, 2, 3))])],
    "Number": [0.5, 1, 2.5, motes.Curve([(0, 0.5), (0.1, 2)])],
    "int": [1, 3, 8],
    "bool": [True, False],
    "str": ["x", "age", "velocity", "disc", "death"],
    "Camera": [CAMERA],
    "Renderer": [motes.Renderer(16, 12, camera=CAMERA)],
    "path": [Path("x.mp4"), "auto"],
    "ramp": [[(0, 1), (1, 2)], [(0, (1, 1, 1))]],
    "where": [None, BALL, ex.column("age") > 0.1],
}


ATTRIBUTES = ("velocity", "mass", "heat", "wind", "size", "color", "position", "age", "lifetime", "up", "x")


def drawn(dice: Dice, call: Callable[..., Any], system: motes.System) -> tuple[list[Any], dict[str, Any]]:
    """Draw arguments for a signature, of which few, half or all are nonsense."""
    share = dice.choice([0.1, 0.5, 1.0])

    def value(name: str, annotation: str) -> Any:
        if dice.random() < share:
            return dice.choice(NONSENSE)
        fitting = [SENSE[key] for key in (name, *annotation.split(" | ")) if key in SENSE]
        return system if name == "into" else dice.choice(fitting[0] if fitting else NONSENSE)

    places: list[Any] = []
    named: dict[str, Any] = {}
    for name, parameter in inspect.signature(call).parameters.items():
        annotation = str(parameter.annotation)
        if parameter.kind is parameter.VAR_POSITIONAL:
            places += [value(name, annotation) for _ in range(dice.randrange(3))]
        elif parameter.kind is parameter.VAR_KEYWORD:
            named |= {attribute: value(name, "ArrayLike") for attribute in dice.sample(ATTRIBUTES, 2)}
        elif parameter.default is not parameter.empty and dice.random() < 0.5:
            continue
        elif parameter.kind is parameter.KEYWORD_ONLY:
            named[name] = value(name, annotation)
        else:
            places.append(value(name, annotation))
    return places, named


def methods(owner: Any, *without: str) -> list[Callable[..., Any]]:
    """Return the bound methods that a user may call."""
    kind = type(owner)
    names = [name for name in dir(kind) if not name.startswith("_") and name not in without]
    return [getattr(owner, name) for name in names if inspect.isfunction(inspect.getattr_static(kind, name))]


def constructors() -> list[Callable[..., Any]]:
    """Return constructors and operators of values, except those that scripts do not call."""
    not_made = (motes.System, motes.Particles, motes.Frame, motes.Run, motes.Runs, BaseException)
    made: list[Callable[..., Any]] = []
    for module in (motes, shapes, actions, motes.balance):
        for value in (getattr(module, name) for name in module.__all__ if not name.startswith("as_")):
            is_other = inspect.isclass(value) and (issubclass(value, not_made) or value in BASES)
            if (inspect.isclass(value) or inspect.isfunction(value)) and not is_other:
                made.append(value)
    for one in (ex.column("age"), ex.column("velocity"), ex.column("age") > 1, BALL, BALL | BALL):
        names = [name for name in OPERATORS if hasattr(one, name)]
        made += [getattr(one, name) for name in names] + methods(one)
    nowhere = motes.Frame(0, 0.0, None)  # a frame held by another rank: checks arguments and writes nothing
    return [
        *made,
        motes.World(seed=1, progress="off").system,
        nowhere.save,
        motes.Movie("x.mp4").write,
        motes.Export("x").write,
    ]


def shown(places: list[Any], named: dict[str, Any]) -> str:
    """Show arguments, even those that cannot be shown."""

    def one(value: Any) -> str:
        try:
            return repr(value)[:200]
        except Exception:
            return type(value).__name__

    return f"({', '.join([one(v) for v in places] + [f'{k}={one(v)}' for k, v in named.items()])})"
