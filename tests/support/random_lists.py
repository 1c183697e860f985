"""Random scripts drawn by hypothesis: births and lists of 1 to 12 actions, as users write them.

The arguments of an action follow from the fields of its class: a new action needs no change here.
"""

from __future__ import annotations

import dataclasses
import inspect
from functools import cache
from typing import Any

import numpy as np
from hypothesis import strategies as st
from random_clumps import templates, with_clumps
from random_laws import BETWEEN_KINDS, law, readable
from random_shapes import SURFACES, directions, numbers, shapes, triples
from random_worlds import PERIODS, allowed, balancers

from motes import actions
from motes._values.space import CURVES, in_a_row
from motes.errors import ArgumentError
from motes.expressions._conditions import MOST_STEPS

__all__ = ["FRAMES", "HEADER", "KINDS", "script"]

Text = st.SearchStrategy[str]
FRAMES = 5
SCALARS = ("age", "lifetime", "mass", "alpha", "heat")
TRIPLES = ("position", "velocity", "up", "rotational_velocity", "color", "size", "wind", "position_b", "spin")
HEADER = """\
import numpy as np
import motes
from motes import Normal, Uniform, expressions as ex
from motes.expressions import column, maximum, minimum
from motes.actions import *
from motes.shapes import *

def push(p):
    p.position[:] += np.float32(0.125) * (p.id % 3).astype(np.float32)[:, None]
    p.velocity[p.id % 4 == 0] *= np.float32(0.5)

def repel(p):
    return np.float32(0.125) * (p.position - p.other_position)
"""


# --- expressions and conditions


@cache
def scalars() -> Text:
    """Draw a scalar column, or a scalar computed from a vector column."""
    vector = st.sampled_from((*TRIPLES, "hit_normal"))
    part = st.tuples(vector, st.sampled_from([".x", "[1]", ".z", ".length()"]))
    return st.sampled_from((*SCALARS, "hit", "id")).map(column) | part.map(
        lambda drawn: column(drawn[0]) + drawn[1]
    )


def column(name: str) -> str:
    """Return the expression for a column."""
    return f'column("{name}")'


ONE = (
    *(
        "abs({})",
        "(-{})",
        "{}.floor()",
        "abs({}).sqrt()",
        "np.sin({})",
        "np.cos({})",
        "np.exp({})",
        "np.log({})",
    ),
    *("ex.sign({})", "({} * ex.time())", "({} + ex.noise(column('position'), ex.time(), octaves=2))"),
    *("({} * ex.dot(column('velocity'), ex.cross(column('up'), ex.normalize(column('position')))))",),
)
THREE = ("mix", "smoothstep", "clamp")


@cache
def names() -> dict[str, Any]:
    """Return the names that an expression uses."""
    known: dict[str, Any] = {}
    exec(HEADER, known)
    return known


def fits(text: str) -> bool:
    """Return whether an expression has few enough operations, even if multiplied by a vector."""
    try:
        return getattr(eval(text, names()), "_size", 0) <= MOST_STEPS - 8
    except ArgumentError as error:
        return "operations" not in str(error)


@cache
def expressions(leaves: Text) -> Text:
    """Draw an expression of columns and numbers."""
    constant = numbers(-3, 3).map(str)

    def larger(parts: Text) -> Text:
        other = parts | constant
        two = st.tuples(parts, st.sampled_from(["+", "-", "*", "/", "%", "**"]), other).map(
            lambda p: f"({p[0]} {p[1]} {p[2]})"
        )
        chosen = st.tuples(st.sampled_from(["minimum", "maximum", "ex.atan2", "ex.step"]), parts, other)
        one = st.tuples(parts, st.sampled_from(ONE))
        three = st.tuples(st.sampled_from(THREE), parts, other, other)
        return (
            two
            | chosen.map(lambda p: f"{p[0]}({p[1]}, {p[2]})")
            | one.map(lambda p: p[1].format(p[0]))
            | three.map(lambda p: f"ex.{p[0]}({p[1]}, {p[2]}, {p[3]})")
        )

    return st.recursive(leaves, larger, max_leaves=4).filter(fits)


@cache
def conditions() -> Text:
    """Draw a value for `where=`."""
    signs = st.sampled_from(["<", "<=", ">", ">=", "==", "!="])
    other = numbers(-1, 2).map(str) | scalars()
    compared = st.tuples(expressions(scalars()), signs, other).map(lambda p: f"({p[0]} {p[1]} {p[2]})")

    def larger(parts: Text) -> Text:
        two = st.tuples(parts, st.sampled_from("&|"), parts).map(lambda p: f"({p[0]} {p[1]} {p[2]})")
        return two | parts.map(lambda p: f"~{p}")

    return st.recursive(shapes() | compared, larger, max_leaves=4).filter(fits)


# --- actions: values by the name of a field, else by its type

NAMED: dict[str, st.SearchStrategy[Any]] = {
    "acceleration": triples(-20, 20),
    "velocity": triples(-6, 6),
    "rotational_velocity": triples(-6, 6),
    "axis": directions(),
    "look": directions(),
    "damping": triples(0, 1),
    "color": triples(0, 1),
    "epsilon": st.just(0.0) | numbers(0, 1),
    "sigma": numbers(0.125, 2),
    "scale": numbers(0.125, 4),
    "restitution": numbers(0, 1),
    "friction": numbers(0, 1),
    "alpha": numbers(0, 1),
    "age_limit": numbers(0, 0.25),
    "time_left": numbers(-0.125, 0.5),
    "magnitude": numbers(-4, 4),
    "min_speed": numbers(0, 2),
    "max_speed": numbers(2, 20),
    "grid": st.tuples(*[st.integers(1, 4)] * 3).map(
        lambda n: f"np.sin(np.arange({np.prod(n) * 3.0})).reshape({n} + (3,))"
    ),
    "low": triples(-3, -0.5),
    "high": triples(0.5, 3),
    "drag": numbers(0, 3),
    "points": st.lists(triples(-2, 2), min_size=2, max_size=6).filter(lambda p: p[0] != p[1]).map(str),
    "look_ahead": numbers(0.125, 2),
    "speed": numbers(0, 6),
    "angle_deg": numbers(0, 90),
}


@cache
def ties() -> Text:
    """Draw pairs of ids, some of which will never live."""
    one = st.integers(0, 99)
    pairs = st.lists(st.tuples(one, one).filter(lambda p: p[0] != p[1]), max_size=20, unique_by=frozenset)
    pinned = st.lists(one, max_size=2, unique=True)
    return st.tuples(pairs, numbers(0, 1), pinned).map(lambda p: f"motes.Ties({p[0]}, {p[1]}, pinned={p[2]})")


BETWEEN: dict[str, st.SearchStrategy[Any]] = {  # values for actions between particles
    "magnitude": numbers(0, 4),
    "max_radius": st.just(0.0) | numbers(0.001, 0.5),
    "radius": numbers(0.001, 0.25),
    "other_radius": st.none() | numbers(0.001, 0.25),
    "sleep": st.none() | numbers(0, 1),
    "stiffness": numbers(1, 1000),
    "rest_density": numbers(1, 1000),
    "clear": numbers(0, 1),
    "other": st.just("$"),  # the other of the two systems
    "far": st.sampled_from(["'exact'", "'cells'"]),
    "ties": ties(),
    "damping": numbers(0, 3),
    "bend": st.just(0.0) | numbers(0, 0.01),
    "break_at": st.just("np.inf") | numbers(1, 4),
}
TYPED: dict[str, st.SearchStrategy[Any]] = {
    "float": numbers(0, 3),
    "int": st.integers(1, 3),
    "bool": st.booleans(),
    "ArrayLike": triples(-2, 2),
    "float | None": numbers(0, 3),
    "Sequence[Shape | tuple[Shape, Wall]]": st.sampled_from(
        [
            "()",
            "(Plane((0, -1, 0), (0, 1, 0)),)",
            "(Box((-2, -2, -2), (2, 2, 2)), Sphere((0, -3, 0), 2))",
        ]
    ),
    'Literal["velocity"] | ArrayLike': st.just("'velocity'") | directions(),
}
KINDS: dict[str, type[actions.Action]] = {
    name: kind
    for name in actions.__all__
    if inspect.isclass(kind := getattr(actions, name))
    and issubclass(kind, actions.Action)
    and kind is not actions.Action
}


@cache
def field(kind: str, name: str, annotation: str) -> st.SearchStrategy[Any]:
    """Draw a value for a field of an action."""
    annotation = annotation.replace("Vector", "ArrayLike").replace("Number", "float")
    annotation = annotation.replace("'", '"')  # some versions of Python use the other quotes
    if annotation.endswith(" | Expression"):
        plain = field(kind, name, annotation.removesuffix(" | Expression"))
        each = scalars() if annotation.startswith("float") else st.sampled_from(TRIPLES).map(column)
        return plain | expressions(each)
    if kind in actions.between.__all__ and name in BETWEEN:
        return BETWEEN[name]
    if name == "ramp":
        value = triples(0, 1) if "ArrayLike" in annotation else numbers(0, 1)
        return st.lists(st.tuples(numbers(0, 1), value), min_size=1, max_size=12).map(sorted)
    if annotation in ("Shape", "Shape | Sequence[Shape]"):
        one = shapes(SURFACES) if kind in ("Bounce", "Avoid") else shapes()
        listed = st.lists(one, min_size=1, max_size=3).map(lambda parts: f"[{', '.join(parts)}]")
        return one if annotation == "Shape" else one | listed
    if annotation.startswith("Shape"):
        return shapes() | NAMED.get(name, TYPED["ArrayLike"]).map(str)
    if annotation == "ArrayLike" and name == "scale":
        return triples(0, 4)
    return TYPED[annotation] if annotation == "bool" else NAMED.get(name, TYPED[annotation])


@cache
@st.composite
def sets(draw: st.DrawFn, where: Text) -> str:
    """Draw a `Set`."""
    if draw(st.booleans()):
        attribute, value = draw(st.sampled_from(SCALARS)), draw(expressions(scalars()))
    else:
        attribute, value = (
            draw(st.sampled_from(TRIPLES)),
            draw(expressions(st.sampled_from(TRIPLES).map(column))),
        )
    return f'Set(attribute="{attribute}", value={value}, where={draw(where)})'


@cache
@st.composite
def one_action(draw: st.DrawFn, meets: bool) -> str:
    """Draw an action: two in three have no condition; one in three or none is between particles."""
    alone = st.sampled_from(sorted(KINDS.keys() - BETWEEN_KINDS))
    kind = draw(alone | alone | st.sampled_from(BETWEEN_KINDS) if meets else alone)
    where = st.just("None") | st.just("None") | conditions()
    if kind == "Set":
        return draw(sets(where))
    if kind in ("Law", "Interact"):
        return draw(law(kind, where, expressions, SCALARS, TRIPLES))
    arguments = []
    for part in dataclasses.fields(KINDS[kind]):
        if part.name == "where" or (part.default is not dataclasses.MISSING and draw(st.booleans())):
            continue
        if part.name == "other_radius" and "other=$" not in arguments:
            continue
        if part.name == "hits":
            arguments.append(f"hits={'exact_hit=False' not in arguments}")
            continue
        if part.name == "far" and any(text.startswith("max_radius") for text in arguments):
            continue
        arguments.append(f"{part.name}={draw(field(kind, part.name, str(part.type)))}")
    arguments.append(f"where={draw(where)}")
    action = f"{kind}({', '.join(arguments)})"
    if kind == "Rest":
        return f"[Bounce(shape={draw(shapes(SURFACES))}, restitution=0.25, hits=True), {action}]"
    return action


# --- births, and the other calls of a system


@cache
@st.composite
def distribution(draw: st.DrawFn, width: int, low: float, high: float) -> str:
    """Draw a value that `configure` takes for an attribute of 1 or 3 numbers."""
    one = numbers(low, high) if width == 1 else triples(low, high)
    first, second = draw(one), draw(one)
    kind = draw(st.sampled_from(["value", "Uniform", "Normal", "shape"]))
    if kind == "Uniform":
        pairs = [sorted(pair) for pair in zip(*(numbers_of(v) for v in (first, second)), strict=True)]
        lows, highs = zip(*pairs, strict=True)
        return f"Uniform({lows[0] if width == 1 else lows}, {highs[0] if width == 1 else highs})"
    if kind == "Normal":
        spread = draw(numbers(0, 1))
        return f"Normal({first}, {spread if width == 1 else (spread, spread / 2, 0.0)})"
    return draw(shapes()) if kind == "shape" and width == 3 else str(first)


def numbers_of(value: Any) -> tuple[float, ...]:
    """Make a tuple of one number."""
    return value if isinstance(value, tuple) else (value,)


@cache
def configured() -> Text:
    """Draw a call of `configure`."""
    wishes = {
        "velocity": distribution(3, -6, 6),
        "color": distribution(3, 0, 1),
        "up": distribution(3, -1, 1),
        "rotational_velocity": distribution(3, -3, 3),
        "size": distribution(3, 0, 0.5),
        "lifetime": distribution(1, 0.0625, 0.5),
        "mass": distribution(1, 0.125, 3),
        "age": distribution(1, 0, 0.25),
        "alpha": distribution(1, 0, 1),
        "heat": distribution(1, -1, 1),
        "wind": distribution(3, -1, 1),
        "velocity_b": distribution(3, -1, 1),
        "spin": distribution(3, -9, 9),
        "orientation": st.sampled_from(["'random'", "(0.5, -0.5, 0.5, 0.5)", "(0, 2, 0, 1)"]),
    }
    chosen = st.lists(st.sampled_from(sorted(wishes)), min_size=1, max_size=4, unique=True)
    arguments = chosen.flatmap(
        lambda names: st.tuples(*[wishes[n].map(lambda v, n=n: f"{n}={v}") for n in names])
    )
    return arguments.map(lambda parts: f"@.configure({', '.join(parts)})")


@cache
@st.composite
def emitted(draw: st.DrawFn) -> str:
    """Draw a call of `emit`."""
    rows = draw(st.integers(0, 5))
    arguments = [
        f"position={[draw(triples(-3, 3)) for _ in range(rows)]}" if rows else "position=np.zeros((0, 3))"
    ]
    if rows and draw(st.booleans()):
        arguments += [f"velocity={[draw(triples(-3, 3)) for _ in range(rows)]}"]
        arguments += [f"heat={[draw(numbers(-1, 1)) for _ in range(rows)]}"]
    return f"@.emit({', '.join(arguments)})"


@cache
def births() -> Text:
    """Draw a call that emits particles, or sets how they are born."""
    rate = numbers(0, 1500) | st.tuples(numbers(0, 1500), st.sampled_from(["linear", "smooth", "hold"])).map(
        lambda p: f"motes.Curve([(0, 100), (0.1, {p[0]})], {p[1]!r})"
    )
    source = st.tuples(shapes(), rate, st.booleans())
    moving = st.tuples(triples(-2, 2), triples(-2, 2), numbers(0, 1500), st.booleans())
    burst = st.tuples(shapes(), st.integers(0, 30) | st.integers(500, 1100))
    return st.one_of(
        configured(),
        source.map(lambda p: f"@.source({p[0]}, rate={p[1]}, jitter={p[2]})"),
        moving.map(
            lambda p: f"@.source(Sphere({p[0]}, 1), {p[2]}, {p[3]}, moving_from=Sphere({p[1]}, 0.5, 0.25))"
        ),
        burst.map(lambda p: f"@.burst({p[0]}, count={p[1]})"),
        triples(-2, 2).map(lambda p: f"@.burst({p})"),
        emitted(),
    )


@cache
@st.composite
def spawns(draw: st.DrawFn) -> str:
    """Draw a call of `spawn`."""
    into, on = draw(st.sampled_from("ab")), draw(st.sampled_from(["birth", "death", "collision", "frame"]))
    arguments = f"into={into}, on={on!r}, count={draw(st.integers(1, 3))}"
    part, where = draw(st.sampled_from([0, 0.5])), draw(st.just("None") | conditions())
    return f"@.spawn({arguments}, inherit_velocity={part}, where={where})"


OTHERS = (
    "@.callback(push)",
    "@.callback(push, where=column('age') > 0.125)",
    "@.gather()",
    "with @.local() as p: push(p)",
)


@cache
@st.composite
def calls(draw: st.DrawFn, meets: bool) -> list[str]:
    """Draw the lines of a frame: 1 to 12 actions, with births and other calls between them."""
    others = (*OTHERS, "@.pairs(repel, 0.25)") if meets else OTHERS
    lines = draw(st.lists(one_action(meets).map(lambda text: f"@.apply({text})"), min_size=1, max_size=12))
    ties = [line for line in lines if "Tie(" in line]
    # Ties that can tear must not share particles.
    if any("break_at=" in tie and "np.inf" not in tie for tie in ties):
        lines = [line for line in lines if line not in ties[1:]]
    for extra in draw(st.lists(births() | spawns() | st.sampled_from(others), max_size=5)):
        lines.insert(draw(st.integers(0, len(lines))), extra)
    if draw(st.integers(0, 3)):
        lines.append("@.move()")
    return readable([called(line, draw(st.sampled_from("aab"))) for line in lines])


def called(line: str, name: str) -> str:
    """Fill in the names of the list's system and of the other one."""
    return line.replace("@", name).replace("$", "b" if name == "a" else "a")


@st.composite
def script(draw: st.DrawFn) -> str:
    """Draw a script of two systems, with a list for even and one for odd frames.

    `note` is called with the particles' digest and the picture of each frame.
    """
    axes = st.sampled_from(["x", "y", "z", "xy", "zx", "yz", "xyz", None, "hilbert", "morton"])
    space = st.sampled_from(["None", "'fit'", *(rooms := ["(-2, 2)", "(0.5, 0.75)"])])
    facts = f"seed={draw(st.integers(0, 2**64 - 1))}, substeps={draw(st.integers(1, 3))}, space={draw(space)}"
    facts += (periods := draw(PERIODS))
    roles = draw(st.sampled_from(["auto", "shared"]))
    combine = draw(st.sampled_from(["together", "one_by_one", "overlapped"]))
    shared = draw(st.integers(0, 3)) == 0  # the second system shares the first one's domains
    cut = [draw(axes)] * 2 if shared else [draw(axes), draw(axes)]
    rows = all(in_a_row(axis or "id") for axis in cut)
    facts += f", roles={roles!r}, combine={combine!r}, balancer={draw(st.sampled_from(balancers(rows=rows)))}"
    lines = [
        f"world = motes.World({facts}, progress='off')",
        "world.renderer = motes.Renderer(32, 24, camera=motes.Camera((0, 1, 9), (0, 0, 0)))",
    ]
    clumps = draw(templates())
    for name, axis in zip("ab", cut, strict=True):
        capacity = draw(st.sampled_from([300, 40] if name in clumps else [3000, 700, 40]))
        options = f"capacity={capacity}, "
        own = f"axis={axis!r}, space={draw(st.sampled_from(rooms) if axis in CURVES else space)}"
        options += "domains_of=a" if shared and name == "b" else own
        lines.append(f"{name} = world.system({name!r}, {options}, attributes=dict(heat=0.5, wind=(0, 1, 0)))")
    lines += [f"{name}.clumps({template})" for name, template in clumps.items()]
    lines += ["with world:", f"    for frame in world.frames({FRAMES}):"]
    start = [line.replace("@", draw(st.sampled_from("ab"))) for line in draw(st.lists(births(), max_size=2))]
    start.append("a.source(Box((-2, -2, -2), (2, 2, 2)), rate=1500, jitter=True)")
    lines += [f"        {line}" for line in start]
    meets = draw(st.integers(0, 2)) > 0
    for test in ("frame % 2 == 0", "frame % 2 == 1"):
        drawn = allowed(periods, draw(calls(meets)))
        drawn = readable(draw(with_clumps(drawn, clumps if meets else {}, bool(periods))))
        lines += [f"        if {test}:", *(f"            {line}" for line in drawn)]
    if meets:
        lines += ["        picture = world.render()"]
    lines.append(f"        note(world.digest(), {'picture' if meets else 'world.render()'})")
    return "\n".join(lines) + "\n"
