"""The server of a live run: who gets access, what viewers receive, and that no viewer can delay the run."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import socket
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import numpy as np
import pytest
from viewers import Client, address, connect, websockets

from motes import Live
from motes._live import site
from motes._live.orders import Orders
from motes._live.server import Server
from motes._live.viewing import Viewing
from motes._world.world import World, running_of
from motes.errors import MotesError

GREY = np.full((48, 64, 3), 90, np.uint8)


@contextlib.contextmanager
def served(live: Live | None = None, controls: bool = False) -> Iterator[tuple[Server, Orders]]:
    orders = Orders()
    if controls:
        made = World(seed=1)
        made.control("wind", 0.0, low=-5, high=5)
        orders.know(running_of(made).viewers.steering.controls)
    server = Server(live or Live(0), orders, {"title": "test"})
    try:
        yield server, orders
    finally:
        server.close()


def play(conversation: Callable[[], Awaitable[None]], seconds: float = 30) -> None:
    asyncio.run(asyncio.wait_for(conversation(), seconds))


def get(url: str, **headers: str) -> tuple[int, str, dict[str, str]]:
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=10) as response:
            return response.status, response.read().decode(), dict(response.headers)
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(), dict(error.headers)


def taken(orders: Orders) -> dict[str, Any]:
    text, _ = orders.take(lambda: None, 0.1)
    return json.loads(text) if text else {}


async def soon(true: Callable[[], bool], seconds: float = 10) -> None:
    limit = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < limit
        await asyncio.sleep(0.01)


# --- access


def test_the_page_is_there_for_those_who_know_the_token():
    with served() as (server, _):
        code, page, headers = get(server.url)
        assert code == 200 and "<canvas" in page and "NONCE" not in page
        assert "script-src 'nonce-" in headers["Content-Security-Policy"]
        assert headers["Referrer-Policy"] == "no-referrer" and headers["Content-Type"].startswith("text/html")
        for wrong in (server.url[:-1], server.url.partition("?")[0], server.url.replace("k=", "k=x")):
            code, page, _ = get(wrong)
            assert code == 403 and "token" in page
        assert get(server.url.replace("/?", "/secret?"))[0] == 404
        assert get(server.url, Origin="http://evil.example")[0] == 403
        assert get(server.url, Host="evil.example:80")[0] == 403


def test_two_runs_have_two_tokens_and_two_ports():
    with served(Live(18080)) as (one, _), served(Live(18080)) as (two, _):
        assert one.port != two.port and one.port >= 18080 and two.port >= 18080
        assert (
            one.url.partition("k=")[2] != two.url.partition("k=")[2] and len(one.url.partition("k=")[2]) >= 20
        )
        assert get(two.url)[0] == 200


def test_only_this_machine_gets_in_by_default():
    with served() as (server, _):
        others = [a[4][0] for a in socket.getaddrinfo(socket.gethostname(), server.port, socket.AF_INET)]
        for address_ in {one for one in others if not one.startswith("127.")}:
            with pytest.raises(OSError), socket.create_connection((address_, server.port), timeout=2):
                pass


def test_no_free_port_and_no_such_address_are_said(monkeypatch):
    monkeypatch.setattr(site, "MOST_PORTS", 1)
    with socket.create_server(("127.0.0.1", 0)) as taken_:
        port = taken_.getsockname()[1]
        with pytest.raises(MotesError, match=f"cannot be served: 127.0.0.1:{port}: .*in use"):
            Server(Live(port), Orders(), {})
    with pytest.raises(MotesError, match="cannot be served: 192.0.2.1:0"):
        Server(Live(0, host="192.0.2.1"), Orders(), {})


@pytest.mark.parametrize(
    "options",
    [
        {"origin": "http://evil.example"},
        {"additional_headers": {"Host": "evil.example:80"}},
        {"token": "wrong"},
    ],
)
def test_strangers_get_no_socket(options):
    async def conversation() -> None:
        url = server.url + options.pop("token", "")
        with pytest.raises(websockets.exceptions.InvalidStatus) as refused:
            async with connect(address(url), **options):
                pass
        assert refused.value.response.status_code == 403
        async with Client.of(server.url, origin=f"http://127.0.0.1:{server.port}") as viewer:
            await viewer.until(lambda: viewer.state.get("title") == "test")

    with served() as (server, _):
        play(conversation)


# --- pictures


def test_a_viewer_gets_the_newest_picture_and_then_one_without_loss():
    import PIL.Image

    async def conversation() -> None:
        server.tell({"frame": 3, "paused": True})
        server.show(GREY // 2, frame=1, orders=0)
        server.show(GREY, frame=2, orders=7)
        async with Client.of(server.url) as viewer:
            await viewer.until(lambda: bool(viewer.pictures) and viewer.pictures[-1][3] == 1)
            assert {picture[0] for picture in viewer.pictures} == {2}  # the first was replaced
            assert viewer.pictures[-1][1:3] == (2, 7)
            assert (np.asarray(PIL.Image.open(io.BytesIO(viewer.last))) == GREY).all()
            assert viewer.state["frame"] == 3 and viewer.state["viewers"] == 1
            server.show(GREY, frame=4, orders=8)
            await viewer.until(lambda: viewer.pictures[-1][0] == 3)
            jpeg = next(picture for picture in viewer.pictures if picture[0] == 3)
            assert jpeg[1:4] == (4, 8, 0)

    with served() as (server, _):
        play(conversation)


def test_a_viewer_has_two_pictures_in_flight_at_most_and_then_the_newest():
    async def conversation() -> None:
        async with Client.of(server.url) as viewer:
            viewer.acknowledges = False
            for frame in range(1, 31):
                server.show(GREY, frame=frame, orders=0)
                await asyncio.sleep(0.01)
            await asyncio.sleep(0.3)
            assert len(viewer.pictures) == 2
            await viewer.say(ack=viewer.pictures[0][0])
            await viewer.until(lambda: len(viewer.pictures) == 3)
            assert viewer.pictures[-1][1] == 30
            await viewer.say(ack=12345)  # a number that was never sent
            await viewer.say(ack="x")
            await asyncio.sleep(0.1)
            assert len(viewer.pictures) == 3

    with served(Live(0, max_fps=1000)) as (server, _):
        play(conversation)


def test_no_more_pictures_a_second_than_asked_for():
    async def conversation() -> None:
        async with Client.of(server.url) as viewer:
            start = time.monotonic()
            while time.monotonic() - start < 1.5:
                server.show(GREY, frame=1, orders=0)
                await asyncio.sleep(0.005)
            took = time.monotonic() - start
            assert 3 <= len(viewer.pictures) <= 10 * took + 2

    with served(Live(0, max_fps=10)) as (server, _):
        play(conversation)


def test_ten_viewers_see_the_same():
    async def conversation() -> None:
        async with contextlib.AsyncExitStack() as stack:
            viewers = [await stack.enter_async_context(Client.of(server.url)) for _ in range(10)]
            for frame in range(40):
                server.show(GREY, frame=frame, orders=0)
                await asyncio.sleep(0.02)
            for viewer in viewers:
                await viewer.until(
                    lambda viewer=viewer: bool(viewer.pictures) and viewer.pictures[-1][1] == 39
                )
                await viewer.until(lambda viewer=viewer: viewer.state["viewers"] == 10)
                assert len(viewer.pictures) > 5
            await viewers[3].say(set={"wind": 2})
            await soon(lambda: taken(orders) == {"set": {"wind": 2.0}})
        await soon(lambda: server.viewers == 0)

    with served(controls=True) as (server, orders):
        play(conversation)


def test_a_viewer_that_stops_reading_costs_nothing():
    large = np.random.default_rng(1).integers(0, 255, (720, 1280, 3), np.uint8)  # 1 MB as JPEG

    async def conversation() -> None:
        deaf = await connect(address(server.url), max_size=None, max_queue=1)
        deaf.transport.pause_reading()
        async with Client.of(server.url) as viewer:
            seconds = []
            for frame in range(60):
                start = time.monotonic()
                server.show(large, frame=frame, orders=0)
                seconds.append(time.monotonic() - start)
                await asyncio.sleep(0.02)
            assert sorted(seconds)[50] < 0.005
            await viewer.until(lambda: viewer.pictures[-1][1] == 59)
            assert len(viewer.pictures) > 5
            held = [v for v in server._viewers if len(v._flying) == 2]
            assert len(held) <= 1
            waiting = sum(v._socket.transport.get_write_buffer_size() for v in server._viewers)
            assert waiting < 3 * len(viewer.last)
        deaf.transport.abort()

    with served() as (server, _):
        play(conversation)
        start = time.monotonic()
    assert time.monotonic() - start < 5


def test_a_viewer_that_stays_deaf_does_not_hold_up_the_end():
    large = np.random.default_rng(1).integers(0, 255, (720, 1280, 3), np.uint8)

    async def conversation() -> None:
        deaf = await connect(address(server.url), max_size=None, max_queue=1)
        deaf.transport.pause_reading()
        for frame in range(5):
            server.show(large, frame=frame, orders=0)
            await asyncio.sleep(0.05)
        start = time.monotonic()
        await asyncio.to_thread(server.close)
        assert time.monotonic() - start < 5
        deaf.transport.abort()

    with served() as (server, _):
        play(conversation)
    assert not server._thread.is_alive()


# --- orders


@pytest.mark.parametrize(
    "nonsense",
    [
        *("", "{", "[" * 60_000, "null", "[1]", '{"eval": "1"}', '{"set": {"rain": 1}}', b"\x00\xff"),
        *('{"zoom": 1%s}' % ("0" * 400), '{"zoom": 1%s}' % ("0" * 9000), '{"orbit": [1, Infinity]}'),
    ],
)
def test_nonsense_is_answered_and_ignored(nonsense):
    async def conversation() -> None:
        async with Client.of(server.url) as viewer:
            await viewer.socket.send(nonsense)
            await viewer.until(lambda: bool(viewer.refusals))
            assert taken(orders) == {}
            await viewer.say(set={"wind": 9})
            await soon(lambda: taken(orders) == {"set": {"wind": 5.0}})

    with served(controls=True) as (server, orders):
        play(conversation)


def test_a_giant_message_ends_its_viewer_and_nothing_else():
    async def conversation() -> None:
        async with Client.of(server.url) as other:
            giant = await connect(address(server.url))
            await soon(lambda: server.viewers == 2)
            with contextlib.suppress(websockets.exceptions.ConnectionClosed):
                await giant.send("[" + " " * 100_000_000)
            await soon(lambda: server.viewers == 1)
            await other.say(pause=True)
            await soon(lambda: taken(orders) == {"pause": True})

    with served() as (server, orders):
        play(conversation)


def test_half_a_request_and_dead_connections_cost_nothing():
    async def conversation() -> None:
        for text in (
            b"",
            b"GET / HTTP",
            b"\x16\x03\x01",
            b"POST / HTTP/1.1\r\n\r\n",
            b"GET /?k=" + b"x" * 70_000,
        ):
            reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
            with contextlib.suppress(ConnectionError):
                writer.write(text)
                await writer.drain()
            writer.close()
        async with Client.of(server.url) as viewer:
            await viewer.until(lambda: bool(viewer.state))

    with served() as (server, _):
        play(conversation)


def test_connections_that_say_nothing_push_each_other_out_and_leave_the_run_its_descriptors():
    async def conversation() -> None:
        silent = [await asyncio.open_connection("127.0.0.1", server.port) for _ in range(100)]
        for k, (_, writer) in enumerate(silent):
            with contextlib.suppress(ConnectionError):
                writer.write(b"GET / HTTP/1.1\r\n" if k % 2 else b"GET /live HTTP/1.1\r\n\r\n")

        async def until_closed(reader: asyncio.StreamReader) -> None:
            with contextlib.suppress(ConnectionError):
                await reader.read()

        waits = [asyncio.create_task(until_closed(reader)) for reader, _ in silent]
        await asyncio.wait(waits, timeout=1)
        assert sum(not one.done() for one in waits) <= site.MOST_WAITING
        assert len(server._waiting) <= site.MOST_WAITING
        async with Client.of(server.url) as viewer:
            await viewer.until(lambda: bool(viewer.state))
            assert not any(one.done() and one.exception() for one in waits)
        for one in waits:
            one.cancel()
        for _, writer in silent:
            writer.close()
        await soon(lambda: not server._waiting)

    with served() as (server, _):
        play(conversation)


def test_there_are_no_more_viewers_than_are_let_in(monkeypatch):
    monkeypatch.setattr(site, "MOST_VIEWERS", 2)

    async def conversation() -> None:
        async with Client.of(server.url) as one, Client.of(server.url) as two:
            await one.until(lambda: one.state.get("viewers") == 2)
            with pytest.raises(websockets.exceptions.InvalidStatus) as refused:
                async with Client.of(server.url):
                    pass
            assert refused.value.response.status_code == 503
            await two.until(lambda: bool(two.state))
        await soon(lambda: server.viewers == 0)
        async with Client.of(server.url) as again:
            await again.until(lambda: bool(again.state))

    with served() as (server, _):
        play(conversation)


def test_a_server_without_viewers_rests(monkeypatch):
    woken = []

    async def conversation() -> None:
        monkeypatch.setattr(server, "_call", lambda function: woken.append(function))
        for frame in range(1, 9):
            server.tell({"frame": frame})
            server.show(GREY, frame=frame, orders=0)
        assert woken == []
        monkeypatch.undo()
        async with Client.of(server.url) as viewer:
            await viewer.until(lambda: bool(viewer.pictures) and viewer.state.get("frame") == 8)
            assert viewer.pictures[-1][1] == 8
            server.tell({"frame": 9})
            await viewer.until(lambda: viewer.state["frame"] == 9)

    with served() as (server, _):
        play(conversation)


def test_viewers_hear_of_the_end():
    async def conversation() -> None:
        async with Client.of(server.url) as viewer:
            await viewer.until(lambda: bool(viewer.state))
            threading.Thread(target=server.close).start()
            await viewer.until(lambda: bool(viewer.state.get("closed")))
            assert viewer.state["ended"]

    with served() as (server, _):
        play(conversation)


def test_the_last_picture_arrives_however_fast_the_run_was():
    async def conversation() -> None:
        async with Client.of(server.url) as viewer:
            viewer.acknowledges = False
            await viewer.until(lambda: bool(viewer.state))
            for frame in range(1, 100):
                server.show(GREY, frame=frame, orders=0)
                await asyncio.sleep(0.002)
            threading.Thread(target=server.close).start()
            await viewer.until(lambda: bool(viewer.state.get("closed")))
            assert viewer.pictures[-1][1] == 99 and len(viewer.pictures) <= 3

    with served(Live(0)) as (server, _):
        play(conversation)


def test_the_line_that_is_printed_says_how_to_get_there(capfd):
    for host, tunnel in (("127.0.0.1", "127.0.0.1"), ("::1", "[::1]"), ("localhost", "localhost")):
        viewing = Viewing(Live(0, host=host), {}, None)
        viewing.close()
        port = viewing.url.partition("/?")[0].rpartition(":")[2]
        (line,) = capfd.readouterr().err.splitlines()
        machine = socket.gethostname()
        command = f"ssh -L {port}:{tunnel}:{port} {machine}"
        assert line == f"motes: live at {viewing.url}  (from another machine: {command})"
    viewing = Viewing(Live(0, host="0.0.0.0"), {}, None)
    viewing.close()
    assert f"//{socket.gethostname()}:" in viewing.url
