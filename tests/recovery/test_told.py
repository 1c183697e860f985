"""What a script tells the engine outside its lists holds after a loss of ranks, and after a restart.

The lists of setters come from the classes themselves: a new one must be added to CHANGES.
"""

from __future__ import annotations

import inspect
import json
import sys
from pathlib import Path

import pytest
from launching import command
from standing import on_ranks

import motes
from motes import _core
from motes._launch import starting
from motes._values.values import Settings

SCENE = Path(__file__).parents[1] / "scenes" / "told.py"
FRAMES = 17

survives = pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))

IMAGES = "[[[[1.0, 0.3, 0, 0.8], [0, 0, 1.0, 0.3]]], [[[0, 1.0, 0, 1.0], [1.0, 1.0, 1.0, 0.2]]]]"
CHANGES = {
    "System.clumps()": ("grains", "lambda s: s.clumps([(-.2, 0, 0, .15), (.2, 0, 0, .15), (0, .3, 0, .1)])"),
    "System.configure()": ("dust", "lambda s: s.configure(color='#ff8800', alpha=0.5, heat=3.0)"),
    "System.sprite": ("dust", f"motes.Sprite('image', 7, 'alpha', 0, {IMAGES}, pick='random', lit=True)"),
    "World.renderer": ("World", "world.renderer"),
    "Camera.position": ("Camera", "camera.position"),
    "Camera.look_at": ("Camera", "(0.2, 0.1, 0)"),
    "Camera.up": ("Camera", "(0.3, 1, 0)"),
    "Camera.fov_deg": ("Camera", "50"),
    "Camera.near": ("Camera", "0.5"),
    "Camera.focus": ("Camera", "3.0"),
    "Camera.aperture": ("Camera", "0.1"),
    "Renderer.width": ("Renderer", "80"),
    "Renderer.height": ("Renderer", "50"),
    "Renderer.camera": ("Renderer", "camera"),
    "Renderer.background": ("Renderer", "motes.Gradient((0, 0, 0.2), (0, 0.2, 0))"),
    "Renderer.fog": ("Renderer", "((0.2, 0.2, 0.2), 9)"),
    "Renderer.exposure": ("Renderer", "1.5"),
    "Renderer.objects": ("Renderer", "[motes.Solid(motes.shapes.Sphere((0, 0, -1), 0.5), (1, 0, 0))]"),
    "Renderer.sun": ("Renderer", "(1, 1, 1)"),
    "Renderer.sun_size": ("Renderer", "2"),
    "Renderer.sun_color": ("Renderer", "'#ffcc88'"),
    "Renderer.sun_power": ("Renderer", "2"),
    "Renderer.occlusion": ("Renderer", "0.5"),
    "Renderer.lights": ("Renderer", "[motes.Light((0, 1, 1), (0, 0, 1), 5)]"),
    "Renderer.path": ("Renderer", "'composite'"),
    "Renderer.shutter": ("Renderer", "0.75"),
    "Renderer.bloom": ("Renderer", "0.2"),
    "Renderer.smooth": ("Renderer", "False"),
    "Renderer.layers": ("Renderer", "('depth', 'alpha')"),
}
ENGINE = {
    "set_clumps": "System.clumps()",
    "set_sprite": "System.sprite",
    "set_image_sha256": "told again with each picture",
    "set_unsaved_from": "told again before each frame",
    "set_saving": "told again around each checkpoint",
    "on_callback": "kept by recovering_engine.cpp; lists with callbacks end the run",
    "on_orders": "kept in the settings; steered runs end",
    "set_policy": "chosen by viewers; steered runs end",
    "set_speed": "chosen by viewers; steered runs end",
}


def setters() -> set[str]:
    """Return all attributes that scripts may set of what is alive during a run."""
    found = set()
    for kind in (motes.World, motes.Renderer, motes.Camera, type(motes.World(progress="off").system("s"))):
        if issubclass(kind, Settings):
            found |= {f"{kind.__name__}.{name}" for name in kind._checks}
        properties = inspect.getmembers(kind, lambda member: isinstance(member, property))
        found |= {f"{kind.__name__}.{name}" for name, one in properties if one.fset is not None}
    return found


def test_every_setter_is_tried_here():
    here = {name for name in CHANGES if not name.endswith("()")}
    assert setters() <= here, f"add to CHANGES: {sorted(setters() - here)}"
    told = {name for name in vars(_core.Engine) if name.startswith(("set_", "on_"))}
    assert told == set(ENGINE), "a setter of the engine must survive losses and restarts"


def plan(**more) -> str:
    known = {*setters(), "System.clumps()", "System.configure()"}
    changes = [
        (owner, name.partition(".")[2], text) for name, (owner, text) in CHANGES.items() if name in known
    ]
    return json.dumps({"changes": changes, "often": False, "recover": False, "checkpoint": 0, **more})


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """Run both kinds of the scene undisturbed, on one rank."""
    out = tmp_path_factory.mktemp("whole")
    return {often: on_ranks(1, SCENE, out, plan(often=often), timeout=120).lines for often in (False, True)}


def seen(lines: list[str]) -> dict[tuple[str, str], str]:
    return {(words[0], words[1]): " ".join(words[2:]) for words in map(str.split, lines)}


@survives
@pytest.mark.parametrize(
    "kill",
    [
        *("0 -1 start", "0 0 told", "0 12 start", "0 12 redrawn", "1 0 start"),
        *(
            pytest.param(kill, marks=pytest.mark.slow)
            for frame in (0, 1, 11, 12, 13, 14, 15)
            for place in ("start", "redrawn", "told", "recorded", "rendered")
            for kill in [f"{frame % 2} {frame} {place}"]
        ),
    ],
)
def test_it_holds_after_a_loss(tmp_path, expected, kill):
    arguments = ["--survive", "-n", 3, SCENE, tmp_path, plan(recover=True)]
    result = command([sys.executable, "-m", "motes", "run", *arguments], env={"KILL": kill}, timeout=90)
    assert result.code == 0 and "continue from replicas" in result.err, result.text
    assert seen(result.lines) == seen(expected[False])


@pytest.mark.parametrize(("ranks", "again", "frame"), [(2, 3, 13), (3, 1, 7)])
def test_it_holds_after_a_restart(tmp_path, expected, ranks, again, frame):
    wanted = plan(often=True, checkpoint=3)
    kill = {"KILL": f"0 {frame} rendered"}
    first = command([sys.executable, "-m", "motes", "run", "-n", ranks, SCENE, tmp_path, wanted], env=kill)
    assert first.code != 0
    second = on_ranks(again, SCENE, tmp_path, wanted)
    assert second.code == 0 and "continues with frame" in second.err, second.text
    made = seen(second.lines)
    assert ("0", "0") not in made and made.items() <= seen(expected[True]).items()
    whole = {**seen(first.out.splitlines()), **made}
    assert whole == seen(expected[True])
