"""Key frames: values, integrals, births by the integral of the rate, and where curves are accepted."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from launching import command
from PIL import Image
from standing import COMMAND_LINE, alike, on_ranks

import motes
from motes import Curve, actions
from motes.expressions import column
from motes.shapes import Box, Sphere

NAN, INF = float("nan"), float("inf")
KINDS = ("linear", "smooth", "hold")


@st.composite
def curves(draw: st.DrawFn, low: float = 0, high: float = 500) -> Curve:
    times = sorted(draw(st.lists(st.integers(-8, 24).map(lambda n: n / 8), min_size=1, max_size=6)))
    values = [draw(st.integers(int(low * 4), int(high * 4))) / 4 for _ in times]
    return Curve(list(zip(times, values, strict=True)), interpolation=draw(st.sampled_from(KINDS)))


# --- values


def test_a_curve_has_its_keys_values_and_interpolates_between_them():
    keys = [(1, 10), (2, 20), (4, -20)]
    linear, smooth, hold = (Curve(keys, interpolation=kind) for kind in KINDS)
    for curve in (linear, smooth, hold):
        assert [curve(t) for t, _ in keys] == [v for _, v in keys]
        assert (curve(-5), curve(9), curve(INF)) == (10, -20, -20)
        assert isinstance(curve(1), float)
    assert linear(1.25) == 12.5 and linear(3) == 0
    assert smooth(1.25) == 10 + 10 * (3 * 0.25**2 - 2 * 0.25**3) and smooth(3) == 0
    assert hold(1.99) == 10 and hold(3.99) == 20
    way = Curve([(0, (0, 0)), (2, np.array([2, 4, 6]))])
    assert way(1) == (1.0, 2.0, 3.0)
    jump = Curve([(0, 1), (1, 1), (1, 5), (2, 5)])
    assert (jump(0.999), jump(1), jump(1.5)) == (1, 5, 5)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(curves(), st.integers(-16, 40), st.integers(0, 40))
def test_integrals_are_those_of_a_fine_sum(curve: Curve, start: int, length: int):
    low, high = start / 8, (start + length) / 8
    n = 4000
    middle = low + (np.arange(n) + 0.5) * (high - low) / n
    fine = sum(curve(float(t)) for t in middle) * (high - low) / n
    assert curve.integral(low, high) == pytest.approx(fine, rel=1e-3, abs=500 * (high - low) / n * 6)
    inside = low + (high - low) / 3
    assert curve.integral(low, inside) + curve.integral(inside, high) == pytest.approx(
        curve.integral(low, high)
    )


def test_curves_are_values():
    curve = Curve([(0, 1), (1, (2))], interpolation="smooth")
    for again in (pickle.loads(pickle.dumps(curve)), copy.copy(curve), eval(repr(curve), vars(motes))):
        assert again == curve and hash(again) == hash(curve) and again(0.3) == curve(0.3)
    assert curve != Curve([(0, 1), (1, 2)])
    with pytest.raises(AttributeError, match="cannot be assigned"):
        curve.keys = ()  # type: ignore[misc]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Curve([]), "keys must be a list of .time, value., at least one"),
        (lambda: Curve(5), "keys must be a list"),
        (lambda: Curve([(0, 1, 2)]), "keys must be a list"),
        (lambda: Curve([(1, 0), (0, 1)]), "keys must be times in ascending order"),
        (lambda: Curve([(0, NAN)]), "keys must be a finite number, got nan"),
        (lambda: Curve([(NAN, 0)]), "keys must be a finite number, got nan"),
        (lambda: Curve([(INF, 0)]), "keys must be a finite number"),
        (lambda: Curve([(0, (1, NAN, 2))]), "keys must be 3 finite numbers"),
        (lambda: Curve([(0, 1), (1, (1, 2, 3))]), "keys must be either numbers or vectors"),
        (lambda: Curve([(0, True)]), "keys must be a number"),
        (
            lambda: Curve([(0, 1)], interpolation="cubic"),
            "interpolation must be 'linear' or 'smooth' or 'hold'",
        ),
        (lambda: Curve([(0, 1)])(NAN), "time must be a number, got nan"),
        (lambda: Curve([(0, (1, 2, 3))]).integral(0, 1), "curve must be a curve of numbers"),
        (lambda: actions.Gravity(acceleration=Curve([(0, 1)])), "acceleration must be 3 numbers, got 1"),
        (
            lambda: actions.Bounce(shape=Box((0, 0, 0), (1, 1, 1)), restitution=Curve([(0, 1), (5, -1)])),
            "restitution",
        ),
        (
            lambda: actions.CurlNoise(strength=1, scale=1, octaves=Curve([(0, 1)])),
            "octaves must be an integer",
        ),
        (lambda: actions.Gravity(acceleration=(0, 0, 0), where=Curve([(0, 1)])), "where must be a shape"),
        (lambda: Sphere((0, 0, 0), Curve([(0, 1)])), "radius must be a number, got Curve"),
        (
            lambda: motes.Light((0, 0, 0), power=Curve([(0, 1), (1, -1)])),
            "power must be a finite number in 0",
        ),
        (lambda: motes.Camera((0, 0, 5), (0, 0, 0), near=Curve([(0, 0.1), (1, -0.1)])), "near must be"),
        (lambda: motes.Camera((0, 0, 5), Curve([(0, (0, 0, 0)), (1, (0, 0, 5))])), "must be different"),
        (lambda: motes.Renderer(Curve([(0, 8)]), 8, camera=motes.Camera((0, 0, 5), (0, 0, 0))), "width"),
    ],
)
def test_wrong_curves_are_refused_at_the_call(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(motes.ArgumentError, match=message):
        make()


def test_rates_must_be_numbers_that_are_not_negative():
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        for wrong in ([(0, 1), (9, -1)], [(0, (1, 2, 3))], [(0, 1e13)]):
            with pytest.raises(motes.ArgumentError, match="rate must be particles per second"):
                s.source((0, 0, 0), rate=Curve(wrong))
        with pytest.raises(motes.ArgumentError, match="velocity must be 3 numbers"):
            s.configure(velocity=Curve([(0, 1)]))
        with pytest.raises(motes.ArgumentError, match="at most 4000000000 particles in a step"):
            s.source((0, 0, 0), rate=Curve([(0, 1e12)]))
        assert s.recorded == []


# --- births


def born_by(rate: Any, frames: int, *, dt: float, substeps: int, jitter: bool = False) -> list[int]:
    world = motes.World(seed=1, dt=dt, substeps=substeps, progress="off")
    s = world.system("s")
    counts = []
    with world:
        for _ in world.frames(frames):
            s.source((0, 0, 0), rate=rate, jitter=jitter)
            world.step()
            counts.append(s.born)
    return counts


@settings(max_examples=40, deadline=None, derandomize=True)
@given(curves(), st.sampled_from([1, 3]), st.sampled_from([1 / 24, 0.1, 0.125]))
def test_frames_emit_the_integral_of_the_rate(rate: Curve, substeps: int, dt: float):
    born = born_by(rate, 8, dt=dt, substeps=substeps)
    for k, count in enumerate(born):
        wanted = rate.integral(0, (k + 1) * dt)
        assert count == math.floor(wanted + 1e-9)


def test_a_constant_curve_emits_as_the_constant():
    for rate in (0, 1, 24, 100, 333.3, 7.7):
        for substeps in (1, 5):
            for dt in (1 / 24, 0.1):
                constant = born_by(rate, 30, dt=dt, substeps=substeps)
                assert born_by(Curve([(0, rate)]), 30, dt=dt, substeps=substeps) == constant
                assert (
                    born_by(Curve([(0.3, rate), (0.7, rate)], "smooth"), 30, dt=dt, substeps=substeps)
                    == constant
                )


def test_copies_of_births_are_made_again_from_their_history():
    """With a changing rate, *_b attributes hold the birth values, however late they are requested."""
    found = []
    for early in (True, False):
        world = motes.World(seed=3, substeps=2, progress="off")
        s = world.system("s")
        with world:
            for frame in world.frames(4):
                before, now = (Sphere((k * 2.0, 0, 0), 1) for k in (frame, frame + 1))
                s.source(now, rate=Curve([(0, 100), (1, 900)]), jitter=True, moving_from=before)
                s.gravity((0, -5, 0))
                s.move()
                if early or frame == 3:
                    s.restore(time_left=10.0, where=column("position_b").x > 1000)
                world.step()
            found.append(s.gather().position_b)
    assert len(found[0]) == 27
    np.testing.assert_array_equal(found[0], found[1])


# --- curves in place of numbers and vectors


def test_actions_get_the_value_at_the_frames_start():
    pull = Curve([(0, (0, 0, 0)), (1, (0, -8, 0))])
    world = motes.World(seed=1, dt=0.25, substeps=2, progress="off")
    s = world.system("s", attributes={"heat": 0.0})
    with world:
        for frame in world.frames(3):
            if frame == 0:
                s.burst((0, 0, 0))
            s.gravity(pull)
            s.apply(actions.Damping(damping=(1, 1, 1), max_speed=Curve([(0, 5)])))
            s.set(heat=Curve([(0, 1), (0.5, 3)], interpolation="hold"))
            assert s.recorded[-3] == actions.Gravity(acceleration=(0, -8 * world.time, 0))
            world.step()
        p = s.gather()
    assert p.velocity.tolist() == [[0, -(2 + 4) * 0.25, 0]]
    assert p.heat.tolist() == [3.0]


def test_newborn_particles_get_the_value_of_their_frame():
    world = motes.World(seed=1, dt=0.5, progress="off")
    s, children = world.system("s"), world.system("children")
    with world:
        s.configure(
            mass=Curve([(0, 1), (1, 3)]),
            velocity=motes.Uniform(Curve([(0, (0, 0, 0)), (1, (4, 0, 0))]), (4, 0, 0)),
        )
        children.configure(size=Curve([(0, (1, 1, 1)), (1, (2, 2, 2))]))
        for frame in world.frames(4):
            if frame == 3:
                s.configure(mass=9)
            s.burst((0, 0, 0), count=50)
            s.spawn(into=children, on="birth", count=1)
            world.step()
        p, c = s.gather(), children.gather()
    by_frame = p.mass.reshape(4, 50)
    assert [set(row.tolist()) for row in by_frame] == [{1.0}, {2.0}, {3.0}, {9.0}]
    speeds = p.velocity[:, 0].reshape(4, 50)
    assert speeds[0].min() < 1 and 2 <= speeds[1].min() < 2.6 and (speeds[2] == 4).all()
    assert sorted(set(c.size[:, 0].tolist())) == [1.0, 1.5, 2.0]


def test_cameras_renderers_and_lights_move():
    def pictures(curved: bool) -> list[str]:
        def number(low: Any, high: Any) -> Any:
            curve = Curve([(0, low), (1, high)])
            return curve if curved else curve(0.0)

        parts: dict[str, Any] = {
            "camera": {"position": number((0, 1, 6), (2, 1, 6)), "fov_deg": number(40, 60)},
            "light": {"position": number((0, 3, 0), (3, 3, 0)), "power": number(1, 5)},
            "renderer": {
                "exposure": number(1, 2),
                "background": number((0, 0, 0), (0.2, 0, 0)),
                "bloom": number(0, 0.5),
            },
        }
        camera = motes.Camera(look_at=(0, 0, 0), **parts["camera"])
        renderer = motes.Renderer(
            48,
            32,
            camera=camera,
            objects=[motes.Solid(Box((-1, -1, -1), (1, 1, 1)))],
            lights=[motes.Light(**parts["light"])],
            **parts["renderer"],
        )
        world = motes.World(seed=1, dt=0.5, renderer=renderer, progress="off")
        s = world.system("s")
        found = []
        with world:
            for frame in world.frames(3):
                if frame == 0:
                    s.burst(Sphere((0, 0, 0), 2), count=200)
                if not curved:
                    part = min(1.0, world.time)
                    camera.position, camera.fov_deg = (2 * part, 1, 6), 40 + 20 * part
                    renderer.lights = [motes.Light((3 * part, 3, 0), power=1 + 4 * part)]
                    renderer.exposure, renderer.background = 1 + part, (0.2 * part, 0, 0)
                    renderer.bloom = 0.5 * part
                found.append(world.render().digest())
        return found

    moving = pictures(True)
    assert len(set(moving)) == 3
    assert moving == pictures(False)


# --- emission along a shape's path


def trail(frames: int, speed: float, substeps: int = 1, **options: Any) -> motes.Particles:
    world = motes.World(seed=2, dt=0.5, substeps=substeps, progress="off")
    s = world.system("s")
    at = Curve([(0, (0, 0, 0)), (100, (100 * speed, 0, 0))])
    with world:
        for _ in world.frames(frames):
            before, now = (Sphere(at(world.time + d), 0.5) for d in (0, world.dt))
            s.move()
            s.source(now, rate=4000, moving_from=before, **options)
            world.step()
        return s.gather()


@pytest.mark.parametrize("substeps", [1, 4])
def test_a_moving_source_leaves_no_gaps(substeps: int):
    p = trail(4, speed=20, substeps=substeps, jitter=True)
    assert len(p) == 8000
    counts, _ = np.histogram(p.position[:, 0], np.linspace(0, 40, 41))
    assert counts.min() > 150 and counts.max() < 250  # expected: 200 per metre
    assert np.abs(p.position[:, 1:]).max() <= 0.5
    # Particles born early in a frame are older and farther back.
    frame = p.id // 2000
    wanted = 20 * (2 - p.age)
    assert np.abs(p.position[:, 0] - wanted).max() < 0.51
    assert set(frame.tolist()) == {0, 1, 2, 3}


def test_particles_travel_on_from_where_they_were_born():
    world = motes.World(seed=2, dt=0.5, progress="off")
    s = world.system("s")
    with world:
        s.configure(velocity=(0, 8, 0))
        s.source((10, 0, 0), rate=1000, jitter=True, moving_from=(0, 0, 0))
        world.step()
        p = s.gather()
    np.testing.assert_allclose(p.position[:, 1], 8 * p.age, rtol=1e-5)
    np.testing.assert_allclose(p.position[:, 0], 10 * (1 - p.age / 0.5), atol=1e-4)


def test_a_shape_that_stands_still_emits_as_without_a_way():
    def run(**options: Any) -> motes.Particles:
        world = motes.World(seed=2, progress="off")
        s = world.system("s")
        with world:
            s.source(Sphere((1, 2, 3), 2), rate=5000, jitter=True, **options)
            world.step()
            return s.gather()

    np.testing.assert_array_equal(run().position, run(moving_from=Sphere((1, 2, 3), 2)).position)


def test_a_shape_that_grows_fills_what_it_crosses():
    world = motes.World(seed=2, progress="off")
    s = world.system("s")
    with world:
        s.source(Sphere((0, 0, 0), 3, 3), rate=48000, moving_from=Sphere((0, 0, 0), 1, 1))
        world.step()
        r = np.linalg.norm(s.gather().position, axis=1)
    assert np.histogram(r, np.linspace(1, 3, 9))[0].min() > 200  # expected: 250 each
    assert r.min() > 0.99 and r.max() < 3.01


@pytest.mark.parametrize(
    ("shape", "before", "message"),
    [
        (
            Sphere((0, 0, 0), 1),
            Box((0, 0, 0), (1, 1, 1)),
            "moving_from must be of the same kind as shape",
        ),
        (Sphere((0, 0, 0), 1) | Sphere((1, 0, 0), 1),) * 2 + ("not a Union",),
        (Sphere((0, 0, 0), 1), "x", "moving_from must be a shape"),
    ],
)
def test_ways_between_other_shapes_are_refused(shape: Any, before: Any, message: str):
    world = motes.World(seed=2, progress="off")
    s = world.system("s")
    with world, pytest.raises(motes.ArgumentError, match=message):
        s.source(shape, rate=1, moving_from=before)


SCRIPT = """
import numpy as np
import motes
from motes import expressions as ex
from motes.expressions import column
from motes.shapes import Sphere

world = motes.World(seed=3, progress="off", substeps=2)
comet, dust = world.system("comet"), world.system("dust")
comet.configure(velocity=motes.Curve([(0, (0, 0, 0)), (1, (0, 3, 0))]))
around = ex.cross((0, 1, 0), column("position")) * np.sin(9 * ex.time())
with world:
    for frame in world.frames(8):
        before, now = (Sphere((0.3 * k, 0, 0), 0.2) for k in (frame, frame + 1))
        comet.source(now, motes.Curve([(0, 0), (0.4, 2000)], "smooth"), True, moving_from=before)
        comet.set(velocity=column("velocity") + around, where=ex.noise(column("position"), ex.time()) > 0)
        comet.move()
        comet.trail(dust, every=0.1)
        dust.restore(1.0)
        dust.move()
        world.step()
        digest = world.digest()
        if world.rank == 0:
            print(digest)
"""


def test_recorded_scenes_and_any_ranks_make_the_same(tmp_path: Path, motes_replay: Path):
    script, scene = tmp_path / "comet.py", tmp_path / "comet.motes"
    script.write_text(SCRIPT)
    alone = alike(script)
    assert len(set(alone)) == 8
    assert on_ranks(1, COMMAND_LINE, "record", script, "-o", scene).lines
    replayed = command([motes_replay, scene, "--digest", "--no-images"]).lines
    assert [line.split()[1] for line in replayed] == alone


def test_a_film_fades_to_black(tmp_path: Path) -> None:
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    renderer = motes.Renderer(32, 18, camera=camera, background=(0.2, 0.3, 0.1), linear=True)
    renderer.exposure = Curve([(0, 1), (2, 0)])
    world = motes.World(seed=1, dt=1, renderer=renderer, progress="off")
    s = world.system("s")
    with world:
        for _ in world.frames(4):
            s.burst((0, 0, 0), count=100)
            frame = world.render()
            assert frame is not None
            frame.save(tmp_path / "a.png", bits=16)
            deep = np.asarray(Image.open(tmp_path / "a.png"))
            assert bool(frame.pixels.max()) == bool(deep.max()) == (frame.index < 2)
            assert frame.linear.max() > 0.2, "the light itself stays"
