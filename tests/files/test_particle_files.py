"""Particle files: each format round-trips, packing joins parts by id, and damage is reported."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_export import FORMATS, NAMES, same, short_run

import motes
from motes import ArgumentError, MotesError
from motes._interchange import formats, npz, usd, vtp
from motes._interchange.manifest import Column, FrameParts, Manifest, Part, SystemColumns, stems
from motes.cli import main

KINDS = {
    kind: row for kind, row in formats.FORMATS.items() if kind != "usdc" or importlib.util.find_spec("pxr")
}
SPECIAL = np.array([0.0, -0.0, np.nan, np.inf, -np.inf, 1e-45, 3.4e38, 1.5], np.float32)


def columns_of(count: int, seed: int) -> dict[str, np.ndarray]:
    """Return columns with arbitrary bits and shuffled ids, some above 2^31."""
    dice = np.random.default_rng(seed)
    ids = dice.permutation(count).astype(np.uint64) + np.uint64(dice.choice([0, 2**31, 2**63 - count - 1]))

    def floats(*shape: int) -> np.ndarray:
        return np.where(dice.random(shape) < 0.2, dice.choice(SPECIAL, shape), dice.random(shape)).astype(
            np.float32
        )

    return {
        "position": floats(count, 3),
        "velocity": floats(count, 3),
        "color": floats(count, 3),
        "alpha": floats(count),
        "size": floats(count, 3),
        "up": floats(count, 3),
        "heat": floats(count),
        "id": ids,
    }


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=25, deadline=None)
@given(count=st.integers(0, 40), seed=st.integers(0, 10**6), frame=st.integers(0, 10**6))
def test_each_format_gives_back_every_bit(kind, tmp_path_factory, count, seed, frame):
    columns = columns_of(count, seed)
    path = tmp_path_factory.getbasetemp() / f"bits.{kind}"
    KINDS[kind].write(path, columns, frame=frame, time=frame / 24)
    read = KINDS[kind].read(path, list(columns), frame=frame)
    order, wanted = np.argsort(read["id"]), np.argsort(columns["id"])
    for name, column in columns.items():
        assert same(read[name][order], column[wanted]), name
    if kind == "usdc":
        assert (np.diff(read["id"].astype(object)) > 0).all(), "sorted"
        layer = importlib.import_module("pxr.Sdf").Layer.OpenAsAnonymous(str(path))
        ids = layer.QueryTimeSample("/particles.primvars:id", float(frame))
        assert (ids is None) == (count > 0 and int(columns["id"].max()) >= 2**31)
    before = path.read_bytes()
    KINDS[kind].write(path, columns, frame=frame, time=frame / 24)
    assert path.read_bytes() == before, "equal particles make equal files"


def test_other_readers_read_vtp(tmp_path):
    """VTK's own reader gets the same columns."""
    io = pytest.importorskip("vtkmodules.vtkIOXML")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    for count in (0, 1, 1000):
        columns = columns_of(count, 3)
        vtp.write(tmp_path / "a.vtp", columns, frame=3, time=0.25)
        reader = io.vtkXMLPolyDataReader()
        reader.SetFileName(str(tmp_path / "a.vtp"))
        reader.Update()
        data = reader.GetOutput()
        assert data.GetNumberOfPoints() == data.GetNumberOfVerts() == count
        assert data.GetFieldData().GetArray("TimeValue").GetValue(0) == 0.25
        if count:
            assert same(vtk_to_numpy(data.GetPoints().GetData()), columns["position"])
            for name in set(columns) - {"position"}:
                assert same(vtk_to_numpy(data.GetPointData().GetArray(name)), columns[name]), name
            assert (vtk_to_numpy(data.GetVerts().GetConnectivityArray()) == np.arange(count)).all()


def test_a_vtp_read_by_itself_has_the_columns_that_the_system_had(tmp_path):
    """Other programs get a radius, too; an attribute may be named as VTK names its points."""
    world = motes.World(seed=2, progress="off")
    system = world.system("s", attributes={"Points": (1, 2, 3)})
    own = world.system("own", attributes={"radius": 5.0})
    with world, motes.Export(tmp_path / "a.pvd") as export:
        for one in (system, own):
            one.configure(size=motes.Uniform(1, 2))
            one.burst(motes.shapes.Sphere((0, 0, 0), 1), count=20)
        world.step()
        export.write(world)
        shown = {one.name: one.gather() for one in (system, own)}
    for name, extra in (("s", "Points"), ("own", "radius")):
        read = motes.open_particles(tmp_path / f"a.pvd.parts/{name}.000000.r0000.vtp")[0]
        assert set(read.columns()) == {"position", "velocity", "size", extra}
        assert all(same(getattr(read, one), getattr(shown[name], one)) for one in read.columns())
        assert same(motes.open_particles(tmp_path / "a.pvd", system=name)[0].position, read.position)


def test_numpy_reads_npz(tmp_path):
    columns = columns_of(100, 4)
    npz.write(tmp_path / "a.npz", columns, frame=0, time=0)
    with np.load(tmp_path / "a.npz") as archive:
        assert archive.files == list(columns)
        assert all(same(archive[name], column) for name, column in columns.items())


def test_a_usd_stage_is_what_blender_reads(tmp_path):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    world = motes.World(seed=2, dt=1 / 30, progress="off")
    system = world.system("falling snow", attributes={"heat": 1.0})
    shown = {}
    with world, motes.Export(tmp_path / "at@home.usd", every=2) as export:
        for frame in world.frames(5):
            system.configure(size=motes.Uniform(0.1, 0.2), color=(1, 0, 0), alpha=0.5, velocity=(0, -1, 0))
            system.burst(motes.shapes.Sphere((0, 0, 0), 1), count=20)
            system.move()
            world.step()
            export.write(world)
            shown[frame] = system.gather()
    stage = Usd.Stage.Open(str(tmp_path / "at@home.usd"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (0, 4, 30)
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Y", 1)
    assert str(stage.GetDefaultPrim().GetPath()) == "/World"
    prim = stage.GetPrimAtPath("/World/falling_snow/falling_snow")
    assert prim.GetParent().GetDisplayName() == "falling snow"
    points = UsdGeom.Points(prim)
    for frame in (0, 2, 4):
        wanted = shown[frame]
        assert same(np.array(points.GetPointsAttr().Get(frame)), wanted.position)
        assert same(np.array(points.GetVelocitiesAttr().Get(frame)), wanted.velocity)
        assert same(np.array(points.GetWidthsAttr().Get(frame)), np.ascontiguousarray(wanted.size[:, 0]))
        assert (np.array(points.GetIdsAttr().Get(frame)) == wanted.id).all()
        primvars = {v.GetPrimvarName(): v for v in UsdGeom.PrimvarsAPI(prim).GetPrimvars()}
        assert all(v.GetInterpolation() == "vertex" for v in primvars.values())
        for name, column in (
            ("displayColor", wanted.color),
            ("displayOpacity", wanted.alpha),
            ("heat", wanted.heat),
        ):
            assert same(np.array(primvars[name].Get(frame)), column), name
        assert (np.array(primvars["id"].Get(frame)) == wanted.id).all()
        around = UsdGeom.Boundable.ComputeExtentFromPlugins(points, frame)
        np.testing.assert_allclose(points.GetExtentAttr().Get(frame), around, rtol=1e-6)
        half = wanted.size[:, :1] / 2
        np.testing.assert_allclose(around[1], (wanted.position + half).max(axis=0), rtol=1e-6)
    assert len(points.GetPointsAttr().Get(3)) == 60, "a frame that was not written shows the one before"


@pytest.mark.parametrize("names", [("position", "id"), ("position", "size", "id")])
@pytest.mark.parametrize("count", [1, 50])
def test_usd_bounds_are_those_that_usd_computes(tmp_path, names, count):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    dice = np.random.default_rng(1)
    columns = {name: dice.random((count, 3)).astype(np.float32) for name in names[:-1]}
    usd.write(tmp_path / "a.usdc", {**columns, "id": np.arange(count, dtype=np.uint64)}, frame=3, time=0)
    stage = Usd.Stage.Open(str(tmp_path / "a.usdc"))
    points = UsdGeom.Points(stage.GetPrimAtPath("/particles"))
    extent = np.array(points.GetExtentAttr().Get(3))
    np.testing.assert_allclose(extent, UsdGeom.Boundable.ComputeExtentFromPlugins(points, 3), rtol=1e-6)
    assert ((extent[1] - extent[0]) > 0).all() or (count == 1 and "size" not in names)


def test_paths_in_usd_are_the_same_for_any_ranks_and_joined():
    systems = [SystemColumns("s", "s", [])]
    for ranks in ([0], [2, 3], [None]):
        parts = tuple(Part(0, rank, f"s.{rank}.usdc", 1, 1) for rank in ranks)
        text = usd.stage(Manifest("usdc", 1, 0.1, 1, systems, [FrameParts(0, 0.1, parts)]), "f").decode()
        named = re.findall(r'def Points "(\w+)"', text)
        assert named == ["s", "s_2"][: len(ranks)]


# --- opening


def test_what_can_be_opened(tmp_path, monkeypatch):
    shown = short_run(motes.Export(tmp_path / "a.pvd"))
    monkeypatch.chdir(tmp_path)
    for path in ("a.pvd", "a.pvd.parts", tmp_path / "a.pvd"):
        assert motes.open_particles(path).frames == (0, 1, 2)
    single = motes.open_particles("a.pvd.parts/s.000001.r0000.vtp")
    assert len(single) == 1 and same(single[0].position, shown[1].position)
    np.savez("mine.npz", position=np.ones((5, 3)), heat=np.arange(5.0))
    mine = motes.open_particles("mine.npz")[0]
    assert (mine.id == range(5)).all() and (mine.heat == range(5)).all() and mine.position.dtype == np.float32
    assert repr(motes.open_particles("a.pvd")) == "<particles of 's' in 'a.pvd', frames 0..2 (3)>"


@pytest.mark.parametrize(
    "path", ["nothing", "nothing.usd", "nothing.npz", "empty", "text.txt", "foreign.pvd"]
)
def test_what_cannot_be_opened(tmp_path, path):
    (tmp_path / "empty").mkdir()
    for name in ("text.txt", "foreign.pvd"):
        (tmp_path / name).write_text("x")
    with pytest.raises(ArgumentError, match="path must be "):
        motes.open_particles(tmp_path / path)


def test_of_several_systems_one_is_chosen(tmp_path):
    world = motes.World(seed=2, progress="off")
    systems = [world.system(name) for name in ("snow", "rain")]
    with world, motes.Export(tmp_path / "a") as export:
        for system in systems:
            system.burst((0, 0, 0))
        world.step()
        export.write(world)
    opened = motes.open_particles(tmp_path / "a")
    assert opened.systems == ("snow", "rain") and opened.system is None and opened.frames == (0,)
    with pytest.raises(
        ArgumentError, match=r"system must be one of 'snow', 'rain', got None; as in open_particles"
    ):
        opened[0]
    with pytest.raises(ArgumentError, match="got 'snoww'; did you mean 'snow'"):
        motes.open_particles(tmp_path / "a", system="snoww")
    assert len(motes.open_particles(tmp_path / "a", system="rain")[-1]) == 1


@pytest.mark.parametrize("format", FORMATS)
@pytest.mark.parametrize("damage", ["cut", "gone", "other", "empty"])
def test_damaged_parts_are_told(tmp_path, format, damage):
    short_run(motes.Export(tmp_path / NAMES[format]))
    opened = motes.open_particles(tmp_path / NAMES[format])
    first, second = sorted(path for path in opened.folder.glob("s.*") if path.name[2] == "0")[:2]
    content = first.read_bytes()
    if damage == "gone":
        first.unlink()
    else:
        other = {"cut": content[: len(content) // 2], "other": second.read_bytes(), "empty": b""}
        first.write_bytes(other[damage])
    with pytest.raises(MotesError, match=r"s\.000000\.r0000"):
        opened[0]
    assert len(opened[2]) == 150


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda m: m.update(version=2), "has version 2; this motes reads 1"),
        (lambda m: m.update(format="x"), "is not a manifest"),
        (lambda m: m.pop("systems"), "is damaged: KeyError"),
        (lambda m: m["frames"][0]["parts"][0].__setitem__(0, 7), "is damaged"),
        (lambda m: m["frames"][0]["parts"][0].__setitem__(2, "../../etc/passwd"), "is damaged"),
        (lambda m: m["systems"][0]["columns"][0].update(width=2), "is damaged"),
        (None, "cannot be read"),
    ],
)
def test_damaged_manifests_are_told(tmp_path, change, message):
    short_run(motes.Export(tmp_path / "a"))
    path = tmp_path / "a" / "manifest.json"
    text = path.read_text()
    if change is None:
        path.write_text(text[:-5])
    else:
        manifest = json.loads(text)
        change(manifest)
        path.write_text(json.dumps(manifest))
    with pytest.raises(MotesError, match=message):
        motes.open_particles(tmp_path / "a")


@given(
    names=st.lists(st.text(min_size=1), max_size=5, unique=True),
    initial=st.floats(width=32),
    rows=st.integers(0, 2**40),
    seed=st.none() | st.integers(0, 2**64 - 1),
)
@settings(max_examples=40, deadline=None)
def test_manifests_are_read_as_they_were_written(tmp_path_factory, names, initial, rows, seed):
    folder = tmp_path_factory.getbasetemp() / "manifest"
    names = [name for name in names if not any("\ud800" <= letter <= "\udfff" for letter in name)]
    folder.mkdir(exist_ok=True)
    columns = [Column("position", 3, (0.0, 0.0, 0.0), 2), Column("lifetime", 1, (initial,), None)]
    systems = [SystemColumns(n, s, columns) for n, s in zip(names, stems(names), strict=True)]
    parts = tuple(Part(i, None if i else 3, f"{one.stem}.npz", rows, 5) for i, one in enumerate(systems))
    missing = FrameParts(7, 1 / 3, (*parts, Part(0, 1, "gone", -1, -1))) if parts else FrameParts(7, 1.0, ())
    made = Manifest("npz", seed, 1 / 24, 3, systems, [FrameParts(4, 0.1, parts)], [missing], True)
    made.write(folder)
    read = Manifest.read(folder)
    if not parts:
        made.frames, made.announced = [*made.frames, missing], []  # all parts are present
    assert repr(read) == repr(made)
    assert len({one.stem.lower() for one in systems}) == len(systems)
    assert all(one.stem.isascii() and one.stem.isidentifier() for one in systems)


def test_reading_starts_no_mpi(tmp_path):
    short_run(motes.Export(tmp_path / "a"))
    script = (
        "import sys, motes\np = motes.open_particles(sys.argv[1])[0]\nassert len(p) == len(p.age) == 50\n"
        "assert not {'mpi4py.MPI', 'motes._core'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", script, tmp_path / "a"], check=True, timeout=60)


# --- packing


@pytest.mark.parametrize("target", FORMATS)
def test_packing_gives_the_same_files_whatever_the_ranks_were(tmp_path, target, capsys):
    from standing import on_ranks
    from test_export import SCENE, check_all

    packed = {}
    for ranks in (1, 3):
        folder = tmp_path / str(ranks)
        folder.mkdir()
        assert on_ranks(ranks, SCENE, folder, "end", "npz", "--roles", "shared").code == 0
        (folder / "joined").mkdir()
        np.savez(folder / "joined/reference.npz", **np.load(folder / "reference.npz"))
        assert (
            main(["pack", str(folder / "all"), "-o", str(folder / "joined" / NAMES[target]), "--json"]) == 0
        )
        figures = json.loads(capsys.readouterr().out)
        assert figures["frames"] == 8 and figures["files"] == 3 * 8 + 5
        check_all(folder / "joined", NAMES[target])
        (folder / "joined/reference.npz").unlink()
        files = [path for path in (folder / "joined").rglob("*") if path.is_file()]
        packed[ranks] = {path.relative_to(folder): path.read_bytes() for path in files}
        with np.load(folder / "all/snow.000003.r0000.npz") as part:
            assert (np.diff(part["id"].astype(np.int64)) < 0).any() or ranks == 3
    assert packed[1] == packed[3]


@pytest.mark.parametrize("target", FORMATS)
def test_columns_of_any_name_and_width_can_be_packed(tmp_path, target, capsys):
    """As in a file of another program."""
    names = ["heat flux", "1st", "größe", "ns:x", 'a"b<', "points", "heat"]
    columns = {name: np.arange(3, dtype=np.float32) + i for i, name in enumerate(names)}
    columns |= {"position": np.ones((3, 3), np.float32), "rgba": np.ones((3, 4), np.float32)}
    np.savez(tmp_path / "a.npz", **columns)
    packed = tmp_path / NAMES[target]
    assert main(["pack", str(tmp_path / "a.npz"), "-o", str(packed)]) == 0
    read = motes.open_particles(packed)[0].columns()
    assert set(read) == set(columns) and all(same(read[name], columns[name]) for name in columns)
    np.savez(tmp_path / "b.npz", **columns, heat_flux=columns["heat"])
    capsys.readouterr()
    clash = main(["pack", str(tmp_path / "b.npz"), "-o", str(packed)])
    assert clash == (2 if target == "usd" else 0)
    if clash:
        said = "columns 'heat flux' and 'heat_flux' have one name in USD, primvars:heat_flux"
        assert said in capsys.readouterr().err


def test_packing_one_frame_to_emit_from(tmp_path, capsys):
    shown = short_run(motes.Export(tmp_path / "a"))
    target = tmp_path / "pile.npz"
    assert main(["pack", str(tmp_path / "a"), "--frame", "-1", "-o", str(target)]) == 0
    assert capsys.readouterr().out == f"{target}: 1 frames, 150 particles in 1 files\n"
    pile = motes.open_particles(target)[0]
    assert same(pile.position, shown[-1].position) and set(pile.columns()) == {
        "position",
        "velocity",
        "age",
        "heat",
    }


def test_what_was_read_or_gathered_can_be_emitted(tmp_path):
    short_run(motes.Export(tmp_path / "a"))
    read = motes.open_particles(tmp_path / "a")[-1]
    world = motes.World(seed=1, progress="off")
    system = world.system("s", attributes={"heat": 0.0})
    cold = world.system("without heat")
    with world:
        system.emit(read, velocity=np.ones((150, 3)))
        with pytest.raises(
            ArgumentError, match="column must be .*attributes={'heat': 0.0}.*, or leave it out, .*got 'heat'"
        ):
            cold.emit(read)
        with pytest.raises(ArgumentError, match="position must be"):
            system.emit(velocity=read.velocity)
        with pytest.raises(ArgumentError, match=r"particles must be motes.Particles; pass arrays by name"):
            system.emit(read.position)
        cold.emit(position=read.position[:7])
        world.step()
        born = system.gather()
        cold.emit(cold.gather())
        world.step()
    assert same(born.position, read.position) and same(born.heat, read.heat) and len(born) == 150
    assert born.velocity.all() and not read.velocity.any() and born.id.tolist() == list(range(150))
    assert cold.count == 14


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["a", "-o", "x.npz"], "frame must be one of 3 frames, for a single .npz file"),
        (["a", "-o", "a"], "output must be a place other than"),
        (["a", "-o", "x.mp4"], "output must be a name ending in .usd or .pvd"),
        (["a", "-o", "taken"], "output must be a new or empty directory"),
        (["a", "-o", "b", "--frame", "9"], "frame must be one of the 3 frames"),
        (["a", "-o", "b", "--system", "t"], "system must be one of 's', got 't'"),
        (["nothing", "-o", "b"], "it does not exist"),
    ],
)
def test_what_cannot_be_packed(tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    short_run(motes.Export("a"))
    os.mkdir("taken")
    (tmp_path / "taken/mine").write_text("x")
    before = sorted(tmp_path.rglob("*"))
    assert main(["pack", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


# --- particles as values


def test_particles_as_tables_and_in_notebooks(tmp_path):
    pandas = pytest.importorskip("pandas")
    particles = short_run(frames=1)[0]
    table = particles.to_frame()
    assert isinstance(table, pandas.DataFrame) and len(table) == 50
    assert list(table.columns[:4]) == ["id", "position_x", "position_y", "position_z"]
    assert (table["velocity_y"] == particles.velocity[:, 1]).all() and (table["age"] == particles.age).all()
    shown = particles._repr_html_()
    assert "<b>50 particles</b>" in shown and "<th>position</th>" in shown and "<td>0 .. 49</td>" in shown
    assert "<th>lifetime</th><td>inf</td>" in shown
    assert "-" in motes.Particles({"id": np.empty(0, np.uint64)})._repr_html_()
    elsewhere = motes.Particles(None)
    assert "elsewhere" in elsewhere._repr_html_()
    for call in (elsewhere.to_frame, elsewhere.columns):
        with pytest.raises(motes.NotHereError):
            call()
    with pytest.raises(ArgumentError, match="did you mean 'velocity'"):
        particles.columns("velocty")
    assert list(particles.columns("age", "id")) == ["age", "id"] and "id" not in particles.columns()


# --- the page


PAGE = Path(__file__).resolve().parents[2] / "docs" / "particles_out.md"


@pytest.mark.skipif(not PAGE.is_file(), reason="the page stands in the source tree")
def test_the_code_of_the_page_runs(tmp_path, monkeypatch):
    pytest.importorskip("pandas")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) == 4
    for block in blocks:
        exec(block, {})
