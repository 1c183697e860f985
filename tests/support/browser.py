"""Headless Chromium, driven by its DevTools protocol: mouse, keys, screenshots."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import io
import itertools
import json
import os
import shutil
import subprocess
import tempfile
import time
import urllib.request
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from launching import kill_session
from viewers import connect

START_S = 60
SIZE = (1000, 640)


def chromium() -> str:
    """Find the program; skip the test if it is missing, unless MOTES_TEST_CHROMIUM=required."""
    names = ("chromium", "chromium-browser", "google-chrome", "chrome")
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        if os.environ.get("MOTES_TEST_CHROMIUM") == "required":
            pytest.fail("there is no Chromium, and MOTES_TEST_CHROMIUM=required")
        pytest.skip("there is no Chromium (Debian: apt-get install chromium)")
    return found


class Page:
    """A page of the browser."""

    def __init__(self, socket: Any) -> None:
        self._socket = socket
        self._numbers = itertools.count(1)
        self._answers: dict[int, asyncio.Future[Any]] = {}
        self.complaints: list[str] = []

    @classmethod
    @contextlib.asynccontextmanager
    async def of(cls, url: str) -> AsyncIterator[Page]:
        """Start a browser with this page."""
        program = chromium()
        with tempfile.TemporaryDirectory(prefix="motes-chromium-", ignore_cleanup_errors=True) as home:
            options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
            options += ["--no-first-run", f"--user-data-dir={home}", "--remote-debugging-port=0"]
            process = subprocess.Popen(
                [program, *options, "about:blank"],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
            try:
                target = await _target(Path(home))
                async with connect(target, max_size=None) as socket:
                    page = cls(socket)
                    reading = asyncio.create_task(page._read())
                    for domain in ("Page", "Runtime", "Log"):
                        await page.call(f"{domain}.enable")
                    size = {"width": SIZE[0], "height": SIZE[1], "deviceScaleFactor": 1, "mobile": False}
                    await page.call("Emulation.setDeviceMetricsOverride", **size)
                    await page.call("Page.navigate", url=url)
                    await page.until("document.readyState === 'complete' && location.protocol !== 'about:'")
                    await page.call("Page.captureScreenshot")  # until it has painted, it ignores clicks
                    try:
                        yield page
                    finally:
                        reading.cancel()
            finally:
                process.terminate()
                process.wait(20)
                kill_session(process.pid)  # its helpers keep writing to `home` for a moment

    async def call(self, method: str, **parameters: Any) -> Any:
        """Call the protocol, and return the result."""
        number = next(self._numbers)
        self._answers[number] = asyncio.get_running_loop().create_future()
        await self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        return await asyncio.wait_for(self._answers[number], 30)

    async def value(self, expression: str) -> Any:
        """Return the value of a JavaScript expression."""
        said = await self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in said, said
        return said["result"].get("value")

    async def until(self, expression: str, seconds: float = 30) -> Any:
        """Wait until a JavaScript expression is true."""
        limit = time.monotonic() + seconds
        while not (value := await self.value(expression)):
            assert time.monotonic() < limit, f"not within {seconds} s: {expression}"
            await asyncio.sleep(0.05)
        return value

    async def middle(self, selector: str) -> tuple[float, float]:
        """Return the middle of an element, px."""
        box = f"document.querySelector({selector!r}).getBoundingClientRect()"
        x, y = await self.value(f"(b => [b.x + b.width / 2, b.y + b.height / 2])({box})")
        return x, y

    async def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """Send a mouse event with the left button held, pressed or released."""
        buttons = {"button": "left", "buttons": 0 if kind == "mouseReleased" else 1, "clickCount": 1} | more
        await self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **buttons)

    async def click(self, selector: str) -> None:
        """Press a button."""
        x, y = await self.middle(selector)
        await self.mouse("mousePressed", x, y)
        await self.mouse("mouseReleased", x, y)

    async def drag(self, selector: str, dx: float, dy: float, steps: int = 8) -> None:
        """Drag from an element's middle."""
        x, y = await self.middle(selector)
        await self.mouse("mousePressed", x, y)
        for i in range(1, steps + 1):
            await self.mouse("mouseMoved", x + dx * i / steps, y + dy * i / steps)
            await asyncio.sleep(0.02)
        await self.mouse("mouseReleased", x + dx, y + dy)

    async def press(self, key: str) -> None:
        """Press a key."""
        text = {"text": key} if len(key) == 1 else {}
        await self.call("Input.dispatchKeyEvent", type="keyDown", key=key, code=key, **text)
        await self.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=key)

    async def screenshot(self, path: Path) -> np.ndarray:
        """Return a screenshot, and write it to a file."""
        import PIL.Image

        said = await self.call("Page.captureScreenshot", format="png")
        path.write_bytes(base64.b64decode(said["data"]))
        return np.asarray(PIL.Image.open(io.BytesIO(path.read_bytes())).convert("RGB"))

    async def _read(self) -> None:
        async for message in self._socket:
            said = json.loads(message)
            if "id" in said:
                answer = self._answers.pop(said["id"])
                if not answer.done():
                    answer.set_result(said.get("result", {"error": said.get("error")}))
            elif said["method"] == "Page.javascriptDialogOpening":
                await self._socket.send(
                    json.dumps({"id": 0, "method": "Page.handleJavaScriptDialog", "params": {"accept": True}})
                )
                self._answers[0] = asyncio.get_running_loop().create_future()
            elif said["method"] in ("Runtime.exceptionThrown", "Log.entryAdded"):
                self.complaints.append(json.dumps(said["params"]))


async def _target(home: Path) -> str:
    """Wait for the browser, and return the address of its page."""
    limit = time.monotonic() + START_S
    while time.monotonic() < limit:
        with contextlib.suppress(OSError, ValueError, IndexError, StopIteration):  # the file may be empty
            port = int((home / "DevToolsActivePort").read_text().split()[0])
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/json", timeout=5) as answer:
                return next(one["webSocketDebuggerUrl"] for one in json.load(answer) if one["type"] == "page")
        await asyncio.sleep(0.1)
    raise AssertionError("Chromium does not start")
