"""Expressions: every operation against NumPy, NumPy's own names, the time, and what is refused.

Random trees are checked node by node: the engine's result for a node must equal NumPy's for the same
operands, as the engine computed them. So errors do not add up, and jumps (floor, %, step) are no problem.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motes
from motes import expressions as ex
from motes.expressions import column
from motes.expressions._conditions import as_condition
from motes.expressions._expression import as_expression
from motes.shapes import Sphere

Array = np.ndarray
NOTHING = np.float32(-4321.5)  # kept by an attribute where the result is not finite
COUNT = 200


def particles() -> dict[str, Array]:
    dice = np.random.default_rng(7)
    special = np.float32([0, -0.0, 1, -1, 2, 0.5, 1e-30, -1e-30, 1e30, -1e30, 1e-42, 16777216, 3, -2.5])
    heat = np.concatenate([special, dice.normal(0, 2, COUNT - len(special))]).astype(np.float32)
    return {
        "position": dice.normal(0, 3, (COUNT, 3)).astype(np.float32),
        "velocity": (dice.normal(0, 1, (COUNT, 3)) * 10.0 ** dice.integers(-3, 4, (COUNT, 1))).astype(
            np.float32
        ),
        "heat": heat,
        "whole": np.round(dice.normal(0, 2, COUNT)).astype(np.float32),
    }


STATE = particles()


def computed(values: list[ex.Expression], widths: list[int], **world: Any) -> list[Array]:
    """Evaluate expressions in the engine; NOTHING stands for results that are not finite."""
    keep: dict[str, Any] = {f"v{i}": (NOTHING,) * w if w > 1 else NOTHING for i, w in enumerate(widths)}
    run = motes.World(seed=1, progress="off", **world)
    system = run.system("all", attributes={"heat": 0.0, "whole": 0.0, **keep})
    with run:
        system.emit(**STATE)
        for i, value in enumerate(values):
            system.set(**{f"v{i}": value})
        run.step()
        found = system.gather()
    return [getattr(found, f"v{i}") for i in range(len(values))]


def one(value: Any, width: int = 1) -> Array:
    return computed([value], [width])[0]


# --- each operation on float32 values: NumPy's result, and the allowed difference in ulp

f32, f64 = np.float32, np.float64


def wide(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function that computes in float64."""
    return lambda *values: function(*(np.asarray(v, f64) for v in values))


def smoothstep(low: Array, high: Array, x: Array) -> Array:
    t = np.minimum(np.maximum((x - low) / (high - low), f32(0)), f32(1))
    t = np.where(np.isnan(t), f32(0), t)
    return np.where(np.isnan(x), x, t * t * (f32(3) - f32(2) * t))


def total(a: Array) -> Array:
    return (a[:, 0] + a[:, 1] + a[:, 2])[:, None]


def cross(a: Array, b: Array) -> Array:
    return np.stack([a[:, j] * b[:, k] - a[:, k] * b[:, j] for j, k in ((1, 2), (2, 0), (0, 1))], axis=1)


def modulo(a: Array, b: Array) -> Array:
    return np.where(b == 0, np.nan, np.mod(a, b))


Rule = tuple[int, Callable[..., Any], Callable[..., Any], float]
EACH: dict[str, Rule] = {  # operands, the expression, NumPy's value, ulp
    "add": (2, lambda a, b: a + b, np.add, 0),
    "subtract": (2, lambda a, b: a - b, np.subtract, 0),
    "multiply": (2, lambda a, b: a * b, np.multiply, 0),
    "divide": (2, lambda a, b: a / b, np.divide, 0),
    "power": (2, lambda a, b: a**b, wide(np.power), 1),
    "square": (1, lambda a: a**2, np.square, 0),
    "modulo": (2, lambda a, b: a % b, wide(modulo), 0.5),
    "negate": (1, lambda a: -a, np.negative, 0),
    "absolute": (1, abs, np.abs, 0),
    "floor": (1, ex.floor, np.floor, 0),
    "sign": (1, ex.sign, np.sign, 0),
    "sqrt": (1, ex.sqrt, np.sqrt, 0),
    "exp": (1, ex.exp, wide(np.exp), 2),
    "log": (1, ex.log, wide(np.log), 1),
    "atan2": (2, ex.atan2, wide(np.arctan2), 1),
    "minimum": (2, ex.minimum, np.minimum, 0),
    "maximum": (2, ex.maximum, np.maximum, 0),
    "mix": (3, ex.mix, lambda a, b, t: a + (b - a) * t, 0),
    "step": (2, ex.step, lambda e, a: (a >= e).astype(f32), 0),
    "smoothstep": (3, ex.smoothstep, smoothstep, 0),
    "clamp": (3, ex.clamp, lambda a, low, high: np.minimum(np.maximum(a, low), high), 0),
}
TURNS: dict[str, Rule] = {
    "sin": (1, ex.sin, wide(np.sin), 2),
    "cos": (1, ex.cos, wide(np.cos), 2),
}
VECTORS: dict[str, Rule] = {
    "dot": (2, ex.dot, lambda a, b: total(a * b), 0),
    "cross": (2, ex.cross, cross, 0),
    "length": (1, ex.length, lambda a: np.sqrt(total(a * a)), 0),
    "normalize": (1, ex.normalize, lambda a: a / np.sqrt(total(a * a)), 0),
}
RULES = {**EACH, **TURNS, **VECTORS}
SCALARS = {"heat": column("heat"), "whole": column("whole"), "x": column("position").x}
TRIPLES = {"position": column("position"), "velocity": column("velocity")}


class Node:
    """An operation, its operands, and whether its result is a vector."""

    def __init__(self, name: str, parts: tuple[Node, ...] = (), number: float = 0.0) -> None:
        """Build the expression from those of the operands."""
        self.name, self.parts, self.number = name, parts, number
        if name in RULES:
            self.value = RULES[name][1](*(part.value for part in parts))
        else:
            self.value = as_expression("number", number) if name == "number" else {**SCALARS, **TRIPLES}[name]
        inner = any(part.vector for part in parts)
        self.vector = name in TRIPLES or (name in ("cross", "normalize") if name in VECTORS else inner)

    def leaf(self) -> Array:
        """Return the values of a number or column, of shape (n, 1) or (n, 3)."""
        if self.name == "number":
            return np.full((COUNT, 1), self.number, f32)
        array = STATE["position"][:, 0] if self.name == "x" else STATE[self.name]
        return array.reshape(COUNT, -1)

    def all(self) -> list[Node]:
        """List the operations, operands first."""
        return [node for part in self.parts for node in part.all()] + ([self] if self.parts else [])


def vectors(parts: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
    return parts.map(lambda node: node if node.vector else Node("multiply", (Node("position"), node)))


def trees() -> st.SearchStrategy[Node]:
    number = st.integers(-4000, 4000).map(lambda n: Node("number", number=n / 1000))
    leaves = st.sampled_from([*SCALARS, *TRIPLES]).map(Node) | number

    def larger(parts: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
        def of(names: dict[str, Rule], kind: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
            return st.sampled_from(sorted(names)).flatmap(
                lambda name: st.tuples(*[kind] * names[name][0]).map(lambda p, name=name: Node(name, p))
            )

        return of(EACH, parts) | of(TURNS, parts) | of(VECTORS, vectors(parts))

    return st.recursive(leaves, larger, max_leaves=6).filter(lambda node: bool(node.parts))


def check(node: Node, found: dict[int, Array]) -> None:
    """Compare a node's result with NumPy's for the same operands."""
    operands = [found[id(part)] if part.parts else part.leaf() for part in node.parts]
    known = np.ones((COUNT, 1), bool)
    for operand in operands:
        known = known & (operand != NOTHING).all(axis=1, keepdims=True)
    with np.errstate(all="ignore"):
        exact = np.asarray(RULES[node.name][2](*operands))
        ours = np.broadcast_to(found[id(node)], np.broadcast_shapes(exact.shape, found[id(node)].shape))
        wanted = np.asarray(exact, f32)
        finite = np.isfinite(wanted)
        near = np.abs(ours.astype(f64) - exact) <= RULES[node.name][3] * ulp(exact)
        if node.name in TURNS:  # large angles are reduced with errors
            near |= (np.abs(operands[0]) > 1e6) & (np.abs(ours - exact) < 3e-7)
            near |= np.abs(operands[0]) > 1e9
    right = np.where(finite, near | (ours == wanted), ours == NOTHING)
    right |= np.abs(exact) > 3.4e38  # rounds to the largest float32 or to infinity
    wrong = np.argwhere(~right & known)
    if len(wrong):
        i, c = wrong[0]
        values = [float(o[i, c % o.shape[1]]) for o in operands]
        pytest.fail(f"{node.value!r}: {node.name}{values} = {exact[i, c]}, got {ours[i, c]}", pytrace=False)


def ulp(values: Array) -> Array:
    return np.spacing(np.maximum(np.abs(values.astype(f32)), f32(1e-45))).astype(f64)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(trees())
def test_every_node_of_random_trees_is_what_numpy_makes_of_its_operands(tree: Node) -> None:
    nodes = tree.all()
    try:
        arrays = computed([n.value for n in nodes], [3 if n.vector else 1 for n in nodes])
    except motes.ArgumentError as error:
        assert "operations" in str(error) or "values at once" in str(error)
        return
    found = {id(n): array.reshape(COUNT, -1) for n, array in zip(nodes, arrays, strict=True)}
    for node in nodes:
        check(node, found)


@pytest.mark.parametrize("name", RULES)
def test_each_operation_of_columns(name: str) -> None:
    leaves = [Node(n) for n in (TRIPLES if name in VECTORS else {**SCALARS, **TRIPLES})]
    for first in leaves:
        for second in leaves:
            node = Node(name, (first, second, Node("heat"))[: RULES[name][0]])
            width = 3 if node.vector else 1
            check(node, {id(node): one(node.value, width).reshape(COUNT, width)})


# --- conditions


def test_choose_takes_conditions_and_shapes():
    heat, p = STATE["heat"], STATE["position"]
    np.testing.assert_array_equal(
        one(ex.choose(column("heat") > 0.5, column("heat"), -1)), np.where(heat > 0.5, heat, f32(-1))
    )
    whole = STATE["whole"]
    np.testing.assert_array_equal(one(ex.choose(column("whole") >= 1, 1, 0)), np.where(whole >= 1, 1, 0))
    ball = Sphere((0, 0, 0), 3)
    inside = ball.contains(p)[:, None]
    np.testing.assert_array_equal(one(ex.choose(ball, column("position"), 7), 3), np.where(inside, p, f32(7)))
    assert 0 < inside.sum() < COUNT
    both = ball & (column("heat") < 0)
    np.testing.assert_array_equal(one(np.where(both, 1, 0)), np.where(inside[:, 0] & (heat < 0), 1, 0))


def test_conditions_compare_functions():
    world = motes.World(seed=1, progress="off")
    s = world.system("s", attributes={"heat": 0.0, "whole": 0.0})
    with world:
        s.emit(**STATE)
        world.step()
        p = STATE["position"].astype(f64)
        angle = np.arctan2(p[:, 2], p[:, 0])
        assert (
            s.total(1, where=ex.atan2(column("position").z, column("position").x) > 0.5)
            == (angle > 0.5).sum()
        )
        power = s.total(ex.sin(column("whole")) * ex.normalize(column("position")))
        unit = p / np.linalg.norm(p, axis=1, keepdims=True)
        np.testing.assert_allclose(
            power, (np.sin(STATE["whole"].astype(f64))[:, None] * unit).sum(axis=0), atol=1e-5
        )


# --- NumPy's names


def test_numpy_makes_the_same_expressions():
    a, b = column("heat"), column("position")
    for made, meant in (
        (np.sin(a), ex.sin(a)),
        (np.cos(a), ex.cos(a)),
        (np.exp(a), ex.exp(a)),
        (np.log(a), ex.log(a)),
        (np.sqrt(a), ex.sqrt(a)),
        (np.floor(a), ex.floor(a)),
        (np.sign(a), ex.sign(a)),
        (np.abs(a), abs(a)),
        (np.arctan2(a, 2), ex.atan2(a, 2)),
        (np.maximum(a, b), ex.maximum(a, b)),
        (np.minimum(2, b), ex.minimum(2, b)),
        (np.clip(b, 0, a), ex.clamp(b, 0, a)),
        (np.where(a > 1, b, 0), ex.choose(a > 1, b, 0)),
        (np.dot(b, (1, 2, 3)), ex.dot(b, (1, 2, 3))),
        (np.cross(b, np.array([0, 1, 0])), ex.cross(b, (0, 1, 0))),
        (np.linalg.norm(b), b.length()),
        (np.power(a, 2), a**2),
        (np.float32(2) ** a, 2**a),
        (np.mod(a, 3), a % 3),
        (5 % a, np.float64(5) % a),
        (np.float32(2) * a, 2 * a),
        (np.array([1, 2, 3]) * a, (1, 2, 3) * a),
        (b - np.array([1.0, 2, 3]), b - (1, 2, 3)),
        (np.array(2.0) / a, 2 / a),
        (np.int64(2) + a, 2 + a),
        (-a, np.negative(a)),
    ):
        assert isinstance(made, ex.Expression)
        assert repr(made) == repr(meant)
    for compared, told in (
        (np.float32(2) > a, a < 2),
        (np.less_equal(2, a), a >= 2),
        (np.array(1) == a, a == 1),
    ):
        assert isinstance(compared, motes.expressions.Condition)
        assert isinstance(told, motes.expressions.Condition)


REGION = Sphere((0, 0, 0), 1)


@pytest.mark.parametrize("held", [REGION, REGION | (5, 0, 0), ~REGION, column("heat") > 1])
def test_numpy_takes_what_holds_particles_as_choose_and_signs_do(held: Any):
    for made, meant in (
        (np.where(held, 1, 2), ex.choose(held, 1, 2)),
        (np.logical_and(held, REGION), held & REGION),
        (np.bitwise_and(REGION, held), REGION & held),
        (np.logical_or(held, column("age") > 1), as_condition("", held) | (column("age") > 1)),
        (np.logical_not(held), ~held),
        (np.invert(held), ~held),
    ):
        assert type(made) is type(meant) and repr(made) == repr(meant)


KINDS = [REGION, REGION | (5, 0, 0), column("heat") > 1, motes.Curve([(0, 1), (1, 2)]), motes.Uniform(0, 1)]
CALLS: list[Callable[[Any], Any]] = [
    *(np.any, np.all, np.sum, np.max, np.mean, np.sqrt, np.isfinite, np.count_nonzero, np.argwhere, np.round),
    *(np.nonzero, np.shape, lambda one: np.select([one], [1], 0), lambda one: np.choose(one, [1, 2])),
    *(lambda one: np.where([1, 0], one, one), lambda one: np.piecewise(one, [one], [1, 2])),
    *(lambda one: np.maximum(one, 1), lambda one: np.array([1.0, 2]) * one, lambda one: np.isclose(one, 1)),
    *(lambda one: np.extract(one, [1]), lambda one: np.array_equal(one, one), lambda one: np.isin(one, [1])),
    *(lambda one: np.interp(one, [0, 1], [2, 3]), lambda one: np.float32(2) + one),
]


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("given", KINDS, ids=lambda one: type(one).__name__)
def test_numpy_makes_no_constant_of_what_differs_by_particle_or_time(given: Any, call: Any):
    with pytest.raises(motes.ArgumentError):
        call(given)


@pytest.mark.parametrize("call", [bool, lambda one: one and 1, lambda one: np.where([one], 1, 2)])
def test_what_holds_particles_is_not_tested_in_python(call: Any):
    for held in (REGION, REGION & REGION, column("heat") > 1):
        with pytest.raises(motes.ArgumentError, match="combined with & | ~"):
            call(held)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda a: np.arcsinh(a), "function must be one that expressions support: .*, got 'numpy.arcsinh'"),
        (lambda a: np.tan(a), "'numpy.tan'"),
        (lambda a: np.add.reduce(a), "'numpy.add.reduce'"),
        (lambda a: np.sum(a), "'numpy.sum'"),
        (lambda a: np.sin(a, where=[True]), "where must be left out"),
        (lambda a: np.array([1, 2, 3, 4]) * a, "operand must be 3 numbers"),
        (lambda a: np.array(["x"]) * a, "operand must be 3 numbers"),
        (lambda a: ex.sin("x"), "operand must be 3 numbers"),
        (lambda a: ex.sin(a > 1), "operand must be a number, 3 numbers or an expression"),
        (lambda a: ex.choose(a, 1, 2), "condition must be a shape or a comparison"),
        (lambda a: ex.noise(column("position"), octaves=9), "octaves must be an integer in 1..8, got 9"),
        (lambda a: ex.noise(column("position"), field=-1), "field must be an integer in 0..65535"),
        (lambda a: column("position") ** column("position") ** "x", "operand must be"),
    ],
)
def test_what_cannot_be_said_is_refused_at_the_call(make: Callable[[Any], Any], message: str) -> None:
    with pytest.raises(motes.ArgumentError, match=message):
        make(column("heat"))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ex.dot(column("heat"), column("velocity")), "dot must be of vectors"),
        (lambda: ex.cross((1, 2, 3), column("heat")), "cross must be of vectors"),
        (lambda: ex.normalize(column("heat")), "normalize must be of vectors"),
        (lambda: ex.noise(column("heat")), "noise must be of vectors"),
        (lambda: ex.noise(column("position"), column("position")), "time must be one number"),
        (lambda: ex.sin(column("haet")), "column must be one of .* did you mean 'heat'"),
    ],
)
def test_vectors_and_columns_are_checked_where_the_system_is_known(
    make: Callable[[], Any], message: str
) -> None:
    with pytest.raises(motes.ArgumentError, match=message):
        one(make())


def test_expressions_are_values_that_read_back():
    a, p = column("heat"), column("position")
    for value in (
        *(ex.sin(a), ex.cos(a), ex.exp(a), ex.log(a), ex.sign(a), ex.atan2(a, 1), a**2, a**1.5, a % 3, 2**a),
        *(ex.mix(a, 1, 2), ex.step(a, 1), ex.smoothstep(0, 1, a), ex.clamp(a, 0, 1), ex.choose(a > 1, a, 2)),
        *(
            ex.dot(p, p),
            ex.cross(p, (0, 1, 0)),
            ex.normalize(p),
            p.length(),
            ex.noise(p, ex.time(), octaves=3),
        ),
    ):
        again = eval(repr(value), vars(ex) | {"abs": abs})
        assert repr(again) == repr(value)
        assert repr(pickle.loads(pickle.dumps(value))) == repr(value)
        np.testing.assert_array_equal(one(again, 3), one(value, 3))
    long = a > 0
    for _ in range(250):
        long = ~long
    with pytest.raises(motes.ArgumentError, match="of at most 256 operations"):
        _ = pickle.loads(pickle.dumps(long)) & long
