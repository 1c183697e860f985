"""Meshes that tests share: arrays of vertices and triangles, closed and facing outwards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["TETRAHEDRON", "Arrays", "block", "globe", "sheet", "torus"]

Arrays = tuple[NDArray[np.float64], NDArray[np.int64]]

TETRAHEDRON: Arrays = (
    np.array([(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)], np.float64),
    np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]),
)


def sheet(points: NDArray[np.float64]) -> Arrays:
    """Join a grid of points, shape (n, m, 3), by two triangles per cell."""
    rows, columns = points.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, c, b), (a, d, c))])
    return points.reshape(-1, 3), triangles


def globe(parallels: int = 40, meridians: int = 60, radius: float = 1) -> Arrays:
    """Make a ball around the origin; vertices on its seam and poles are repeated."""
    down, turn = np.meshgrid(
        np.linspace(0, np.pi, parallels + 1), np.linspace(0, 2 * np.pi, meridians + 1), indexing="ij"
    )
    parts = (np.sin(down) * np.cos(turn), np.cos(down), np.sin(down) * np.sin(turn))
    return sheet(radius * np.stack(parts, axis=-1))


def torus(around: int = 60, across: int = 30, radius: float = 1, tube: float = 0.4) -> Arrays:
    """Make a ring around the y axis."""
    turn, roll = np.meshgrid(
        np.linspace(0, 2 * np.pi, around + 1), np.linspace(0, 2 * np.pi, across + 1), indexing="ij"
    )
    far = radius + tube * np.cos(roll)
    return sheet(np.stack((far * np.cos(turn), tube * np.sin(roll), far * np.sin(turn)), axis=-1))


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Arrays:
    """Make a box."""
    corners = np.array([[(low, high)[i >> c & 1][c] for c in range(3)] for i in range(8)], float)
    sides = ["023", "031", "457", "476", "015", "054", "267", "273", "046", "062", "137", "175"]
    return corners, np.array([[int(digit) for digit in side] for side in sides])
