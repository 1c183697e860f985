"""The number of particles from sources, against exact sums: changing rates, pauses, curves, sub-steps."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from launching import command, said
from standing import COMMAND_LINE, on_ranks

import motes
from motes import (
    Curve,
    _core,  # noqa: F401  (starts MPI before `starting` asks for its abilities)
)
from motes._launch import starting

FILM = Fraction(1, 24)
STEPS = [FILM, Fraction(1, 60), Fraction(1001, 30000), Fraction(1, 10), Fraction(1, 8)]
Calls = Sequence[Fraction | None]
"""The rate of each source in one frame, in particles per second; None: not called."""


def born(frames: Sequence[Sequence[Any]], dt: Fraction = FILM, substeps: int = 1) -> list[int]:
    """Return the particles born until the end of each frame; `frames` holds the rates of all sources."""
    world = motes.World(seed=1, dt=float(dt), substeps=substeps, progress="off")
    s = world.system("s", capacity=0)  # particles are only counted
    counts = []
    with world:
        for frame in world.frames(len(frames)):
            for key, rate in enumerate(frames[frame]):
                if rate is not None:
                    s.source((key, 0, 0), rate if isinstance(rate, Curve) else float(rate), key=key)
            world.step()
            counts.append(s.born + s.dropped)
    return counts


def wanted(frames: Sequence[Calls], dt: Fraction) -> list[int]:
    """Return the particles born until the end of each frame, rounding each source's exact sum down."""
    sums = [Fraction(0)] * max(map(len, frames))
    counts = []
    for calls in frames:
        for key, rate in enumerate(calls):
            sums[key] += (rate or 0) * dt
        counts.append(sum(map(math.floor, sums)))
    return counts


rates = st.one_of(
    st.none(),
    st.just(Fraction(0)),
    st.integers(0, 100_000).map(lambda k: Fraction(k, 1000)),
    st.integers(0, 10**12).map(Fraction),
    st.integers(0, 1000).map(lambda k: Fraction(k, 10**6)),
    st.sampled_from([12, 24, 48, 6, 8]).map(Fraction),
)


def held(frames: list[tuple[int, list[Fraction | None]]]) -> list[list[Fraction | None]]:
    return [calls for count, calls in frames for _ in range(count)]


stretches = st.lists(
    st.tuples(st.integers(1, 6), st.lists(rates, min_size=1, max_size=3)), min_size=1, max_size=12
).map(held)


def check_exact_sums(frames: list[list[Fraction | None]], dt: Fraction, substeps: int) -> None:
    assert born(frames, dt, substeps) == wanted(frames, dt)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(stretches, st.sampled_from(STEPS), st.sampled_from([1, 1, 3, 7]))
def test_sources_emit_the_whole_particles_of_exact_sums(frames, dt, substeps):
    check_exact_sums(frames, dt, substeps)


@pytest.mark.slow
@settings(max_examples=3000, deadline=None)
@given(stretches, st.sampled_from(STEPS), st.sampled_from([1, 2, 3, 7, 10]))
def test_sources_emit_the_whole_particles_of_exact_sums_in_many_ways(frames, dt, substeps):
    check_exact_sums(frames, dt, substeps)


@pytest.mark.parametrize(
    ("rate", "frames", "count"),
    [
        (lambda f: 12 if f % 2 else 0, 240, 60),
        (lambda f: 12 if f % 2 else None, 240, 60),
        (lambda f: Fraction(20 * f, 240), 240, 99),  # floor(99.58)
        (lambda f: Fraction(5000 + f, 1000), 240, 51),  # floor(51.195)
        (lambda f: 24 if f >= 5 else None, 10, 5),
        (lambda f: 30 if f >= 1 else None, 4, 3),  # floor(3.75); counting from time 0 would give 4
        (lambda f: Fraction(24 if f == 7 else 1, 10**6), 24, 0),
        (lambda _: Fraction(1, 7), 24 * 70, 10),
    ],
)
def test_rates_that_a_script_changes_lose_and_gain_nothing(
    rate: Callable[[int], Any], frames: int, count: int
) -> None:
    for substeps in (1, 5):
        assert born([[rate(frame)] for frame in range(frames)], substeps=substeps)[-1] == count


def test_the_rate_of_a_curve_goes_on_where_a_number_has_stopped():
    rise = Curve([(0, 0), (10, 240)])  # emits (k + 1/2) / 24 particles in frame k
    frames: list[list[Any]] = [[12], [rise], [None], [rise], [12.0], [Curve([(-3, 12)])]]
    sums = [12, 12 + 1.5, 13.5, 13.5 + 3.5, 29, 41]
    assert born(frames) == [math.floor(one / 24) for one in sums]
    assert born(frames, substeps=3) == [math.floor(one / 24) for one in sums]
    frames = [[rise] if frame % 3 else [None] for frame in range(240)]
    total = sum(Fraction(2 * frame + 1, 48) for frame in range(240) if frame % 3)
    assert born(frames)[-1] == math.floor(total)


@pytest.mark.parametrize("late", [100.0, 1000.0])
def test_curves_that_set_in_late_are_as_exact_as_early_ones(late: float) -> None:
    """Rounding errors grow with time, yet each frame's particle is born in that frame."""
    world = motes.World(seed=1, dt=1 / 24, progress="off")
    s = world.system("s", capacity=0)
    jump = Curve([(0, 0), (late, 0), (late, 24)])
    with world:
        for frame in world.frames(round(24 * late) + 50):
            if frame >= 24 * late - 2:
                s.source((0, 0, 0), jump)
            world.step()
            assert s.dropped == max(0, frame + 1 - 24 * late)


def test_redrawing_is_no_frame():
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    world = motes.World(seed=1, progress="off", renderer=motes.Renderer(8, 8, camera=camera))
    s = world.system("s", capacity=0)
    with world:
        for frame in world.frames(8):
            s.source((0, 0, 0), 18)
            world.render()
            world.redraw()
            assert s.dropped == 3 * (frame + 1) // 4


# --- how a source is identified in later frames


def test_sources_are_known_again_by_their_line():
    world = motes.World(seed=1, progress="off")
    s, other = world.system("s", capacity=0), world.system("other", capacity=0)
    seen = []
    with world:
        for frame in world.frames(8):
            if frame % 2 == 0:
                s.source((0, 0, 0), 18)
            s.source((1, 0, 0), 12)
            other.source((1, 0, 0), 18)
            world.step()
            seen.append((s.dropped, other.dropped))
    assert [count for count, _ in seen] == [0, 1, 2, 3, 4, 5, 6, 7]
    assert [count for _, count in seen] == [0, 1, 2, 3, 3, 4, 5, 6]


def test_calls_of_one_line_are_known_by_their_order_or_key():
    emitters = [{0, 1}, {1}, {0}, {0, 1}, {1}, {1}]

    def counts(keyed: bool) -> list[int]:
        world = motes.World(seed=1, progress="off")
        s = world.system("s", capacity=0)
        found = []
        with world:
            for frame in world.frames(len(emitters)):
                for k in sorted(emitters[frame]):
                    s.source((k, 0, 0), (18, 6)[k], key=("left", 2**70)[k] if keyed else None)
                world.step()
                found.append(s.dropped)
        return found

    assert counts(True) == [0, 0, 1, 2, 3, 3]  # 0.75 in each of frames 0, 2, 3; 0.25 in each of 0, 1, 3, 4, 5
    assert counts(False) == [0, 1, 1, 2, 2, 3]  # sums of a frame's first call: .75, 1, 1.75, 2.5, 2.75, 3


@pytest.mark.parametrize("key", [1.5, True, b"left", ("left",)])
def test_keys_are_texts_or_integers(key: Any) -> None:
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        with pytest.raises(motes.ArgumentError, match="key must be a string or an integer, got"):
            s.source((0, 0, 0), 10, key=key)
        assert s.recorded == []


# --- the same births on any ranks, after restarts and losses, and in replays

SCENE = """
import json, os, sys
import motes
options = json.loads(os.environ.get("OPTIONS", "{}"))
frames, dies = options.pop("frames", 24), options.pop("dies", None)
reads = options.pop("reads", True)
world = motes.World(seed=1, progress="off", space=(-3, 3), **options)
s, b = world.system("s"), world.system("b", capacity=4)
with world:
    for frame in world.frames(frames):
        if frame % 3 < 2:
            s.source((frame / 9 - 1, 0, 0), 7.3 * (frame % 5), jitter=True)
            s.gravity((0, -1, 0))
            if frame % 4 == 0 and reads:
                with s.local() as seen:
                    len(seen.id)
        for k in range(frame % 4):
            s.source((k, 1, 0), 50 + k)
        b.source((0, 0, 0), motes.Curve([(0, 0), (1, 99)]) if frame % 2 else 13)
        s.move()
        b.kill_old(0.2)
        b.move()
        if frame == 13 and world.rank == dies:
            os.kill(os.getpid(), 9)
        world.step()
        world.say(f"{frame} {s.born} {b.born} {b.dropped} {world.digest()}")
"""


def lines_of(ranks: int, **options: Any) -> list[str]:
    result = on_ranks(ranks, SCENE, env={"OPTIONS": json.dumps(options)})
    assert result.code == 0, result.text
    return result.lines


@pytest.mark.parametrize("substeps", [1, 3])
def test_births_are_the_same_on_any_ranks(substeps: int) -> None:
    lines = lines_of(1, substeps=substeps)
    assert len(lines) == 24 and int(lines[-1].split()[3]) > 0
    assert lines_of(2, substeps=substeps) == lines
    assert lines_of(3, substeps=substeps, births="calculators") == lines
    assert lines_of(5, substeps=substeps, axis="xyz", roles="shared", combine="overlapped") == lines


@pytest.mark.parametrize("substeps", [1, 3])
def test_reads_in_a_frame_count_nothing_twice(substeps: int) -> None:
    assert lines_of(1, substeps=substeps, reads=False) == lines_of(1, substeps=substeps)


@pytest.mark.parametrize("substeps", [1, 3])
def test_fractions_are_part_of_a_checkpoint(tmp_path: Path, substeps: int) -> None:
    kept = {"substeps": substeps, "checkpoint": str(tmp_path)}
    parts = [lines_of(ranks, frames=frames, **kept) for ranks, frames in ((3, 13), (2, 17), (1, 24))]
    assert [len(part) for part in parts] == [13, 4, 7]
    assert sum(parts, []) == lines_of(1, substeps=substeps)


@pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))
@pytest.mark.parametrize("dies", [0, 1, 2])
def test_fractions_survive_the_loss_of_a_rank(tmp_path: Path, dies: int) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCENE)
    run = [sys.executable, "-m", "motes", "run", "--survive", "-n", 3, script]
    options = {"on_loss": "recover", "dies": dies}
    result = command(run, timeout=90, env={"OPTIONS": json.dumps(options)})
    assert result.code == 0, result.text
    assert said(result.err, f"motes: lost rank {dies}")
    assert result.lines == lines_of(1)


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_replayed_scene_counts_as_its_script(motes_replay: Path, tmp_path: Path, ranks: int) -> None:
    script, scene = tmp_path / "script.py", tmp_path / "x.motes"
    script.write_text(SCENE)
    recorded = on_ranks(1, COMMAND_LINE, "record", "-o", scene, script)
    assert recorded.code == 0, recorded.text
    program = [str(motes_replay), str(scene), "--digest"]
    replayed = command(program if ranks == 1 else starting.command(ranks, program), timeout=60)
    assert [line.split()[1] for line in replayed.lines] == [line.split()[-1] for line in lines_of(1)]
