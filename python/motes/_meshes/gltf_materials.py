"""Reads the materials of a glTF file: base colour, metal, roughness, and their textures.

A motes mesh has one material. Of a file with several, the base colours become colours of vertices, taken from
the textures at their places, and the roughness and metal are those of the material with most triangles.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._values.images import interpolated, picture_in
from .._values.materials import Material
from ..errors import ArgumentError
from .accessors import Accessors
from .polygons import Unreadable
from .surfaces import Surface, joined

__all__ = ["MOST_SIDE", "Materials", "with_materials"]

MOST_SIDE = 8192


class Materials:
    """The materials of a document, read when they are first used."""

    def __init__(self, document: dict[str, Any], accessors: Accessors) -> None:
        self._document = document
        self._accessors = accessors
        self._known: dict[int, Material] = {}

    def places_of(self, number: int) -> int:
        """Return the number of the texture coordinates that a material uses."""
        facts = self._facts(number)
        texture = facts.get("baseColorTexture", facts.get("metallicRoughnessTexture", {}))
        return int(texture.get("texCoord", 0))

    def applied(self, parts: Sequence[Surface], numbers: Sequence[int]) -> Surface:
        """Return parts as one surface with one material; `numbers`: of their materials, -1: none."""
        if not set(numbers) - {-1}:
            return joined(parts)
        return with_materials(parts, [self._material(number) for number in numbers])

    def _facts(self, number: int) -> dict[str, Any]:
        if number < 0:
            return {}
        facts: dict[str, Any] = self._document["materials"][number].get("pbrMetallicRoughness", {})
        return facts

    def _material(self, number: int) -> Material:
        if number not in self._known:
            facts = self._facts(number)
            plain = number < 0  # vertices without a material are white and matt here
            self._known[number] = Material(
                tuple(facts.get("baseColorFactor", (1, 1, 1, 1))[:3]),
                facts.get("roughnessFactor", 1),
                facts.get("metallicFactor", 0 if plain else 1),
                self._picture(facts.get("baseColorTexture")),
                self._picture(facts.get("metallicRoughnessTexture")),
            )
        return self._known[number]

    def _picture(self, texture: dict[str, Any] | None) -> NDArray[np.uint8] | None:
        if texture is None:
            return None
        source = self._document["textures"][texture["index"]].get("source")
        if source is None:  # in a format of an extension
            return None
        image = self._document["images"][source]
        if "bufferView" in image:
            content = self._accessors.view(image["bufferView"])
        else:
            content = self._accessors.file_of("image", source, image["uri"])
        try:
            pixels = picture_in("image", io.BytesIO(content), most=MOST_SIDE)
        except ArgumentError as error:
            raise Unreadable(f"image {source} cannot be read ({error})") from None
        return pixels[:, :, :3]


def with_materials(parts: Sequence[Surface], materials: Sequence[Material | None]) -> Surface:
    """Return parts as one surface with one material."""
    different = set(materials)
    if len(different) <= 1:
        return joined(parts)._replace(material=next(iter(different), None))
    plain = Material()
    looks = [plain if one is None else one for one in materials]
    triangles = dict.fromkeys(looks, 0)
    for part, look in zip(parts, looks, strict=True):
        triangles[look] += len(part.triangles)
    most = max(triangles, key=triangles.__getitem__)
    tinted = [_tinted(part, look) for part, look in zip(parts, looks, strict=True)]
    return joined(tinted)._replace(material=Material((1, 1, 1), most.roughness, most.metal))


def _tinted(part: Surface, material: Material) -> Surface:
    """Return a part with the base colour of its material as colours of vertices."""
    colors = np.ones((len(part.vertices), 3)) if part.colors is None else part.colors
    colors = colors * np.array(material.color)
    if material.image is not None and part.uv is not None:
        colors = colors * interpolated(material.image, part.uv, lambda pixels: pixels.astype(np.float64))
    return part._replace(colors=colors)
