"""Reads glTF 2.0 in one file, .glb: the triangles of its scene, posed by nodes, morph targets and skins.

Materials, animations, lines and points are ignored.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .accessors import Accessors
from .polygons import Floats, Indices, Triangles, Unreadable, fan, strip

__all__ = ["read"]

DRACO = "KHR_draco_mesh_compression"
INSTANCING = "EXT_mesh_gpu_instancing"
READ = (DRACO, INSTANCING, "KHR_mesh_quantization")
"""The extensions that are read. A file that requires another is refused."""
_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def read(path: Path, content: bytes) -> Triangles:
    """Return the vertices and triangles of a file. Raises Unreadable."""
    document, binary = _chunks(content)
    unread = [one for one in document.get("extensionsRequired", ()) if one not in READ]
    if unread:
        raise Unreadable(f"it requires {', '.join(map(str, unread))}, which is not supported")
    return _Scene(document, Accessors(path, document, binary)).triangles()


def _chunks(content: bytes) -> tuple[dict[str, Any], bytes]:
    if content[:4] != b"glTF" or len(content) < 12:
        raise Unreadable("it does not begin like a .glb file")
    version, length = (int.from_bytes(content[at : at + 4], "little") for at in (4, 8))
    if version != 2:
        raise Unreadable(f"it is glTF of version {version}; only version 2 is supported")
    if length > len(content):
        raise Unreadable(f"it is cut off: {len(content)} of {length} bytes")
    chunks: dict[int, bytes] = {}
    at = 12
    while at + 8 <= length:
        size, kind = (int.from_bytes(content[k : k + 4], "little") for k in (at, at + 4))
        chunks.setdefault(kind, content[at + 8 : at + 8 + size])
        at += 8 + size
    document = json.loads(chunks.get(_JSON, b"null"))
    if not isinstance(document, dict):
        raise Unreadable("it has no JSON document")
    return document, chunks.get(_BINARY, b"")


class _Scene:
    """Joins the meshes of the default scene."""

    def __init__(self, document: dict[str, Any], accessors: Accessors) -> None:
        self._document = document
        self._accessors = accessors
        self._nodes: list[dict[str, Any]] = document.get("nodes", [])
        self._globals: dict[int, Floats] = {}

    def triangles(self) -> Triangles:
        vertices: list[Floats] = [np.empty((0, 3))]
        triangles: list[Indices] = [np.empty((0, 3), np.int64)]
        count = 0
        for points, corners in self._parts():
            wrong = corners[(corners < 0) | (corners >= len(points))]
            if len(wrong):
                raise Unreadable(f"a triangle uses vertex {wrong[0]}, counted from 0, of {len(points)}")
            vertices.append(points)
            triangles.append(corners + count)
            count += len(points)
        return np.concatenate(vertices), np.concatenate(triangles)

    def _parts(self) -> Iterator[Triangles]:
        """Yield the meshes of all nodes, in the scene's coordinates."""
        self._place_nodes()
        for number in self._visible():
            node = self._nodes[number]
            if "mesh" not in node:
                continue
            mesh = self._document["meshes"][node["mesh"]]
            weights = node.get("weights", mesh.get("weights", []))
            for primitive in mesh["primitives"]:
                points, triangles = self._primitive(primitive, weights)
                if "skin" in node:
                    yield self._skinned(points, primitive["attributes"], node["skin"]), triangles
                    continue
                for place in self._places(number):
                    # A mirroring matrix reverses the winding.
                    turned = triangles[:, ::-1] if np.linalg.det(place[:3, :3]) < 0 else triangles
                    yield points @ place[:3, :3].T + place[:3, 3], turned

    # --- nodes

    def _place_nodes(self) -> None:
        """Compute the global matrix of each node, from the roots down."""
        children = {child for node in self._nodes for child in node.get("children", ())}
        waiting = [(number, np.eye(4)) for number in range(len(self._nodes)) if number not in children]
        while waiting:
            number, above = waiting.pop()
            if number in self._globals:
                raise Unreadable(f"node {number} has two parents")
            here = above @ _matrix(self._nodes[number])
            self._globals[number] = here
            waiting += [(child, here) for child in self._nodes[number].get("children", ())]

    def _visible(self) -> list[int]:
        """Return the nodes of the default scene, parents before children; all, if there is no scene."""
        scenes = self._document.get("scenes")
        if not scenes:
            return sorted(self._globals)
        waiting = list(scenes[self._document.get("scene", 0)].get("nodes", ()))[::-1]
        nodes: dict[int, None] = {}
        while waiting:
            number = waiting.pop()
            if number in nodes or number not in self._globals:
                raise Unreadable(f"node {number} is part of itself, or twice in the scene")
            nodes[number] = None
            waiting += self._nodes[number].get("children", ())[::-1]
        return list(nodes)

    def _places(self, number: int) -> list[Floats]:
        """Return the matrices of a node's instances: one, if it is not instanced."""
        here = self._globals[number]
        instanced = self._nodes[number].get("extensions", {}).get(INSTANCING)
        if instanced is None:
            return [here]
        names = {"TRANSLATION": "translation", "ROTATION": "rotation", "SCALE": "scale"}
        places = {
            names[name]: self._accessors.read(accessor)
            for name, accessor in instanced["attributes"].items()
            if name in names
        }
        rows = zip(*places.values(), strict=True)
        return [here @ _matrix(dict(zip(places, row, strict=True))) for row in rows]

    # --- meshes

    def _primitive(self, primitive: dict[str, Any], weights: list[float]) -> Triangles:
        """Return a primitive's vertices, moved by its weighted morph targets, and its triangles."""
        mode = primitive.get("mode", _TRIANGLES)
        if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in primitive["attributes"]:
            return np.empty((0, 3)), np.empty((0, 3), np.int64)
        compressed = primitive.get("extensions", {}).get(DRACO)
        stored = self._document["accessors"][primitive["attributes"]["POSITION"]]
        # A file may also hold the same data uncompressed.
        if compressed is not None and "bufferView" not in stored:
            points, triangles = self._draco(compressed, stored)
        else:
            points = self._vectors(primitive["attributes"]["POSITION"])
            triangles = self._corners(primitive, mode, len(points))
        for weight, target in zip(weights, primitive.get("targets", ()), strict=False):
            if weight and "POSITION" in target:
                points = points + weight * self._vectors(target["POSITION"])
        return points, triangles

    def _vectors(self, accessor: int) -> Floats:
        vectors = self._accessors.read(accessor).astype(np.float64)
        if vectors.shape[1] != 3:
            raise Unreadable("positions have 3 numbers")
        return vectors

    def _corners(self, primitive: dict[str, Any], mode: int, count: int) -> Indices:
        corners = np.arange(count)
        if "indices" in primitive:
            corners = self._accessors.read(primitive["indices"])[:, 0].astype(np.int64)
        if mode == _TRIANGLES:
            return corners.reshape(-1, 3)
        if len(corners) < 3:
            return np.empty((0, 3), np.int64)
        return strip(corners) if mode == _STRIP else fan(corners)

    def _draco(self, compressed: dict[str, Any], stored: dict[str, Any]) -> Triangles:
        library = _extras.draco(f"a .glb with {DRACO}")
        content = self._accessors.view(compressed["bufferView"])
        try:
            mesh = library.decode(content)
            triangles = np.asarray(mesh.faces).astype(np.int64).reshape(-1, 3)
            points = mesh.get_attribute_by_unique_id(compressed["attributes"]["POSITION"])["data"]
        except Exception as error:  # any: a compiled library with its own errors
            raise Unreadable(f"its {DRACO} is damaged: {error}") from None
        points = np.asarray(points).reshape(-1, 3)
        if stored.get("normalized") and points.dtype.kind in "iu":
            points = np.maximum(points / np.iinfo(points.dtype).max, -1.0)
        return points.astype(np.float64), triangles

    def _skinned(self, points: Floats, attributes: dict[str, Any], number: int) -> Floats:
        """Return vertices as posed by the joints of a skin; the node's own matrix does not count."""
        skin = self._document["skins"][number]
        joints = [self._globals[joint] for joint in skin["joints"]]
        if "inverseBindMatrices" in skin:
            bound = self._accessors.read(skin["inverseBindMatrices"]).astype(np.float64)
            joints = [m @ inverse.reshape(4, 4).T for m, inverse in zip(joints, bound, strict=False)]
        matrices = np.stack(joints)
        moved = np.zeros_like(points)
        total = np.zeros(len(points))
        k = 0
        while f"JOINTS_{k}" in attributes:
            indices = self._accessors.read(attributes[f"JOINTS_{k}"]).astype(np.int64)
            weights = self._accessors.read(attributes[f"WEIGHTS_{k}"]).astype(np.float64)
            for column in range(indices.shape[1]):
                placed = matrices[indices[:, column]]
                at = np.einsum("nij,nj->ni", placed[:, :3, :3], points) + placed[:, :3, 3]
                moved += weights[:, column, None] * at
                total += weights[:, column]
            k += 1
        if not (total > 0).all():
            raise Unreadable("its skin has vertices without weights")
        skinned: Floats = moved / total[:, None]
        return skinned


def _matrix(node: dict[str, Any]) -> Floats:
    """Return a node's local transform as a matrix of shape (4, 4)."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    x, y, z, w = _unit(np.array(node.get("rotation", (0, 0, 0, 1)), np.float64))
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turned * np.array(node.get("scale", (1, 1, 1)), np.float64)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def _unit(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(quaternion)
    if not 0.5 < length < 2:
        raise Unreadable("a rotation is not a unit quaternion")
    unit: NDArray[np.float64] = quaternion / length
    return unit
