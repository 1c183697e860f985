"""A second start of a script continues its export: no complete frame is lost, and none is there twice."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from launching import command, mpirun, python
from standing import on_ranks
from test_export import short_run

import motes
from motes import ArgumentError
from motes._interchange import formats
from motes._interchange.manifest import Manifest

HAS_USD = importlib.util.find_spec("pxr") is not None
NAMES = ["all", "all.pvd", "fourth", *(["all.usd", "shot.usd"] if HAS_USD else [])]
FRAMES = 20

SCENE = """
import os, signal, sys
import numpy as np
import motes
from motes.shapes import Box, Mesh, Sphere

folder = sys.argv[1]
names = os.environ.get("NAMES", "all all.pvd fourth").split()
every = int(os.environ.get("CHECKPOINT", "5"))
card = np.full((2, 2, 4), 255, np.uint8)
sprites = [
    motes.Sprite("image", image=[card, card // 2], facing="velocity"),
    motes.Sprite("ribbon", width=0.1, length=0.1),
]
way = motes.Curve([(0, (1, 2, 5)), (1, (2, 1, 4))])
renderer = motes.Renderer(64, 36, camera=motes.Camera(way, (0, 0, 0)))
world = motes.World(
    seed=3, space=(-1, 1), roles="shared", progress="off", renderer=renderer,
    balancer=motes.balance.PrefixCuts(0.01, min_particles=1),
    checkpoint=motes.Checkpoint(f"{folder}/checkpoints", every=every) if every else None,
)
systems = [
    world.system("a", sprite=sprites[0], attributes={"heat": 1.0}), world.system("b", sprite=sprites[1])
]

who, place, count, when = (os.environ.get("DIE") or "-1 never 0 before").split()
found, replace = [], os.replace

def die(where, before):
    if where == place:
        if before:
            found.append(where)
        if before == (when == "before") and len(found) == int(count):
            os.kill(os.getpid(), signal.SIGKILL)

def replaced(source, target, **more):
    name = os.path.basename(target)
    where = "part" if name.startswith(("a.0", "b.0")) else name
    die(where, True)
    replace(source, target, **more)
    die(where, False)

exports = [
    motes.Export(f"{folder}/{name}", every=4 if name == "fourth" else 1, scene=name == "shot.usd")
    for name in names
]
with world:
    if world.rank == int(who):
        os.replace = replaced
    for frame in world.frames(int(os.environ.get("FRAMES", "20"))):
        sheet = Mesh([(0, 0, 0), (1, 0, 0), (0, 1 + frame // 3, 0)], [(0, 1, 2)])
        shapes = [Sphere((frame / 9, 0, 0), 0.5), sheet, Box((0, 0, 0), (1, 1, 1))]
        renderer.objects = [motes.Solid(shape) for shape in shapes[: 1 + frame % 4]]
        for s in systems:
            s.configure(velocity=Sphere((0, 0, 0), 3), lifetime=motes.Uniform(0.1, 0.4))
            if frame >= 7:
                s.configure(color=(0.5, 0.25, 1))
            s.source(Box((-1, -1, -1), (1, 1, 1)), rate=1200)
            s.kill_expired()
            s.move()
        world.step()
        if world.rank == int(who):
            die("step", True)
        for export in exports:
            export.write(world)
        if world.rank == int(who):
            die("frame", True)
"""


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """Run the scene undisturbed on one rank; return all columns of all frames."""
    folder = tmp_path_factory.mktemp("whole")
    assert on_ranks(1, SCENE, folder, env={"NAMES": " ".join(NAMES)}).code == 0
    return {name: columns_of(folder / name) for name in NAMES}


def columns_of(path):
    """Return {(system, frame, column): digest} of an export; of a shot also what it shows besides."""
    found = shown_by(path) if path.name == "shot.usd" else {}
    for system in ("a", "b"):
        for frame, particles in motes.open_particles(path, system=system).items():
            for name, values in particles.columns("id", *particles.columns()).items():
                said = f"{values.dtype} {values.shape}".encode() + values.tobytes()
                found[system, frame, name] = hashlib.sha256(said).hexdigest()
    return found


def shown_by(path):
    """Return the scenery of each frame of a shot, and each value of each particle as it is drawn."""
    from pxr import Sdf

    found = {}
    manifest = Manifest.read(formats.place_of("path", path).folder)
    for frame in manifest.frames:
        found["scene", frame.frame, ""] = frame.scene
        for part in frame.parts:
            layer = Sdf.Layer.OpenAsAnonymous(str(formats.place_of("path", path).folder / part.file))
            one = {
                value.name: np.array(layer.QueryTimeSample(value.path, float(frame.frame)))
                for value in layer.GetPrimAtPath("/drawn").attributes
            }
            ids, counts = one.pop("primvars:id"), one.pop("curveVertexCounts", None)
            del one["extent"]
            for name, rows in one.items():
                ends = np.cumsum(counts) if len(rows) != len(ids) else np.arange(1, len(ids) + 1)
                for number, own in zip(ids, np.split(rows, ends[:-1]), strict=True) if len(ids) else ():
                    key = manifest.systems[part.system].name, frame.frame, f"{name} of {number}"
                    assert key not in found
                    found[key] = own.tobytes()
    return found


def check_whole(folder, reference, names=NAMES):
    """Compare exports with those of the undisturbed run, as motes and as other programs read them."""
    for name in names:
        assert columns_of(folder / name) == reference[name], name
        assert motes.open_particles(folder / name, system="a").finished
        place = formats.place_of("path", folder / name)
        manifest = json.loads((place.folder / "manifest.json").read_text())
        listed = {part[2] for frame in manifest["frames"] for part in frame["parts"]}
        known = Manifest.read(place.folder)
        stay = {"manifest.json", *place.beside(known), *known.scene_files()}
        assert set(os.listdir(place.folder)) == listed | stay, "nothing is left behind"
    if "all.pvd" in names:
        text = (folder / "all.pvd").read_text()
        shown = [part.split('"')[0] for part in text.split('file="')[1:]]
        assert len(shown) == len(set(shown)) and all((folder / file).is_file() for file in shown)
        assert {file.split(".")[-3] for file in shown} == {f"{frame:06d}" for frame in range(FRAMES)}
    if "all.usd" in names:
        opened = motes.open_particles(folder / "all.usd", system="a")
        assert points_shown(folder / "all.usd") == [opened.count(frame) for frame in range(FRAMES)]


def points_shown(path):
    """Return how many points of system a USD shows in each frame."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    prims = [prim for prim in stage.Traverse() if str(prim.GetPath()).startswith("/World/a/a")]
    return [
        sum(len(UsdGeom.Points(prim).GetPointsAttr().Get(frame)) for prim in prims) for frame in range(FRAMES)
    ]


def start(ranks, folder, *, die=None, names=NAMES, **more):
    """Start the scene; `die`: which rank dies, where, at which time of that place, and before or after."""
    env = {"NAMES": " ".join(names), **({"DIE": die} if die else {}), **more}
    result = mpirun(ranks, SCENE, folder, env=env)
    assert (result.code == 0) == (die is None), result.text
    return result


@pytest.mark.parametrize("ranks, again, die", [(1, 1, 12), (3, 2, 12), (2, 5, 9), (5, 1, 3), (1, 3, 20)])
def test_a_second_start_goes_on_on_any_number_of_ranks(tmp_path, reference, ranks, again, die):
    start(ranks, tmp_path, die=f"{ranks - 1} frame {die} before")
    before = {name: columns_of(tmp_path / name) for name in NAMES}
    result = start(again, tmp_path)
    check_whole(tmp_path, reference)
    first = int(result.err.partition("continues with frame ")[2].partition(",")[0] or "0")
    assert first == max(0, first) and first <= die
    for name in NAMES:
        kept = {key: value for key, value in before[name].items() if key[1] < first}
        assert kept.items() <= reference[name].items()


@pytest.mark.parametrize(
    "die",
    [
        *("1 part 3 before", "0 part 11 after", "2 part 40 before", "0 manifest.json 1 before"),
        *("0 manifest.json 1 after", "0 manifest.json 14 before", "0 manifest.json 22 after"),
        *(
            "0 all.pvd 4 before",
            "0 all.pvd 9 after",
            "0 shot.usd 7 before",
            "0 shot.usd 8 after",
            "2 step 6 before",
            "1 step 11 before",
        ),
    ],
)
def test_a_kill_in_the_middle_of_writing_is_repaired(tmp_path, reference, die):
    start(3, tmp_path, die=die)
    start(2 if "part" in die else 3, tmp_path)
    check_whole(tmp_path, reference)


@pytest.mark.parametrize("again", [1, 3])
def test_a_start_that_is_killed_while_it_takes_over_loses_nothing(tmp_path, reference, again):
    names = ["all", "all.pvd"]
    start(3, tmp_path, die="0 frame 13 before", names=names)
    start(again, tmp_path, die="0 manifest.json 1 after", names=names)
    start(again, tmp_path, die="0 all.pvd 1 before", names=names)
    start(2, tmp_path, names=names)
    check_whole(tmp_path, reference, names)


def test_without_a_checkpoint_all_frames_are_written_again_and_that_is_said(tmp_path, reference):
    start(3, tmp_path, die="0 frame 9 before", CHECKPOINT="0")
    there = motes.open_particles(tmp_path / "all", system="a").frames
    result = start(2, tmp_path, CHECKPOINT="0")
    check_whole(tmp_path, reference)
    said = f"all: frames 0 to {there[-1]} are written again, in place of an earlier start's"
    assert said in result.err, result.err


def test_a_finished_run_is_extended(tmp_path, reference):
    start(2, tmp_path, FRAMES="13")
    assert motes.open_particles(tmp_path / "all", system="a").frames == tuple(range(13))
    result = start(3, tmp_path)
    check_whole(tmp_path, reference)
    assert "written again" not in result.err
    whole = columns_of(tmp_path / "all")
    result = start(3, tmp_path)  # nothing is left to do
    assert columns_of(tmp_path / "all") == whole and "written again" not in result.err


GONE = """
import os, sys, motes
checkpoint = motes.Checkpoint(sys.argv[1] + "/checkpoints", every=3)
world = motes.World(seed=3, progress="off", checkpoint=checkpoint, roles="shared")
s = world.system("s")
with world, motes.Export(sys.argv[1] + "/out") as export:
    for frame in world.frames(10):
        s.configure(color=(1, 0, 0) if frame == 0 else (1, 1, 1), lifetime=0.05)
        s.burst((0, 0, 0), count=3)
        s.kill_expired()
        s.move()
        if frame == 8 and "DIE" in os.environ:
            os._exit(9)
        world.step()
        export.write(world)
"""


def test_a_column_stays_although_its_particles_are_gone(tmp_path):
    """A column that files hold once is in all later ones: the later start has no particle that differs."""
    assert mpirun(2, GONE, tmp_path / "whole").code == 0
    assert python(GONE, tmp_path / "again", env={"DIE": "1"}).code != 0
    assert "continues with frame" in mpirun(2, GONE, tmp_path / "again").err
    there = [formats.place_of("path", tmp_path / name / "out").folder for name in ("whole", "again")]
    for rank in range(2):
        held = [set(np.load(folder / f"s.000009.r{rank:04}.npz").files) for folder in there]
        assert held[0] == held[1] and "color" in held[0], rank
    since = [json.loads((folder / "manifest.json").read_text())["systems"] for folder in there]
    assert since[0] == since[1]


def test_a_changed_script_goes_on_where_that_is_wished(tmp_path):
    assert python(GONE, tmp_path, env={"DIE": "1"}).code != 0
    result = python(GONE + "# changed\n", tmp_path, env={"MOTES_ANYWAY": "1"})
    assert "continues with frame" in result.err, result.text
    assert motes.open_particles(tmp_path / "out").frames == tuple(range(10))


SLOW = """
import os, signal, sys, time
import motes
from motes._interchange import formats

write = formats.Place.write_part
def slow(*arguments, **more):
    time.sleep(0.8)
    return write(*arguments, **more)
formats.Place.write_part = slow
checkpoint = motes.Checkpoint(f"{sys.argv[1]}/checkpoints", every=4)
world = motes.World(seed=3, progress="off", checkpoint=checkpoint)
s = world.system("s")
with world, motes.Export(f"{sys.argv[1]}/out", every=3) as export:
    for frame in world.frames(6):
        s.burst((0, 0, 0))
        world.step()
        export.write(world)
        if frame == 4:
            limit = time.monotonic() + 30
            while "DIE" in os.environ and not os.path.isdir(f"{sys.argv[1]}/checkpoints/frame-000004"):
                assert time.monotonic() < limit
                world.digest()
                world_look()
            if "DIE" in os.environ:
                os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_checkpoint_waits_until_the_frames_before_it_are_on_disk(tmp_path):
    script = SLOW.replace("world_look()", "world._loop.checkpoints._saver.look()")
    assert python(script, tmp_path, env={"DIE": "1"}).code != 0
    assert (tmp_path / "checkpoints" / "frame-000004").is_dir()
    assert motes.open_particles(tmp_path / "out").frames == (0, 3)
    result = python(script, tmp_path)
    assert result.code == 0 and "continues with frame 4" in result.err, result.text
    assert motes.open_particles(tmp_path / "out").frames == (0, 3)


OWN_LOOP = """
import os, signal, sys
import motes
world = motes.World(seed=3, progress="off", checkpoint=sys.argv[1] + "/checkpoints", roles="shared")
s = world.system("s")
with world, motes.Export(sys.argv[1] + "/out") as export:
    while world.frame < 9:
        s.burst((0, 0, 0), count=3)
        if world.frame == 4 and "STOP" in os.environ and world.rank == 0:
            os.kill(os.getpid(), signal.SIGTERM)
        world.step()
        export.write(world)
    print(export.frames)
"""


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_stopped_run_with_a_loop_of_its_own_has_its_frames(tmp_path, ranks):
    stopped = mpirun(ranks, OWN_LOOP, tmp_path, env={"STOP": "1"})
    there = motes.open_particles(tmp_path / "out")
    assert there.frames == (0, 1, 2, 3, 4), stopped.text
    assert mpirun(3 - ranks, OWN_LOOP, tmp_path).lines == ["9"] * (3 - ranks), "earlier frames count"
    whole = motes.open_particles(tmp_path / "out")
    assert whole.frames == tuple(range(9)) and [len(p) for p in whole.values()] == list(range(3, 28, 3))


# --- exports of others


SMALL = """
import os, sys, motes
world = motes.World(seed=int(os.environ.get("SEED", "1")), dt=float(os.environ.get("DT", "0.04")),
                    progress="off", roles="shared")
s = world.system("s")
export = motes.Export(sys.argv[1])
with world:
    s.burst((0, 0, 0), count=5)
    world.step()
    try:
        export.write(world)
    except motes.MotesError as error:
        print(world.rank, type(error).__name__, error, flush=True)
        world._session.comm.Barrier()  # the first rank that leaves ends the job
        raise
"""


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.parametrize(
    "name, script, env, more, said",
    [
        *((name, SMALL + "# another\n", {}, (), "whose text was a different one") for name in NAMES),
        ("all", SMALL, {}, ("more",), "the script's arguments were"),
        ("all.pvd", SMALL, {"SEED": "2"}, (), r"World(seed=...) was 1 and is 2"),
        ("all", SMALL, {"DT": "0.05"}, (), r"World(dt=...) was 0.04 and is 0.05"),
        ("all", SMALL + "# another\n", {"MOTES_ANYWAY": "1"}, (), "whose text was a different one"),
    ],
)
def test_an_export_of_another_script_is_never_removed(tmp_path, name, script, env, more, said):
    path = tmp_path / name
    assert on_ranks(3, SMALL, path).lines == []
    there = contents(tmp_path)
    result = on_ranks(2, script, path, *more, env=env)
    lines = result.out.splitlines()
    assert result.code != 0
    assert sorted(line.split()[0] for line in lines) == ["0", "1"], "the error is raised on every rank"
    assert all(said in line and str(path) in line and "--fresh" in line for line in lines), lines
    assert {line.split()[1] for line in lines} == {"ArgumentError", "RankError"}
    assert contents(tmp_path) == there
    assert on_ranks(2, script, path, *more, env={**env, "MOTES_FRESH": "1"}).lines == []
    assert motes.open_particles(path).frames == (0,) and len(motes.open_particles(path)[0]) == 5


@pytest.mark.parametrize("damage", ["missing", "cut", "later", "nobody", "odd"])
def test_an_export_whose_origin_is_unknown_is_refused(tmp_path, monkeypatch, damage):
    short_run(motes.Export(tmp_path / "a"))
    path = tmp_path / "a" / "manifest.json"
    said = json.loads(path.read_text())
    changed = {
        "later": {**said, "version": 99},
        "nobody": {k: v for k, v in said.items() if k != "origin"},
        "odd": {**said, "origin": {"seed_given": True, "script": 3, "substeps": 1, "periodic": {}}},
    }
    path.unlink() if damage == "missing" else path.write_text(json.dumps(changed.get(damage, said)))
    mark = f"particles of motes, process {os.getpid()}\n"  # the run was killed
    (tmp_path / "a" / ".lock").write_text(mark)
    if damage == "cut":
        path.write_text(path.read_text()[:100])
    there = contents(tmp_path)
    with pytest.raises(ArgumentError, match=r"the same script, arguments and settings .*--fresh") as caught:
        short_run(motes.Export(tmp_path / "a"))
    assert caught.value.argument == "path" and contents(tmp_path) == there
    monkeypatch.setenv("MOTES_FRESH", "1")
    short_run(motes.Export(tmp_path / "a"), frames=1)
    assert motes.open_particles(tmp_path / "a").frames == (0,) and len(os.listdir(tmp_path / "a")) == 2


def test_an_export_without_a_complete_frame_is_free(tmp_path, monkeypatch):
    monkeypatch.setattr(formats.Place, "write_part", lambda *_, **__: 1 / 0)
    with pytest.raises(motes.MotesError, match="could not be written"):
        short_run(motes.Export(tmp_path / "a"), frames=9)
    monkeypatch.undo()
    assert json.loads((tmp_path / "a" / "manifest.json").read_text())["frames"] == []
    assert on_ranks(2, SMALL, tmp_path / "a").lines == []


def test_a_seed_that_nobody_chose_may_be_another_one(tmp_path):
    script = SMALL.replace('int(os.environ.get("SEED", "1"))', "None")
    for _ in range(2):
        assert on_ranks(2, script, tmp_path / "a").lines == []


def test_fresh_on_the_command_line_begins_anew(tmp_path):
    script = tmp_path / "scene.py"
    script.write_text(SMALL)
    assert on_ranks(1, script, tmp_path / "a").code == 0
    script.write_text(SMALL.replace("count=5", "count=6"))
    argv = [sys.executable, "-m", "motes", "run", "-n", "2", "--fresh", script, tmp_path / "a"]
    assert command(argv).code == 0
    assert len(motes.open_particles(tmp_path / "a")[0]) == 6


def test_packing_replaces_what_was_packed_and_no_run(tmp_path):
    from motes.cli import main

    short_run(motes.Export(tmp_path / "a"), motes.Export(tmp_path / "b"))
    for _ in range(2):
        assert main(["pack", str(tmp_path / "a"), "-o", str(tmp_path / "c")]) == 0
    there = contents(tmp_path)
    with pytest.raises(ArgumentError, match="output must be a new path"):
        motes._interchange.pack.pack(tmp_path / "a", tmp_path / "b")
    with pytest.raises(ArgumentError, match="path must be a new path"):
        short_run(motes.Export(tmp_path / "c"))
    assert contents(tmp_path) == there
    assert np.array_equal(
        motes.open_particles(tmp_path / "c")[2].id, motes.open_particles(tmp_path / "a")[2].id
    )
