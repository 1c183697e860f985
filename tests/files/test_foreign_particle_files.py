"""Particle files of other programs, and hostile ones: read correctly, or rejected with one error type."""

from __future__ import annotations

import base64
import io
import json
import lzma
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motes
from motes import MotesError
from motes.cli import main

COUNT = 1000
DICE = np.random.default_rng(5)
COLUMNS = {
    "Points": DICE.normal(size=(COUNT, 3)).astype(np.float32),
    "heat": DICE.random(COUNT),
    "id": DICE.permutation(COUNT).astype(np.int64),
    "flag": DICE.integers(0, 9, COUNT).astype(np.uint8),
    "velocity": DICE.normal(size=(COUNT, 3)),
}
PACKERS = {"vtkZLibDataCompressor": zlib.compress, "vtkLZMADataCompressor": lzma.compress}
BLOCK = 700  # bytes; gives several blocks, the last one shorter


def encoded(content: bytes, length: np.dtype[Any], packer: str | None, text: bool) -> bytes:
    """Return an array's bytes as VTK writes them."""

    def said(part: bytes) -> bytes:
        return base64.b64encode(part) if text else part

    if packer is None:
        return said(np.array([len(content)], length).tobytes() + content)
    blocks = [content[at : at + BLOCK] for at in range(0, len(content), BLOCK)]
    packed = [PACKERS[packer](block) for block in blocks]
    head = [len(blocks), BLOCK, len(blocks[-1]) % BLOCK, *map(len, packed)]
    return said(np.array(head, length).tobytes()) + said(b"".join(packed))


def vtp(
    form: str = "appended",
    *,
    text: bool = False,
    packer: str | None = None,
    order: str = "<",
    wide: bool = False,
) -> bytes:
    """Write COLUMNS as VTK does, in two pieces."""
    length = np.dtype(order + ("u8" if wide else "u4"))
    appended = b""
    pieces = ""
    for rows in (slice(0, 300), slice(300, None)):
        said = {}
        for name, column in COLUMNS.items():
            part = column[rows]
            kind = {"f": "Float", "i": "Int", "u": "UInt"}[part.dtype.kind] + str(part.itemsize * 8)
            head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{part.size // len(part)}" '
            content = part.astype(part.dtype.newbyteorder(order)).tobytes()
            if form == "ascii":
                said[name] = (
                    f'{head} format="ascii">\n{" ".join(map(repr, part.reshape(-1).tolist()))}\n</DataArray>'
                )
            elif form == "binary":
                body = encoded(content, length, packer, True).decode()
                said[name] = f'{head} format="binary">\n  {body}\n</DataArray>'
            else:
                said[name] = f'{head} format="appended" offset="{len(appended)}"/>'
                appended += encoded(content, length, packer, text)
        points = said.pop("Points")
        pieces += f'<Piece NumberOfPoints="{len(part)}"><PointData>{"".join(said.values())}</PointData>'
        pieces += f"<Points>{points}</Points></Piece>"
    byte_order = "LittleEndian" if order == "<" else "BigEndian"
    packed = f' compressor="{packer}"' if packer else ""
    header = f' header_type="{"UInt64" if wide else "UInt32"}"'
    made = f'<VTKFile type="PolyData" version="0.1" byte_order="{byte_order}"{header}{packed}>'
    made += f"<PolyData>{pieces}</PolyData>"
    if form == "appended":
        made += f'<AppendedData encoding="{"base64" if text else "raw"}">\n   _'
        return made.encode() + appended + b"\n</AppendedData></VTKFile>"
    return made.encode() + b"</VTKFile>"


@pytest.mark.parametrize("packer", [None, *PACKERS])
@pytest.mark.parametrize(
    ("form", "text"), [("ascii", False), ("binary", True), ("appended", False), ("appended", True)]
)
@pytest.mark.parametrize(("order", "wide"), [("<", False), (">", True), ("<", True)])
def test_what_vtk_writes_is_read(tmp_path, form, text, packer, order, wide):
    (tmp_path / "a.vtp").write_bytes(vtp(form, text=text, packer=packer, order=order, wide=wide))
    read = motes.open_particles(tmp_path / "a.vtp")[0]
    sort = np.argsort(COLUMNS["id"])
    np.testing.assert_array_equal(read.id, np.arange(COUNT))
    np.testing.assert_array_equal(read.position, COLUMNS["Points"][sort])
    for name in ("heat", "flag", "velocity"):
        np.testing.assert_array_equal(getattr(read, name), COLUMNS[name][sort].astype(np.float32))


SMALL = b"""<VTKFile type="PolyData" byte_order="LittleEndian" compressor="X"><PolyData>
<Piece NumberOfPoints="1"><Points>
<DataArray type="Float32" Name="Points" NumberOfComponents="3" format="ascii">1 2 3</DataArray></Points>
<PointData><DataArray type="Float32" Name="h" format="ascii">4</DataArray></PointData>
</Piece></PolyData></VTKFile>"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"", b"", ""),
        (b'"3"', b'"0"', "'Points' has 0 components"),
        (b'"3"', b'"-1"', "NumberOfComponents is '-1', not a whole number"),
        (b'"3"', b'"x"', "NumberOfComponents is 'x'"),
        (b'NumberOfPoints="1"', b'NumberOfPoints="-1"', "NumberOfPoints is '-1'"),
        (b'NumberOfPoints="1"', b'NumberOfPoints="999999999999999"', "cut short"),
        (b"1 2 3", b"1 2", "cut short: 2 of 3"),
        (b"1 2 3", b"1 2 z", "could not convert"),
        (b'Name="h" format="ascii"', b'Name="h" format="binary"', "packed by X is not supported"),
        (
            b'Name="h" format="ascii"',
            b'Name="h" format="appended" offset="0"',
            "packed by X is not supported",
        ),
        (b'Name="h" format="ascii"', b'Name="h" format="hex"', "format 'hex', which is not supported"),
        (b"LittleEndian", b"Middle", "byte order is 'Middle'"),
        (b"PolyData>", b"Grid>", "it has no PolyData with a piece"),
        (b"</VTKFile>", b"", "no element found"),
        (b'Name="h" ', b'Name="h" NumberOfComponents="3" ', "cut short"),
        (b'Name="h" ', b'Name="h" NumberOfComponents="2.0" ', "NumberOfComponents is '2.0'"),
        (b'"Float32" Name="Points"', b'"String" Name="Points"', "'Points' is of type 'String'"),
        (b'"Points" NumberOfComponents="3"', b'"Points" NumberOfComponents="2"', "cut short: 3 of 2"),
        (b'Name="h"', b'Name="id"', "'id' is float32 .1,.; ids are whole numbers"),
    ],
)
def test_a_damaged_vtp_is_one_error_with_its_reason(tmp_path, old, new, message):
    (tmp_path / "a.vtp").write_bytes(SMALL.replace(old, new))
    if not message:
        assert motes.open_particles(tmp_path / "a.vtp")[0].h.tolist() == [4]
        return
    with pytest.raises(MotesError, match=f"a.vtp cannot be read: .*{message}"):
        motes.open_particles(tmp_path / "a.vtp")


ODD = b"""<Array type="String" Name="label" format="ascii">97 0</Array>
<DataArray type="Float64" Name="stress" NumberOfComponents="2" format="binary">x</DataArray>
<DataArray type="String" Name="species" NumberOfComponents="1" format="appended" offset="7"/>
<DataArray type="Float32" Name="tensor" NumberOfComponents="9" format="ascii">0 0 0 0 0 0 0 0 0</DataArray>
</PointData>"""


def test_columns_of_a_vtp_that_particles_cannot_have_are_left_out_and_named(tmp_path):
    (tmp_path / "a.vtp").write_bytes(SMALL.replace(b"</PointData>", ODD))
    with pytest.warns(motes.MotesWarning, match="is left out") as warned:
        read = motes.open_particles(tmp_path / "a.vtp")[0]
    assert read.h.tolist() == [4] and read.position.tolist() == [[1, 2, 3]]
    assert sorted(read.columns()) == ["h", "position"]
    told = sorted(str(one.message).removeprefix(f"{tmp_path / 'a.vtp'}: column ") for one in warned)
    assert [text.split(";")[0] for text in told] == [
        "'label' is left out: it has values of type String",
        "'species' is left out: it has values of type String",
        "'stress' is left out: it has 2 numbers per particle",
        "'tensor' is left out: it has 9 numbers per particle",
    ]
    assert all(one.filename == __file__ for one in warned), "the warning is at the caller's line"


def test_columns_of_an_npz_that_particles_cannot_have_are_left_out_and_named(tmp_path):
    odd = {"label": np.array(["a", "b"]), "uv": np.zeros((2, 2)), "on": np.array([True, False])}
    np.savez(tmp_path / "a.npz", position=np.ones((2, 3)), heat=np.arange(2), cube=np.zeros((2, 3, 3)), **odd)
    with pytest.warns(motes.MotesWarning, match="is left out") as warned:
        read = motes.open_particles(tmp_path / "a.npz")[0]
    assert sorted(read.columns()) == ["heat", "position"] and read.heat.tolist() == [0, 1]
    told = " ".join(str(one.message) for one in warned)
    assert len(warned) == 4 and all(f"column {name!r} is left out" in told for name in (*odd, "cube"))


@pytest.mark.parametrize("name", ["position", "P", "id"])
def test_a_file_whose_positions_or_ids_cannot_be_read_is_refused(tmp_path, name):
    np.savez(tmp_path / "a.npz", **{name: np.zeros((2, 2)), "heat": np.zeros(2)})
    with pytest.raises(MotesError, match=rf"{name!r} is float64 \(2, 2\); columns are numbers"):
        motes.open_particles(tmp_path / "a.npz")


def npy(head: str, content: bytes = b"") -> bytes:
    text = head.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + content


def npz(**entries: bytes) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, content in entries.items():
            archive.writestr(f"{name}.npy", content)
    return made.getvalue()


def damaged(content: bytes, at: int) -> bytes:
    return content[:at] + bytes([content[at] ^ 0xFF]) + content[at + 1 :]


HUGE = "{'descr': '<f4', 'fortran_order': False, 'shape': (%d, 3), }"
NPZ: dict[str, bytes] = {
    "an array of one file": npy("{'descr': '<f4', 'fortran_order': False, 'shape': (1,), }", bytes(4)),
    "more than memory": npz(position=npy(HUGE % 10**15)),
    "more than any number": npz(position=npy(HUGE % 10**40)),
    "less than nothing": npz(position=npy(HUGE % -5)),
    "objects": npz(
        position=npy("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }", b"cos\nsystem\n.")
    ),
    "no header": npz(position=b"x"),
    "brackets": npz(position=npy("(" * 110)),
    "an unknown way to pack": damaged(npz(position=b"x" * 40), 8),
    "text": b"no archive",
    "nothing": b"",
    "no column": npz(),
    "one number": npz(position=npy("{'descr': '<f4', 'fortran_order': False, 'shape': (), }", bytes(4))),
    "text as numbers": npz(
        position=npy("{'descr': '<U1', 'fortran_order': False, 'shape': (1,), }", bytes(4))
    ),
    "ids below 0": npz(id=npy("{'descr': '<i4', 'fortran_order': False, 'shape': (1,), }", b"\xff" * 4)),
    "ids that are no numbers": npz(
        id=npy("{'descr': '<f4', 'fortran_order': False, 'shape': (1,), }", b"\xff" * 4)
    ),
}


@pytest.mark.parametrize("name", NPZ)
def test_a_damaged_npz_is_one_error_with_a_sentence(tmp_path, name):
    (tmp_path / "a.npz").write_bytes(NPZ[name])
    with pytest.raises(MotesError, match=r"a\.npz cannot be read: ."):
        motes.open_particles(tmp_path / "a.npz")


def manifest(**changed: Any) -> str:
    column = {"name": "position", "width": 3, "initial": [0, 0, 0], "since": 0}
    system = {"name": "s", "stem": "s", "columns": [column]}
    said = {
        **{"format": "motes particles", "version": 1, "kind": "npz", "seed": 1, "dt": 0.1, "every": 1},
        **{"systems": [system], "frames": [{"frame": 0, "time": 0, "parts": [[0, 0, "s.npz", 1, 9]]}]},
        **{"announced": [], "finished": True},
    }
    return json.dumps({**said, **changed})


SYSTEM = json.loads(manifest())["systems"][0]
PART = {"frame": 0, "time": 0}


@pytest.mark.parametrize(
    "text",
    [
        manifest(dt=float("inf"), every=float("inf")),
        manifest(seed=float("nan")),
        manifest(frames=[{"frame": float("inf"), "time": 0, "parts": []}]),
        manifest(frames=[{**PART, "parts": [[-1, 0, "s.npz", 1, 9]]}]),
        manifest(frames=[{**PART, "parts": [[0, 0, "../s.npz", 1, 9]]}]),
        manifest(systems=[{**SYSTEM, "stem": "../s"}]),
        manifest(systems=[{**SYSTEM, "stem": 's" { }'}]),
        manifest(systems=3),
        manifest(frames={"a": 1}),
        "[" * 100_000,
    ],
)
def test_a_damaged_manifest_is_one_error(tmp_path, text):
    (tmp_path / "e").mkdir()
    (tmp_path / "e" / "manifest.json").write_text(text)
    with pytest.raises(MotesError, match="is damaged|cannot be read"):
        motes.open_particles(tmp_path / "e")


def test_pack_writes_nowhere_else_for_a_hostile_export(tmp_path, capsys):
    (tmp_path / "e").mkdir()
    np.savez(tmp_path / "e" / "s.npz", position=np.zeros((1, 3), "f4"), id=np.zeros(1, "u8"))
    (tmp_path / "e" / "manifest.json").write_text(manifest(systems=[{**SYSTEM, "stem": "../../out"}]))
    assert main(["pack", str(tmp_path / "e"), "-o", str(tmp_path / "packed")]) == 2
    assert "stem" in capsys.readouterr().err
    assert sorted(path.name for path in Path(tmp_path).iterdir()) == ["e"]


def test_houdinis_names_become_ours(tmp_path):
    dice = np.random.default_rng(2)
    columns = {"P": dice.random((9, 3)), "v": dice.random((9, 3)), "Cd": dice.random((9, 3))}
    more = {"pscale": dice.random(9), "Alpha": dice.random(9), "life": dice.random(9), "heat": dice.random(9)}
    np.savez(tmp_path / "a.npz", **columns, **more)
    read = motes.open_particles(tmp_path / "a.npz")[0]
    world = motes.World(seed=1, progress="off")
    system = world.system("s", attributes={"heat": 0.0})
    with world:
        system.emit(read)
        world.step()
        born = system.gather()
    for name, column in (
        *(("position", columns["P"]), ("velocity", columns["v"]), ("color", columns["Cd"])),
        *(("alpha", more["Alpha"]), ("lifetime", more["life"]), ("heat", more["heat"])),
        ("size", np.repeat(2 * more["pscale"][:, None], 3, axis=1)),
    ):
        np.testing.assert_array_equal(getattr(born, name), column.astype(np.float32))
    np.savez(tmp_path / "b.npz", position=columns["P"], P=columns["v"])
    assert sorted(motes.open_particles(tmp_path / "b.npz")[0].columns()) == ["P", "position"]


@pytest.mark.parametrize(
    ("column", "message"),
    [
        (
            {"heat": np.zeros(1)},
            r"declare it, world.system\('s', attributes={'heat': 0.0}\), or leave it out, .*'heat'",
        ),
        ({"dir": np.zeros((1, 3))}, r"attributes={'dir': \(0, 0, 0\)}"),
        ({"velocty": np.zeros((1, 3))}, "did you mean 'velocity'"),
        ({"Cd": np.zeros((1, 3))}, r"column must be named as in motes: emit\(color=...\), got 'Cd'"),
    ],
)
def test_a_column_that_the_system_lacks_says_what_to_do(column, message):
    system = motes.World(seed=1, progress="off").system("s")
    with pytest.raises(motes.ArgumentError, match=message):
        system.emit(position=[(0, 0, 0)], **column)
