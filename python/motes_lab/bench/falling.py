"""A scene for benchmarks that need a busy world: layers of falling, bouncing particles in large pictures."""

from __future__ import annotations

from motes import Camera, Renderer, System
from motes.shapes import Box, Plane

__all__ = ["SPACE", "fall", "renderer"]

SPACE = (-20, 20)


def renderer() -> Renderer:
    """Return a renderer that sees all particles, at 1920x1080."""
    return Renderer(1920, 1080, camera=Camera((0, 4, 40), (0, 4, 0)))


def fall(layer: System, frame: int, particles: int) -> None:
    """Record a frame; the particles of a layer are born in its first one."""
    if frame == 0:
        layer.burst(Box((-20, 0, -5), (20, 12, 5)), count=particles)
    layer.gravity((0, -2, 0))
    layer.random_acceleration(Box((-1, -1, -1), (1, 1, 1)))
    layer.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=0.6)
    layer.move()
