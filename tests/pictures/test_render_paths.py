"""Pixels do not depend on who draws: paths, ranks, roles. Also what the log records about it."""

from __future__ import annotations

import json
import statistics
from pathlib import Path
from typing import Any

import pytest
from same_bits import EVERYTHING, assert_equal, roles, table
from standing import on_ranks

import motes
from motes.errors import ArgumentError

PATHS = ("auto", "gather", "tiles", "composite")

SCENE = """
import json, sys
import motes
from motes import shapes

log, path, roles, distance, linear, count, frames = sys.argv[1:]
far = float(distance)
aside = (-0.065 * far, -0.04 * far) if far > 100 else (0, 0)  # a far cloud lies within one tile
camera = motes.Camera((*aside, far), (*aside, 0))
world = motes.World(
    seed=3,
    space=(-8, 8),
    roles=roles,
    renderer=motes.Renderer(640, 360, camera=camera, path=path, linear=bool(int(linear))),
    progress="off",
    log=log,
    spans=True,
)
dust = world.system("dust")
with world:
    for frame in world.frames(int(frames)):
        if frame == 0:
            dust.configure(color=(0.2, 0.5, 1), alpha=0.3)
            dust.burst(shapes.Box((-8, -4, -1), (8, 4, 1)), count=int(count))
        dust.gravity((0, -1, 0))
        dust.move()
        picture = world.render() if frame != 3 else world.step()
        if picture:
            light = float(picture.linear.sum()) if picture._linear is not None else None
            print(json.dumps({"frame": frame, "digest": picture.digest(), "light": light}))
"""


def frames_of(log: Path) -> list[dict[str, Any]]:
    """Return the rows of frames.jsonl."""
    return [json.loads(line) for line in (log / "frames.jsonl").read_text().splitlines()]


COUNT = 200_000


def pictures(
    log: Path,
    size: int,
    path: str,
    wish: str,
    distance: float = 11,
    linear: int = 0,
    count: int = COUNT,
    frames: int = 5,
    env: dict[str, str] | None = None,
) -> list[Any]:
    """Run the scene; return what it printed about its pictures."""
    lines = on_ranks(size, SCENE, log, path, wish, distance, linear, count, frames, env=env).lines
    return [json.loads(line) for line in lines]


@pytest.mark.parametrize(
    "size", [1, pytest.param(2, marks=pytest.mark.slow), 3, pytest.param(5, marks=pytest.mark.slow)]
)
def test_any_path_ranks_and_roles(size: int):
    variants = [{"roles": wish, "space": [-3, 3], "path": path} for wish in roles(size) for path in PATHS]
    assert_equal(table(on_ranks(size, EVERYTHING, json.dumps(variants), timeout=200).lines), variants)


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    """Return the pictures of one rank, with their linear light."""
    log = tmp_path_factory.mktemp("alone") / "log"
    return [json.loads(line) for line in on_ranks(1, SCENE, log, "gather", "auto", 11, 1, COUNT, 5).lines]


@pytest.mark.parametrize("path", PATHS[1:])
@pytest.mark.parametrize(("size", "wish"), [pytest.param(2, "shared", marks=pytest.mark.slow), (3, "auto")])
def test_the_light_is_the_same(size: int, wish: str, path: str, alone: list[Any], tmp_path: Path):
    assert pictures(tmp_path / "log", size, path, wish, linear=1) == alone


@pytest.mark.parametrize("path", PATHS[1:])
@pytest.mark.parametrize(("size", "wish"), [(2, "shared"), pytest.param(4, "auto", marks=pytest.mark.slow)])
def test_the_log_says_who_drew(size: int, wish: str, path: str, tmp_path: Path):
    # A rank that draws tiles shows up in the log by its pixels, which ranks on one host need not send.
    pictures(tmp_path / "log", size, path, wish, env={"MOTES_SHARED_PICTURES": "0"})
    for row in frames_of(tmp_path / "log"):
        if row["frame"] == 3:
            assert "render_path" not in row, "a frame without a picture"
            continue
        assert row["render_path"] == path
        assert 150_000 < row["records"] < 300_000
        others = row["records"] * (1 if wish == "auto" else 0.49)
        if path == "gather":  # four bytes per record: each system has a single colour
            assert others * 4 < row["render_bytes"] < others * 4.4
        elif wish == "shared":  # calculators draw the part of the picture where their own particles are
            # Ranks delayed by other processes draw less. If the position of particles did not matter, half of
            # the records would be sent.
            pixels = 640 * 360 * 3
            assert 0.3 * pixels < row["render_bytes"] < 0.7 * pixels + 0.15 * row["records"] * 4
            assert 0.7 * pixels + 0.15 * row["records"] * 4 < 0.5 * pixels + others * 4
        else:
            assert row["render_bytes"] > (others * 2 if path == "tiles" else 100_000)
        assert 0 < row["t_project_s"] <= row["t_render_s"]
        assert 0 < row["t_draw_s"] <= row["t_render_s"]
        if wish == "shared":  # in the paper's roles the image generator may draw all tiles of a small picture
            assert (row["t_assemble_s"] > 0) == (path != "gather")


def test_spans_have_the_processor_time_of_each_part(tmp_path: Path):
    """The processor time of a phase, without waits, never exceeds the time elapsed."""
    pictures(tmp_path / "log", 2, "tiles", "shared")
    parts = set()
    for rank in range(2):
        for line in (tmp_path / "log" / f"spans.r{rank:04d}.jsonl").read_text().splitlines():
            span = json.loads(line)
            if span["phase"] in ("messages", "wait"):  # these overlap other phases
                assert span["cpu_s"] is None
                continue
            parts.add(span["phase"])
            assert 0 <= span["cpu_s"] < span["end_s"] - span["start_s"] + 1e-3
            if span["phase"] in ("project", "draw") and span["frame"] != 3:
                assert span["cpu_s"] > 1e-4
    assert {"project", "draw", "send records", "wait for records", "assemble"} <= parts


@pytest.mark.parametrize(
    ("distance", "count", "chosen"), [(11, COUNT, "tiles"), (400, 3 * COUNT, "composite")]
)
def test_auto_draws_a_far_cloud_where_its_particles_are(
    distance: float, count: int, chosen: str, tmp_path: Path
):
    """A cloud that fills the picture is divided by tiles; a cloud within one tile, by particles.

    The choice depends on measured seconds, so it may differ for a picture or two on a busy machine. A single
    rank draws enough to tell its speed, so different speeds of ranks play no part.
    """
    pictures(tmp_path / "log", 3, "auto", "shared", distance, count=count, frames=10)
    drawn = [row["render_path"] for row in frames_of(tmp_path / "log") if "render_path" in row]
    assert statistics.mode(drawn[2:]) == chosen


BLENDS = """
import sys
import zlib
import motes
from motes import Sprite, shapes

log, path, roles, blends, layers = sys.argv[1:]
camera = motes.Camera((0, 0.5, 14), (0, 0, 0))
ball = shapes.Sphere((1, 0, 0), 1.5)
world = motes.World(
    seed=5,
    space=(-5, 5),
    roles=roles,
    renderer=motes.Renderer(
        300, 200, camera=camera, path=path, objects=[ball], layers=layers.split(",") if layers else ()
    ),
    progress="off",
    log=log,
)
forms = {
    "add": Sprite("disc", pixels=5),
    "alpha": Sprite("disc", pixels=9, blend="alpha", softness=0.3),
    "opaque": Sprite("sphere", pixels=7, blend="opaque"),
    "wide": Sprite("sphere", pixels=None, blend="opaque"),
}
systems = [world.system(name, sprite=forms[name]) for name in blends.split(",")]
with world:
    for frame in world.frames(3):
        for system in systems:
            system.configure(color=motes.Uniform((0, 0, 0), (1, 1, 1)), alpha=0.5, size=0.05)
            system.burst(shapes.Sphere((0, 0, 0), 4), count=3000)
            system.move()
        picture = world.render()
        if picture:
            layer = [zlib.crc32(picture.layer(name).tobytes()) for name in world.renderer.layers]
            print(frame, picture.digest(), *layer)
"""


@pytest.mark.parametrize(
    "size", [pytest.param(2, marks=pytest.mark.slow), 3, pytest.param(5, marks=pytest.mark.slow)]
)
@pytest.mark.parametrize(
    ("blends", "layers", "drawn"),
    [
        ("opaque", "", "composite"),
        ("opaque,wide", "depth", "composite"),
        ("add,opaque", "", "composite"),
        ("add,alpha,opaque,wide", "depth,alpha", "composite"),
        ("opaque", "velocity", "tiles"),
        ("add,alpha", "", "tiles"),
    ],
)
def test_opaque_particles_are_merged_and_others_are_blended(
    size: int, blends: str, layers: str, drawn: str, tmp_path: Path
):
    alone = on_ranks(1, BLENDS, tmp_path / "one", "gather", "auto", blends, layers).lines
    assert len(alone) == 3
    for wish in ("auto", "shared"):
        log = tmp_path / wish
        assert on_ranks(size, BLENDS, log, "composite", wish, blends, layers).lines == alone
        assert {row["render_path"] for row in frames_of(log)} == {drawn}


SIZES = """
import sys
import motes
from motes import shapes

path, sizes = sys.argv[1], [tuple(map(int, size.split("x"))) for size in sys.argv[2:]]
world = motes.World(
    seed=3,
    space=(-3, 3),
    roles="shared",
    renderer=motes.Renderer(64, 64, camera=motes.Camera((0, 1, 8), (0, 0.5, 0)), path=path),
    progress="off",
)
world.renderer.objects = [shapes.Sphere((0, 0, 0), 1.5)]
dust = world.system("dust")
with world:
    for frame in world.frames(6):
        if frame == 0:
            dust.burst(shapes.Box((-2, -1, -1), (2, 2, 1)), count=2000)
        dust.move()
        world.renderer.width, world.renderer.height = sizes[frame % len(sizes)]
        picture = world.render()
        if frame == 4:  # a still in between
            world.renderer.width, world.renderer.height = sizes[-1]
            world.redraw()
        if picture:
            print(frame, picture.digest())
"""


@pytest.mark.parametrize("size", [1, 3])
@pytest.mark.parametrize("path", ["auto", "tiles", "composite"])
def test_pictures_of_alternating_sizes_are_drawn_in_full(size: int, path: str):
    large, small = (on_ranks(1, SIZES, "gather", one).lines for one in ("320x200", "70x130"))
    lines = on_ranks(size, SIZES, path, "320x200", "70x130").lines
    assert lines == [large[0], small[1], large[2], small[3], large[4], small[5]]


def test_paths_are_checked():
    camera = motes.Camera((0, 0, 9), (0, 0, 0))
    with pytest.raises(ArgumentError, match="path.*'gathered'"):
        motes.Renderer(8, 8, camera=camera, path="gathered")
