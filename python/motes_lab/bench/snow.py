"""The paper's snow (5.1), used by the paper's tables, weak scaling, `bench overhead` and `bench paths`."""

from __future__ import annotations

from dataclasses import dataclass

from motes import System, Uniform
from motes.shapes import Box, Plane, Rectangle, Shape

__all__ = ["Snow"]


@dataclass(frozen=True)
class Snow:
    """Flakes that fall over the whole width and lie on the ground for the rest of their lives.

    The first frame already has flakes of all ages, so as many die in each frame as are born.
    """

    width: float = 60.0
    """Metres along x, centred on 0."""
    top: float = 12.0
    """Height in metres at which flakes are born."""
    depth: float = 8.0
    """Metres along z, centred on 0."""
    life: float = 12.0
    """Lifetime in seconds."""
    velocity: Shape = Box((-0.4, -1.4, -0.3), (0.4, -1.2, 0.3))
    """Velocities of newborn flakes, m/s."""
    gusts: Shape = Box((-1, -1, -1), (1, 1, 1))
    """Random accelerations, m/s^2."""
    obstacles: tuple[Shape, ...] = ()
    """Shapes on which flakes fall besides the ground."""

    def record(self, system: System, frame: int, particles: int) -> None:
        """Record a frame of a system of `particles` flakes."""
        x, z = self.width / 2, self.depth / 2
        system.configure(velocity=self.velocity, age=0)
        if frame == 0:
            system.configure(age=Uniform(0, self.life))
            system.burst(Box((-x, 0.1, -z), (x, self.top, z)), count=particles)
            system.configure(age=0)
        clouds = Rectangle((-x, self.top, -z), (self.width, 0, 0), (0, 0, self.depth))
        system.source(clouds, rate=particles / self.life)
        system.random_acceleration(self.gusts)
        for shape in (Plane((0, 0, 0), (0, 1, 0)), *self.obstacles):
            system.bounce(shape, restitution=0.1, friction=0.9)
        system.kill_old(self.life)
        system.move()
