"""Reads USD: the visible meshes of a stage at a time, in metres and with y up, and their materials."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import _extras
from .._values.images import picture_in
from .._values.materials import Material
from ..errors import ArgumentError
from .gltf_materials import MOST_SIDE, with_materials
from .polygons import Floats, Indices, Unreadable, triangulate
from .surfaces import Surface, moved

__all__ = ["Stage", "read"]

NEED = "reading .usd"
_MOTION = ("translations", "rotations", "scales", "blendShapeWeights")


class Stage:
    """An open stage, and a time code of it."""

    def __init__(self, path: Path, time: float | None) -> None:
        """Open a file; `time`: seconds after its start, None: the first time at which it has values."""
        pxr = _extras.usd_stages(NEED)
        self.pxr = pxr
        try:
            self.stage = pxr.Usd.Stage.Open(str(path))
        except pxr.Tf.ErrorException as error:
            raise Unreadable(str(error).strip().splitlines()[-1].strip()) from None
        self.per_second = self.stage.GetTimeCodesPerSecond()
        self.start = self.stage.GetStartTimeCode()
        self.code = pxr.Usd.TimeCode.EarliestTime() if time is None else self.code_of(time)

    def code_of(self, time: float) -> Any:
        """Return the time code at a time, s after the start."""
        return self.pxr.Usd.TimeCode(self.start + time * self.per_second)

    def in_world(self, prim: Any, code: Any) -> Floats:
        """Return the transform of a prim, (4, 4), with axes and position as columns, in metres with y up."""
        geom = self.pxr.UsdGeom
        place = np.array(geom.Imageable(prim).ComputeLocalToWorldTransform(code)).T
        if geom.GetStageUpAxis(self.stage) == geom.Tokens.z:
            place = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]) @ place
        place[:3] *= self.metres
        return place

    @property
    def metres(self) -> float:
        """Metres per unit of the file."""
        return float(self.pxr.UsdGeom.GetStageMetersPerUnit(self.stage))

    def prims(self, kind: Any) -> Iterator[Any]:
        """Yield the visible prims of a type; the prototypes of instances are not seen themselves."""
        usd, geom = self.pxr.Usd, self.pxr.UsdGeom
        found = iter(usd.PrimRange.Stage(self.stage, usd.TraverseInstanceProxies()))
        for prim in found:
            if prim.IsA(geom.PointInstancer):
                found.PruneChildren()
            elif prim.IsA(kind):
                image = geom.Imageable(prim)
                shown = image.ComputeVisibility(self.code) != geom.Tokens.invisible
                if shown and image.ComputePurpose() in (geom.Tokens.default_, geom.Tokens.render):
                    yield prim


def read(path: Path, content: bytes, time: float | None = None) -> Surface:
    """Return the surface of a stage. Raises Unreadable."""
    del content  # USD reads other files besides
    stage = Stage(path, time)
    _bake_skins(stage)
    parts, materials = [], []
    for prim in stage.prims(stage.pxr.UsdGeom.Mesh):
        part = _part(stage, prim)
        if len(part.triangles):
            parts.append(moved(part, stage.in_world(prim, stage.code)))
            materials.append(_material(stage, prim))
    return with_materials(parts, materials)


def _bake_skins(stage: Stage) -> None:
    """Let bones move the points of meshes, in memory."""
    pxr = stage.pxr
    if any(prim.IsA(pxr.UsdSkel.Root) for prim in stage.stage.Traverse()):
        own = stage.stage.GetSessionLayer()
        own.timeCodesPerSecond = stage.per_second  # or USD maps times from 24 per second
        stage.stage.SetEditTarget(own)
        code = stage.start if stage.code.IsEarliestTime() else stage.code.GetValue()
        # USD bakes at the times of samples, so there has to be one.
        for prim in stage.stage.Traverse():
            for name in _MOTION if prim.IsA(pxr.UsdSkel.Animation) else ():
                attribute = prim.GetAttribute(name)
                if (value := attribute.Get(code)) is not None:
                    attribute.Set(value, code)
        pxr.UsdSkel.BakeSkinning(stage.stage.Traverse(), pxr.Gf.Interval(code, code))


def _part(stage: Stage, prim: Any) -> Surface:
    geom, code = stage.pxr.UsdGeom, stage.code
    mesh = geom.Mesh(prim)
    points = _rows(mesh.GetPointsAttr().Get(code), 3)
    counts, corners = (
        np.array(one.Get(code) or (), np.int64)
        for one in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
    )
    if counts.sum() != len(corners):
        raise Unreadable(f"{prim.GetPath()} has {len(corners)} corners in faces of {counts.sum()}")
    variables = geom.PrimvarsAPI(prim)
    found: dict[str, Floats] = {}
    for name, variable, width in (("uv", "st", 2), ("colors", "displayColor", 3), ("normals", "normals", 3)):
        primvar = variables.FindPrimvarWithInheritance(variable)
        rows, kind = (primvar.ComputeFlattened(code), primvar.GetInterpolation()) if primvar else (None, "")
        if rows is None and name == "normals":
            rows, kind = mesh.GetNormalsAttr().Get(code), mesh.GetNormalsInterpolation()
        if rows is not None and len(rows):
            found[name] = _by_corner(_rows(rows, width), kind, counts, corners, len(points), prim)
    try:
        if not found:
            return _turned_out(mesh, Surface(points, triangulate(points, counts, corners)))
        rows = np.column_stack([corners, *found.values()])
        _, first, own = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        triangles = triangulate(points[corners[first]], counts, own.reshape(-1))
    except Unreadable as error:
        raise Unreadable(f"{prim.GetPath()}: {error}") from None
    kept: dict[str, Any] = {name: values[first] for name, values in found.items()}
    return _turned_out(mesh, Surface(points[corners[first]], triangles, **kept))


def _turned_out(mesh: Any, part: Surface) -> Surface:
    if mesh.GetOrientationAttr().Get() == "leftHanded":
        return part._replace(triangles=part.triangles[:, ::-1])
    return part


def _rows(values: Any, width: int) -> Floats:
    return np.array(values if values is not None else (), np.float64).reshape(-1, width)


def _by_corner(rows: Floats, kind: str, counts: Indices, corners: Indices, points: int, prim: Any) -> Floats:
    """Return a row per corner of each face."""
    which = {
        "constant": np.zeros(len(corners), np.int64),
        "uniform": np.repeat(np.arange(len(counts)), counts),
        "faceVarying": np.arange(len(corners)),
    }.get(kind, corners)
    needed = {"constant": 1, "uniform": len(counts), "faceVarying": len(corners)}.get(kind, points)
    if len(rows) != needed:
        raise Unreadable(f"{prim.GetPath()} has {len(rows)} values where {needed} are {kind}")
    return rows[which]


def _material(stage: Stage, prim: Any) -> Material | None:
    """Return what a UsdPreviewSurface says; None: the mesh has none."""
    shade = stage.pxr.UsdShade
    material = shade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    surface = material.ComputeSurfaceSource()[0] if material else None
    if not surface or surface.GetShaderId() != "UsdPreviewSurface":
        return None
    color, image = _input(stage, surface, "diffuseColor", (0.18, 0.18, 0.18))
    finish = [
        _input(stage, surface, name, plain, channel)
        for name, plain, channel in (("roughness", 0.5, 1), ("metallic", 0.0, 2))
    ]
    (roughness, _), (metal, _) = finish
    numbers = min(max(roughness, 0), 1), min(max(metal, 0), 1)
    return Material(tuple(np.clip(color, 0, 1e6)), *numbers, image, _finish([one for _, one in finish]))


def _finish(pictures: Sequence[Any]) -> Any:
    """Return the pictures of roughness and metal as one: green and blue; None if there is none."""
    there = [one.shape for one in pictures if one is not None]
    if not there:
        return None
    high, wide = np.max(there, axis=0)
    found = np.full((high, wide, 3), 255, np.uint8)
    for channel, one in enumerate(pictures, 1):
        if one is not None:  # a smaller one with its pixels repeated
            rows, columns = (np.arange(n) * own // n for n, own in zip((high, wide), one.shape, strict=True))
            found[:, :, channel] = one[rows[:, None], columns]
    return found


def _input(stage: Stage, surface: Any, name: str, plain: Any, channel: int | None = None) -> tuple[Any, Any]:
    """Return a number or colour of a shader, and the picture that multiplies it.

    `channel`: of a number's picture, where its connection names none.
    """
    port = surface.GetInput(name)
    if not port:
        return plain, None
    sources = port.GetConnectedSources()[0]
    if not sources:
        value = port.Get(stage.code)
        return plain if value is None else value, None
    shader = stage.pxr.UsdShade.Shader(sources[0].source.GetPrim())
    file = shader.GetInput("file") if shader.GetShaderId() == "UsdUVTexture" else None
    file = file.Get(stage.code) if file else None
    if file is None:  # such as displayColor
        return ((1.0, 1.0, 1.0) if channel is None else plain), None
    pixels = _pixels(stage, file)
    scale = shader.GetInput("scale")
    factor = scale.Get(stage.code) if scale else None
    factors = (1.0, 1.0, 1.0, 1.0) if factor is None else tuple(factor)
    if channel is None:
        return factors[:3], pixels[:, :, :3]
    channel = {"r": 0, "g": 1, "b": 2}.get(sources[0].sourceName, channel)
    return factors[channel], pixels[:, :, channel]


def _pixels(stage: Stage, file: Any) -> Any:
    try:
        content = stage.pxr.Ar.GetResolver().OpenAsset(stage.pxr.Ar.ResolvedPath(file.resolvedPath))
        if content is None:
            raise Unreadable(f"the picture {file.path} is missing")
        return picture_in("image", io.BytesIO(bytes(content.GetBuffer())), most=MOST_SIDE)
    except ArgumentError as error:
        raise Unreadable(f"the picture {file.path} cannot be read ({error})") from None
