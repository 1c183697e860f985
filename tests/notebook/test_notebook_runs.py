"""Runs in a real kernel: cell output, interrupts, `motes.show`, `motes.launch` and their widgets."""

from __future__ import annotations

import base64
import importlib.util
import io
import json
import re
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
from kernels import Kernel, Widget, kernel
from launching import python

import motes
from motes._notebook import kernel as kernel_module
from motes._notebook.stills import still

pytest.importorskip("anywidget")
pytest.importorskip("websockets")
pytest.importorskip("simplejpeg")
PIL_IMAGE = pytest.importorskip("PIL.Image")

LAUNCHED = Path(__file__).parents[1] / "scenes" / "launched.py"
SCENE = """
import os, threading, time
import motes
from motes.shapes import Box

def scene(**options):
    global world, snow, wind
    camera = motes.Camera((0, 2, 9), (0, 2, 0))
    renderer = motes.Renderer(160, 90, camera=camera)
    world = motes.World(**{"seed": 1, "renderer": renderer} | options)
    snow = world.system("snow")
    wind = world.control("wind", 0.0, low=-5, high=5)

def one_frame():
    snow.burst(Box((-4, 3, -2), (4, 4, 2)), count=50)
    snow.gravity((wind.value, -2, 0))
    snow.kill_old(1)
    snow.move()
    return world.render()

def loop(n=100_000, pause_s=0.005):
    for frame in world.frames(n):
        one_frame()
        time.sleep(pause_s)
    return world.frame
"""


@pytest.fixture(scope="module")
def notebook():
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTES_PROGRESS", "")
        with kernel() as made:
            made.run(SCENE)
            yield made


# --- what a cell shows


def test_a_loop_shows_a_bar_a_line_and_the_last_picture(notebook: Kernel):
    cell = notebook.run("scene(); world.open(); loop(24, 0.05)")
    (shown,) = cell.displays.values()
    page = shown[-1]["text/html"]
    assert cell.text == "" and '<progress value="24" max="24"' in page
    assert re.search(r">frame 24/24  100%  [\d.]+ fps  eta 0:00  1200 particles<", page)
    assert shown[-1]["text/plain"] in page
    picture = base64.b64decode(re.search(r'alt="frame 23" .*src="data:image/jpeg;base64,(.*?)"', page)[1])
    assert PIL_IMAGE.open(io.BytesIO(picture)).size == (160, 90) and len(picture) < 120_000
    took = shown[-1]["at"] - shown[0]["at"]
    assert 3 <= len(shown) <= 2 * took + 2
    assert '<progress value="0" max="24"' in shown[0]["text/html"] and "<img" not in shown[0]["text/html"]


def test_an_interrupt_ends_the_frame_and_the_next_cell_goes_on(notebook: Kernel):
    notebook.run("scene(); world.open()")
    cell = notebook.begin("loop(100_000)")
    notebook.until(lambda: any(len(shown) > 1 for shown in cell.displays.values()))
    notebook.interrupt()
    notebook.ended(cell)
    assert cell.error.startswith("KeyboardInterrupt")
    reached = int(notebook.run("done = world.frame; done").result)
    (shown,) = cell.displays.values()
    assert f"frame {reached}/100000" in shown[-1]["text/plain"]
    more = notebook.run("[frame - done for frame in world.frames(done + 2) if one_frame()]")
    assert more.result == "[0, 1]"
    notebook.run("world.close()")


WAYS = {"bar": "\x1b[Kframe 3/3", "off": ""}


@pytest.mark.parametrize("way", WAYS)
def test_a_way_that_is_named_keeps_its_meaning(notebook: Kernel, way: str):
    text, cell = WAYS[way], notebook.run(f"scene(progress={way!r})\nwith world: loop(3)")
    assert cell.displays == {} and text in cell.text and bool(text) == bool(cell.text)


def test_the_environment_asks_for_plain_lines(notebook: Kernel):
    notebook.run("os.environ['MOTES_PROGRESS'] = 'lines'; scene(); del os.environ['MOTES_PROGRESS']")
    cell = notebook.run("with world: loop(3)")
    assert cell.displays == {} and "frame 3/3  100%" in cell.text


def test_a_function_gets_the_rows_and_nothing_is_shown(notebook: Kernel):
    cell = notebook.run("rows = []; scene(progress=rows.append)\nwith world: loop(3)\nlen(rows)")
    assert (cell.displays, cell.text, cell.result) == ({}, "", "3")


def test_the_environment_takes_precedence(notebook: Kernel):
    notebook.run("os.environ['MOTES_PROGRESS'] = 'off'; scene(); del os.environ['MOTES_PROGRESS']")
    cell = notebook.run("with world: loop(3)")
    assert (cell.displays, cell.text) == ({}, "")


def test_without_a_renderer_there_is_a_bar_and_a_line(notebook: Kernel):
    notebook.run("scene(renderer=None); world.open()")
    code = "for frame in world.frames(3): snow.burst((0, 0, 0), count=5); world.step()"
    (shown,) = notebook.run(code).displays.values()
    assert "15 particles" in shown[-1]["text/html"] and "<img" not in shown[-1]["text/html"]


# --- motes.show


def test_show_is_steered_by_the_messages_of_its_page(notebook: Kernel, tmp_path: Path):
    notebook.run(f"scene(log={str(tmp_path)!r}); world.open(); player = motes.show(world, loop)")
    widget = notebook.widget
    notebook.until(lambda: widget.shown.get("frame", 0) > 3)
    assert widget.pictures == [] and widget.shown["title"] == "loop"  # no viewer is looking
    notebook.say(widget, looks=True)
    notebook.until(lambda: len(widget.pictures) > 5)
    assert PIL_IMAGE.open(io.BytesIO(widget.last)).size == (160, 90)

    notebook.say(widget, pause=True)
    notebook.until(lambda: widget.shown["paused"] and widget.pictures[-1][3] == 1)  # lossless PNG
    held, still = widget.shown["frame"], widget.last
    notebook.say(widget, orbit=[0.5, 0.2])
    notebook.until(lambda: widget.last != still and widget.pictures[-1][3] == 1)
    assert widget.shown["frame"] == held and widget.shown["turned"]
    notebook.say(widget, step=2)
    notebook.until(lambda: widget.shown["frame"] == held + 2)
    assert notebook.run("world.frame").result == str(held + 2)
    notebook.say(widget, set={"wind": 99})
    notebook.until(lambda: widget.shown["controls"]["wind"]["value"] == 5)
    notebook.say(widget, set={"rain": 1})
    notebook.until(lambda: widget.refusals == ["there is no control 'rain'"])

    notebook.say(widget, pause=False)
    notebook.until(lambda: widget.shown["frame"] > held + 5)
    notebook.say(widget, stop=True)
    notebook.until(lambda: widget.shown["ended"])
    assert notebook.run("player.result() == world.frame").result == "True"
    frames = int(notebook.run("world.frame").result)
    assert widget.shown["notice"] == f"stopped after {frames} frames" and "error" not in widget.shown
    assert widget.shown["frame"] == frames
    assert widget.pictures[-1][1] == frames - 1
    notebook.until(lambda: bytes(widget.state["last"])[20:] == widget.last)
    # The cells control the world again, with the script's own camera.
    notebook.run(f"again = [frame for frame in world.frames({frames + 1}) if one_frame()]")
    notebook.run("from motes._world.world import running_of")
    seen = "again, running_of(world).viewers.steering.camera, wind.value"
    assert notebook.run(seen).result == f"([{frames}], None, 5.0)"
    notebook.run("world.close()")
    rows = [json.loads(line) for line in (tmp_path / "steer.jsonl").read_text().splitlines()][1:]
    assert {"frame": frames, "camera": None} in rows and any(row.get("set") == {"wind": 5.0} for row in rows)
    assert not any("stop" in row for row in rows), "the run went on"


def test_only_the_loops_thread_may_use_the_world(notebook: Kernel):
    notebook.run("scene(); world.open(); player = motes.show(world, loop)")
    for call, name in (
        ("world.render()", "render"),
        ("world.frames(3)", "frames"),
        ("snow.gravity((0, 0, 0))", "Gravity"),
        ("snow.gather()", "gather"),
        ("world.close()", "close"),
        ("world.system('more')", "system"),
        ("motes.show(world, loop)", "motes.show"),
    ):
        cell = notebook.ended(notebook.begin(call))
        assert cell.error.startswith(f"MotesError: {name}"), (call, cell.error)
        assert "motes.show runs this world's loop in a thread" in cell.error
    assert notebook.run("player.running, world.frame > 0").result == "(True, True)"
    assert notebook.run("player.stop(); player.wait(), player.running, player").result.endswith("frames>)")
    assert notebook.run("loop(world.frame + 2) == world.frame").result == "True"
    notebook.run("world.close()")


def test_an_error_of_the_loop_is_shown_and_raised(notebook: Kernel):
    code = """
    scene()
    def fails(world):
        with world:
            for frame in world.frames(9):
                one_frame()
                if frame == 2:
                    raise ValueError("too windy")
    player = motes.show(world, fails)
    """
    notebook.run(textwrap.dedent(code))
    widget = notebook.widget
    notebook.until(lambda: widget.shown["ended"])
    assert widget.shown["error"] == "ValueError: too windy"
    assert widget.shown["notice"] == "failed after 3 frames"
    assert notebook.ended(notebook.begin("player.result()")).error == "ValueError: too windy"


def test_an_interrupt_of_wait_stops_the_loop(notebook: Kernel):
    notebook.run("scene(); world.open(); player = motes.show(world, loop)")
    cell = notebook.begin("print('waits', flush=True); player.wait()")
    notebook.until(lambda: "waits" in cell.text)
    time.sleep(0.3)  # between the two calls of the cell
    notebook.interrupt()
    assert notebook.ended(cell).error.startswith("KeyboardInterrupt")
    assert notebook.run("player.running").result == "False"
    notebook.run("world.close()")


def test_a_page_that_does_not_answer_gets_fewer_pictures(notebook: Kernel):
    notebook.run("scene(); world.open(); player = motes.show(world, loop)")
    widget = notebook.widget
    widget.acknowledges = False
    notebook.say(widget, looks=True)
    notebook.until(lambda: len(widget.pictures) >= 2)
    notebook.run("time.sleep(1.5)")
    assert 3 <= len(widget.pictures) <= 6
    notebook.say(widget, ack=widget.pictures[-1][0])
    widget.acknowledges = True
    notebook.until(lambda: len(widget.pictures) > 12)
    notebook.run("player.stop(); player.result(); world.close()")


@pytest.mark.parametrize(
    "call, told",
    [
        ("motes.show(3, loop)", "world must be a motes.World, got 3"),
        ("motes.show(world, 3)", "loop must be a function without arguments, or of the world, got 3"),
        (
            "motes.show(world, lambda a, b: 0)",
            "loop must be a function without arguments, or of the world, got <",
        ),
        ("motes.show(world, loop, paused=2)", "paused must be"),
        (
            "motes.launch('nowhere.py', n=2)",
            "script must be the path of an existing script, got 'nowhere.py'",
        ),
        ("motes.launch('scene.py', n=0)", "n must be "),
        ("motes.launch('scene.py', n=10**9)", "n must be "),
        ("motes.launch('scene.py', n=2, arguments='--fast')", "arguments must be a list of the script"),
    ],
)
def test_bad_input_is_named(notebook: Kernel, tmp_path, call: str, told: str):
    (tmp_path / "scene.py").write_text("")
    cell = notebook.ended(notebook.begin(f"os.chdir({str(tmp_path)!r}); scene(); {call}"))
    assert cell.error.startswith(f"ArgumentError: {told}"), cell.error


# --- motes.launch


def launch(notebook: Kernel, folder: Path, kind: str, more: str = "") -> Widget:
    """Start a script on two ranks."""
    notebook.run(
        f"player = motes.launch({str(LAUNCHED)!r}, n=2, arguments=[{kind!r}, {str(folder)!r}]{more})"
    )
    notebook.say(notebook.widget, looks=True)
    return notebook.widget


def test_a_script_on_two_ranks_is_seen_steered_and_stopped(notebook: Kernel, tmp_path: Path):
    widget = launch(notebook, tmp_path, "runs", ", paused=True")
    assert widget.shown["notice"] == "starting 2 ranks ..." and widget.shown["title"] == "launched.py"
    notebook.until(lambda: widget.pictures and widget.pictures[-1][3] == 1)
    assert widget.shown["paused"] and widget.shown["frame"] == 0 and "notice" not in widget.shown
    notebook.say(widget, set={"wind": 3})
    notebook.say(widget, step=4)
    notebook.until(lambda: widget.shown["frame"] == 4)
    assert widget.shown["controls"]["wind"]["value"] == 3
    notebook.say(widget, orbit=[0.3, 0])
    notebook.until(lambda: widget.shown["turned"])
    notebook.say(widget, pause=False)
    notebook.until(lambda: widget.pictures[-1][1] > 10)
    assert PIL_IMAGE.open(io.BytesIO(widget.last)).size == (160, 90)
    # An interrupt of a cell does not reach the ranks.
    cell = notebook.begin("print('sleeps', flush=True); time.sleep(30)")
    notebook.until(lambda: "sleeps" in cell.text)
    notebook.interrupt()
    assert notebook.ended(cell).error.startswith("KeyboardInterrupt")
    reached = widget.shown["frame"]
    notebook.until(lambda: widget.shown["frame"] > reached)

    notebook.say(widget, stop=True)
    notebook.until(lambda: widget.shown["ended"])
    assert widget.shown["notice"] == "stopped" and "error" not in widget.shown
    ends = [int((tmp_path / f"ended-{rank}").read_text()) for rank in (0, 1)]
    assert ends[0] == ends[1] == widget.pictures[-1][1] + 1 == widget.shown["frame"]
    assert notebook.run("player.result(), player.running").result == "(None, False)"
    assert "begins: runs" in notebook.run("player.output").result
    assert not any("?k=" in line for line in widget.shown["output"]), "the token is not for saved notebooks"


@pytest.mark.parametrize(
    "kind, told",
    [
        ("fails", "ValueError: too windy"),
        pytest.param("early", "there is no scene", marks=pytest.mark.slow),
    ],
)
def test_a_script_that_fails_is_told(notebook: Kernel, tmp_path: Path, kind: str, told: str):
    widget = launch(notebook, tmp_path, kind)
    notebook.until(lambda: widget.shown["ended"])
    assert widget.shown["error"].startswith("MotesError: launched.py on 2 ranks: exit code 1\n")
    assert told in widget.shown["error"] and any(told in line for line in widget.shown["output"])
    assert told in notebook.ended(notebook.begin("player.result()")).error


def test_the_second_stop_terminates(notebook: Kernel, tmp_path: Path):
    widget = launch(notebook, tmp_path, "stuck")
    notebook.until(lambda: widget.shown.get("frame", 0) >= 3)
    notebook.say(widget, stop=True)
    notebook.until(lambda: widget.shown["stop"] == "End now")
    notebook.run("player.stop(); player.result()")
    assert widget.shown["notice"] == "terminated" and not list(tmp_path.iterdir())


# --- the page


PAGE = Path(__file__).resolve().parents[2] / "docs" / "notebooks.md"


@pytest.mark.skipif(not PAGE.is_file(), reason="the page stands in the source tree")
def test_the_pages_cells_run(notebook: Kernel, tmp_path: Path):
    notebook.run(f"os.chdir({str(tmp_path)!r})")
    cells = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(cells) == 6
    for code in cells:
        assert notebook.run(code).text == ""
    assert notebook.run("still, world.frame").result == "(<Frame 200 640x360>, 201)"
    assert notebook.widget.shown["notice"] == "ended"


# --- elsewhere


def test_the_end_of_the_kernel_ends_what_goes_on(tmp_path: Path):
    with kernel() as notebook:
        notebook.run(SCENE + "scene(); world.open()")
        notebook.run(f"def ends(): loop(); open({str(tmp_path / 'ended')!r}, 'w').close()")
        notebook.run("motes.show(world, ends)")
        launch(notebook, tmp_path, "runs")
        notebook.until(lambda: notebook.widget.shown.get("frame", 0) > 3)
    assert (tmp_path / "ended").exists()
    limit = time.monotonic() + 20
    while not (tmp_path / "ended-1").exists():
        assert time.monotonic() < limit
        time.sleep(0.05)


ELSEWHERE = """
import sys, urllib.request
import motes

renderer = motes.Renderer(32, 18, camera=motes.Camera((0, 0, 9), (0, 0, 0)))
world = motes.World(seed=1, progress="off", renderer=renderer)
snow = world.system("snow")

def loop():
    with world:
        for frame in world.frames(100_000):
            snow.burst((0, 0, 0), count=3)
            snow.move()
            world.render()
    return "done"

player = motes.show(world, loop)
page = urllib.request.urlopen(player.url, timeout=10).read().decode()
assert "<canvas" in page
player.stop()
assert player.wait(20) and player.result() == "done" and player.url is None
job = motes.launch(sys.argv[1], n=1, arguments=["runs", sys.argv[2]])
assert not job.wait(0.1) and job.running
while job.url is None:
    job.wait(0.05)
job.stop()
assert job.wait(30)
job.result()
assert not {"IPython", "anywidget"} & set(sys.modules)
"""


def test_outside_a_notebook_the_page_is_in_the_browser(tmp_path: Path):
    result = python(ELSEWHERE, LAUNCHED, tmp_path, timeout=90)
    assert result.code == 0, result.text
    assert result.err.count("motes: live at http://127.0.0.1:") == 2
    assert "begins: runs" in result.err


def test_what_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch):
    world = motes.World(seed=1, progress="off")
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "anywidget" else True)
    monkeypatch.setattr(kernel_module, "running", lambda: True)
    with pytest.raises(motes.MissingExtraError, match=r"needs anywidget.*anywidget>=0.9"):
        motes.show(world, lambda: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(motes.MissingExtraError, match="motes.launch needs websockets.*anywidget"):
        motes.launch(LAUNCHED, n=2)


def test_pictures_for_a_notebook_are_small(monkeypatch: pytest.MonkeyPatch):
    noise = np.random.default_rng(1).integers(0, 255, (1080, 1920, 3), np.uint8)
    width, kind, data = still(noise)
    assert (width, kind) == (960, "image/jpeg") and len(data) < 120_000
    assert PIL_IMAGE.open(io.BytesIO(data)).size == (960, 540)
    grey = np.full((90, 160, 3), 90, np.uint8)
    sizes = []
    for missing in ((), ("simplejpeg",), ("simplejpeg", "PIL.Image")):
        for name in missing:
            monkeypatch.setitem(sys.modules, name, None)
        _, kind, data = still(grey)
        sizes.append(kind)
        if kind == "image/png":
            break
        assert abs(int(np.asarray(PIL_IMAGE.open(io.BytesIO(data))).mean()) - 90) <= 2
    assert sizes == ["image/jpeg", "image/jpeg", "image/png"]
