"""Meshes and pictures of a shot as files, named after their content, so each is written once."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._io import files, hdr, png

__all__ = ["Files", "Mesh", "place_at"]

Array = NDArray[Any]


class Mesh:
    """The arrays of a mesh, as USD has them: a row per vertex, or `st` per corner of each triangle."""

    def __init__(
        self,
        points: Array,
        triangles: Array,
        normals: Array | None = None,
        st: Array | None = None,
        colors: Array | None = None,
    ) -> None:
        """Take the arrays: `st` has a row per vertex, or per corner of each triangle."""
        self.points, self.triangles, self.normals, self.st, self.colors = (
            points,
            triangles,
            normals,
            st,
            colors,
        )

    def write(self, path: Path) -> None:
        """Write the mesh as a layer, as a default and as a sample at time 0, which value clips need."""
        pxr = _extras.usd_writer("an export to .usd")
        layer = pxr.Sdf.Layer.CreateAnonymous(".usdc")
        prim = pxr.Sdf.CreatePrimInLayer(layer, "/Mesh")
        prim.specifier, prim.typeName = pxr.Sdf.SpecifierDef, "Mesh"
        layer.defaultPrim = "Mesh"
        for name, kind, values, wide in self._attributes(pxr):
            attribute = pxr.Sdf.AttributeSpec(prim, name, pxr.Sdf.ValueTypeNames.Find(kind))
            attribute.default = values
            layer.SetTimeSample(attribute.path, 0.0, values)
            if wide:
                attribute.SetInfo("interpolation", wide)
        scheme = pxr.Sdf.AttributeSpec(
            prim, "subdivisionScheme", pxr.Sdf.ValueTypeNames.Token, pxr.Sdf.VariabilityUniform
        )
        scheme.default = "none"
        if not layer.Export(str(path)):
            raise OSError(f"{path} could not be written")

    def _attributes(self, pxr: Any) -> list[tuple[str, str, Any, str]]:
        def vectors(rows: Array) -> Any:
            return pxr.Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows, np.float32))

        def whole(rows: Array) -> Any:
            return pxr.Vt.IntArray.FromNumpy(np.ascontiguousarray(rows, np.int32).reshape(-1))

        bounds = np.stack([self.points.min(axis=0), self.points.max(axis=0)])
        found = [
            ("points", "point3f[]", vectors(self.points), ""),
            ("extent", "float3[]", vectors(bounds), ""),
            ("faceVertexCounts", "int[]", whole(np.full(len(self.triangles), 3)), ""),
            ("faceVertexIndices", "int[]", whole(self.triangles), ""),
        ]
        if self.normals is not None:
            found.append(("normals", "normal3f[]", vectors(self.normals), "vertex"))
        if self.colors is not None:
            found.append(("primvars:displayColor", "color3f[]", vectors(self.colors), "vertex"))
        if self.st is not None:
            rows = pxr.Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(self.st, np.float32))
            corners = "vertex" if len(self.st) == len(self.points) else "faceVarying"
            found.append(("primvars:st", "texCoord2f[]", rows, corners))
        return found


class Files:
    """The files that a frame needs, each with the function that writes it."""

    def __init__(self) -> None:
        """Begin with none."""
        self.writers: dict[str, Callable[[Path], None]] = {}

    def mesh(self, key: Any, make: Callable[[], Mesh]) -> str:
        """Return the name of a mesh's file; `key`: what decides its content."""
        name = f"mesh_{_hash(repr(key).encode())}.usdc"
        self.writers[name] = lambda path: make().write(path)
        return name

    def light(self, picture: NDArray[np.float32], key: Any) -> str:
        """Return the name of a picture of linear light: sRGB where it is no brighter than white."""
        bright = _is_bright(key, picture)
        name = f"picture_{_hash(repr(key).encode())}.{'hdr' if bright else 'png'}"
        encode = hdr.encode if bright else lambda light: png.encode(_srgb(light))
        self.writers[name] = lambda path: _ignore(path.write_bytes(encode(picture)))
        return name

    def pixels(self, picture: NDArray[np.uint8], key: int) -> str:
        """Return the name of a picture, uint8 (height, width, 3 or 4), as it is."""
        name = f"picture_{_hash(repr(key).encode())}.png"
        self.writers[name] = lambda path: _ignore(path.write_bytes(png.encode(picture)))
        return name

    def write(self, folder: Path, known: set[str]) -> None:
        """Write the files that a folder lacks, each whole or not at all; add all names to `known`."""
        for name in self.writers.keys() - known:
            if not (folder / name).is_file():
                with files.whole_path(folder / name) as draft:
                    self.writers[name](draft)
            known.add(name)


def place_at(pose: tuple[float, ...]) -> NDArray[np.float64]:
    """Return a pose, position and quaternion (w, x, y, z), as a transform (4, 4)."""
    from .._meshes.writing import turned

    place = np.eye(4)
    place[:3, :3] = turned(np.eye(3), pose).T
    place[:3, 3] = pose[:3]
    return place


_bright: dict[Any, bool] = {}


def _is_bright(key: Any, picture: NDArray[np.float32]) -> bool:
    """Return whether a picture is brighter than white; asked once per content."""
    if key not in _bright:
        _bright[key] = bool(picture.max(initial=0) > 1)
    return _bright[key]


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def _srgb(light: NDArray[np.float32]) -> NDArray[np.uint8]:
    encoded = np.where(
        light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055
    )
    pixels: NDArray[np.uint8] = np.rint(encoded * 255).astype(np.uint8)
    return pixels


def _ignore(_: object) -> None:
    pass
