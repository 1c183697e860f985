"""The blackboard: a lecturer sees who waits for whom, and changes balancer and speeds while a run goes on."""

from __future__ import annotations

import asyncio
import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from browser import Page, chromium
from desks import live
from handmade import load_row, rows, write_log
from standing import on_ranks

import motes
from motes import errors
from motes._desk.board import Board
from motes._live import steer_file
from motes._live.orders import Orders
from motes._world import balancing
from motes._world.world import session_of
from motes.analysis import open_run

SCENE = Path(__file__).parents[1] / "scenes" / "steered.py"
FRAMES = 150
OPTIONS = "dict(pause_s=0.01, shutter=0, moves=False)"


def film(folder: Path) -> list[tuple[int, str, str]]:
    rows = map(json.loads, (folder / "log" / "frames.jsonl").read_text().splitlines())
    return [(row["frame"], row["particles_digest"], row["image_sha256"]) for row in rows]


@pytest.fixture(scope="module")
def taught(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """Run a scene on 3 ranks, while a lecturer changes balancer and speeds; return the waits on the page."""
    chromium()
    folder = tmp_path_factory.mktemp("taught")
    scene = shutil.copy(SCENE, folder / "snow.py")
    seen: dict[str, Any] = {}

    async def lecturer(url: str) -> None:
        async with Page.of(url) as page:
            await page.until("view.state.paused")
            await page.value("view.say({ step: 8 })")
            await page.until("view.state.frame === 8", 60)
            await page.click("[data-part=board] summary")
            await page.until("view.board.told.frame > 3", 60)
            assert await page.value("view.state.balancer") == "Static()"
            await page.value("window.at = view.state.frame")
            choose = "(s => { s.value = 'Pairwise'; s.dispatchEvent(new Event('change')) })"
            await page.value(f"{choose}(document.querySelector('[data-part=kind]'))")
            await page.value("document.querySelector('[data-option=threshold]').value = '0.02'")
            await page.value("document.querySelector('[data-part=apply]').click()")
            await page.until("view.state.balancer.startsWith('Pairwise(threshold=0.02')")
            await page.value("view.say({ step: 1 })")
            await page.until("view.state.frame > window.at")
            slow = "(i => { i.value = 0.3; i.oninput(); i.onchange() })"
            await page.value(f"{slow}(document.querySelector('[data-speed=\"2\"]'))")
            await page.until("view.state.speeds['2'] === 0.3")
            await page.value("view.say({ pause: false })")
            await page.value("document.querySelector('[data-part=domains]').click()")
            await page.until("!view.board.overlay.hidden")
            await page.value("view.say({ balancer: 'Nobody()' })")
            await page.until("view.refusal.includes('Nobody')")
            await page.until("view.state.finished && view.board.told.frame === view.state.total - 1", 90)
            await page.value("view.say({ stop: true })")
            await page.until("view.state.job === 'ended'")
            await page.value("window.old = view.board.told")
            await page.until("view.board.told !== window.old")
            cells = "[...document.querySelectorAll('td[data-waits]')]"
            pairs = await page.value(f"{cells}.map(c => [c.dataset.waits, c.dataset.seconds])")
            seen["waits"] = dict(pairs)
            seen["course"] = await page.value("view.board.told.course")
            assert page.complaints == []

    with live(scene, folder, FRAMES, OPTIONS, ranks=3, options=("--paused",)) as command:
        asyncio.run(lecturer(command.url))
    return folder, seen


def test_the_matrix_of_waits_is_that_of_the_log(taught):
    folder, seen = taught
    waits = open_run(folder / "log").waits()
    by_pair = waits[waits["waited_for"] >= 0].groupby(["rank", "waited_for"])["seconds"].sum()
    assert len(seen["waits"]) == 9 and len(by_pair) > 3
    for pair, seconds in seen["waits"].items():
        rank, other = map(int, pair.split(":"))
        assert float(seconds) == pytest.approx(by_pair.get((rank, other), 0.0), rel=1e-9)
    assert len(seen["course"]) > 3 and all(point[1] >= 1 for point in seen["course"])


@pytest.mark.parametrize("ranks", [1, 2, pytest.param(3, marks=pytest.mark.slow), 5])
def test_balancing_by_hand_is_repeated_and_changes_no_particle(taught, tmp_path, ranks):
    folder, _ = taught
    rows = [json.loads(line) for line in (folder / "log" / "steer.jsonl").read_text().splitlines()][1:]
    assert [set(row) - {"frame"} for row in rows] == [{"balancer"}, {"speeds"}]
    more = f"dict(steering={str(folder / 'log' / 'steer.jsonl')!r}, shutter=0, moves=False)"
    result = on_ranks(ranks, folder / "snow.py", tmp_path, FRAMES, more, timeout=100)
    assert result.code == 0, result.text
    assert film(tmp_path) == film(folder)
    told = [json.loads(line) for line in (tmp_path / "log" / "steer.jsonl").read_text().splitlines()][1:]
    assert told == rows
    policies = {row["policy"].partition("(")[0] for row in map(json.loads, _lines(tmp_path, "balance.jsonl"))}
    assert policies == (set() if ranks < 3 else {"Pairwise"})


def test_nobody_at_the_blackboard_is_the_same_film(taught, tmp_path):
    folder, _ = taught
    assert on_ranks(2, folder / "snow.py", tmp_path, FRAMES, "dict(shutter=0, moves=False)").code == 0
    assert film(tmp_path) == film(folder)


def _lines(folder: Path, name: str) -> list[str]:
    path = folder / "log" / name
    return path.read_text().splitlines() if path.exists() else []


# --- what is allowed


def test_balancers_are_judged_when_they_are_ordered():
    world = motes.World(seed=1, axis="xz", progress="off")
    world.system("bricks")
    session = session_of(world)
    orders = Orders()
    orders.judge = lambda call: balancing.policy(call, session).name
    for call, told in (
        ("Pairwise()", "needs domains in a row; those of 'bricks' are not"),
        ("Pairwise(", "Pairwise("),
        ("Nobody()", "Nobody"),
        ("PrefixCuts(threshold=-1)", "threshold"),
        ("__import__('os')", "__import__"),
    ):
        with pytest.raises(ValueError) as refused:
            orders.put({"balancer": call})
        assert told in str(refused.value)
    orders.put({"balancer": "PrefixCuts(threshold=0.2)"})
    text, _ = orders.take(lambda: None, 0.1)
    assert json.loads(text)["balancer"].startswith("PrefixCuts(threshold=0.2")
    assert "Pairwise" not in balancing.menu(session)["balancers"]
    with pytest.raises(ValueError, match="cannot change its balancer"):
        Orders().put({"balancer": "Static()"})


@pytest.mark.parametrize(
    "speeds",
    [{}, {"0": 0}, {"0": 1.5}, {"x": 0.5}, {"-1": 0.5}, {"0": True}, {"0": float("nan")}, [0.5], None],
)
def test_speeds_are_fractions_of_ranks(speeds, tmp_path):
    orders = Orders()
    with pytest.raises(ValueError, match="no order 'speeds' with this value"):
        orders.put({"speeds": speeds})
    if speeds != {}:
        path = tmp_path / "steer.jsonl"
        head = {"schema": 1, "seed": 1, "script_sha256": "", "controls": {}}
        path.write_text(json.dumps(head) + "\n" + json.dumps({"frame": 1, "speeds": speeds}) + "\n")
        with pytest.raises(errors.ArgumentError, match="line 2 has no speeds"):
            steer_file.read(str(path))
    orders.put({"speeds": {"0": 0.5}})
    orders.put({"speeds": {"1": 1}})
    assert json.loads(orders.take(lambda: None, 0.1)[0]) == {"speeds": {"0": 0.5, "1": 1}}


@pytest.mark.parametrize("ranks", [0, -1, 1.5, "3", True, None, 2**31])
def test_the_number_of_ranks_is_a_whole_number(ranks, tmp_path):
    orders = Orders()
    orders.resize = lambda _: pytest.fail("it was asked for")
    with pytest.raises(ValueError, match="no order 'resize' with this value"):
        orders.put({"resize": ranks})
    with pytest.raises(ValueError, match="cannot change its number of ranks"):
        Orders().put({"resize": 3})
    if ranks == 2**31:
        return
    path = tmp_path / "steer.jsonl"
    head = {"schema": 1, "seed": 1, "script_sha256": "", "controls": {}}
    path.write_text(json.dumps(head) + "\n" + json.dumps({"frame": 1, "resize": ranks}) + "\n")
    with pytest.raises(errors.ArgumentError, match="line 2 has no number of ranks"):
        steer_file.read(str(path))


def test_waits_are_counted_once_when_a_run_goes_on_with_other_ranks(tmp_path, monkeypatch):
    """A continued run writes its tables again: the rows of the frames before it, and its own."""

    async def nothing(_: Board) -> None:
        pass

    monkeypatch.setattr(Board, "_explain", nothing)
    log = write_log(
        tmp_path / "run", [load_row(frame, "s", rank, n_end=5) for frame in (0, 1) for rank in (0, 1)]
    )
    waits = [
        {"frame": frame, "rank": 0, "phase": "report", "waited_for": 1, "seconds": 0.25} for frame in range(3)
    ]
    rows(log / "waits.jsonl", waits[:2])

    async def look() -> None:
        board = Board(log, 1)
        assert (await board.look(last=False))["waits"] == [[0, 1, 0.5]]
        rows(log / "new", [*waits, {**waits[2], "rank": 2}])
        (log / "new").rename(log / "waits.jsonl")
        told = await board.look(last=False)
        assert told["waits"] == [[0, 1, 0.75], [2, 1, 0.25]]
        assert (await board.look(last=False))["waits"] == told["waits"]

    asyncio.run(look())
