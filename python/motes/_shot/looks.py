"""What the sprite of a system is in USD: its form, prototypes and material."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._picture.sheets import Sheet, sheet_of
from .._picture.sprites import Sprite, tinted
from ..shapes._mesh import content_of
from . import words
from .facts import CURVES, INSTANCES, POINTS
from .files import Files, Mesh
from .solids import mesh_of

__all__ = ["form_of_sprite", "look_of"]


def form_of_sprite(sprite: Sprite) -> str:
    """Return the type of prim that stands for the particles of a system."""
    return {"mesh": INSTANCES, "image": INSTANCES, "ribbon": CURVES}.get(sprite.kind, POINTS)


def look_of(sprite: Sprite, files: Files) -> dict[str, Any]:
    """Return the facts of a sprite that concern a whole system."""
    shaded = sprite.lit or sprite.kind in ("sphere", "mesh", "surface")
    values = {
        "float inputs:roughness": words.number(0.05 if sprite.kind == "surface" else sprite.roughness),
        "float inputs:metallic": words.number(sprite.metal),
    }
    if sprite.kind == "surface":
        values |= {"float inputs:ior": words.number(sprite.glass), "float inputs:opacity": "0.3"}
    material: dict[str, Any] = {"values": values, "by": "color", "shaded": shaded}
    if sprite.blend != "opaque" and sprite.kind != "surface":
        material["fades"] = True
    look = {"form": form_of_sprite(sprite), "material": material}
    if sprite.kind == "image":
        sheet = _sheet(sprite)
        look["prototypes"] = [_card(sheet, number, files) for number in range(sheet.number)]
        material["picture"] = files.pixels(sheet.pixels, sprite.__dict__["_picture"])
        material["clear"] = bool((sheet.pixels[:, :, 3] < 255).any())
    if sprite.mesh is not None:
        mesh = tinted(sprite.mesh)
        look["prototypes"] = [files.mesh((content_of(mesh), ()), lambda: mesh_of(mesh))]
        if sprite.image is not None:
            material["picture"] = files.light(sprite.image, sprite.__dict__["_picture"])
    return look


def _sheet(sprite: Sprite) -> Sheet:
    assert sprite.image is not None
    return sheet_of(sprite.image, sprite.tiles)


def _card(sheet: Sheet, number: int, files: Files) -> str:
    """Return the file of a card, whose longer side is 1 m, with a tile of a sheet."""
    key = ("card", sheet.pixels.shape, *sheet[1:], number)
    return files.mesh(key, lambda: _card_mesh(sheet, number))


def _card_mesh(sheet: Sheet, number: int) -> Mesh:
    high, wide = sheet.pixels.shape[0] / sheet.rows, sheet.pixels.shape[1] / sheet.columns
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    points = np.column_stack([corners * (wide, high) / max(wide, high), np.zeros(4)])
    row, column = divmod(number, sheet.columns)
    at = np.array([column + 0.5, sheet.rows - row - 0.5]) + corners
    return Mesh(points, np.array([[0, 1, 2], [0, 2, 3]]), st=at / (sheet.columns, sheet.rows))
