"""A column that later files of an export hold is in its earlier files, too, as the particles had it."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from standing import on_ranks
from test_export import FORMATS, NAMES, same

import motes
from motes import MotesError
from motes._interchange import complete, formats
from motes._interchange.ledger import Ledger, note_of
from motes._interchange.manifest import NAME, Manifest
from motes._interchange.pack import pack
from motes.shapes import Sphere

LATE = {
    "color": (0.1, 0.2, 0.3),
    "alpha": 0.5,
    "size": (2, 3, 4),
    "mass": 7.0,
    "lifetime": 9.0,
    "up": (1, 0, 0),
    "spin": (1, 2, 3),
    "rotational_velocity": (4, 5, 6),
}


def run(*exports, frames=5):
    """Run a scene in which all late columns start in frame 3; return what `gather` showed of each frame."""
    world = motes.World(seed=2, progress="off")
    system = world.system("s", attributes={"heat": 1.0})
    shown = []
    with world:
        for frame in world.frames(frames):
            if frame:
                system.burst(Sphere((0, 0, 0), 1), count=4)
            if frame == 3:
                system.set(**LATE)
            system.move()  # spin turns the orientation
            world.step()
            for export in exports:
                export.write(world)
            shown.append(system.gather())
    return shown


def check(path, shown, *, since=0):
    """Compare every file's columns with what `gather` showed."""
    opened = motes.open_particles(path)
    files, manifest = opened.folder, Manifest.read(opened.folder)
    assert opened.finished and opened.frames == tuple(range(len(shown)))
    (system,) = manifest.systems
    names = [column.name for column in system.used]
    assert {*LATE, "orientation"} < set(names) and {column.since for column in system.used} == {since}
    format = formats.FORMATS[manifest.kind]
    for frame, wanted in zip(manifest.frames, shown, strict=True):
        (part,) = frame.parts
        assert part.bytes == (files / part.file).stat().st_size and part.rows == len(wanted)
        read = format.read(files / part.file, [*names, "id"], frame=frame.frame)
        order = np.argsort(read["id"])
        assert all(same(read[name][order], getattr(wanted, name)) for name in (*names, "id")), frame.frame


@pytest.mark.parametrize("format", FORMATS)
def test_earlier_files_get_the_columns_when_the_export_is_closed(tmp_path, format):
    shown = run(motes.Export(tmp_path / NAMES[format]))
    check(tmp_path / NAMES[format], shown)
    assert not [path for path in tmp_path.rglob(".*") if path.is_file()]


def test_files_that_hold_all_columns_are_not_written_again(tmp_path, monkeypatch):
    monkeypatch.setattr(complete, "complete", None)
    run(motes.Export(tmp_path / "a", attributes=["color", "spin"]))
    assert motes.open_particles(tmp_path / "a").finished


HALF = """
import sys, time, motes
from motes.shapes import Sphere
world = motes.World(seed=2, progress="off", roles="shared", space=(-1, 1))
s = world.system("s")
export = motes.Export(sys.argv[1])
with world:
    for frame in world.frames(6):
        s.burst(Sphere((0, 0, 0), 1), count=40)
        if frame == 3:
            s.set(color=(1, 0, 0))
        world.step()
        export.write(world)
    if world.rank == 1:
        from motes._interchange.formats import Place
        write = Place.write_part
        def full(*given, **more):
            if full.left == 0:
                raise OSError(28, "No space left on device")
            full.left -= 1
            time.sleep(float(sys.argv[3]))
            return write(*given, **more)
        full.left = int(sys.argv[2])
        while not export._writer.is_idle(1):
            pass
        Place.write_part = full
    export.close()
"""


@pytest.mark.parametrize("ranks", [2, 3])
def test_a_full_disk_meanwhile_ends_the_job_and_keeps_every_frame(tmp_path, ranks):
    result = on_ranks(ranks, HALF, tmp_path / "a", 1, 0)
    assert result.code == 1 and "No space left on device" in result.err and "rank 1 (" in result.err
    opened = motes.open_particles(tmp_path / "a")
    assert not opened.finished and [len(particles) for particles in opened.values()] == [
        40,
        80,
        120,
        160,
        200,
        240,
    ]
    assert [set(map(tuple, p.color.tolist())) for p in opened.values()][:4] == [{(1, 1, 1)}] * 3 + [
        {(1, 0, 0)}
    ]
    written = [sorted(np.load(path).files) for path in sorted((tmp_path / "a").glob("*.npz"))]
    assert 0 < sum("color" in names for names in written[: 3 * ranks]) < 3 * ranks, "some have been completed"
    pack(tmp_path / "a", tmp_path / "joined")
    assert all("color" in np.load(path).files for path in (tmp_path / "joined").glob("*.npz"))


def test_a_slow_disk_of_one_rank_is_waited_for(tmp_path):
    result = on_ranks(2, HALF, tmp_path / "a", -1, 0.7, env={"MOTES_STALL_S": "1.2"})
    assert result.code == 0, result.text
    assert "is still completing the columns of a; the other ranks are waiting for it" in result.err
    assert motes.open_particles(tmp_path / "a").finished
    assert all("color" in np.load(path).files for path in (tmp_path / "a").glob("*.npz"))


@pytest.mark.parametrize("share", [0, 1])
def test_shares_are_disjoint_and_can_be_written_again(tmp_path, share):
    shown = run(motes.Export(tmp_path / "whole"))
    run(motes.Export(tmp_path / "a"))
    place = formats.place_of("path", tmp_path / "a")
    manifest = Manifest.read(place.folder)
    for column in manifest.systems[0].columns:
        column.since = 3 if column.name in (*LATE, "orientation") else column.since
    for path in place.folder.glob("s.00000[012].*"):
        columns = formats.FORMATS["npz"].read(path, None, frame=0)
        kept = {name: column for name, column in columns.items() if name not in (*LATE, "orientation")}
        formats.FORMATS["npz"].write(path, kept, frame=0, time=0)
    assert not complete.is_complete(manifest)
    stopped = complete.complete(place, manifest, 0, 1, lambda: True)
    assert stopped == []
    first = complete.complete(place, manifest, share, 2, lambda: False)
    again = complete.complete(place, manifest, share, 2, lambda: False)
    rest = complete.complete(place, manifest, 1 - share, 2, lambda: False)
    assert first == again and len(first) + len(rest) == 3
    assert sorted(frame for frame, _ in first + rest) == [0, 1, 2]
    assert not complete.is_complete(complete.amended(manifest, rest)), "a share is missing"
    complete.amended(manifest, first + rest).write(place.folder)
    check(tmp_path / "a", shown)


def test_files_of_which_only_the_names_are_known_are_completed(tmp_path):
    """A killed run had announced these frames; a manifest does not know their rows and bytes."""
    shown = run(motes.Export(tmp_path / "a"))
    place = formats.place_of("path", tmp_path / "a")
    manifest = Manifest.read(place.folder)
    manifest.frames = [
        dataclasses.replace(one, parts=tuple(dataclasses.replace(p, rows=-1, bytes=-1) for p in one.parts))
        for one in manifest.frames
    ]
    for column in manifest.systems[0].columns:
        column.since = 3 if column.name == "color" else column.since
    ledger = Ledger(place, manifest)
    assert ledger.is_late()
    ledger.amend([note_of(complete.complete(place, manifest, share, 2, lambda: False)) for share in (0, 1)])
    read = Manifest.read(place.folder)
    assert complete.is_complete(read) and read.finished
    assert [frame.parts[0].rows for frame in read.frames] == [
        len(shown[f]) if f < 3 else -1 for f in range(5)
    ]
    opened = motes.open_particles(tmp_path / "a")
    assert all(same(opened[frame].color, wanted.color) for frame, wanted in enumerate(shown))


@pytest.mark.parametrize("format", FORMATS)
def test_packing_completes_an_export_that_was_not_closed(tmp_path, format):
    shown = run(motes.Export(tmp_path / "a"))
    path = tmp_path / "a" / NAME
    said = json.loads(path.read_text())
    for column in said["systems"][0]["columns"]:
        column["since"] = 3 if column["name"] in (*LATE, "orientation") else column["since"]
    path.write_text(json.dumps(said))
    pack(tmp_path / "a", tmp_path / NAMES[format].replace("all", "joined"))
    check(tmp_path / NAMES[format].replace("all", "joined"), shown)
    pack(tmp_path / "a", tmp_path / "one.npz", frame=2)
    assert set(LATE) < set(np.load(tmp_path / "one.npz").files)


def test_damage_that_is_found_meanwhile_is_told(tmp_path):
    export = motes.Export(tmp_path / "a")
    with pytest.raises(MotesError, match=r"s\.000001|could not be written"):
        world = motes.World(seed=2, progress="off")
        system = world.system("s")
        with world:
            for frame in world.frames(4):
                system.burst((0, 0, 0))
                if frame == 2:
                    system.set(color=(1, 0, 0))
                world.step()
                export.write(world)
            while not export._writer.is_idle(1):
                pass
            (tmp_path / "a" / "s.000001.r0000.npz").write_bytes(b"")
            export.close()
