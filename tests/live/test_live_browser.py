"""A person at the page of a live run turns the camera, moves a slider, pauses, steps and ends the run."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Coroutine
from pathlib import Path

import numpy as np
import pytest
from browser import Page, chromium
from standing import on_ranks
from viewers import Beside, url_of

import motes
from motes import Live
from motes._live.orders import Orders
from motes._live.pose import Pose
from motes._live.server import Server
from motes._world.world import running_of

pytest.importorskip("PIL")
SCENE = Path(__file__).parents[1] / "scenes" / "steered.py"
FRAME = "Number(document.querySelector('[data-part=frame]').textContent)"
PICTURE = "document.querySelector('[data-part=picture]').dataset"
HOME = Pose((0.0, 2.0, 12.0), (0.0, 2.0, 0.0), (0.0, 1.0, 0.0), 40.0)
NOTICE = "document.querySelector('[data-part=notice]')"
EXACT = f"{PICTURE}.exact === 'true'"


def brightness(screen: np.ndarray) -> float:
    """Return the mean brightness of the picture's part of the page."""
    return float(screen[:, :700].mean())


def visit(server: Server, person: Callable[[], Coroutine[None, None, None]]) -> None:
    """Let a person use a page, then close its server."""
    try:
        asyncio.run(person())
    finally:
        server.close()


async def until_as_before(page: Page, screen: np.ndarray, path: Path) -> None:
    """Wait until the picture looks as before; the page first shows the pictures of earlier orders."""
    limit = time.monotonic() + 30
    while not ((await page.screenshot(path))[:, :700] == screen[:, :700]).all():
        assert time.monotonic() < limit, f"not as before: {path}"
        await asyncio.sleep(0.1)


def test_the_page_connects_again(tmp_path):
    chromium()
    orders = Orders()
    server = Server(Live(0), orders, {"title": "again"})

    async def person() -> None:
        async with Page.of(server.url) as page:
            for frame in (1, 2, 3):
                server.show(np.full((48, 64, 3), 60 * frame, np.uint8), frame=frame, orders=0)
                await page.until(f"{PICTURE}.frame === '{frame}'")
                assert await page.value(f"{NOTICE}.hidden")
                (viewer,) = server._viewers
                server._loop.call_soon_threadsafe(viewer._socket.transport.abort)
                await page.until(f"!{NOTICE}.hidden")
                assert (
                    await page.value("document.querySelector('[data-part=notice]').textContent")
                ).startswith("no conn")
            await page.until("socket !== null && socket.readyState === 1")
            await page.press(" ")
            limit = time.monotonic() + 20
            while not orders._order:
                assert time.monotonic() < limit
                await asyncio.sleep(0.05)

    visit(server, person)


def test_buttons_stay_where_they_are():
    chromium()
    server = Server(Live(0), Orders(), {"title": "still"})
    moved = """(() => {
        const root = document.body.appendChild(document.createElement("div"));
        const view = new View(root, () => {});
        const place = () => view.part("pause").getBoundingClientRect().y, before = place();
        view.showRate();
        const after = place();
        view.close();
        root.remove();
        return after - before;
    })()"""

    async def person() -> None:
        async with Page.of(server.url) as page:
            assert await page.value(moved) == 0

    visit(server, person)


def test_keys_reach_the_picture_whatever_was_used_last_and_small_pictures_fill_the_window():
    chromium()
    orders = Orders()
    world = motes.World(seed=1, progress="off")
    world.control("wind", 0.0, low=-5, high=5)
    world.control("still", False)
    orders.know(running_of(world).viewers.steering.controls)
    server = Server(Live(0), orders, {"title": "keys", "width": 64, "height": 48})
    controls = {
        name: control._definition for name, control in running_of(world).viewers.steering.controls.items()
    }
    server.tell({"frame": 1, "paused": False, "turned": False, "controls": controls})

    async def said(name: str) -> None:
        limit = time.monotonic() + 20
        while name not in json.loads(orders.take(lambda: HOME, 0.1)[0] or "{}"):
            assert time.monotonic() < limit, name
            await asyncio.sleep(0.05)

    async def person() -> None:
        async with Page.of(server.url) as page:
            server.show(np.full((48, 64, 3), 90, np.uint8), frame=1, orders=0)
            await page.until(f"{PICTURE}.frame === '1'")
            await page.until("document.querySelector('input[data-control=still]') !== null")
            box = "document.querySelector('[data-part=picture]').getBoundingClientRect()"
            assert await page.value(f"{box}.width") > 600 and await page.value(f"{box}.height") > 500
            assert (
                await page.value("getComputedStyle(document.documentElement).backgroundColor")
                == "rgb(16, 18, 22)"
            )
            for use in ("input[data-control=wind]", "input[data-control=still]"):
                await (page.drag(use, 20, 0) if "wind" in use else page.click(use))
                await said("set")
                for key, name in ((" ", "pause"), ("ArrowLeft", "camera"), ("+", "camera"), ("-", "camera")):
                    await page.press(key)
                    await said(name)
            await page.value("document.querySelector('input[data-control=wind]').focus()")
            for key, name in ((" ", "pause"), ("+", "camera"), ("ArrowRight", "set")):
                await page.press(key)
                await said(name)
            await page.click("[data-part=pace]")
            await page.press("+")
            await said("camera")
            assert orders.paced
            await page.call(
                "Emulation.setDeviceMetricsOverride", width=360, height=900, deviceScaleFactor=1, mobile=True
            )
            assert await page.value(f"{box}.width") == 360

    visit(server, person)


@pytest.mark.timeout(240)
def test_a_person_steers_a_run_in_a_browser(tmp_path):
    chromium()

    async def person() -> None:
        async with Page.of(await url_of(tmp_path)) as page:
            await page.until(f"{PICTURE}.frame > 20")
            assert await page.value("document.querySelector('[data-part=title]').textContent") == "steered.py"
            assert await page.value(f"{NOTICE}.hidden")

            await page.click("[data-part=pause]")
            await page.until("document.querySelector('[data-part=pause]').textContent === 'Continue'")
            held = await page.value(FRAME)
            await page.until(f"Number({PICTURE}.frame) === {held} - 1 && {EXACT}")  # frames count from 0
            first = await page.screenshot(tmp_path / "first.png")
            assert first.shape[:2] == (640, 1000) and brightness(first) > 0.5

            # Paused: the camera turns, the frame stays the same.
            number = await page.value(f"{PICTURE}.number")
            await page.drag("[data-part=picture]", 120, -40)
            await page.until(f"{PICTURE}.number > {number} && {EXACT}")
            turned = await page.screenshot(tmp_path / "turned.png")
            assert (turned[:, :700] != first[:, :700]).any(axis=2).mean() > 0.005
            assert await page.value(FRAME) == held
            x, y = await page.middle("[data-part=picture]")
            number = await page.value(f"{PICTURE}.number")
            await page.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-300)
            await page.until(f"{PICTURE}.number > {number} && {EXACT}")

            # Back to the script's camera: the first picture again.
            await page.click("[data-part=reset]")
            await page.until("document.querySelector('[data-part=reset]').disabled")
            await until_as_before(page, first, tmp_path / "back.png")

            for step in (1, 2):
                await page.click("[data-part=step]")
                await page.until(f"{FRAME} === {held + step}")
            await page.press("s")
            await page.until(f"{FRAME} === {held + 3}")

            # A slider, a choice and a check box.
            await page.drag("input[data-control=wind]", 60, 0)
            await page.until("view.state.controls.wind.value > 1")
            await page.click("input[data-control=still]")
            await page.until("view.state.controls.still.value === true")
            choose = "(s => { s.value = 1; s.dispatchEvent(new Event('change')) })"
            await page.value(f"{choose}(document.querySelector('select'))")
            await page.until("view.state.controls.shape.value === 'narrow'")
            await page.screenshot(tmp_path / "controls.png")
            await page.value("document.activeElement.blur()")
            await page.press(" ")
            await page.until(f"{FRAME} > {held + 10}")
            await page.drag("[data-part=picture]", -80, 20)
            await page.until("view.state.turned")
            await page.screenshot(tmp_path / "running.png")

            await page.click("[data-part=stop]")
            await page.until(f"{NOTICE}.textContent === 'the run has ended'")
            await page.screenshot(tmp_path / "ended.png")
            assert page.complaints == []

    camera = "motes.Camera((0, 2, 12), (0, 2, 0))"
    options = f"shutter=0, pause_s=0.02, renderer=motes.Renderer(640, 360, camera={camera})"
    with Beside(person) as beside:
        result = on_ranks(
            3,
            SCENE,
            tmp_path,
            100_000,
            f"dict(live=motes.Live(0), {options})",
            timeout=200,
            watch=beside.check,
        )
    assert result.code == 0, result.text
    rows = [json.loads(line) for line in (tmp_path / "log" / "steer.jsonl").read_text().splitlines()][1:]
    sets = {name: value for row in rows for name, value in row.get("set", {}).items()}
    assert sets["wind"] > 1 and sets["still"] is True and sets["shape"] == "narrow"
    assert rows[-1]["stop"] and rows[-2]["camera"]["look_at"] == [0.0, 2.0, 0.0]
    film = (tmp_path / "log" / "frames.jsonl").read_text().splitlines()

    # The same film again, without a browser.
    again = tmp_path / "again"
    again.mkdir()
    more = f"dict(steering={str(tmp_path / 'log' / 'steer.jsonl')!r}, {options})"
    assert on_ranks(2, SCENE, again, 100_000, more, timeout=100).code == 0
    fingerprints = ("frame", "particles_digest", "image_sha256")
    one, two = (
        [[json.loads(line)[name] for name in fingerprints] for line in lines]
        for lines in (film, (again / "log" / "frames.jsonl").read_text().splitlines())
    )
    assert one == two
