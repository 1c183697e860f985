"""Colours as text, and curves as artists write them: splines, sums and products."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_values import equal_and_immutable

import motes
from motes import Curve
from motes.errors import ArgumentError

ORANGE = (1.0, 0.246201, 0.0)  # "#ff8800" in linear light


def light(encoded: float) -> float:
    return encoded / 12.92 if encoded <= 0.04045 else ((encoded + 0.055) / 1.055) ** 2.4


@pytest.mark.parametrize("text", ["#ff8800", "#FF8800", "#f80", " #f80 "])
def test_hexadecimal_colours_are_srgb(text: str):
    assert motes.Light((0, 0, 0), text).color == pytest.approx(ORANGE, abs=1e-6)


def test_names_are_those_of_css():
    css = pytest.importorskip("matplotlib.colors").CSS4_COLORS
    assert len(css) == 148
    for name, text in css.items():
        parts = [light(int(text[i : i + 2], 16) / 255) for i in (1, 3, 5)]
        assert motes.Light((0, 0, 0), name).color == pytest.approx(parts, abs=1e-12), name


@pytest.mark.parametrize(
    ("text", "hint"), [("orang", "'orange'"), ("#ff880", "CSS"), ("#gg0000", "CSS"), ("", "CSS")]
)
def test_other_texts_are_refused(text: str, hint: str):
    with pytest.raises(ArgumentError, match=hint) as caught:
        motes.Light((0, 0, 0), text)
    assert caught.value.argument == "color"


def test_text_stands_wherever_a_colour_does():
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    motes.Renderer(8, 8, camera=motes.Camera((0, 0, 1), (0, 0, 0)), background="skyblue", fog=("#fff", 3))
    with world:
        s.configure(color="#f80")
        s.burst((0, 0, 0), count=1)
        s.configure(color=motes.Uniform("#f80", "#f80"), lifetime=1)
        s.burst((0, 0, 0), count=1)
        s.emit(position=[(0, 0, 0), (1, 0, 0)], color=["#f80", "#f80"])
        s.emit(position=[(0, 0, 0)], color="#f80")
        s.configure(color=Curve([(0, "#f80"), (1, "#f80")]))
        s.burst((0, 0, 0), count=1)
        world.step()
        p = s.gather()
        np.testing.assert_allclose(p.color, np.tile(ORANGE, (6, 1)), atol=1e-5)
        s.target_color("lime", alpha=1, scale=1e9)
        s.color_over_life([(0, "black"), (1, "white")])
        s.set(color="#f80")
        world.step()
        np.testing.assert_allclose(s.gather().color, np.tile(ORANGE, (6, 1)), atol=1e-5)
    with pytest.raises(ArgumentError, match="velocity"):
        s.configure(velocity="red")


# --- splines, and curves combined

KEYS = st.lists(st.tuples(st.integers(0, 40), st.integers(-9, 9)), min_size=2, max_size=6).map(sorted)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(KEYS)
def test_splines_pass_through_their_keys_and_stay_between_them(keys):
    curve = Curve([(t / 8, v) for t, v in keys], "spline")
    for (start, a), (end, b) in zip(curve.keys, curve.keys[1:], strict=False):
        if start == end:
            continue
        assert curve(start) in {v for t, v in curve.keys if t == start}
        between = [curve(float(t)) for t in np.linspace(start, end, 40, endpoint=False)]
        assert min(a, b) - 1e-9 <= min(between) and max(between) <= max(a, b) + 1e-9
        assert np.all(np.diff(between) * (b - a) >= -1e-9), "monotone between two keys"


def test_a_spline_does_not_halt_at_keys_on_its_way():
    keys = [(0, 0), (1, 1), (2, 3), (3, 4)]
    spline, smooth = Curve(keys, "spline"), Curve(keys, "smooth")

    def slope(curve: Curve, t: float) -> float:
        return (curve(t + 1e-6) - curve(t - 1e-6)) / 2e-6

    assert slope(smooth, 2) == pytest.approx(0, abs=1e-4)
    assert slope(spline, 2) == pytest.approx(1.5, abs=1e-4)  # the mean slope of both sides
    assert slope(spline, 1 - 1e-5) == pytest.approx(slope(spline, 1 + 1e-5), abs=1e-3)
    assert slope(spline, 0) == pytest.approx(0, abs=1e-4) == slope(spline, 3)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(KEYS, st.sampled_from(["linear", "smooth", "spline"]), st.integers(0, 40), st.integers(0, 40))
def test_integrals_of_splines_and_of_combined_curves(keys, kind, low, high):
    curve = Curve([(t / 8, v) for t, v in keys], kind)
    low, high = sorted((low / 8 - 0.5, high / 8 - 0.5))
    middle = low + (np.arange(4000) + 0.5) * (high - low) / 4000
    for made in (curve, 2 - curve * curve * 0.5 + curve):
        fine = float(np.mean([made(float(t)) for t in middle])) * (high - low)
        steps = 2 * (1 + max(abs(made(t)) for t in made.times)) * len(keys) * (high - low) / 4000
        assert made.integral(low, high) == pytest.approx(fine, abs=steps + 1e-6)


def test_curves_add_subtract_and_multiply():
    a, b = Curve([(0, 1), (2, 5)]), Curve([(1, 2), (3, 4)], "hold")
    for t in (-1.0, 0.5, 1.0, 2.5, 9.0):
        assert (a + b)(t) == a(t) + b(t)
        assert (a - 1)(t) == a(t) - 1 and (1 - a)(t) == 1 - a(t)
        assert (a * b * 0.5)(t) == a(t) * b(t) * 0.5
        assert (-a)(t) == -a(t)
    way = Curve([(0, (0, 0, 0)), (1, (1, 2, 3))])
    assert (way * 2 + (0, 1, 0))(1) == (2.0, 5.0, 6.0)
    assert (way * a)(1) == (3.0, 6.0, 9.0)
    equal_and_immutable(a * b, a * b)
    assert pickle.loads(pickle.dumps(a + b)) == a + b != a * b
    assert dataclasses.replace(a, interpolation="spline") != a


@pytest.mark.parametrize("other", ["red herring", None, (1, 2, 3, 4), float("nan"), [[1]]])
def test_other_operands_are_refused(other):
    with pytest.raises(ArgumentError):
        Curve([(0, 1)]) * other


def test_combined_curves_stand_where_curves_do():
    world = motes.World(seed=1, dt=0.25, progress="off")
    s = world.system("s")
    ramp, half = Curve([(0, 0), (1, 40)], "spline"), Curve([(0, 1), (1, 0.5)])
    motes.Camera(Curve([(0, (0, 0, 5)), (1, (5, 0, 0))], "spline") + (0, 1, 0), (0, 0, 0), fov_deg=half * 40)
    with world:
        for _ in world.frames(4):
            s.source((0, 0, 0), rate=ramp * half)
            world.step()
        assert s.born == round((ramp * half).integral(0, 1)) == 13
        with pytest.raises(ArgumentError, match="rate"):
            s.source((0, 0, 0), rate=half - 2)
