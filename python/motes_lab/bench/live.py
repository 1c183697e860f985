"""Measures a viewer's latency, from an order to the picture that shows it, in a real job."""

from __future__ import annotations

import asyncio
import contextlib
import json
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from motes.errors import MotesError

from .._engine import extras

__all__ = ["live"]

START_S = 60.0
END_S = 30.0
_SCENE = """
import os
import sys
import motes
from motes.shapes import Box, Plane

particles, width, height = map(int, sys.argv[1:4])
folder = sys.argv[4]
renderer = motes.Renderer(width, height, camera=motes.Camera((0, 4, 30), (0, 4, 0)))
world = motes.World(seed=1, space=(-10, 10), renderer=renderer, progress="off", live=motes.Live(0))
wind = world.control("wind", 0.0, low=-5, high=5)
snow = world.system("snow")
with world:
    if world.live_url is not None:
        with open(folder + "/url.part", "w") as file:
            file.write(world.live_url)
        os.rename(folder + "/url.part", folder + "/url")
    for frame in world.frames(1_000_000):
        if frame == 0:
            snow.burst(Box((-10, 0, -5), (10, 10, 5)), count=particles)
        snow.gravity((0, -2, 0))
        snow.wind((wind.value, 0, 0), drag=0.5)
        snow.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=0.95)
        snow.move()
        world.render()
"""


def live(*, particles: int, size: tuple[int, int], ranks: int, orders: int) -> dict[str, Any]:
    """Start a job of falling particles, give orders one by one, and measure the wall time to each picture."""
    extras.require_live()
    with tempfile.TemporaryDirectory(prefix="motes-bench-") as place:
        folder = Path(place)
        script = folder / "scene.py"
        script.write_text(_SCENE)
        arguments = [str(particles), str(size[0]), str(size[1]), place]
        argv = [sys.executable, "-m", "motes", "run", "-n", str(ranks), str(script), *arguments]
        with (folder / "err").open("wb") as err:
            job = subprocess.Popen(argv, stdout=err, stderr=err, stdin=subprocess.DEVNULL)
        try:
            viewer = _Viewer(_url(job, folder), orders)
            job.wait(END_S)
        finally:
            if job.poll() is None:
                job.terminate()
                job.wait()
    late = sorted(viewer.waits_s)
    return {
        "particles": particles,
        "size": f"{size[0]}x{size[1]}",
        "ranks": ranks,
        "orders": orders,
        "order_to_picture_ms": 1e3 * statistics.median(late),
        "order_to_picture_p95_ms": 1e3 * late[int(0.95 * (len(late) - 1))],
        "paused_order_to_picture_ms": 1e3 * statistics.median(viewer.paused_s),
        "frames_per_s": viewer.frames_per_s,
        "pictures_per_s": viewer.pictures_per_s,
        "picture_kib": viewer.picture_bytes / 1024,
    }


def _url(job: subprocess.Popen[bytes], folder: Path) -> str:
    limit = time.monotonic() + START_S
    while not (folder / "url").exists():
        if job.poll() is not None or time.monotonic() > limit:
            raise MotesError(f"the job did not start:\n{(folder / 'err').read_text(errors='replace')}")
        time.sleep(0.02)
    return (folder / "url").read_text()


class _Viewer:
    """Repeatedly orbits a little and waits for the first picture that shows it, in another thread."""

    def __init__(self, url: str, orders: int) -> None:
        parts = urlsplit(url)
        self._address = f"ws://{parts.netloc}/live?{parts.query}"
        self._orders = orders
        self.waits_s: list[float] = []
        self.paused_s: list[float] = []
        self.frames_per_s = self.pictures_per_s = 0.0
        self.picture_bytes = 0
        self._given = 0
        failed: list[BaseException] = []

        def run() -> None:
            try:
                asyncio.run(self._watch())
            except Exception as error:  # any: raised again below
                failed.append(error)

        thread = threading.Thread(target=run)
        thread.start()
        thread.join()
        if failed:
            raise MotesError(f"the viewer failed: {type(failed[0]).__name__}: {failed[0]}") from failed[0]

    async def _watch(self) -> None:
        connect = extras.websockets("asyncio.client").connect
        closed = extras.websockets("exceptions").ConnectionClosed
        async with connect(self._address, max_size=None) as socket:
            await self._until(socket, 0)
            pictures, frame, start = 0, 0, time.perf_counter()
            first = await self._picture(socket)
            while time.perf_counter() - start < 2:
                frame = await self._picture(socket)
                pictures += 1
            took = time.perf_counter() - start
            self.frames_per_s, self.pictures_per_s = (frame - first) / took, pictures / took
            for number in range(self._orders):
                await asyncio.sleep(0.013 * (number % 7))  # not in step with the frames
                self.waits_s.append(await self._order(socket, {"orbit": [0.02, 0.0]}))
            await self._say(socket, {"pause": True})
            await asyncio.sleep(0.5)
            for _ in range(max(1, self._orders // 4)):
                self.paused_s.append(await self._order(socket, {"orbit": [0.02, 0.0]}))
            await self._say(socket, {"stop": True})
            with contextlib.suppress(closed):
                while True:
                    await socket.recv()

    async def _say(self, socket: Any, order: dict[str, Any]) -> None:
        self._given += 1
        await socket.send(json.dumps(order))

    async def _order(self, socket: Any, order: dict[str, Any]) -> float:
        start = time.perf_counter()
        await self._say(socket, order)
        await self._until(socket, self._given)
        return time.perf_counter() - start

    async def _until(self, socket: Any, orders: int) -> None:
        while True:
            message = await self._message(socket)
            if int.from_bytes(message[12:16], "little") >= orders:
                return

    async def _picture(self, socket: Any) -> int:
        message = await self._message(socket)
        self.picture_bytes = len(message)
        return int.from_bytes(message[8:12], "little")

    async def _message(self, socket: Any) -> bytes:
        while True:
            message = await asyncio.wait_for(socket.recv(), START_S)
            if isinstance(message, bytes):
                await socket.send(json.dumps({"ack": int.from_bytes(message[4:8], "little")}))
                return message
