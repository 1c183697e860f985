"""The page of `motes live` outlives its runs. A person scrubs, loops, restarts, and edits the script."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import time
from pathlib import Path
from typing import Any

import pytest
from browser import Page, chromium
from desks import live
from standing import on_ranks
from viewers import Client

from motes._desk import script as scripts
from motes._desk.film import Film, Shot
from motes._desk.script import Script
from motes._launch import starting
from motes._launch.resizing import LAUNCHER, STOPPED, Size
from motes._launch.supervisor import Ended
from motes.cli import live as live_command
from motes.cli.parser import Parser

SCENE = Path(__file__).parents[1] / "scenes" / "steered.py"
SHOWN = "Number(document.querySelector('[data-part=picture]').dataset.frame)"
OPTIONS = "dict(pause_s=0.01, shutter=0)"


def part(name: str) -> str:
    return f"document.querySelector('[data-part={name}]')"


def rows(folder: Path, name: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "log" / name).read_text().splitlines()]


def film(folder: Path) -> list[tuple[int, str]]:
    return [(row["frame"], row["particles_digest"]) for row in rows(folder, "frames.jsonl")]


@pytest.mark.timeout(240)
def test_a_person_works_at_the_desk(tmp_path):
    chromium()
    scene = shutil.copy(SCENE, tmp_path / "snow.py")

    async def person(url: str) -> None:
        async with Page.of(url) as page:
            await page.call(
                "Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path / "saved")
            )
            await page.until("view.state.frame > 20")

            # Scrub to a frame that is kept: with the mouse, with keys, and as fast as a hand moves.
            await page.click("[data-part=scrub]")
            await page.until("view.at !== null")
            await page.value("view.seek(4)")
            await page.until(f"{SHOWN} === 4")
            await page.press(".")
            await page.until(f"{SHOWN} === 5 && {part('at')}.textContent.startsWith('film 5')")
            await page.value("view.say({ pause: true })")
            await page.until("view.state.paused")
            waits = []
            for frame in range(6, 16):
                waits.append(
                    await page.call(
                        "Runtime.evaluate",
                        awaitPromise=True,
                        returnByValue=True,
                        expression=f"""new Promise(done => {{
                            const since = performance.now();
                            const tell = () => done(performance.now() - since);
                            view.drawn = () => {{ if ({SHOWN} === {frame}) tell(); }};
                            view.seek({frame});
                        }})""",
                    )
                )
            waited = sorted(one["result"]["value"] for one in waits)
            print("scrub, ms:", waited)
            crowded = max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))  # processes that share a processor
            assert waited[0] < 200 * crowded
            await page.value("view.say({ pause: false })")

            # Loop a range: nothing else is shown.
            await page.value("view.seek(3)")
            await page.press("[")
            await page.value("view.seek(8)")
            await page.press("]")
            assert await page.value(f"{part('loop')}.textContent") == "Loop 3 – 8"
            await page.value(f"window.seen = []; view.drawn = () => window.seen.push({SHOWN})")
            await page.press(" ")
            await page.until("window.seen.filter(frame => frame === 3).length > 2")
            await page.until("new Set(window.seen).size > 3")
            await page.press(" ")
            assert set(await page.value("window.seen")) <= {3, 4, 5, 6, 7, 8}
            assert await page.value("view.playing") is None
            await page.press("l")
            await page.until("view.state.finished", 60)

            # After the last frame the world is still there.
            assert await page.value(f"{part('frames')}.textContent") == "frame 60 of 60, complete"
            await page.until(f"{part('picture')}.dataset.exact === 'true'")
            number = await page.value(f"Number({part('picture')}.dataset.number)")
            await page.drag("[data-part=picture]", 90, 10)
            await page.until(f"Number({part('picture')}.dataset.number) > {number} && view.state.turned")
            await page.press("u")
            await page.until("!view.state.turned")
            assert await page.value(f"{part('undo')}.disabled")

            # The camera by numbers, and as Python.
            await page.value("document.querySelector('[data-part=camera]').open = true")
            await page.value(
                "(i => { i.value = 9; i.dispatchEvent(new Event('change')) })(view.poses.position[2])"
            )
            await page.until("view.state.camera.position[2] === 9")
            line = "motes.Camera((0.59, 2, 9), (0, 2, 0), up=(0, 1, 0), fov_deg=40)"
            assert await page.value(f"{part('line')}.value") == line

            # A typed value, keys whatever has the focus, and the picture as a file.
            await page.value("document.querySelector('input[data-typed=dense]').focus()")
            await page.until(f"{part('picture')}.dataset.exact === 'true'")
            await page.press("p")
            typed = "document.querySelector('input[data-typed=dense]')"
            await page.value(f"(i => {{ i.value = 47; i.dispatchEvent(new Event('change')) }})({typed})")
            await page.until("view.state.controls.dense.value === 50")
            await page.value("document.querySelector('select').focus()")
            await page.press("Home")
            await page.press(",")
            await page.until(f"{SHOWN} === 58")
            limit = time.monotonic() + 20
            while not (saved := list((tmp_path / "saved").glob("snow-*.png"))):
                assert time.monotonic() < limit
                await asyncio.sleep(0.05)
            assert saved[0].read_bytes().startswith(b"\x89PNG") and saved[0].name == "snow-0059.png"

            # Restart with the values and the camera of now; then finish, and the film is still there.
            await page.press("n")
            await page.until("view.state.take === 2 && view.state.finished", 60)
            assert await page.value("view.state.controls.dense.value") == 50
            await page.value(f"{part('stop')}.scrollIntoView()")
            await page.click("[data-part=stop]")
            await page.until("view.state.job === 'ended'")
            await page.call("Page.reload")
            await page.until("document.readyState === 'complete' && view.state.job === 'ended'")
            await page.value("view.seek(30)")
            await page.until(f"{SHOWN} === 30")
            assert not await page.value(f"{part('restart')}.disabled")

            await page.call(
                "Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=2, mobile=True
            )
            assert await page.value("document.documentElement.scrollWidth") == 390
            assert page.complaints == []

    with live(scene, tmp_path, 60, OPTIONS, options=("--wait",)) as command:
        asyncio.run(person(command.url))
        command.process.send_signal(signal.SIGINT)
        assert command.ended() == 0, "".join(command.lines)
    begins = rows(tmp_path, "steer.jsonl")[1]
    assert begins["frame"] == 0 and begins["set"] == {"dense": 50} and begins["camera"]["position"][2] == 9

    again = tmp_path / "again"
    again.mkdir()
    more = f"dict(steering={str(tmp_path / 'log' / 'steer.jsonl')!r}, shutter=0)"
    assert on_ranks(3, scene, again, 60, more, timeout=100).code == 0
    assert film(again) == film(tmp_path)


@pytest.mark.timeout(240)
def test_a_script_saved_again_on_the_way_goes_where_the_first_one_was(tmp_path):
    scene = tmp_path / "snow.py"
    scene.write_text(SCENE.read_text())

    async def conversation(url: str) -> None:
        async with Client.of(url) as viewer:
            await viewer.until(lambda: viewer.state.get("frame", 0) >= 5)
            await viewer.say(set={"wind": 2})
            await viewer.until(lambda: viewer.state["controls"]["wind"]["value"] == 2)
            await viewer.until(lambda: viewer.state["frame"] >= 14)
            await viewer.say(pause=True)
            await viewer.until(lambda: bool(viewer.state["paused"]))
            await asyncio.sleep(0.5)
            at = viewer.state["frame"]
            scene.write_text(scene.read_text().replace("time.sleep(pause_s)", "time.sleep(0.5)"))
            way = f"on the way to frame {at}"
            await viewer.until(
                lambda: viewer.state["take"] == 2 and way in (viewer.state["notice"] or ""), 60
            )
            scene.write_text(SCENE.read_text())
            await viewer.until(lambda: viewer.state["take"] == 3 and viewer.state["job"] == "running", 60)
            await viewer.until(lambda: viewer.state["frame"] == at and viewer.pictures[-1][1] == at - 1, 30)
            assert viewer.state["controls"]["wind"]["value"] == 2
            await viewer.say(stop=True)
            await viewer.until(lambda: viewer.state["job"] == "ended")

    with live(scene, tmp_path, 1000, OPTIONS, options=("--wait",)) as command:
        asyncio.run(conversation(command.url))


@pytest.mark.timeout(240)
def test_a_saved_script_is_reloaded_at_the_same_frame_and_a_wrong_one_is_told(tmp_path):
    text = SCENE.read_text()
    scene = tmp_path / "snow.py"
    scene.write_text(text)

    async def conversation(url: str) -> None:
        async with Client.of(url) as viewer:
            await viewer.until(lambda: viewer.state.get("frame", 0) >= 10)
            await viewer.say(set={"wind": 2})
            await viewer.until(lambda: viewer.state["controls"]["wind"]["value"] == 2)
            await viewer.say(pause=True)
            await viewer.until(lambda: bool(viewer.state["paused"]))
            at = viewer.state["frame"]

            # Neither a script that cannot be read nor one that fails in its first frame stops the run.
            for wrong, told in (("with with", "SyntaxError"), ("world.step_on()", "AttributeError")):
                scene.write_text(text.replace("        world.render()", f"        {wrong}"))
                await viewer.until(lambda told=told: told in (viewer.state["error"] or ""), 60)
                assert viewer.state["take"] == 1 and viewer.state["job"] == "running"
                await viewer.say(step=1)
                at += 1
                await viewer.until(lambda at=at: viewer.state["frame"] == at)

            # A script with another system goes on at the same frame, with what was set before it.
            other = text.replace('system("glow"', 'system("embers"').replace(
                "(wind.value, -2, 0)", "(wind.value, -9, 0)"
            )
            scene.write_text(other)
            await viewer.until(lambda: viewer.state["take"] == 2 and viewer.state["job"] == "running", 60)
            await viewer.until(lambda: viewer.state["frame"] == at and viewer.state["paused"], 60)
            assert viewer.state["error"] is None and viewer.state["controls"]["wind"]["value"] == 2
            await viewer.until(lambda: viewer.pictures[-1][1] == at - 1)

            # One that fails on its way there makes room for the last good one again.
            scene.write_text(
                other.replace("    world.render()", "    assert frame < 6, 'too far'\n        world.render()")
            )
            await viewer.until(lambda: viewer.state["take"] == 4 and viewer.state["frame"] == at, 90)
            assert (
                "too far" in viewer.state["error"] and "The last good script goes on" in viewer.state["error"]
            )
            await viewer.say(step=2)
            await viewer.until(lambda: viewer.state["frame"] == at + 2)
            await viewer.say(stop=True)
            await viewer.until(lambda: viewer.state["job"] == "ended")
            assert not list(tmp_path.glob(".snow*"))

    with live(scene, tmp_path, 1000, OPTIONS, options=("--wait",)) as command:
        asyncio.run(conversation(command.url))
    told = rows(tmp_path, "steer.jsonl")
    assert {name for row in told for name in row.get("set", {})} == {"wind"} and told[-1]["stop"]
    moved = sorted(path.name for path in tmp_path.glob("log*"))
    assert moved == ["log", "log.1", "log.2", "log.3"]  # the runs before are kept


def test_a_script_that_loops_for_ever_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(scripts, "REHEARSAL_S", 2.0)
    path = tmp_path / "loops.py"
    path.write_text("while True:\n    pass\n")
    told = asyncio.run(Script(path, []).rehearse())
    assert "has not finished its first 2 frames within 2 s" in told


def test_a_rehearsal_writes_nothing(tmp_path):
    path = tmp_path / "writes.py"
    path.write_text(f"""
import motes
log = {str(tmp_path / "log")!r}
camera = motes.Camera((0, 0, 9), (0, 0, 0))
world = motes.World(
    seed=1,
    log=log,
    checkpoint=motes.Checkpoint({str(tmp_path / "kept")!r}, every=1),
    roles=motes.Roles(manager=0, image_generator=2, calculators=[1]),
    renderer=motes.Renderer(32, 18, camera=camera),
)
snow = world.system("snow")
out = motes.Export({str(tmp_path / "out")!r})
with world, motes.Movie({str(tmp_path / "film.mp4")!r}) as film:
    for frame in world.frames(5):
        snow.burst((0, 0, 0), count=3)
        picture = world.render()
        picture.save({str(tmp_path / "still.png")!r})
        film.write(picture)
        out.write(world)
open({str(tmp_path / "after")!r}, "w").close()
""")
    assert asyncio.run(Script(path, []).rehearse()) == ""
    assert sorted(one.name for one in tmp_path.iterdir()) == ["writes.py"]


def test_a_run_that_nobody_watches_ends_the_command(tmp_path):
    with live(SCENE, tmp_path, 5, ranks=1) as command:
        assert command.ended() == 0, "".join(command.lines)
    assert len(film(tmp_path)) == 5
    wrong = tmp_path / "wrong.py"
    wrong.write_text("raise SystemExit(3)")
    with live(wrong, ranks=1) as command:
        assert command.ended() == 3


def test_a_resized_run_that_began_paused_goes_on(tmp_path, monkeypatch):
    """Its viewers may have left, so that nobody would let it go on."""
    starts = []

    def supervise(argv, variables, ranks, resizing):
        starts.append((ranks, os.environ["MOTES_LIVE"]))
        resizing.wanted = Size(3) if len(starts) == 1 else None
        return Ended(STOPPED if len(starts) == 1 else 0, lost=False)

    script = tmp_path / "script.py"
    script.write_text("")
    monkeypatch.setattr(starting, "supervise", supervise)
    monkeypatch.setattr(starting, "_leave_mpi", lambda: None)
    monkeypatch.setenv("MOTES_LIVE", "0,wait,host=127.0.0.1,paused")
    monkeypatch.setenv(LAUNCHER, "")
    before = signal.getsignal(signal.SIGUSR2)
    try:
        assert starting.run(1, [str(script)]) == 0
    finally:
        signal.signal(signal.SIGUSR2, before)
    assert starts == [(1, "0,wait,host=127.0.0.1,paused"), (3, "0,host=127.0.0.1")]


def test_options_of_run_reach_each_job():
    parser = Parser(prog="live")
    live_command.configure(parser)
    args = parser.parse_args(
        ["-n", "3", "--survive", "--restarts", "2", "--paused", "--", "--x", "snow.py", "-n", "9"]
    )
    assert live_command._words(args) == ["--ranks", "3", "--survive", "--restarts", "2"]
    assert live_command._words(parser.parse_args(["-n", "1", "snow.py"])) == ["--ranks", "1"]


# --- the film


def test_a_film_keeps_every_frame_until_its_budget_and_then_every_second():
    film = Film(budget=1000)
    for frame in range(10):
        film.add(frame, Shot(1, bytes(100)))
    assert film.spans() == [[0, 9, 1]] and film.bytes == 1000
    film.add(4, Shot(2, bytes(100)))
    assert film.spans() == [[0, 3, 1], [4, 4, 2], [5, 9, 1]] and film.at(4)[1].take == 2
    film.add(10, Shot(1, bytes(100)))
    assert film.bytes <= 1000 and film.step == 2 and film.spans()[-1] == [6, 10, 1]
    assert film.at(7)[0] == 6 and film.at(10)[0] == 10 and film.at(12) is None
    film.add(20, Shot(1, b"x"))
    assert film.spans()[-1] == [20, 20, 1] and film.at(15) is None
    film.spans()[-1][1] = 99
    assert film.spans()[-1] == [20, 20, 1], "what was told does not change"
    film.add(21, Shot(3, b"x"))
    film.add(12, Shot(3, b"x"))
    assert film.spans()[-4:] == [[6, 10, 1], [12, 12, 3], [20, 20, 1], [21, 21, 3]]


@pytest.mark.timeout(240)
def test_a_run_goes_on_with_the_ranks_that_the_page_asks_for(tmp_path):
    chromium()
    scene = shutil.copy(SCENE, tmp_path / "snow.py")
    checkpoint = f"checkpoint=motes.Checkpoint({str(tmp_path / 'kept')!r}, every=1000)"

    async def person(url: str) -> None:
        async with Page.of(url) as page:
            await page.until("view.state.frame > 8", 60)
            await page.value("view.say({ set: { wind: 2 } })")
            await page.until("view.state.controls.wind.value === 2")
            await page.click("[data-part=board] summary")
            await page.until(f"{part('size')}.value === '2' && !{part('resize')}.disabled")
            await page.value(f"{part('size')}.value = 3")
            await page.value(f"{part('resize')}.click()")
            await page.until("view.state.ranks === 3", 60)
            assert await page.value("!view.state.paused && view.state.take === 1")
            at = await page.value("view.state.frame")
            await page.until(f"view.state.frame > {at} + 3 && view.state.notice === null", 60)
            assert await page.value("view.state.controls.wind.value") == 2
            assert await page.value(f"view.take(4) === 1 && {part('size')}.value") == "3"

            # A paused run goes on paused, at the same frame.
            await page.value("view.say({ pause: true })")
            await page.until("view.state.paused")
            await page.value("view.say({ resize: 10000000 })")
            await page.until("view.refusal.includes('n must be in 1..')", 60)
            await page.value("window.frameThen = view.state.frame")
            await page.value("view.say({ resize: 1 })")
            await page.until("view.state.ranks === 1 && view.state.paused", 60)
            assert await page.value("view.state.frame === window.frameThen")
            await page.value("view.say({ pause: false })")
            await page.until("view.state.finished", 90)
            await page.value("view.say({ resize: 2 })")
            await page.until("view.refusal.includes('past its last frame')", 60)

            shutil.copytree(tmp_path / "log", tmp_path / "whole" / "log")

            # A restart has the ranks of now.
            await page.value("view.say({ restart: true })")
            await page.until("view.state.take === 2 && view.state.frame > 3", 60)
            assert await page.value("view.state.ranks") == 1
            assert page.complaints == []

    options = f"dict(pause_s=0.02, shutter=0, moves=False, {checkpoint})"
    with live(scene, tmp_path, 90, options) as command:
        asyncio.run(person(command.url))
    whole = tmp_path / "whole"
    header, *changes = rows(whole, "steer.jsonl")
    assert header["ranks"] == 2 and [row["resize"] for row in changes if "resize" in row] == [3, 1]
    assert [frame for frame, _ in film(whole)] == list(range(90))

    # A run that repeats this one keeps its own ranks, and makes the same film.
    steering = f"steering={str(whole / 'log' / 'steer.jsonl')!r}"
    (again := tmp_path / "again").mkdir()
    done = on_ranks(2, scene, again, 90, f"dict(shutter=0, moves=False, {steering})", timeout=100)
    assert done.code == 0, done.text
    assert film(again) == film(whole)
