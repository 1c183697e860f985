"""Solids of a picture as meshes of USD, with their materials."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from .._picture.solids import Solid, parts
from ..shapes import Shape
from ..shapes._mesh import Mesh as Loaded
from ..shapes._mesh import content_of, origin_of, pose_of, shown_normals
from . import words
from .files import Files, Mesh, place_at
from .forms import form_of

__all__ = ["mesh_of", "solids"]

Prim = dict[str, Any]


def solids(given: Iterable[Solid], files: Files, before: Mapping[str, Prim]) -> dict[str, Prim]:
    """Return the prims of a frame's solids by name; one that was in the frame before keeps its name."""
    prims = [_prim(solid, part, files) for solid in given for part in parts(solid.shape)]
    names: list[str] = [""] * len(prims)
    for exact in (True, False):
        for i, prim in enumerate(prims):
            kind = prim["kind"]
            if exact:
                known = [n for n, one in before.items() if (one["kind"], one["of"]) == (kind, prim["of"])]
            else:
                known = [f"{kind}_{k}" for k in range(1, len(prims) + 1)]
            names[i] = names[i] or next((name for name in known if name not in names), "")
    return dict(sorted(zip(names, prims, strict=True)))


def _prim(solid: Solid, shape: Shape | Loaded, files: Files) -> Prim:
    color = np.array(solid.color, float)
    image = solid.__dict__["_image"] if solid.image is not None else 0
    mesh = shape if isinstance(shape, Loaded) else None
    by_place = image and (mesh is None or mesh.uv is None)  # the picture is projected along axes
    if mesh is not None:
        tint = solid.color if mesh.colors is not None else ()
        key: tuple[Any, ...] = (content_of(mesh), tint)
        place = place_at(pose_of(mesh))
    else:
        form = form_of(shape)
        key, place = form.key, form.place
        if by_place:
            key, place = (shape,), np.eye(4)
    size = (0.0, 0.0)
    if by_place:
        assert solid.image is not None
        size = (solid.scale, solid.scale * solid.image.shape[0] / solid.image.shape[1])
        key = (*key, size)
    values = {"matrix4d xformOp:transform": words.matrix(place)}
    if mesh is None or mesh.colors is None:
        values["color3f[] primvars:displayColor"] = f"[{words.vector(color)}]"
    return {
        "type": "Mesh",
        "apis": ["MaterialBindingAPI"],
        "kind": "Mesh" if mesh is not None else type(shape).__name__,
        "of": "" if mesh is None else f"{origin_of(mesh):x}",
        "mesh": files.mesh(key, lambda: mesh_of(shape, size, color)),
        "values": values,
        "material": _material(solid, image, files, tinted=mesh is not None and mesh.colors is not None),
    }


def mesh_of(shape: Shape | Loaded, size: tuple[float, float] = (0, 0), tint: Any = 1) -> Mesh:
    """Return a shape's mesh; `size`: of a picture that is projected on it, m; `tint` multiplies colours."""
    if isinstance(shape, Loaded):
        colors = None if shape.colors is None else shape.colors * tint
        mesh = Mesh(shape.vertices, shape.triangles, shown_normals(shape), shape.uv, colors)
        if size[0]:
            mesh.st = _projected(shape.vertices[shape.triangles], size)
        return mesh
    form = form_of(shape)
    points, triangles, normals = form.make()
    if np.linalg.det(form.place[:3, :3]) < 0:
        triangles = triangles[:, ::-1]
    if not size[0]:
        return Mesh(points, triangles, normals)
    points = points @ form.place[:3, :3].T + form.place[:3, 3]
    if normals is not None:
        normals = normals @ np.linalg.inv(form.place[:3, :3])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(points, triangles, normals, _projected(points[triangles], size))


def _projected(corners: Any, size: tuple[float, float]) -> Any:
    """Return the places in a picture of triangles' corners, as in cpp/image/raycast/cast_textures.h."""
    normal = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    flat = (normal[:, 1] >= normal[:, 0]) & (normal[:, 1] >= normal[:, 2])
    side = ~flat & (normal[:, 0] >= normal[:, 2])
    u = np.where(side[:, None], corners[:, :, 2], corners[:, :, 0]) / size[0]
    v = np.where(flat[:, None], corners[:, :, 2], -corners[:, :, 1]) / size[1]
    return np.stack([u, -v], axis=-1).reshape(-1, 2)  # rows count from the top


def _material(solid: Solid, image: int, files: Files, *, tinted: bool) -> dict[str, Any]:
    color = words.vector(solid.color)
    values = {
        "float inputs:roughness": words.number(solid.roughness if solid.glass is None else 0),
        "float inputs:metallic": words.number(solid.metal),
        "color3f inputs:diffuseColor": color,
    }
    if solid.light > 0:
        values["color3f inputs:emissiveColor"] = words.vector(np.array(solid.color) * solid.light)
    if solid.glass is not None:
        values |= {"float inputs:ior": words.number(solid.glass), "float inputs:opacity": "0"}
    material: dict[str, Any] = {"values": values}
    if image and solid.image is not None:
        material |= {"picture": files.light(solid.image, image), "scale": [*solid.color]}
    elif tinted:
        material["by"] = "color"
    finish = solid.__dict__["_finish_image"]
    own = getattr(solid.shape, "material", None)
    if finish and own is not None:
        parts_of = np.rint(own.finish_image * 255).astype(np.uint8)
        material |= {"finish": files.pixels(parts_of, finish), "factors": [1, solid.roughness, solid.metal]}
    return material
