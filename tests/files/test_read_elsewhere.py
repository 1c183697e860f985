"""What other programs read of an export, at and between frames, is what `gather` showed: each value of it."""

from __future__ import annotations

import base64
import importlib.util
import os
import re
import subprocess
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from readers import usd_core
from standing import on_ranks

import motes
from motes._interchange.pack import pack

ROOT = Path(__file__).parents[2]
SCENE = ROOT / "tests/scenes/read_elsewhere.py"
READERS = ROOT / "tests/support/readers"
FRAMES = 10
TIMES = [time / 2 for time in range(2 * FRAMES)]
SYSTEMS = {
    "grains": "grains",
    "drops_of_rain": "drops of rain",
    "named": "named",
    "void": "void",
    "late": "late",
}


@pytest.fixture(scope="module")
def exports(tmp_path_factory):
    """Run the scene on three ranks; return its folder."""
    if importlib.util.find_spec("pxr") is None:
        pytest.skip("needs usd-core")
    folder = tmp_path_factory.mktemp("exports")
    assert on_ranks(3, SCENE, folder, timeout=120).code == 0
    pack(folder / "fours", folder / "fours.usd")
    return folder


@pytest.fixture(scope="module")
def shown(exports):
    """Return what `gather` showed: column by system, frame and name."""
    columns: dict[tuple[str, int], dict[str, Any]] = {}
    for key, column in np.load(exports / "reference.npz").items():
        system, frame, name = key.split("/")
        columns.setdefault((system, int(frame)), {})[name] = column
    return columns


def reader(name: str) -> str:
    """Return the Python of an environment of `.ci/readers`, or skip the test."""
    folder = Path(os.environ.get("MOTES_TEST_READERS", ROOT / ".venv-readers"))
    python = folder / name / "bin/python"
    if not python.is_file():
        pytest.skip(f"no {python}: make it with `bash .ci/readers/make`, or set MOTES_TEST_READERS")
    return str(python)


def read_by(name: str, script: str, *arguments: object) -> None:
    command = [reader(name), READERS / script, *map(str, arguments)]
    clean = {
        key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "OMPI", "PMIX"))
    }
    subprocess.run(command, check=True, timeout=300, env=clean, stdout=subprocess.DEVNULL)


def joined(found: dict[str, Any], system: str, time: float | int) -> dict[str, Any]:
    """Join what was read of a system's parts at a time, sorted by id; refuse parts with different columns."""
    parts: dict[str, dict[str, Any]] = {}
    for key, values in found.items():
        owner, part, at, name = key.split("|")
        if owner == system and float(at) == time:
            parts.setdefault(part, {})[name] = values
    whole = [part for part in parts.values() if len(part["id"])] or list(parts.values())
    names = set(whole[0])
    assert all(set(part) == names for part in whole), (system, time)
    columns = {name: np.concatenate([part[name] for part in whole]) for name in names}
    order = np.argsort(columns["id"].reshape(-1))
    return {name: column[order] if len(column) == len(order) else column for name, column in columns.items()}


def same(read: Any, wanted: Any) -> bool:
    return read.dtype == wanted.dtype and read.reshape(wanted.shape).tobytes() == wanted.tobytes()


def ours(primvar: str) -> str:
    """Return the column of a primvar."""
    return {"displayColor": "color", "displayOpacity": "alpha"}.get(primvar, primvar.removesuffix("_"))


def check_usd(read: dict[str, Any], wanted: dict[str, Any], where: tuple[Any, ...], *, exact: bool) -> None:
    """Compare the columns of a system that a program read with those that `gather` showed."""
    for name, values in read.items():
        column = ours(name)
        assert column in wanted, (*where, name, "is unknown")
        # Between frames USD mixes a value with itself, which rounds.
        close = np.allclose(values.reshape(wanted[column].shape), wanted[column], rtol=1e-6, atol=1e-6)
        assert close and values.dtype == np.float32, (*where, name)
        assert same(values, wanted[column]) or not exact, (*where, name)


def written(folder: Path, name: str, system: str) -> set[str]:
    """Return the columns of a system that the export holds, all from its first frame on."""
    files = motes.open_particles(folder / name, system=system)
    columns = files._manifest.systems[files.systems.index(system)].columns
    assert all(column.since in (None, 0) for column in columns)
    return {column.name for column in columns if column.since is not None} | {"id"}


@pytest.mark.parametrize(("name", "every"), [("all.usd", 1), ("fours.usd", 4)])
def test_usd_core_reads_what_gather_shows_at_and_between_frames(exports, shown, name, every):
    found = usd_core.read(str(exports / name), TIMES)
    parts = {tuple(key.split("|")[:2]) for key in found}
    assert {owner for owner, _ in parts} == set(SYSTEMS)
    assert all(re.fullmatch(rf"{owner}(_\d)?", part) for owner, part in parts), "named after their systems"
    for owner, system in SYSTEMS.items():
        names = written(exports, name, system)
        for time in TIMES:
            frame = int(time) // every * every
            read = joined(found, owner, time)
            wanted = shown.get((system, frame))
            if wanted is None:  # before the system's first frame
                assert not any(len(column) for name, column in read.items() if name != "extent"), (
                    owner,
                    time,
                )
                continue
            check_moved(read, wanted, (time - frame) / 60)
            where = (owner, time)
            widths, ids, id32 = (read.pop(one, None) for one in ("widths", "id", "id32"))
            assert (ids == wanted["id"]).all() and (id32 == wanted["id"]).all(), where
            assert (widths is None) == ("size" not in names), where
            assert widths is None or np.allclose(widths, wanted["size"][:, 0], rtol=1e-6), where
            assert {ours(name) for name in read} == names - {"id"}, where
            check_usd(read, wanted, where, exact=time % every == 0)


def check_moved(read: dict[str, Any], wanted: dict[str, Any], seconds: float) -> None:
    """Compare the extrapolated positions of points with those that velocities lead to; check the extents."""
    moved, extents = read.pop("moved"), read.pop("extent").reshape(-1, 2, 3)
    velocity = wanted["velocity"].astype(np.float64)
    np.testing.assert_allclose(moved, wanted["position"] + velocity * seconds, atol=1e-5)
    if len(wanted["id"]):
        np.testing.assert_array_less(extents[:, 0].min(axis=0), wanted["position"].min(axis=0) + 1e-6)
        np.testing.assert_array_less(wanted["position"].max(axis=0), extents[:, 1].max(axis=0) + 1e-6)
    else:
        assert (extents[:, 0] > extents[:, 1]).all(), "the extent of no points"


@pytest.mark.slow
@pytest.mark.parametrize("version", ["4.5", "5.0"])
@pytest.mark.parametrize(("name", "every"), [("all.usd", 1), ("fours.usd", 4)])
def test_blender_reads_what_gather_shows_at_and_between_frames(
    exports, shown, tmp_path, name, every, version
):
    read_by(f"blender-{version}", "blender.py", exports / name, tmp_path / "read.npz", *TIMES)
    found, counts = {}, {}
    for key, values in np.load(tmp_path / "read.npz").items():
        prim, time, attribute = key.split("|")
        owner = re.sub(r"_\d$", "", prim)
        if attribute == "count":
            counts[owner, time] = counts.get((owner, time), 0) + int(values)
        else:
            found[f"{owner}|{prim}|{time}|{attribute}"] = values
    assert {owner for owner, _ in counts} == set(SYSTEMS)
    for owner, system in SYSTEMS.items():
        names = written(exports, name, system)
        for time in TIMES:
            wanted = shown.get((system, int(time) // every * every))
            assert counts[owner, str(time)] == (0 if wanted is None else len(wanted["id"])), (owner, time)
            if not counts[owner, str(time)]:
                continue
            read = joined(found, owner, time)
            where = (version, owner, time)
            radius, ids = read.pop("radius", None), read.pop("id")
            assert (ids.reshape(-1) == wanted["id"]).all() and (radius is None) == ("size" not in names), (
                where
            )
            assert radius is None or np.allclose(radius[:, 0], wanted["size"][:, 0] / 2, rtol=1e-6), where
            assert {ours(name) for name in read} == names - {"id"}, where
            if "orientation" in read:  # w, x, y, z
                read["orientation"] = np.roll(read["orientation"], -1, axis=1)
            if "displayColor" in read:
                assert (read["displayColor"][:, 3] == 1).all(), where
                read["displayColor"] = np.ascontiguousarray(read["displayColor"][:, :3])
            check_usd(read, wanted, where, exact=time % every == 0)


# --- .pvd


def decoded(array: ElementTree.Element) -> Any:
    """Decode a DataArray in base64, without any code of motes."""
    assert array.get("format") == "binary"
    content = base64.b64decode(array.text or "", validate=True)
    assert int.from_bytes(content[:8], "little") == len(content) - 8
    kind = {"Float32": "<f4", "UInt64": "<u8", "Int32": "<i4"}[array.get("type", "")]
    return np.frombuffer(content[8:], kind).reshape(-1, int(array.get("NumberOfComponents", "1")))


def check_vtp(read: dict[str, Any], wanted: dict[str, Any], names: set[str], where: tuple[Any, ...]) -> None:
    """Compare the columns of a system in .vtp files with those that `gather` showed."""
    radius = read.pop("radius", None)
    assert (radius is None) == ("size" not in names), where
    assert radius is None or (radius.reshape(-1) == wanted["size"][:, 0] / 2).all(), where
    assert set(read) == names, where
    for name, values in read.items():
        assert same(values, wanted[name]), (*where, name)


@pytest.mark.parametrize("system", SYSTEMS)
def test_vtp_files_are_plain_xml_with_every_column(exports, shown, system):
    names = written(exports, "all.pvd", SYSTEMS[system])
    for frame in range(FRAMES):
        found = {}
        for path in (exports / "all.pvd.parts").glob(f"{system}.{frame:06d}.*.vtp"):
            text = path.read_text()
            root = ElementTree.fromstring(text)
            (piece,) = root.findall("./PolyData/Piece")
            assert root.attrib.keys() == {"type", "version", "byte_order", "header_type"}, "not compressed"
            assert text.startswith('<?xml version="1.0"?>\n<VTKFile '), "OVITO opens nothing else"
            assert "<FieldData" not in text[: text.index("</Piece>")]
            assert piece.get("NumberOfPoints") == piece.get("NumberOfVerts")
            rows = int(piece.get("NumberOfPoints", "-1"))
            columns = {array.get("Name"): decoded(array) for array in piece.findall("./PointData/DataArray")}
            (points,) = piece.findall("./Points/DataArray[@Name='Points']")
            columns["position"] = decoded(points)
            assert all(len(column) == rows for column in columns.values())
            cells = [decoded(array).reshape(-1) for array in piece.findall("./Verts/DataArray")]
            assert (cells[0] == range(rows)).all() and (cells[1] == range(1, rows + 1)).all()
            found |= {f"{system}|{path.name}|{frame}|{name}": column for name, column in columns.items()}
        wanted = shown.get((SYSTEMS[system], frame))
        assert (wanted is None) == (not found)
        if wanted is not None:
            check_vtp(joined(found, system, frame), wanted, names, (system, frame))


@pytest.mark.slow
def test_pyvista_reads_what_gather_shows(exports, shown, tmp_path):
    read_by("viewers", "viewer.py", exports / "all.pvd", tmp_path / "read.npz")
    found = dict(np.load(tmp_path / "read.npz"))
    for key in [key for key in found if key.endswith("|time")]:
        frame, times = int(key.split("|")[2]), found.pop(key)
        assert times == pytest.approx([(frame + 1) / 60] * 2)
    for key in [key for key in found if key.endswith("|cells")]:
        assert found.pop(key) == len(found[key.replace("|cells", "|id")])
    assert {tuple(map(str, key.split("|")[0:3:2])) for key in found} == {
        (owner, str(frame))
        for owner, system in SYSTEMS.items()
        for frame in range(FRAMES)
        if (system, frame) in shown
    }
    for (system, frame), wanted in shown.items():
        owner = system.replace(" ", "_")
        check_vtp(joined(found, owner, frame), wanted, written(exports, "all.pvd", system), (system, frame))


OVITO = {"Position": "position", "Particle Identifier": "id", "Mass": "mass", "Radius": "radius"}


@pytest.mark.slow
def test_ovito_reads_what_gather_shows(exports, shown, tmp_path):
    """Each file, and the frames of a system whose parts are joined; OVITO has numbers of its own kinds."""
    for system in ("grains", "drops of rain"):
        pack(exports / "all", tmp_path / f"{system[0]}.pvd", system=system)
    parts = sorted((exports / "all.pvd.parts").glob("*.vtp"))
    read_by("viewers", "atoms.py", tmp_path / "read.npz", *parts, *tmp_path.glob("*.pvd"))
    found: dict[str, Any] = {}
    for key, values in np.load(tmp_path / "read.npz").items():
        file, frame, name = key.split("|")
        owner, number, part = [*file.split(".")[:3]] if file.endswith("vtp") else (file, frame, "")
        if name != "Particle Type":
            found[f"{owner}|{part}|{int(number)}|{OVITO.get(name, name)}"] = values
    joint = [
        (system[0] + ".pvd", system, frame)
        for system in ("grains", "drops of rain")
        for frame in range(FRAMES)
    ]
    single = [(system.replace(" ", "_"), system, frame) for system, frame in shown]
    for owner, system, frame in [*joint, *single]:
        wanted, names = shown[system, frame], written(exports, "all.pvd", system)
        read = joined(found, owner, frame)
        kinds = {"id": np.uint64}
        read = {name: values.astype(kinds.get(name, np.float32)) for name, values in read.items()}
        check_vtp(
            read, wanted, names - {"Points"}, (owner, frame)
        )  # an attribute of that name is lost in OVITO
