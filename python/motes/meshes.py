"""Surfaces of triangles, made of arrays or read from files: Mesh."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _extras, arguments
from .errors import ArgumentError
from .values import Value, value

__all__ = ["Mesh"]

SUFFIXES = (".obj", ".ply", ".stl", ".glb")
VERTICES = "finite numbers of shape (n, 3), metres, n >= 3"
TRIANGLES = "integers of shape (m, 3), m >= 1"


@value(init=False)
class Mesh(Value):
    """A surface of triangles, visible from both sides.

    `vertices`: positions in metres, float32 (n, 3). `triangles`: three indices of vertices each, uint32
    (m, 3). Both are read-only. Two meshes are equal if their arrays are.
    """

    vertices: NDArray[np.float32]
    triangles: NDArray[np.uint32]

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        """Take the arrays, which are copied."""
        points = _vertices(vertices)
        corners = _triangles(triangles, len(points))
        self.__dict__.update(vertices=points, triangles=corners)
        self.__dict__["_name"] = _core.keep_mesh(points, corners)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, scale: float = 1) -> Mesh:
        """Read a file, .obj .ply .stl or .glb, by trimesh, the extra `[mesh]`.

        All its parts become one mesh, placed as the file says; its colours and images are not read. `scale`:
        metres per unit of the file.
        """
        if arguments.file_path("path", path).suffix.lower() not in SUFFIXES:
            raise ArgumentError("path", os.fspath(path), f"a name ending in {', '.join(SUFFIXES)}")
        scale = arguments.number("scale", scale, low=0)
        library = _extras.trimesh()
        if not os.path.isfile(path):
            raise ArgumentError("path", os.fspath(path), "a file that exists")
        try:
            read = library.load_scene(path, process=False).to_mesh()
        except Exception as error:  # any: each format has errors of its own
            raise ArgumentError("path", os.fspath(path), f"a mesh that can be read ({error})") from None
        return cls(np.asarray(read.vertices) * scale, read.faces)

    @property
    def key(self) -> int:
        """The engine's name for it, made from its content; for the package itself."""
        made: int = self.__dict__["_name"]
        return made

    def _key(self) -> tuple[Any, ...]:
        return (self.key,)

    def __repr__(self) -> str:
        """Name the numbers of vertices and triangles."""
        return f"<Mesh of {len(self.vertices)} vertices, {len(self.triangles)} triangles>"


def _vertices(given: Any) -> NDArray[np.float32]:
    array = arguments.floats("vertices", given, np.float32, VERTICES)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) < 3:
        raise ArgumentError("vertices", f"{array.dtype} {array.shape}", VERTICES)
    wrong = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(wrong):
        raise ArgumentError(f"vertices[{wrong[0]}]", array[wrong[0]].tolist(), VERTICES)
    return _kept(array)


def _triangles(given: Any, vertices: int) -> NDArray[np.uint32]:
    try:
        array: NDArray[Any] = np.asarray(given)
    except Exception:  # any: this runs methods of users' classes
        raise ArgumentError("triangles", given, TRIANGLES) from None
    if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != 3 or len(array) < 1:
        raise ArgumentError("triangles", f"{array.dtype} {array.shape}", TRIANGLES)
    wrong = np.flatnonzero(((array < 0) | (array >= vertices)).any(axis=1))
    if len(wrong):
        allowed = f"indices of the {vertices} vertices, 0..{vertices - 1}"
        raise ArgumentError(f"triangles[{wrong[0]}]", array[wrong[0]].tolist(), allowed)
    return _kept(array.astype(np.uint32))


def _kept(array: NDArray[Any]) -> NDArray[Any]:
    copy = np.array(array, order="C")
    copy.flags.writeable = False
    return copy
