"""Reads glTF 2.0 in one file, .glb: the triangles of its scene, posed by nodes, morph targets and skins.

Animations, lines and points are ignored.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._values.rotations import matrix_of
from .accessors import Accessors
from .gltf_materials import Materials
from .polygons import Floats, Indices, Unreadable, fan, strip
from .surfaces import Surface

__all__ = ["read"]

DRACO = "KHR_draco_mesh_compression"
INSTANCING = "EXT_mesh_gpu_instancing"
READ = (DRACO, INSTANCING, "KHR_mesh_quantization")
"""The extensions that are read. A file that requires another is refused."""
_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def read(path: Path, content: bytes) -> Surface:
    """Return the surface of a file. Raises Unreadable."""
    document, binary = _chunks(content)
    unread = [one for one in document.get("extensionsRequired", ()) if one not in READ]
    if unread:
        raise Unreadable(f"it requires {', '.join(map(str, unread))}, which is not supported")
    accessors = Accessors(path, document, binary)
    return _Scene(document, accessors, Materials(document, accessors)).surface()


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

    def __init__(self, document: dict[str, Any], accessors: Accessors, materials: Materials) -> None:
        self._document = document
        self._materials = materials
        self._accessors = accessors
        self._nodes: list[dict[str, Any]] = document.get("nodes", [])
        self._globals: dict[int, Floats] = {}

    def surface(self) -> Surface:
        parts: list[Surface] = []
        of_parts: list[int] = []
        for part, material in self._parts():
            corners, count = part.triangles, len(part.vertices)
            wrong = corners[(corners < 0) | (corners >= count)]
            if len(wrong):
                raise Unreadable(f"a triangle uses vertex {wrong[0]}, counted from 0, of {count}")
            if len(corners):
                parts.append(part)
                of_parts.append(material)
        return self._materials.applied(parts, of_parts)

    def _parts(self) -> Iterator[tuple[Surface, int]]:
        """Yield the meshes of all nodes, in the scene's coordinates, and the numbers of their materials."""
        self._place_nodes()
        for number in self._visible():
            node = self._nodes[number]
            if "mesh" not in node:
                continue
            mesh = self._document["meshes"][node["mesh"]]
            weights = node.get("weights", mesh.get("weights", []))
            for primitive in mesh["primitives"]:
                part, material = self._primitive(primitive, weights), primitive.get("material", -1)
                if "skin" in node:
                    yield self._skinned(part, primitive["attributes"], node["skin"]), material
                    continue
                for place in self._places(number):
                    yield _moved(part, place), material

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

    def _primitive(self, primitive: dict[str, Any], weights: list[float]) -> Surface:
        """Return a primitive, moved by its weighted morph targets."""
        mode = primitive.get("mode", _TRIANGLES)
        if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in primitive["attributes"]:
            return Surface(np.empty((0, 3)), np.empty((0, 3), np.int64))
        compressed = primitive.get("extensions", {}).get(DRACO)
        stored = self._document["accessors"][primitive["attributes"]["POSITION"]]
        # A file may also hold the same data uncompressed.
        if compressed is not None and "bufferView" not in stored:
            part = self._draco(compressed, stored, primitive)
        else:
            attributes = primitive["attributes"]
            points = self._vectors(attributes["POSITION"])
            part = Surface(
                points,
                self._corners(primitive, mode, len(points)),
                **self._others(primitive, lambda name: self._accessors.read(attributes[name]), len(points)),
            )
        points, normals = part.vertices, part.normals
        for weight, target in zip(weights, primitive.get("targets", ()), strict=False):
            if weight and "POSITION" in target:
                points = points + weight * self._vectors(target["POSITION"])
            if weight and "NORMAL" in target and normals is not None:
                normals = normals + weight * self._vectors(target["NORMAL"])
        return part._replace(vertices=points, normals=normals)

    def _others(
        self, primitive: dict[str, Any], read: Callable[[str], NDArray[Any]], count: int
    ) -> dict[str, Any]:
        """Return what a primitive's vertices have besides positions; `read` returns an attribute's rows."""
        place = f"TEXCOORD_{self._materials.places_of(primitive.get('material', -1))}"
        names = {"normals": ("NORMAL", 3), "uv": (place, 2), "colors": ("COLOR_0", 3)}
        found: dict[str, Any] = {}
        for name, (attribute, width) in names.items():
            if attribute not in primitive["attributes"]:
                continue
            rows = read(attribute).astype(np.float64)[:, :width]
            if rows.shape != (count, width):
                raise Unreadable(f"{attribute} has {rows.shape} numbers for {count} vertices")
            found[name] = rows
        if found.get("uv") is not None:
            found["uv"] = found["uv"] * (1, -1) + (0, 1)  # from the top in the file
        return found

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

    def _draco(
        self, compressed: dict[str, Any], stored: dict[str, Any], primitive: dict[str, Any]
    ) -> Surface:
        library = _extras.draco(f"a .glb with {DRACO}")
        content = self._accessors.view(compressed["bufferView"])
        try:
            mesh = library.decode(content)
            triangles = np.asarray(mesh.faces).astype(np.int64).reshape(-1, 3)
            points = _rows_of(mesh, compressed["attributes"]["POSITION"])
        except Exception as error:  # any: a compiled library with its own errors
            raise Unreadable(f"its {DRACO} is damaged: {error}") from None
        points = points.reshape(-1, 3)
        if stored.get("normalized") and points.dtype.kind in "iu":
            points = np.maximum(points / np.iinfo(points.dtype).max, -1.0)
        known = {
            name: one for name, one in primitive["attributes"].items() if name in compressed["attributes"]
        }
        others = self._others(
            primitive | {"attributes": known},
            lambda name: _normalised(
                _rows_of(mesh, compressed["attributes"][name]), self._document["accessors"][known[name]]
            ),
            len(points),
        )
        return Surface(points.astype(np.float64), triangles, **others)

    def _skinned(self, part: Surface, attributes: dict[str, Any], number: int) -> Surface:
        """Return vertices as posed by the joints of a skin; the node's own matrix does not count."""
        skin = self._document["skins"][number]
        joints = [self._globals[joint] for joint in skin["joints"]]
        if "inverseBindMatrices" in skin:
            bound = self._accessors.read(skin["inverseBindMatrices"]).astype(np.float64)
            joints = [m @ inverse.reshape(4, 4).T for m, inverse in zip(joints, bound, strict=False)]
        matrices = np.stack(joints)
        points, normals = part.vertices, part.normals
        moved, along = np.zeros_like(points), np.zeros_like(points)
        total = np.zeros(len(points))
        k = 0
        while f"JOINTS_{k}" in attributes:
            indices = self._accessors.read(attributes[f"JOINTS_{k}"]).astype(np.int64)
            weights = self._accessors.read(attributes[f"WEIGHTS_{k}"]).astype(np.float64)
            for column in range(indices.shape[1]):
                placed = matrices[indices[:, column]]
                at = np.einsum("nij,nj->ni", placed[:, :3, :3], points) + placed[:, :3, 3]
                moved += weights[:, column, None] * at
                if normals is not None:  # joints hardly scale, so the inverse is not needed
                    along += weights[:, column, None] * np.einsum("nij,nj->ni", placed[:, :3, :3], normals)
                total += weights[:, column]
            k += 1
        if not (total > 0).all():
            raise Unreadable("its skin has vertices without weights")
        return part._replace(vertices=moved / total[:, None], normals=None if normals is None else along)


def _moved(part: Surface, place: Floats) -> Surface:
    """Return a part at a place, a matrix of shape (4, 4)."""
    turn = place[:3, :3]
    mirrors = np.linalg.det(turn) < 0
    normals = part.normals
    if normals is not None:
        # The matrix of cofactors keeps normals perpendicular, also where the place squeezes the part.
        cofactors = np.stack(
            [np.cross(turn[1], turn[2]), np.cross(turn[2], turn[0]), np.cross(turn[0], turn[1])]
        )
        normals = normals @ cofactors.T * (-1 if mirrors else 1)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = normals / np.where(lengths > 0, lengths, 1)
    return part._replace(
        vertices=part.vertices @ turn.T + place[:3, 3],
        triangles=part.triangles[:, ::-1] if mirrors else part.triangles,  # mirroring reverses the winding
        normals=normals,
    )


def _rows_of(mesh: Any, number: int) -> NDArray[Any]:
    """Return the rows of an attribute of a mesh that Draco decoded."""
    rows: NDArray[Any] = np.asarray(mesh.get_attribute_by_unique_id(number)["data"])
    return rows.reshape(len(mesh.points), -1)


def _normalised(rows: NDArray[Any], accessor: dict[str, Any]) -> NDArray[Any]:
    if accessor.get("normalized") and rows.dtype.kind in "iu":
        return np.maximum(rows / np.iinfo(rows.dtype).max, -1.0)
    return rows


def _matrix(node: dict[str, Any]) -> Floats:
    """Return a node's local transform as a matrix of shape (4, 4)."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    turned = matrix_of(*_unit(np.array(node.get("rotation", (0, 0, 0, 1)), np.float64)).tolist())
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
