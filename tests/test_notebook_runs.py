"""Runs in a real kernel: what a cell shows, interrupts, `motes.show` and `motes.launch` with their widgets."""

from __future__ import annotations

import base64
import io
import re
import textwrap

import pytest
from kernels import Kernel, kernel

pytest.importorskip("anywidget")
pytest.importorskip("websockets")
pytest.importorskip("simplejpeg")
PIL_IMAGE = pytest.importorskip("PIL.Image")

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
    assert notebook.run("[frame for frame in world.frames(done + 2) if one_frame()] == [done, done + 1]").result == "True"
    notebook.run("world.close()")


@pytest.mark.parametrize("way, text", [("'lines'", "frame 3/3  100%"), ("'bar'", "\x1b[Kframe 3/3"), ("'off'", "")])
def test_a_way_that_is_named_keeps_its_meaning(notebook: Kernel, way: str, text: str):
    cell = notebook.run(f"scene(progress={way})\nwith world: loop(3)")
    assert cell.displays == {} and text in cell.text and bool(text) == bool(cell.text)


def test_a_function_gets_the_rows_and_nothing_is_shown(notebook: Kernel):
    cell = notebook.run("rows = []; scene(progress=rows.append)\nwith world: loop(3)\nlen(rows)")
    assert (cell.displays, cell.text, cell.result) == ({}, "", "3")


def test_the_environment_takes_precedence(notebook: Kernel):
    cell = notebook.run(
        "os.environ['MOTES_PROGRESS'] = 'off'; scene(); os.environ['MOTES_PROGRESS'] = ''\nwith world: loop(3)"
    )
    assert (cell.displays, cell.text) == ({}, "")


def test_without_a_renderer_there_is_a_bar_and_a_line(notebook: Kernel):
    code = "scene(renderer=None)\nwith world:\n for frame in world.frames(3): snow.burst((0, 0, 0), count=5); world.step()"
    (shown,) = notebook.run(code).displays.values()
    assert "15 particles" in shown[-1]["text/html"] and "<img" not in shown[-1]["text/html"]


# --- motes.show


def test_show_is_steered_by_the_messages_of_its_page(notebook: Kernel):
    notebook.run("scene(); world.open(); player = motes.show(world, loop)")
    widget = notebook.widget
    notebook.until(lambda: widget.shown.get("frame", 0) > 3)
    assert widget.pictures == [] and widget.shown["title"] == "loop"  # nobody looks
    notebook.say(widget, looks=True)
    notebook.until(lambda: len(widget.pictures) > 5)
    assert PIL_IMAGE.open(io.BytesIO(widget.last)).size == (160, 90)

    notebook.say(widget, pause=True)
    notebook.until(lambda: widget.shown["paused"] and widget.pictures[-1][3] == 1)  # PNG: without loss
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
    assert widget.pictures[-1][1] == frames - 1
    notebook.until(lambda: bytes(widget.state["last"])[20:] == widget.last)
    # The cells have the world again, with the script's own camera.
    same = "camera = world.renderer.view(0, None); world._steering._next is None"
    assert notebook.run(same).result == "True"
    assert notebook.run(f"[frame for frame in world.frames({frames + 1}) if one_frame()]").result == f"[{frames}]"
    assert notebook.run("wind.value").result == "5.0"
    notebook.run("world.close()")


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
        ("motes.show(world, lambda a, b: 0)", "loop must be a function without arguments, or of the world, got <"),
        ("motes.show(world, loop, paused=2)", "paused must be"),
        ("motes.launch('nowhere.py', n=2)", "script must be the path of a script, which exists, got 'nowhere.py'"),
        ("motes.launch('scene.py', n=0)", "n must be "),
        ("motes.launch('scene.py', n=10**9)", "n must be "),
        ("motes.launch('scene.py', n=2, arguments='--fast')", "arguments must be a list of what follows"),
    ],
)
def test_bad_input_is_named(notebook: Kernel, tmp_path, call: str, told: str):
    (tmp_path / "scene.py").write_text("")
    cell = notebook.ended(notebook.begin(f"os.chdir({str(tmp_path)!r}); scene(); {call}"))
    assert cell.error.startswith(f"ArgumentError: {told}"), cell.error
