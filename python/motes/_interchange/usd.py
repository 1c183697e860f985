"""Particles as USD: a layer (.usdc) per system, rank and frame, and a stage (.usd) that shows all of them.

Value clips join the layers over time: a stage opens at once, and a program reads only the frames that it
shows. Between two frames the stage holds the earlier one, because the same row may be another particle in
the next. Layers need usd-core; stages are text and need no library.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._particles import by_id
from .._shot.facts import ATTRIBUTES, Drawn, is_users
from .._shot.words import indented, quoted
from .clips import CLIPS, clipped, declared
from .format import Format
from .manifest import Column, Manifest, SystemColumns
from .shots import DRAWN, Looks

if TYPE_CHECKING:
    from .._shot.drawn import Drawing

__all__ = ["FORMAT"]

MARK = "Particles of motes"
PRIM = "/particles"  # path of the particles in each layer
_MOST_INT32 = 2**31 - 1

_NAMES = {
    "position": "points",
    "velocity": "velocities",
    "color": "primvars:displayColor",
    "alpha": "primvars:displayOpacity",
    "id": "ids",
}
_TYPES = {
    "position": "point3f[]",
    "velocity": "vector3f[]",
    "color": "color3f[]",
    "id": "int64[]",
    # x, y, z, w in memory here, too. Blender drops a float4[], and every attribute after it.
    "orientation": "quatf[]",
}
# Primvars of these names would be another column's, or would take precedence over it.
_TAKEN = ("displayColor", "displayOpacity", "id", "normals", "points", "velocities", "widths")
_NOWHERE = "[(3.4028235e38, 3.4028235e38, 3.4028235e38), (-3.4028235e38, -3.4028235e38, -3.4028235e38)]"
"""The extent of no points, as USD writes it."""


@cache
def begin() -> None:
    """Import USD and let it register its plugins.

    USD locks its registry while it waits for the interpreter. If two threads begin at once, one waits for
    that lock while it holds the interpreter, and neither continues.
    """
    _extras.usd_writer("an export to .usd").Sdf.Layer.CreateAnonymous(".usdc")


def write(
    path: Path,
    columns: Mapping[str, NDArray[Any]],
    *,
    frame: int,
    time: float,
    drawn: Drawing | Drawn | None = None,
) -> None:
    """Write columns, including `position` and `id`, into an existing file, sorted by id.

    All values are samples at one time code, the frame's number. `drawn`: what the system's sprite makes of
    them, or how it does so; a second prim holds that.
    """
    del time
    pxr = _extras.usd_writer("an export to .usd")
    _check_names(columns)
    layer = pxr.Sdf.Layer.CreateAnonymous(".usdc")
    put = _putter(pxr, layer, PRIM, "Points", frame)
    order = by_id.order(columns["id"])  # USD takes 20 times as long to store unsorted ids
    memory: dict[int, NDArray[np.uint8]] = {}  # scratch by column size: fresh pages cost more than the copy
    for name, given in columns.items():
        column = given
        if order is not None:
            if given.nbytes not in memory:
                memory[given.nbytes] = np.empty(given.nbytes, np.uint8)
            column = _taken(given, order, memory[given.nbytes])
        put(
            _name_of(name),
            _type_of(name, column.shape[1] if column.ndim == 2 else 1),
            column.view(np.int64) if name == "id" else column,
        )
        if name == "size":
            put("widths", "float[]", np.ascontiguousarray(column[:, 0]))
        if name == "id" and _fits_int32(column):
            put("primvars:id", "int[]", column.astype(np.int32))  # the only ids that Blender reads
    if len(columns["position"]):
        put("extent", "float3[]", _extent(columns["position"], columns.get("size")))
    if drawn is not None:
        _write_drawn(pxr, layer, columns, order, drawn, frame)
    if not layer.Export(str(path)):
        raise OSError(f"{path} could not be written")


def _putter(
    pxr: Any, layer: Any, path: str, kind_of_prim: str, frame: int
) -> Callable[[str, str, Any], None]:
    """Make a prim; return a function that gives it a sample of an attribute: name, type and values."""
    prim = pxr.Sdf.CreatePrimInLayer(layer, path)
    prim.specifier, prim.typeName = pxr.Sdf.SpecifierDef, kind_of_prim
    arrays = {"int": pxr.Vt.IntArray, "int64": pxr.Vt.Int64Array, "float": pxr.Vt.FloatArray}
    arrays |= {"quatf": pxr.Vt.QuatfArray, "quath": pxr.Vt.QuathArray, "color4f": pxr.Vt.Vec4fArray}

    def put(name: str, kind: str, values: Any) -> None:
        attribute = pxr.Sdf.AttributeSpec(prim, name, pxr.Sdf.ValueTypeNames.Find(kind))
        if isinstance(values, np.ndarray):
            values = arrays.get(kind[:-2], pxr.Vt.Vec3fArray).FromNumpy(np.ascontiguousarray(values))
        layer.SetTimeSample(attribute.path, float(frame), values)

    return put


def _write_drawn(
    pxr: Any,
    layer: Any,
    columns: Mapping[str, NDArray[Any]],
    order: NDArray[np.int64] | None,
    drawn: Drawing | Drawn,
    frame: int,
) -> None:
    if isinstance(drawn, Drawn):
        made = drawn
    else:
        known = {**columns, **drawn.columns}
        made = drawn.draw(known if order is None else {name: one[order] for name, one in known.items()})
        for name in filter(is_users, columns):
            rows = columns[name] if order is None else columns[name][order]
            kind = _type_of(name, rows.shape[1] if rows.ndim == 2 else 1)
            made.values[_name_of(name)] = kind, rows
    put = _putter(pxr, layer, DRAWN, made.form, frame)
    for name, (kind, values) in made.values.items():
        put(name, kind, values)


def drawn_in(path: Path, frame: int) -> Drawn:
    """Return what sprites made of a part, to be written again."""
    pxr = _extras.usd_writer("an export to .usd")
    layer = pxr.Sdf.Layer.OpenAsAnonymous(str(path))
    prim = layer.GetPrimAtPath(DRAWN)
    values = {
        one.name: (str(one.typeName), layer.QueryTimeSample(one.path, float(frame)))
        for one in prim.attributes
    }
    return Drawn(prim.typeName, values)


def read(path: Path, names: Iterable[str] | None, *, frame: int) -> dict[str, NDArray[Any]]:
    """Read the named columns. Raises OSError, ValueError or KeyError."""
    pxr = _extras.usd("reading .usd")
    try:
        layer = pxr.Sdf.Layer.OpenAsAnonymous(str(path))
    except pxr.Tf.ErrorException as error:
        raise ValueError(str(error)) from error
    columns = {}
    for name in names or ():
        # Earlier exports had a primvar for each attribute of the user, whatever its name.
        paths = [f"{PRIM}.{known}" for known in (_name_of(name), f"primvars:{name}")]
        samples = (layer.QueryTimeSample(path, float(frame)) for path in paths)
        sample = next((one for one in samples if one is not None), None)
        if sample is None:
            raise KeyError(name)
        values = np.array(sample)  # a copy, since the sample owns its memory
        columns[name] = values.view(np.uint64) if name == "id" else values
    return columns


def clips(system: SystemColumns) -> bytes:
    """Return the clip manifest, which declares the attributes that vary over time.

    Without it USD would open all files to find them. Its values, those of no particles, stand for what a
    layer lacks; as a layer of its own it stands for frames without a file.
    """
    lines = _attributes(system.columns, valued=True)
    text = f'#usda 1.0\n\ndef Points "{PRIM[1:]}"\n{{\n{indented(lines)}\n}}\n'
    if system.drawn:
        kinds = {name: kind for form in ATTRIBUTES.values() for name, kind in form.items()}
        kinds |= {name: kind for kind, name in primvars(system)}
        lines = [f"{kind} {name} = {_NOWHERE if name == 'extent' else '[]'}" for name, kind in kinds.items()]
        text += f'\ndef "{DRAWN[1:]}"\n{{\n{indented(lines)}\n}}\n'
    return text.encode()


def stage(manifest: Manifest, folder: str) -> bytes:
    """Return the stage, which shows the particles of all systems and ranks at each frame's number."""
    frames = manifest.frames
    first, last = (frames[0].frame, frames[-1].frame) if frames else (0, 0)
    rate = repr(round(1 / manifest.dt, 9))  # 1 / (1 / 49) is not 49
    head = [
        "#usda 1.0",
        "(",
        f'    doc = "{MARK}"',
        '    defaultPrim = "World"',
        f"    endTimeCode = {last}",
        f"    framesPerSecond = {rate}",
        "    metersPerUnit = 1",
        f"    startTimeCode = {first}",
        f"    timeCodesPerSecond = {rate}",
        '    upAxis = "Y"',
        ")",
        "",
        'def Xform "World"',
        "{",
    ]
    looks = Looks(frames, manifest.systems)
    # By system, rank, and the look of its sprite, if scenes are written.
    files: dict[tuple[int, int | None, int], dict[int, str]] = {}
    for frame in frames:
        for part in frame.parts:
            look = looks.number(part.system, frame.scene)
            files.setdefault((part.system, part.rank, look), {})[frame.frame] = part.file
    numbers = [frame.frame for frame in frames]
    for number, system in enumerate(manifest.systems):
        head += [
            f'    def Xform "{system.stem}" (',
            f"        displayName = {quoted(system.name)}",
            "    )",
            "    {",
        ]
        parts = [(look, own) for (owner, _, look), own in files.items() if owner == number]
        # Prim paths do not name ranks, so bindings made in other programs stay valid.
        for count, (look, own) in enumerate(parts, 1):
            prim = system.stem if count == 1 else f"{system.stem}_{count}"
            shown = [(frame, own.get(frame, system.stem + CLIPS)) for frame in numbers]
            if look < 0:
                lines = clipped("Points", prim, PRIM, _attributes(system.columns), system.stem, shown, folder)
            else:
                lines = looks.prim(prim, number, look, primvars(system), shown, folder)
            head.append(indented(lines, 8))
        head.append("    }")
    head += [f"    {line}" for line in looks.scenery(folder)]
    return "\n".join([*head, "}", *looks.settings(), ""]).encode()


def _attributes(columns: list[Column], *, valued: bool = False) -> list[str]:
    """Declare the attributes in the files, with or without values; interpolation cannot come from clips."""
    kinds = {"ids": "int64[]", "primvars:id": "int[]"}
    for column in columns:
        if column.since is not None:
            kinds[_name_of(column.name)] = _type_of(column.name, column.width)
            if column.name == "size":
                kinds["widths"] = "float[]"
    value, box = (" = []", f" = {_NOWHERE}") if valued else ("", "")
    lines = [f"float3[] extent{box}"]
    for name, kind in kinds.items():
        varies = name == "widths" or name.startswith("primvars:")
        lines += declared(kind, f"{name}{value}", "vertex" if varies else "")
    return lines


def primvars(system: SystemColumns) -> list[tuple[str, str]]:
    """Return types and names of the primvars of a system's own columns."""
    own = [one for one in system.used if is_users(one.name)]
    return [(_type_of(one.name, one.width), _name_of(one.name)) for one in own]


def _taken(column: NDArray[Any], order: NDArray[np.int64], memory: NDArray[np.uint8]) -> NDArray[Any]:
    from .. import _core  # not at the top: reading files needs no engine

    rows = memory.view(column.dtype).reshape(column.shape)
    _core.take_rows(column, order, rows)
    return rows


def _extent(position: NDArray[Any], size: NDArray[Any] | None) -> NDArray[Any]:
    """Return the lowest and the highest corner of the box around points, half their sizes included.

    Matches `UsdGeomPoints`. NaN is ignored unless a coordinate is NaN for all points.
    """
    half = np.float32(0) if size is None else np.abs(size[:, 0]) / 2
    axes = [position[:, c] for c in range(3)]
    with np.errstate(invalid="ignore", over="ignore"):  # infinite positions, sizes
        low = [np.fmin.reduce(axis - half) for axis in axes]
        high = [np.fmax.reduce(axis + half) for axis in axes]
    return np.array([low, high], np.float32)


def _name_of(column: str) -> str:
    """Return the name of an attribute in USD; a column of another program's file may have any name."""
    legal = re.sub(r"[^A-Za-z0-9_]|^(?=\d)", "_", column) + "_" * (column in _TAKEN)
    return _NAMES.get(column, f"primvars:{legal}")


def _check_names(columns: Iterable[str]) -> None:
    """Raise ValueError if two columns would be one attribute."""
    known: dict[str, str] = {}
    for column in columns:
        other = known.setdefault(_name_of(column), column)
        if other != column:
            raise ValueError(f"columns {other!r} and {column!r} have one name in USD, {_name_of(column)}")


def _type_of(column: str, width: int) -> str:
    return _TYPES.get(column, {1: "float[]", 3: "vector3f[]", 4: "color4f[]"}[width])


def _fits_int32(ids: NDArray[Any]) -> bool:
    return not len(ids) or int(ids.max()) <= _MOST_INT32


FORMAT = Format(
    *("usdc", ".usd", write, read, stage, MARK),
    beside={CLIPS: clips},
    require=lambda: _extras.require_usd("an export to .usd"),
    begin=begin,
    drawn=drawn_in,
    mistaken=(".usda", ".usdc"),
)
