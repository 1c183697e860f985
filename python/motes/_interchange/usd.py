"""Particles as USD: a layer (.usdc) per system, rank and frame, and a stage (.usd) that shows all of them.

Value clips join the layers over time: a stage opens at once, and a program reads only the frames that it
shows. Layers need usd-core; stages are text and need no library.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._particles import by_id
from .format import Format
from .manifest import Column, Manifest, SystemColumns

__all__ = ["FORMAT"]

MARK = "Particles of motes"
CLIPS = ".clips.usda"
NONE = ".none.usda"
PRIM = "/particles"  # path of the particles in each layer
_MOST_INT32 = 2**31 - 1

_NAMES = {
    "position": "points",
    "velocity": "velocities",
    "color": "primvars:displayColor",
    "alpha": "primvars:displayOpacity",
    "id": "ids",
}
_TYPES = {"position": "point3f[]", "velocity": "vector3f[]", "color": "color3f[]", "id": "int64[]"}


@cache
def begin() -> None:
    """Import USD and let it register its plugins.

    USD locks its registry while it waits for the interpreter. If two threads begin at once, one waits for
    that lock while it holds the interpreter, and neither continues.
    """
    _extras.usd_writer("an export to .usd").Sdf.Layer.CreateAnonymous(".usdc")


def write(path: Path, columns: Mapping[str, NDArray[Any]], *, frame: int, time: float) -> None:
    """Write columns, including `position` and `id`, into an existing file, sorted by id.

    All values are samples at one time code, the frame's number.
    """
    del time
    pxr = _extras.usd_writer("an export to .usd")
    layer = pxr.Sdf.Layer.CreateAnonymous(".usdc")
    prim = pxr.Sdf.CreatePrimInLayer(layer, PRIM)
    prim.specifier, prim.typeName = pxr.Sdf.SpecifierDef, "Points"

    def put(name: str, kind: str, values: NDArray[Any]) -> None:
        known = pxr.Sdf.ValueTypeNames.Find(kind)
        attribute = pxr.Sdf.AttributeSpec(prim, name, known)
        arrays = {"int": pxr.Vt.IntArray, "int64": pxr.Vt.Int64Array, "float": pxr.Vt.FloatArray}
        arrays["float4"] = pxr.Vt.Vec4fArray
        array = arrays.get(kind[:-2], pxr.Vt.Vec3fArray)
        layer.SetTimeSample(attribute.path, float(frame), array.FromNumpy(values))

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
    if not layer.Export(str(path)):
        raise OSError(f"{path} could not be written")


def read(path: Path, names: Iterable[str] | None, *, frame: int) -> dict[str, NDArray[Any]]:
    """Read the named columns. Raises OSError, ValueError or KeyError."""
    pxr = _extras.usd("reading .usd")
    try:
        layer = pxr.Sdf.Layer.OpenAsAnonymous(str(path))
    except pxr.Tf.ErrorException as error:
        raise ValueError(str(error)) from error
    columns = {}
    for name in names or ():
        sample = layer.QueryTimeSample(f"{PRIM}.{_name_of(name)}", float(frame))
        if sample is None:
            raise KeyError(name)
        values = np.array(sample)  # a copy, since the sample owns its memory
        columns[name] = values.view(np.uint64) if name == "id" else values
    return columns


def clips(system: SystemColumns) -> bytes:
    """Return the clip manifest, which declares the attributes that vary over time.

    Without it USD would open all files to find them.
    """
    lines = [*_attributes(system.columns)]
    return f'#usda 1.0\n\ndef Points "{PRIM[1:]}"\n{{\n{_indented(lines)}\n}}\n'.encode()


def none(system: SystemColumns) -> bytes:
    """Return a clip without particles, for frames in which a rank has no file.

    Otherwise USD would show that rank's nearest frame, after a run has continued on other ranks.
    """
    columns = [("ids", "int64[]"), ("primvars:id", "int[]"), ("widths", "float[]")]
    columns += [(_name_of(one.name), _type_of(one.name, one.width)) for one in system.columns]
    lines = [f"{kind} {name}.timeSamples = {{ 0: [] }}" for name, kind in columns]
    return f'#usda 1.0\n\ndef Points "{PRIM[1:]}"\n{{\n{_indented(lines)}\n}}\n'.encode()


def stage(manifest: Manifest, folder: str) -> bytes:
    """Return the stage, which shows the particles of all systems and ranks at each frame's number."""
    frames = manifest.frames
    first, last = (frames[0].frame, frames[-1].frame) if frames else (0, 0)
    rate = repr(1 / manifest.dt)
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
    writers = dict.fromkeys((part.system, part.rank) for frame in frames for part in frame.parts)
    files: dict[tuple[int, int | None], list[tuple[int, str]]] = {writer: [] for writer in writers}
    for frame in frames:
        there = {(part.system, part.rank): part.file for part in frame.parts}
        for (number, rank), own in files.items():
            own.append((frame.frame, there.get((number, rank), manifest.systems[number].stem + NONE)))
    for number, system in enumerate(manifest.systems):
        head += [
            f'    def Xform "{system.stem}" (',
            f"        displayName = {_text(system.name)}",
            "    )",
            "    {",
        ]
        parts = [own for (owner, _), own in files.items() if owner == number]
        # Prim paths do not name ranks, so bindings made in other programs stay valid.
        for count, own in enumerate(parts, 1):
            prim = "particles" if count == 1 else f"particles_{count}"
            head.append(_indented(_points(prim, system, own, folder), 8))
        head.append("    }")
    return "\n".join([*head, "}", ""]).encode()


def _points(prim: str, system: SystemColumns, files: list[tuple[int, str]], folder: str) -> list[str]:
    assets = ", ".join(_asset(folder, file) for _, file in files)
    active = ", ".join(f"({frame}, {k})" for k, (frame, _) in enumerate(files))
    times = ", ".join(f"({frame}, {frame})" for frame, _ in files)
    return [
        f'def Points "{prim}" (',
        "    clips = {",
        "        dictionary default = {",
        f"            double2[] active = [{active}]",
        f"            asset[] assetPaths = [{assets}]",
        f"            asset manifestAssetPath = {_asset(folder, system.stem + CLIPS)}",
        f'            string primPath = "{PRIM}"',
        f"            double2[] times = [{times}]",
        "        }",
        "    }",
        ")",
        "{",
        *(f"    {line}" for line in _attributes(system.columns)),
        "}",
    ]


def _attributes(columns: list[Column]) -> list[str]:
    """Declare the attributes in the files, without values; interpolation cannot come from clips."""
    said = ["float3[] extent", "int64[] ids", 'int[] primvars:id (\n    interpolation = "vertex"\n)']
    for column in columns:
        if column.since is None:
            continue
        name, kind = _name_of(column.name), _type_of(column.name, column.width)
        varies = name.startswith("primvars:")
        said.append(f"{kind} {name}" + (' (\n    interpolation = "vertex"\n)' if varies else ""))
        if column.name == "size":
            said.append('float[] widths (\n    interpolation = "vertex"\n)')
    return [line for declared in said for line in declared.split("\n")]


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
    return _NAMES.get(column, f"primvars:{column}")


def _type_of(column: str, width: int) -> str:
    return _TYPES.get(column, {1: "float[]", 3: "vector3f[]", 4: "float4[]"}[width])


def _fits_int32(ids: NDArray[Any]) -> bool:
    return not len(ids) or int(ids.max()) <= _MOST_INT32


def _asset(folder: str, file: str) -> str:
    around = "@@@" if "@" in folder else "@"
    return f"{around}./{folder}/{file}{around}"


def _text(value: str) -> str:
    return json.dumps(
        "".join(letter if letter.isprintable() else " " for letter in value), ensure_ascii=False
    )


def _indented(lines: list[str], by: int = 4) -> str:
    return "\n".join(" " * by + line for line in lines)


FORMAT = Format(
    *("usdc", ".usd", write, read, stage, MARK),
    beside={CLIPS: clips, NONE: none},
    require=lambda: _extras.require_usd("an export to .usd"),
    begin=begin,
    mistaken=(".usda", ".usdc"),
)
