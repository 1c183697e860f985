"""The functions of motes.expressions on NumPy arrays: the bits that the engine gives particles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import motes
from motes import expressions as ex
from motes.errors import ArgumentError

COUNT = 1000  # more than a block of the engine, and no multiple of a vector
X, Y, Z = np.random.default_rng(3).normal(0, 3, (3, COUNT)).astype(np.float32)
V, W = np.random.default_rng(4).normal(0, 2, (2, COUNT, 3)).astype(np.float32)
CURVE = motes.Curve([(0, 1), (1, 4), (3, 0.5)], "spline")
OF_NUMBERS: dict[str, Callable[[Any, Any, Any], Any]] = {
    **{
        name: lambda x, y, z, name=name: getattr(ex, name)(x)
        for name in ("sin", "cos", "exp", "log", "sqrt", "floor", "absolute", "sign")
    },
    **{
        name: lambda x, y, z, name=name: getattr(ex, name)(x, y)
        for name in ("atan2", "minimum", "maximum", "power", "step")
    },
    **{
        name: lambda x, y, z, name=name: getattr(ex, name)(x, y, z) for name in ("clamp", "mix", "smoothstep")
    },
    "power of 2": lambda x, y, z: ex.power(x, 2),
    "ramp": lambda x, y, z: ex.ramp(CURVE, x),
}
OF_VECTORS: dict[str, Callable[[Any, Any], Any]] = {
    "dot": ex.dot,
    "cross": ex.cross,
    "length": lambda v, w: ex.length(v),
    "normalize": lambda v, w: ex.normalize(v),
    "noise": lambda v, w: ex.noise(v, 0.3, octaves=3, field=7),
}


@pytest.fixture(scope="module")
def engine() -> Callable[[Any], np.ndarray]:
    """Return a function that computes an expression of particles with the columns x, y, z, v and w."""

    def compute(expression: Any, start: tuple[float, ...] | float) -> np.ndarray:
        world = motes.World(seed=1, progress="off")
        numbers = {name: 0.0 for name in "xyz"} | {name: (0.0, 0.0, 0.0) for name in "vw"}
        s = world.system("s", attributes={**numbers, "found": start})
        with world:
            s.emit(position=np.zeros((COUNT, 3)), x=X, y=Y, z=Z, v=V, w=W)
            s.set(found=expression)
            world.step()
            return np.array(s.gather().found)

    return compute


def alike(found: np.ndarray, wanted: np.ndarray) -> bool:
    """Tell whether the bits are equal where the engine sets the value: it keeps the previous one for NaN."""
    assert found.dtype == np.float32 and found.shape == wanted.shape
    known = np.isfinite(found)
    return bool(
        known.sum() > COUNT / 3 and (found[known].view(np.uint32) == wanted[known].view(np.uint32)).all()
    )


@pytest.mark.parametrize("name", OF_NUMBERS)
def test_numbers_have_the_bits_of_particles(engine: Callable[..., np.ndarray], name: str):
    function = OF_NUMBERS[name]
    found = function(X, Y, Z)
    assert alike(found, engine(function(*map(ex.column, "xyz")), 0.0))
    grid = function(*(a[:24].reshape(2, 3, 4) for a in (X, Y, Z)))
    np.testing.assert_array_equal(grid, found[:24].reshape(2, 3, 4))
    one = function(*(float(a[5]) for a in (X, Y, Z)))
    assert isinstance(one, np.float32)
    np.testing.assert_array_equal(one, found[5])


@pytest.mark.parametrize("name", OF_VECTORS)
def test_vectors_are_in_the_last_axis(engine: Callable[..., np.ndarray], name: str):
    function = OF_VECTORS[name]
    found = function(V, W)
    wide = found.ndim == 2
    assert alike(found, engine(function(ex.column("v"), ex.column("w")), (0.0,) * 3 if wide else 0.0))
    one = function(V[3], W[3])
    assert np.shape(one) == ((3,) if wide else ())
    np.testing.assert_array_equal(one, found[3])


def test_they_are_right_and_round_to_float32():
    x = np.linspace(0.1, 5, 50)
    for ours, theirs in ((ex.exp, np.exp), (ex.log, np.log), (ex.sin, np.sin), (ex.cos, np.cos)):
        np.testing.assert_allclose(ours(x), theirs(x), rtol=3e-6, atol=3e-7)
    np.testing.assert_allclose(ex.power(x, 2.5), x**2.5, rtol=1e-5)
    assert np.isnan(ex.log(np.array([-1.0]))).all() and ex.exp(np.array([])).shape == (0,)
    np.testing.assert_array_equal(ex.exp(np.arange(3)), ex.exp(np.float32([0, 1, 2])))
    np.testing.assert_array_equal(ex.choose(x > 2, x, 0), np.where(x > 2, np.float32(x), np.float32(0)))
    np.testing.assert_array_equal(ex.where(x > 2, 1, 0), x > 2)


def test_arrays_beside_columns_stay_parts_of_expressions():
    assert isinstance(ex.dot(ex.column("velocity"), np.array([0, 1, 0])), ex.Expression)
    assert isinstance(ex.power(ex.column("age"), np.float64(1.5)), ex.Expression)
    assert isinstance(ex.normalize((1, 2, 3)), ex.Expression)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ex.exp(np.array(["a"])), "a must be an array of real numbers"),
        (lambda: ex.sin(np.array([1j])), "angle must be an array of real numbers"),
        (lambda: ex.log(np.array([True])), "a must be an array of real numbers"),
        (lambda: ex.minimum(np.zeros(3), np.zeros(4)), "of a shape that fits"),
        (lambda: ex.dot(np.zeros((4, 2)), np.zeros((4, 2))), "last axis has 3 components"),
        (lambda: ex.length(np.float32(2)), "last axis has 3 components"),
        (lambda: ex.choose(np.zeros(3), 1, 2), "condition must be an array of booleans"),
    ],
)
def test_wrong_arrays_are_named(call: Callable[[], Any], message: str):
    with pytest.raises(ArgumentError, match=message):
        call()


def test_smoothstep_falls_where_its_ends_are_reversed():
    x = np.float32([-3, -1, 0.5, 2, 3])
    np.testing.assert_array_equal(ex.smoothstep(2, -1, x), [1, 1, 0.5, 0, 0])
    np.testing.assert_array_equal(ex.smoothstep(-1, 2, x), [0, 0, 0.5, 1, 1])
