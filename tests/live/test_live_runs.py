"""Real runs with viewers: pauses, steps, redraws and waits, on several ranks and in all roles."""

from __future__ import annotations

import asyncio
import contextlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from launching import mpirun
from standing import on_ranks
from viewers import Beside, Client, url_of

import motes

SCENE = Path(__file__).parents[1] / "scenes" / "steered.py"


STEPS = """
import sys, motes
world = motes.World(seed=1, progress="off", live=motes.Live(0, host=sys.argv[2], paused=True))
snow = world.system("snow")
with world:
    if world.live_url is not None:
        import os, pathlib
        pathlib.Path(sys.argv[1], "part").write_text(world.live_url)
        os.rename(sys.argv[1] + "/part", sys.argv[1] + "/url")
    for frame in world.frames(5):
        snow.burst((0, 0, 0), count=3)
        snow.move()
        world.step()
"""


def test_a_run_without_pictures_is_paused_and_stepped_too(tmp_path):
    async def conversation() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: viewer.state.get("frame") == 0)
            await viewer.say(orbit=[1, 0])
            await viewer.say(step=1)
            await viewer.until(lambda: viewer.state["frame"] == 1 and viewer.state["paused"])
            await viewer.say(pause=False)
            await viewer.until(lambda: bool(viewer.state.get("ended")))
            assert viewer.pictures == [] and viewer.state["width"] == 0

    with Beside(conversation) as beside:
        result = on_ranks(2, STEPS, tmp_path, "127.0.0.1", watch=beside.check)
    assert result.code == 0, result.text
    assert "motes: what viewers do is not recorded: the run has no log" in result.err


def test_an_address_that_cannot_be_served_ends_the_job_with_one_report(tmp_path):
    result = mpirun(3, STEPS, tmp_path, "192.0.2.1")
    assert result.code == 1 and result.err.count("*** motes") == 1, result.text
    assert "the live view cannot be served: 192.0.2.1:0: " in result.err


def test_paused_from_the_start_then_stepped_looked_around_and_stopped(tmp_path):
    """The run has 3 ranks; the camera moves while the run is paused."""
    seen: dict[str, Any] = {}

    async def conversation() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: bool(viewer.pictures) and viewer.pictures[-1][3] == 1)
            seen["empty"] = viewer.last
            assert viewer.state["frame"] == 0 and viewer.state["paused"]
            for step in (1, 2, 3):
                await viewer.say(step=1)
                await viewer.until(lambda step=step: viewer.state["frame"] == step)
            await viewer.until(lambda: viewer.pictures[-1][1] == 2 and viewer.pictures[-1][3] == 1)
            seen["third"] = viewer.last
            await viewer.say(orbit=[0.5, 0.1])
            await viewer.until(lambda: viewer.last != seen["third"] and viewer.pictures[-1][3] == 1)
            assert viewer.pictures[-1][1] == 2 and viewer.state["frame"] == 3 and viewer.state["turned"]
            await viewer.say(camera=None)
            await viewer.until(lambda: not viewer.state["turned"])
            await viewer.until(lambda: viewer.last == seen["third"])  # the same pixels give the same PNG
            await viewer.say(stop=True)
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    options = "dict(live=motes.Live(0, paused=True), log=None, digest=False, shutter=0)"
    with Beside(conversation) as beside:
        result = on_ranks(3, SCENE, tmp_path, 50, options, timeout=60, watch=beside.check)
    assert result.code == 0, result.text
    assert "motes: stopped by a viewer after frame 3 of 50" in result.err
    assert result.out.count("ended") == 3
    assert seen["empty"] != seen["third"]


def test_a_paused_run_sleeps(tmp_path):
    """Four ranks together use less than a fifth of a processor."""
    pids: list[int] = []

    def ticks() -> float:
        spent = 0
        for pid in pids:
            fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
            spent += int(fields[11]) + int(fields[12])
        return spent / 100

    async def conversation() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: viewer.state.get("frame") == 0 and bool(viewer.pictures))
            for entry in Path("/proc").iterdir():
                with contextlib.suppress(OSError):
                    command = (entry / "cmdline").read_bytes() if entry.name.isdigit() else b""
                    environ = (entry / "environ").read_bytes() if str(tmp_path).encode() in command else b""
                    if b"OMPI_COMM_WORLD_RANK=" in environ:
                        pids.append(int(entry.name))
            assert len(pids) == 4
            await asyncio.sleep(1)
            before = ticks()
            await asyncio.sleep(4)
            spent = ticks() - before
            print(f"{spent / 4:.3f} processors")
            assert spent / 4 < 0.2
            await viewer.say(stop=True)
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    with Beside(conversation) as beside:
        result = mpirun(
            4,
            SCENE,
            tmp_path,
            50,
            "dict(live=motes.Live(0, paused=True), log=None)",
            timeout=60,
            watch=beside.check,
        )
    assert result.code == 0, result.text


AT_A_PROMPT = """
import os, signal, sys, threading, motes
from motes._world.world import running_of
sys.ps1 = ">>> "
world = motes.World(seed=1, progress="off", live=motes.Live(0, paused=True))
snow = world.system("snow")
world.open()
for attempt in range(3):
    threading.Timer(0.6, os.kill, [os.getpid(), signal.SIGINT]).start()
    try:
        for frame in world.frames(3):
            world.step()
    except KeyboardInterrupt:
        print("interrupted before frame", world.frame, flush=True)
running_of(world).viewers.steering.hear('{"pause": false}')
print(*[(frame, bool(world.step().made)) for frame in world.frames(3)], flush=True)
world.close()
"""


def test_a_paused_cell_of_a_notebook_can_be_interrupted_again_and_again():
    lines = mpirun(1, AT_A_PROMPT).lines
    assert lines == ["interrupted before frame 0"] * 3 + ["(0, False) (1, False) (2, False)"]


@pytest.mark.parametrize("ranks", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_a_run_waits_for_its_first_viewer(tmp_path, ranks):
    async def conversation() -> None:
        url = await url_of(tmp_path)
        await asyncio.sleep(0.7)
        assert not (tmp_path / "log" / "frames.jsonl").read_text()
        async with Client.of(url) as viewer:
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    with Beside(conversation) as beside:
        result = on_ranks(
            ranks, SCENE, tmp_path, 5, "dict(live=motes.Live(0, wait=True))", timeout=60, watch=beside.check
        )
    assert result.code == 0, result.text
    assert len((tmp_path / "log" / "frames.jsonl").read_text().splitlines()) == 5


@pytest.mark.parametrize(
    "roles", ["'auto'", "'shared'", "motes.Roles(manager=0, image_generator=2, calculators=[1, 2])"]
)
def test_whoever_draws_serves(tmp_path, roles):
    async def conversation() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.say(set={"wind": 1})
            await viewer.until(lambda: viewer.state.get("controls", {}).get("wind", {}).get("value") == 1)
            await viewer.say(stop=True)
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    options = f"dict(live=motes.Live(0, wait=True), roles={roles}, combine='overlapped')"
    with Beside(conversation) as beside:
        result = on_ranks(3, SCENE, tmp_path, 100_000, options, timeout=60, watch=beside.check)
    assert result.code == 0, result.text
    told = [json.loads(line) for line in (tmp_path / "log" / "steer.jsonl").read_text().splitlines()]
    assert told[1]["set"] == {"wind": 1.0} and told[-1]["stop"] is True


def test_a_run_without_viewers_is_the_same_film(tmp_path):
    for name, options in (("plain", "{}"), ("live", "dict(live=motes.Live(0))")):
        (tmp_path / name).mkdir()
        assert on_ranks(2, SCENE, tmp_path / name, 20, options).code == 0
    films = []
    for name in ("plain", "live"):
        rows = map(json.loads, (tmp_path / name / "log" / "frames.jsonl").read_text().splitlines())
        films.append([(row["particles_digest"], row["image_sha256"]) for row in rows])
    assert films[0] == films[1] and len(films[0]) == 20
    assert not (tmp_path / "plain" / "log" / "steer.jsonl").exists()
    assert len((tmp_path / "live" / "log" / "steer.jsonl").read_text().splitlines()) == 1


REDRAW = """
import numpy as np, motes
from motes.shapes import Box
camera = motes.Camera((0, 0, 9), (0, 0, 0))
world = motes.World(seed=1, space=(-2, 2), progress="off", renderer=motes.Renderer(64, 48, camera=camera))
snow = world.system("snow")
with world:
    empty = world.redraw()
    if empty:
        assert not empty.pixels.any() and empty.index == 0 and empty.time == 0
    for frame in world.frames(4):
        snow.burst(Box((-2, -1, -1), (2, 1, 1)), count=100)
        again = world.redraw()  # before the list has run
        if frame > 0 and again:
            assert (again.pixels == picture.pixels).all() and again.index == frame - 1
        snow.move()
        picture = world.render()
        count, digest = snow.count, world.digest()
        camera.position = (4, 0, 9)
        turned = world.redraw()
        camera.position = (0, 0, 9)
        same = world.redraw()
        assert (snow.count, world.digest(), world.frame) == (count, digest, frame + 1)
        if picture:
            assert (same.pixels == picture.pixels).all() and (turned.pixels != picture.pixels).any()
            assert same.index == picture.index and same.time == picture.time
        else:
            assert not same
    snow.burst(Box((-2, -1, -1), (2, 1, 1)), count=100)
    snow.gather()
    try:
        world.redraw()
    except motes.ArgumentError as error:
        assert "particles of system 'snow' were read" in str(error)
        print("refused", flush=True)
    world.step()
    if world.redraw():
        print("drawn", flush=True)
try:
    world.redraw()
except motes.MotesError as error:
    assert "works only inside `with world:`" in str(error)
bare = motes.World(seed=1, progress="off")
with bare:
    try:
        bare.redraw()
    except motes.ArgumentError as error:
        assert "renderer must be given" in str(error)
        print("bare", flush=True)
"""


def test_a_redraw_has_the_streaks_of_its_frame():
    camera = motes.Camera((0, 0, 9), (0, 0, 0))
    renderer = motes.Renderer(64, 48, camera=camera, shutter=1)
    world = motes.World(seed=1, progress="off", renderer=renderer)
    system = world.system("a")
    with world:
        system.burst((0, 0, 0), count=1)
        for x in (0, 0.5, 1):
            renderer.camera = motes.Camera((x, 0, 9), (x, 0, 0))
            picture = world.render()
            assert np.count_nonzero(picture.pixels[..., 0].any(0)) > (5 if x else 0)
            assert np.array_equal(world.redraw().pixels, picture.pixels)
        renderer.camera = motes.Camera((0, 0, 9), (0, 0, 0))  # a place to which the camera did not move
        assert np.count_nonzero(world.redraw().pixels[..., 0].any(0)) == 5


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.slow), 3, 5])
def test_a_redraw_shows_the_particles_as_they_are_and_changes_nothing(ranks):
    lines = on_ranks(ranks, REDRAW).lines
    assert sorted(lines) == ["bare"] * ranks + ["drawn"] + ["refused"] * ranks
