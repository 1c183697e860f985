"""Errors in a script raise at the call, with a reason: nothing crashes, nothing is dropped silently."""

from __future__ import annotations

import contextlib
import gc
import threading
import time
import weakref
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes import expressions as ex
from motes import shapes
from motes.errors import MotesError, NotAssignableError

BOX = shapes.Box((-1, -1, -1), (1, 1, 1))


def world_of(**arguments: Any) -> motes.World:
    """Make a world without progress output."""
    return motes.World(**{"seed": 1, "progress": "off", **arguments})


# --- assigning


def test_assigning_to_views_raises_and_says_how():
    world = world_of()
    s = world.system("a")
    seen = []

    def callback(particles: Any) -> None:
        with pytest.raises(NotAssignableError, match=r"particles.velocity\[:\] = ..."):
            particles.velocity = (1, 2, 3)
        particles.velocity += 1
        seen.append(len(particles))

    with world:
        s.burst(BOX, count=5)
        with s.local() as p:
            with pytest.raises(NotAssignableError, match=r"particles.velocity\[:\] = ..."):
                p.velocity = (1, 2, 3)
            with pytest.raises(NotAssignableError, match="no attribute 'velocty'; did you mean 'velocity'"):
                p.velocty = 5
            with pytest.raises(AttributeError, match="no attribute 'velocty'; did you mean 'velocity'"):
                _ = p.velocty
            with pytest.raises(ValueError, match="read-only"):
                p.id[:] = 7  # would change only a copy
            p.velocity *= 2  # in place
            p.velocity += (1, 0, 0)
        s.callback(callback)
        world.step()
        q = s.gather()
        assert q.velocity.tolist() == [[2, 1, 1]] * 5
        with pytest.raises(NotAssignableError):
            q.velocity = 0
        q.velocity *= 0
    assert seen == [5]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("color", r"configure\(color=...\) gives it to newborn particles, set\(color=...\) to living ones"),
        ("name", "name of a system cannot be assigned"),
        ("count", "count of a system cannot be assigned"),
        ("gravity", "gravity of a system cannot be assigned"),
        ("sprit", "no attribute 'sprit' to assign; did you mean 'sprite'"),
        ("heat", r"configure\(heat=...\)"),
    ],
)
def test_assigning_to_a_system_raises_and_says_how(name, message):
    s = world_of().system("a", attributes={"heat": 0.0})
    with pytest.raises(NotAssignableError, match=message):
        setattr(s, name, 1)


def test_options_of_balancers_are_suggested():
    balancer = motes.balance.Pairwise()
    with pytest.raises(
        NotAssignableError, match="Pairwise has no option 'treshold'; did you mean 'threshold'"
    ):
        balancer.treshold = 0.2
    with pytest.raises(TypeError, match="'treshold'; did you mean 'threshold'"):
        motes.balance.PrefixCuts(treshold=0.2)
    balancer.threshold = 0.2
    assert "threshold=0.2" in repr(balancer)


def test_unknown_attributes_are_reported_with_near_names():
    world = world_of()
    s = world.system("a")
    with pytest.raises(AttributeError, match="no attribute 'gravty'; did you mean 'gravity'"):
        _ = s.gravty
    with pytest.raises(AttributeError, match="velocity belongs to particles"):
        _ = s.velocity
    with pytest.raises(NotAssignableError, match="did you mean 'renderer'"):
        world.rendrer = None
    with pytest.raises(motes.ArgumentError, match="renderer must be None or a motes.Renderer"):
        world.renderer = 5
    with world:
        with pytest.raises(motes.ArgumentError, match="got 'velocty'; did you mean 'velocity'"):
            s.configure(velocty=(0, 0, 0))
        with pytest.raises(motes.ArgumentError, match="got 'colour'; did you mean 'color'"):
            s.emit(position=[(0, 0, 0)], colour=[(0, 0, 0)])
        with pytest.raises(motes.ArgumentError, match="got 'aeg'; did you mean 'age'"):
            s.set(aeg=1)
        with pytest.raises(motes.ArgumentError, match="got 'aeg'; did you mean 'age'"):
            s.kill_expired(where=ex.column("aeg") > 1)


# --- calls from inside a callback, or from another thread


def calls(world: motes.World, s: motes.System, other: motes.System) -> dict[str, Callable[[], Any]]:
    """Return calls that need the engine, by name."""

    def read(system: motes.System) -> None:
        with system.local() as p:
            _ = p.position

    return {
        "Gravity": lambda: s.gravity((0, -1, 0)),
        "burst": lambda: other.burst((0, 0, 0), count=1),
        "emit": lambda: other.emit(position=[(0, 0, 0)]),
        "spawn": lambda: s.spawn(other, on="death", count=1),
        "callback": lambda: s.callback(print),
        "local()": lambda: read(other),
        "gather()": other.gather,
        "digest()": world.digest,
        "step()": world.step,
        "render()": world.render,
        "system()": lambda: world.system("late"),
        "sprite": lambda: setattr(s, "sprite", motes.Sprite("point")),
    }


NAMES = list(calls(world_of(), world_of().system("a"), world_of().system("b")))


@pytest.mark.parametrize("name", NAMES)
def test_a_callback_cannot_record_step_or_read(name):
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    world = world_of(renderer=motes.Renderer(16, 12, camera=camera))
    s, other = world.system("a"), world.system("b")
    told: list[str] = []

    def callback(particles: Any) -> None:
        try:
            calls(world, s, other)[name]()
        except MotesError as error:
            told.append(str(error))
        particles.velocity[:] = 1

    with world:
        other.burst(BOX, count=7)
        s.burst(BOX, count=10)
        s.callback(callback)
        s.move()
        world.step()
        assert (s.count, other.count, len(world.systems)) == (10, 7, 2)
        assert (s.gather().velocity == 1).all()
        world.step()
    assert len(told) == 1
    assert name in told[0] and "inside the callback" in told[0] and "of system 'a'" in told[0]


@pytest.mark.parametrize("name", NAMES)
def test_another_thread_cannot_use_a_world_while_it_steps(name):
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    world = world_of(renderer=motes.Renderer(16, 12, camera=camera))
    s, other = world.system("a"), world.system("b")
    running, done = threading.Event(), threading.Event()
    told: list[str] = []

    def wait(_: Any) -> None:
        running.set()
        done.wait(30)

    def use() -> None:
        running.wait(30)
        try:
            calls(world, s, other)[name]()
        except MotesError as error:
            told.append(str(error))
        finally:
            done.set()

    thread = threading.Thread(target=use, name="helper")
    with world:
        s.burst(BOX, count=10)
        s.callback(wait)
        thread.start()
        world.step()
        thread.join()
        world.step()
        assert (s.count, len(world.systems)) == (10, 2)
    assert len(told) == 1
    assert name in told[0] and "thread 'helper'" in told[0] and "step()" in told[0]


def test_another_thread_may_drive_a_world_while_nobody_else_does():
    world = world_of()
    s = world.system("a")

    def loop() -> None:
        for _ in world.frames(3):
            s.source(BOX, rate=240)
            s.move()
            world.step()

    with world:
        thread = threading.Thread(target=loop)
        thread.start()
        thread.join()
        assert (world.frame, s.count) == (3, 30)


def test_threads_that_record_at_the_same_time_lose_nothing_silently():
    world = world_of()
    systems = [world.system(str(i)) for i in range(3)]
    recorded = [0, 0, 0]

    def record(i: int) -> None:
        while recorded[i] < 300:
            with contextlib.suppress(MotesError):
                systems[i].burst((0, 0, 0), count=1)
                recorded[i] += 1

    with world:
        threads = [threading.Thread(target=record, args=(i,)) for i in (1, 2)]
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            with contextlib.suppress(MotesError):
                world.step()
            time.sleep(1e-4)  # let the other threads run
        world.step()
        assert [s.count for s in systems] == recorded == [0, 300, 300]


def test_a_balancer_that_steps_is_refused():
    script = """
import motes
class Steps(motes.balance.Balancer):
    def decide(self, load):
        world.step()
world = motes.World(seed=1, space=(-1, 1), balancer=Steps(), progress="off", roles="shared")
s = world.system("s")
with world:
    for _ in world.frames(3):
        s.burst(motes.shapes.Box((-1, 0, 0), (1, 1, 1)), count=1000)
        s.move()
        world.step()
"""
    result = on_ranks(2, script, timeout=60)
    assert result.code != 0
    assert "step() while step() runs" in result.err, result.text


# --- views


def test_what_was_made_of_a_view_changes_no_particle_after_the_block():
    world = world_of()
    s = world.system("a")
    kept: dict[str, Any] = {}

    def keep(particles: Any) -> None:
        kept["callback"] = particles.mass[:3]

    with world:
        s.configure(mass=motes.Uniform(1, 2))
        s.burst(BOX, count=100)
        with s.local() as p:
            kept["slice"] = p.position[10:20]
            kept["flat"] = p.velocity.T
            kept["memory"] = memoryview(p.age)
            p.alpha[:] = 0.5
        s.callback(keep)
        world.step()
        before = s.gather()
        kept["slice"][:] = 99
        kept["flat"][:] = 99
        kept["memory"][0] = 99.0
        kept["callback"][:] = 99
        after = s.gather()
        for name in ("id", "position", "velocity", "age", "mass", "alpha"):
            np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
        assert (after.alpha == 0.5).all()
        assert (kept["slice"] == 99).all(), "memory that a script still holds lives on"


def test_two_blocks_of_one_system_both_write():
    world = world_of()
    s = world.system("a")
    with world:
        s.burst(BOX, count=4)
        with s.local() as p:
            column = p.age
            with s.local() as q:
                q.age[:2] = 5
                held = q.age
            p.age[2:] = 7
        assert column is not held
        world.step()
        assert s.gather().age.tolist() == [5, 5, 7, 7]


def test_a_frame_cannot_end_inside_local():
    world = world_of()
    s, other = world.system("a"), world.system("b")
    with world:
        s.burst(BOX, count=4)
        with s.local() as p:
            for end in (world.step, lambda: world.digest() and other.gather() and world.step()):
                with pytest.raises(MotesError, match=r"step\(\) inside `with` 'a'`.local\(\)`"):
                    end()
            s.burst(BOX, count=4)
            with pytest.raises(MotesError, match="after more was recorded"):
                s.gather()
            p.age[:] = 3
        world.step()
        assert sorted(s.gather().age.tolist()) == [0] * 4 + [3] * 4


# --- worlds


def test_worlds_are_collected():
    """Worlds that ended normally, were never entered, or were left by an exception are collected."""
    gone = []
    for way in ("run", "never entered", "failed"):
        world = world_of(renderer=motes.Renderer(16, 12, camera=motes.Camera((0, 0, 5), (0, 0, 0))))
        s = world.system("a")
        if way == "run":
            with world:
                s.burst(BOX, count=10)
                s.callback(lambda p: None)
                world.render()
        elif way == "failed":
            with pytest.raises(ZeroDivisionError), world:
                _ = 1 / 0
        gone.append((way, weakref.ref(world), weakref.ref(s)))
    del world, s
    gc.collect()
    assert [way for way, world, system in gone if world() is not None or system() is not None] == []


def test_any_number_of_worlds_is_open_at_once():
    worlds = [world_of(seed=i) for i in range(5)]
    systems = [world.system("a") for world in worlds]
    for world in worlds:
        world.open()
    for _ in range(3):
        for world, system in zip(worlds, systems, strict=True):
            system.burst(BOX, count=10)
            system.move()
            world.step()
    assert [system.count for system in systems] == [30] * 5
    assert len({world.digest() for world in worlds}) == 5
    for world in reversed(worlds[1:]):
        world.close()
    worlds[0].step()
    worlds[0].close()


def test_open_and_close_do_what_with_does():
    world = world_of()
    s = world.system("a")
    assert world.open() is world
    s.burst((0, 0, 0))
    world.step()
    assert s.gather().id.tolist() == [0]
    world.close()
    world.close()
    with pytest.raises(MotesError, match="inside `with world:`"):
        world.step()
    with pytest.raises(MotesError, match="runs once"):
        world.open()


def test_a_loop_without_frames_left_is_reported():
    world = world_of()
    with world:
        for _ in world.frames(5):
            world.step()
        with pytest.warns(
            motes.MotesWarning, match=r"frames\(5\): all 5 frames are done; frames\(n\) counts"
        ) as told:
            assert list(world.frames(5)) == []
        assert told[0].filename == __file__
        more = []
        for frame in world.frames(7):
            more.append(frame)
            world.step()
        assert more == [5, 6]


def test_a_linear_picture_is_its_own_frames():
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    world = world_of(renderer=motes.Renderer(16, 12, camera=camera, linear=True))
    s = world.system("a", sprite=motes.Sprite(pixels=9))
    with world:
        s.burst((0, 0, 0), count=1)
        first = world.render()
        s.kill_old(-1)
        second = world.render()
        assert first.linear.max() > 0
        assert second.linear.max() == 0


def test_a_renderer_that_changes_while_its_picture_is_made_changes_the_next_one():
    """The current picture stays the same, even if a progress callback or another thread is that quick."""
    renderer = motes.Renderer(
        16, 12, camera=motes.Camera((0, 0, 5), (0, 0, 0)), linear=True, layers=["depth"]
    )

    def heard(row):  # called about a frame while the next one runs
        renderer.width, renderer.height, renderer.exposure, renderer.layers = 300, 200, 9, ()

    world = motes.World(renderer=renderer, progress=heard)
    s = world.system("a", sprite=motes.Sprite(pixels=9))
    with world:
        s.burst((0, 0, 0), count=1)
        world.render()
        picture = world.render()
        assert renderer.width == 300
        assert picture.pixels.shape == picture.linear.shape == (12, 16, 3)
        assert picture.layer("depth").shape == (12, 16)
        assert picture._exposure == 1
        assert world.render().pixels.shape == (200, 300, 3)


def test_a_png_with_16_bits_has_the_exposure_of_its_frame(tmp_path):
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    world = world_of(renderer=motes.Renderer(16, 12, camera=camera, linear=True, exposure=3))
    s = world.system("a", sprite=motes.Sprite(pixels=9))
    with world:
        s.burst((0, 0, 0), count=1)
        picture = world.render()
    world.renderer.exposure = 1
    picture.save(tmp_path / "a.png", bits=16)
    row = zlib.decompress((tmp_path / "a.png").read_bytes().partition(b"IDAT")[2])
    fine = np.frombuffer(row, np.uint8).reshape(12, -1)[:, 1:].copy().view(">u2").reshape(12, 16, 3)
    assert picture.pixels.max() > 200
    assert np.abs(fine / 257 - picture.pixels).max() < 1.5
