"""An exported frame reads back with the same bits as `gather`, whichever ranks wrote it."""

from __future__ import annotations

import importlib.util
import json
import os
import resource
import threading
import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from standing import alike, on_ranks

import motes
from motes import ArgumentError, MotesError
from motes._interchange import formats
from motes.shapes import Box, Sphere

SCENE = Path(__file__).parents[1] / "scenes" / "exported.py"
FORMATS = ["npz", "pvd", *(["usd"] if importlib.util.find_spec("pxr") else [])]
NAMES = {"npz": "all", "pvd": "all.pvd", "usd": "all.usd"}
FRAMES = 8


@cache
def without(substeps: int) -> list[str]:
    """Return the digests of a run without exports."""
    return on_ranks(1, SCENE, "unused", "never", "--substeps", substeps).lines


def same(one, other) -> bool:
    return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()


def check_all(folder, name, *, frames=range(FRAMES), columns=None) -> None:
    """Compare each frame of each system with what `gather` returned."""
    reference = np.load(folder / "reference.npz")
    systems = motes.open_particles(folder / name).systems
    assert systems == ("snow", "rain, fine", "empty", "late")
    for system in systems:
        opened = motes.open_particles(folder / name, system=system)
        assert opened.frames == tuple(f for f in frames if system != "late" or f >= 3)
        assert opened.finished and opened.seed == 9
        for frame, particles in opened.items():
            key = f"{system}/{frame}/"
            wanted = {k.removeprefix(key): reference[k] for k in reference.files if k.startswith(key)}
            if columns is not None:
                wanted = {k: v for k, v in wanted.items() if k in columns}
            read = particles.columns("id", *particles.columns())
            assert sorted(read) == sorted(wanted), (system, frame)
            assert opened.count(frame) == len(particles)
            for column, values in wanted.items():
                assert same(read[column], values), (system, frame, column)
    counts = [len(p) for p in motes.open_particles(folder / name, system="snow").values()]
    assert max(counts) > 500


@pytest.mark.parametrize(
    "ranks, roles", [(1, "auto"), (2, "shared"), (3, "auto"), (5, "shared"), (5, "auto")]
)
def test_files_hold_what_gather_shows(tmp_path, ranks, roles):
    lines = on_ranks(ranks, SCENE, tmp_path, "end", *FORMATS, "--roles", roles).lines
    assert lines == without(1)
    for format in FORMATS:
        check_all(tmp_path, NAMES[format])
    check_all(tmp_path, "third", frames=range(0, FRAMES, 3))
    some = {"id", "position", "size", "heat"}
    opened = motes.open_particles(tmp_path / "some", system="snow")
    assert set(opened[2].columns()) == some - {"id"}
    assert "heat" not in motes.open_particles(tmp_path / "some", system="empty")[2].columns()
    writers = {
        part[1] for part in json.loads((tmp_path / "all/manifest.json").read_text())["frames"][2]["parts"]
    }
    assert writers == {"1 auto": {0}, "3 auto": {2}, "5 auto": {2, 3, 4}}.get(
        f"{ranks} {roles}", set(range(ranks))
    )
    assert not list(tmp_path.rglob("*.tmp")) and not list(tmp_path.rglob(".lock"))


@pytest.mark.parametrize("ranks, substeps", [(1, 1), (3, 1), (3, 3)])
def test_writing_in_the_middle_of_a_frame_shows_what_gather_shows_there_and_changes_nothing(
    tmp_path, ranks, substeps
):
    lines = on_ranks(ranks, SCENE, tmp_path, "middle", "npz", "pvd", "--substeps", substeps).lines
    assert lines == without(substeps)
    for format in ("npz", "pvd"):
        check_all(tmp_path, NAMES[format])


# --- what is written, on one rank


def short_run(*exports, frames=3, count=50, each=None):
    """Run a small scene that writes to all these exports; return the result of `gather` for each frame."""
    world = motes.World(seed=2, progress="off")
    system = world.system("s", attributes={"heat": 1.0})
    shown = []
    with world:
        for frame in world.frames(frames):
            system.burst(Sphere((0, 0, 0), 1), count=count)
            system.move()
            world.step()
            for export in exports:
                export.write(world)
            shown.append(system.gather())
            if each is not None:
                each(frame, world)
    return shown


def test_only_what_a_system_uses_is_written_and_all_is_read(tmp_path):
    shown = short_run(motes.Export(tmp_path / "a"))
    with np.load(tmp_path / "a" / "s.000002.r0000.npz") as part:
        assert set(part.files) == {"position", "velocity", "age", "heat", "id"}
    read = motes.open_particles(tmp_path / "a")[2]
    assert (read.lifetime == np.inf).all() and (read.up == (0, 1, 0)).all()
    assert set(read.columns()) == set(shown[2].columns())


def test_frames_are_chosen_by_their_number(tmp_path):
    with motes.Export(tmp_path / "a", every=4) as export:
        short_run(export, frames=10)
        assert export.frames == 3
    opened = motes.open_particles(tmp_path / "a")
    assert opened.frames == (0, 4, 8)
    assert opened.times == pytest.approx([1 / 24, 5 / 24, 9 / 24])
    assert len(opened[-1]) == len(opened[8]) == 450
    with pytest.raises(KeyError, match="no frame 5; there are 0, 4, 8"):
        opened[5]
    with motes.Export(tmp_path / "b", every=4) as export:
        short_run(frames=6, each=lambda frame, world: frame and export.write(world))
    assert motes.open_particles(tmp_path / "b").frames == (4,), "not the fourth call"


def test_a_frame_is_written_once_and_not_before_the_first(tmp_path):
    world = motes.World(seed=2, progress="off")
    world.system("s")
    other = motes.World(seed=2, progress="off")
    export = motes.Export(tmp_path / "a")
    with pytest.raises(MotesError, match="works only inside `with world:`"):
        export.write(world)
    with world, export:
        with pytest.raises(MotesError, match="before the first frame"):
            export.write(world)
        world.step()
        export.write(world)
        with pytest.raises(MotesError, match="already has frame 0"):
            export.write(world)
        with pytest.raises(ArgumentError, match=r"world must be a motes\.World, got 3"):
            export.write(3)
        with pytest.raises(ArgumentError, match="an export has one world"):
            export.write(other)
        world.step()
        export.write(world)
    assert motes.open_particles(tmp_path / "a").frames == (0, 1)
    with pytest.raises(MotesError, match="is closed"):
        export.write(world)
    export.close()


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"path": "a.mp4"}, r"path must be a name ending in \.usd or \.pvd, or a directory"),
        ({"path": "a.vtp"}, r"did you mean \.pvd\?"),
        ({"path": "a.npz"}, "did you mean a directory?"),
        ({"path": ""}, "a directory's name"),
        ({"path": 3}, "path must be a path, got 3"),
        ({"every": 0}, "every must be an integer >= 1, got 0"),
        ({"every": 1.5}, "every must be an integer"),
        ({"attributes": "age"}, "attributes must be None or a list of attributes' names, got 'age'"),
        ({"attributes": [3]}, "attributes must be None or a list"),
        ({"attributes": 3}, "attributes must be None or a list"),
    ],
)
def test_wrong_arguments(tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ArgumentError, match=message):
        motes.Export(**{"path": "a", **arguments})
    assert not list(tmp_path.iterdir())


WRONG_NAMES = """
import os, sys, motes
world = motes.World(seed=1, progress="off", roles="shared")
s = world.system("s", attributes={"heat": 1.0})
export = motes.Export(sys.argv[1], attributes=["age", "haet"])
with world:
    world.step()
    try:
        export.write(world)
    except motes.ArgumentError as error:
        print(world.rank, error, flush=True)
    assert not os.path.exists(sys.argv[1])
    world.step()
"""


def test_a_wrong_name_is_an_error_on_every_rank_before_anything_is_written(tmp_path):
    lines = on_ranks(3, WRONG_NAMES, tmp_path / "a").lines
    assert sorted(line[0] for line in lines) == ["0", "1", "2"]
    assert all("attributes must be attributes that a system has" in line for line in lines)
    assert all("got 'haet'; did you mean 'heat'?" in line for line in lines)


def test_without_usd_every_rank_is_told_what_to_install(monkeypatch, tmp_path):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pxr" else find(name))
    with pytest.raises(motes.MissingExtraError, match=r'pip install "\.\[usd\]"'):
        motes.Export(tmp_path / "a.usd")


# --- places


def test_an_earlier_export_is_replaced_and_nothing_else(tmp_path):
    short_run(motes.Export(tmp_path / "a"), motes.Export(tmp_path / "a.pvd"), frames=5)
    (tmp_path / "a" / "notes.txt").write_text("mine")
    short_run(motes.Export(tmp_path / "a"), motes.Export(tmp_path / "a.pvd"), frames=2)
    assert sorted(os.listdir(tmp_path / "a")) == [
        "manifest.json",
        "notes.txt",
        "s.000000.r0000.npz",
        "s.000001.r0000.npz",
    ]
    assert motes.open_particles(tmp_path / "a.pvd").frames == (0, 1)
    assert sorted(os.listdir(tmp_path)) == ["a", "a.pvd", "a.pvd.parts"]


def test_a_directory_that_holds_other_things_is_refused_and_untouched(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "thesis.tex").write_text("mine")
    (tmp_path / "b.pvd").write_text("<VTKFile/>")
    (tmp_path / "c").write_text("a file")
    for name, said in (
        ("a", "this one holds 'thesis.tex'"),
        ("b.pvd", "a new name"),
        ("c", "is a directory or does not exist"),
    ):
        with pytest.raises(ArgumentError, match=said):
            motes.Export(tmp_path / name)
    assert (tmp_path / "a" / "thesis.tex").read_text() == "mine"
    assert (tmp_path / "b.pvd").read_text() == "<VTKFile/>"
    assert len(list(tmp_path.rglob("*"))) == 4


def test_two_exports_cannot_have_one_place_at_a_time(tmp_path):
    first, second = motes.Export(tmp_path / "a"), motes.Export(tmp_path / "a")
    with pytest.raises(ArgumentError, match="no other export is writing to"):
        short_run(first, second)
    short_run(motes.Export(tmp_path / "a"))
    assert motes.open_particles(tmp_path / "a").frames == (0, 1, 2)


OWN_DISKS = """
import os, sys, motes
world = motes.World(seed=1, progress="off", roles="shared")
s = world.system("s")
folder = f"{sys.argv[1]}/{world.rank}"
os.mkdir(folder)
os.chdir(folder)
with world, motes.Export("a") as export:
    for frame in world.frames(5):
        world.step()
        export.write(world)
"""


def test_ranks_that_do_not_see_each_others_files_are_told(tmp_path):
    result = on_ranks(2, OWN_DISKS, tmp_path)
    assert result.code == 1
    assert "rank 1 has written s.000000.r0001.npz" in result.err
    assert "all ranks must see the same directory" in result.err


# --- the thread


def test_a_frame_can_be_read_as_soon_as_its_files_are_whole(tmp_path):
    """The manager need not have received any report yet."""

    def look(frame, world):
        while not (tmp_path / "a" / f"s.{frame:06d}.r0000.npz").exists():
            time.sleep(0.01)
        opened = motes.open_particles(tmp_path / "a")
        assert opened.frames == tuple(range(frame + 1)) and not opened.finished
        assert opened.count(frame) == len(opened[frame]) == 50 * (frame + 1)

    short_run(motes.Export(tmp_path / "a"), each=look)


def test_at_most_two_frames_are_under_way(tmp_path, monkeypatch):
    go, begun = threading.Event(), []
    write = formats.Place.write_part

    def slow(place, file, columns, **more):
        begun.append(file)
        assert go.wait(20)
        return write(place, file, columns, **more)

    monkeypatch.setattr(formats.Place, "write_part", slow)
    export = motes.Export(tmp_path / "a")
    written = []

    def look(frame, world):
        written.append(frame)
        if frame == 1:  # two writes have returned, but nothing is on disk: the third must wait
            assert not list((tmp_path / "a").glob("*.npz"))
            threading.Timer(0.3, lambda: (waiting.append(len(written)), go.set())).start()

    waiting: list[int] = []
    short_run(export, frames=5, each=look)
    assert waiting == [2], "the third write returned before a frame was on disk"
    assert motes.open_particles(tmp_path / "a").frames == tuple(range(5))


def test_what_is_written_is_of_the_frame_it_was_asked_for(tmp_path, monkeypatch):
    """The writing thread is late: meanwhile the script changes the particles."""
    go = threading.Event()
    write = formats.Place.write_part
    late = lambda *given, **more: go.wait(20) and write(*given, **more)  # noqa: E731
    monkeypatch.setattr(formats.Place, "write_part", late)

    def change(frame, world):
        with world.systems[0].local() as particles:
            particles.position[:] = 77
            particles.heat[:] = 5
        go.set()

    shown = short_run(motes.Export(tmp_path / "a"), frames=1, each=change)
    read = motes.open_particles(tmp_path / "a")[0]
    assert same(read.position, shown[0].position) and same(read.heat, shown[0].heat)


@pytest.mark.parametrize("format", FORMATS)
def test_a_full_disk_is_told_at_the_next_call(tmp_path, format):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    def limit(frame, world):
        if frame == 2:
            while len([path for path in tmp_path.rglob("s.*") if path.name[-1] != "a"]) < 3:
                time.sleep(0.01)
            resource.setrlimit(resource.RLIMIT_FSIZE, (8000, hard))

    try:
        with pytest.raises(MotesError, match=r"could not be written to .*all"):
            short_run(motes.Export(tmp_path / NAMES[format]), frames=9, count=300, each=limit)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    opened = motes.open_particles(tmp_path / NAMES[format])
    assert opened.frames == (0, 1, 2) and len(opened[1]) == 600 and not opened.finished
    assert not list(tmp_path.rglob("*.tmp"))


FULL = """
import pathlib, resource, sys, time, motes
from motes.shapes import Sphere
world = motes.World(seed=1, progress="off", roles="shared", space=(-1, 1))
s = world.system("s")
with world, motes.Export(sys.argv[1]) as export:
    for frame in world.frames(50):
        s.burst(Sphere((0, 0, 0), 1), count=500)
        world.step()
        export.write(world)
        while frame == 2 and len(list(pathlib.Path(sys.argv[1]).glob("*.npz"))) < 9:
            time.sleep(0.01)
        if frame == 2 and world.rank == 1:
            resource.setrlimit(resource.RLIMIT_FSIZE, (9000, resource.RLIM_INFINITY))
"""


def test_a_full_disk_of_one_rank_ends_the_job_and_its_frames_remain(tmp_path):
    result = on_ranks(3, FULL, tmp_path / "a")
    assert result.code == 1
    assert "could not be written" in result.err and "File too large" in result.err
    assert "rank 1 (" in result.err
    opened = motes.open_particles(tmp_path / "a")
    assert opened.frames == (0, 1, 2)
    assert [len(p) for p in opened.values()] == [500 * (f + 1) for f in opened]


SLOW = """
import sys, time, motes
from motes._interchange import formats
write = formats.Place.write_part
def slow(*arguments, **more):
    time.sleep(0.7)
    return write(*arguments, **more)
world = motes.World(seed=1, progress="off", roles="shared")
s = world.system("s")
with world, motes.Export(sys.argv[1]) as export:
    if world.rank == 1:
        formats.Place.write_part = slow
    for frame in world.frames(5):
        s.burst((0, 0, 0))
        world.step()
        export.write(world)
"""


def test_a_slow_disk_of_one_rank_is_waited_for(tmp_path):
    result = on_ranks(2, SLOW, tmp_path / "a", env={"MOTES_STALL_S": "1.2"})
    assert result.code == 0, result.text
    assert "is still writing particles to a; the other ranks are waiting for it" in result.err
    assert "waited" not in result.err, "no rank warns of another that is busy"
    assert [len(p) for p in motes.open_particles(tmp_path / "a").values()] == [1, 2, 3, 4, 5]


MISMATCH = """
import sys, motes
world = motes.World(seed=1, progress="off", roles="shared")
s = world.system("s")
with world:
    export = motes.Export(sys.argv[1], attributes=["age"] if world.rank == 1 else None)
    world.step()
    export.write(world)
"""


def test_ranks_that_write_differently_are_told(tmp_path):
    result = on_ranks(3, MISMATCH, tmp_path / "a")
    assert result.code != 0 and "ScriptMismatchError" in result.err


def test_births_from_files(tmp_path):
    shown = short_run(motes.Export(tmp_path / "a"))
    script = (
        "import sys, motes\nworld = motes.World(seed=5, progress='off', space=(-1, 1), roles='shared')\n"
        "s = world.system('s', attributes={'heat': 0.0})\n"
        "p = motes.open_particles(sys.argv[1])[-1]\n"
        "with world:\n    s.emit(**p.columns())\n    world.step()\n    world.say(world.digest())\n"
        "    q = s.gather()\n    assert not q or (q.position == p.position).all() and len(q) == 150\n"
        "    s.emit(position=p.position, velocity=p.velocity, age=p.age)\n    world.step()\n"
    )
    assert alike(script, tmp_path / "a", ranks=(1, 3)) and len(shown[-1]) == 150


def test_particles_from_a_file_remember_where_they_were_emitted(tmp_path):
    """`restore` uses the positions from the file, not the zeros of a system that kept no birth values."""
    short_run(motes.Export(tmp_path / "a"))
    kept = start = motes.open_particles(tmp_path / "a")[-1]
    world = motes.World(seed=5, progress="off")
    system = world.system("s", attributes={"heat": 0.0})
    with world:
        for frame in world.frames(4):
            if frame == 0:
                system.emit(**start.columns())
            if frame == 2:
                system.emit(**kept.columns())
            system.gravity((0, -9, 0))
            system.move()
            if frame in (1, 3):
                system.restore(0)
            world.step()
            kept = system.gather()
    assert "position_b" not in start.columns() and "position_b" in kept.columns()
    assert len(kept) == 2 * len(start)
    assert np.allclose(kept.position[:150], start.position) and np.allclose(
        kept.position[150:], start.position
    )


def test_a_write_that_is_refused_may_come_again(tmp_path):
    world = motes.World(seed=5, progress="off")
    system = world.system("s")
    with world, motes.Export(tmp_path / "a") as export:
        for _ in world.frames(3):
            system.burst(Sphere((0, 0, 0), 1), count=20)
            system.collide(radius=0.1)
            with pytest.raises(ValueError, match="interact in this frame's list so far"):
                export.write(world)
            system.move()
            world.step()
            export.write(world)
    assert [len(p) for p in motes.open_particles(tmp_path / "a").values()] == [20, 40, 60]


def test_a_box_of_systems_without_any_particle(tmp_path):
    world = motes.World(seed=1, progress="off")
    with world, motes.Export(tmp_path / "a") as export, motes.Export(tmp_path / "b.pvd") as other:
        world.step()
        export.write(world)
        s = world.system("s")
        world.step()
        export.write(world)
        other.write(world)
        s.source(Box((0, 0, 0), (1, 1, 1)), rate=48)
        world.step()
        export.write(world)
    assert motes.open_particles(tmp_path / "a").frames == (1, 2)
    assert [len(p) for p in motes.open_particles(tmp_path / "a").values()] == [0, 2]
    assert motes.open_particles(tmp_path / "b.pvd")[1].position.shape == (0, 3)
