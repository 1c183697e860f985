"""Pictures of one thing under a light: a particle, or solids. Both look alike if they have the same shape."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import motes
from motes import shapes

__all__ = [
    "AWAY",
    "CARD",
    "CENTER",
    "COLOR",
    "HALF",
    "LAMPS",
    "WHITE",
    "Picture",
    "inside",
    "picture",
    "smooth",
]

Picture = NDArray[np.float64]
COLOR = (0.75, 0.6, 0.35)
CENTER = (0.4, 0.3, 0.0)
AWAY = {"background": (0.1, 0.1, 0.1), "fog": ("black", 1e9)}  # no fading into the background
HALF = np.sqrt(0.5)
WHITE = np.full((4, 4, 3), 255, np.uint8)
# Turned by 45 degrees about y: a card faces along x + z.
TURN = (0.0, float(np.sin(np.pi / 8)), 0.0, float(np.cos(np.pi / 8)))
CARD = shapes.Rectangle(
    (CENTER[0] - HALF / 2, CENTER[1] - 0.5, CENTER[2] + HALF / 2), (HALF, 0, -HALF), (0, 1, 0)
)
LAMPS: dict[str, dict[str, Any]] = {
    "lamp": {"sun": (0, 0, 0), "lights": [motes.Light((1.5, 1, 1.2), (1, 0.8, 0.6), 1.5)]},
    "spot": {
        "sun": (0, 0, 0),
        "lights": [motes.Light((1.5, 1, 1.5), (0.6, 1, 0.7), 3, spot=((-1.1, -0.6, -1.5), 35))],
    },
    "gradient": {
        "sun": (0, 0, 0),
        "background": motes.Gradient((0.9, 0.5, 0.3), (0.3, 0.5, 1), (0.2, 0.2, 0.1)),
    },
    "fog": {"sun": (0.5, 0.6, 0.7), "fog": ((0.2, 0.4, 0.9), 6)},
}
"""Lights that are not a plain sun, as arguments of a renderer."""


def picture(what: motes.Sprite | None, *objects: motes.Solid | None, **facts: Any) -> Picture:
    """Return the light of one particle of this look, and of solids; `facts`: of the renderer."""
    camera = motes.Camera((0, 0.6, 4), (0, 0.3, 0), fov_deg=36)
    renderer = motes.Renderer(
        120, 90, camera=camera, linear=True, objects=[*filter(None, objects)], **(AWAY | facts)
    )
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("one", **({} if what is None else {"sprite": what}))
    with world:
        if what is not None:
            system.configure(size=1, color=COLOR, orientation=TURN if what.kind != "ribbon" else (0, 0, 0, 1))
            system.burst(CENTER)
            system.move()
        return world.render().linear.astype(float)


def inside(mask: NDArray[np.bool_], pixels: int = 2) -> NDArray[np.bool_]:
    """Return the mask without its outermost pixels."""
    for _ in range(pixels):
        mask = mask & np.all([np.roll(mask, by, axis) for by in (-1, 1) for axis in (0, 1)], axis=0)
    return mask


def smooth(picture: Picture) -> NDArray[np.bool_]:
    """Return the pixels that differ little from their neighbours."""
    near = [np.roll(picture, by, axis) for by in (-1, 1) for axis in (0, 1)]
    return np.abs(np.subtract(near, picture)).max(axis=(0, 3)) < 0.1 * picture.max(axis=2) + 0.004
