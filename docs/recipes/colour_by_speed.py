"""Colour by speed: attributes are set from expressions of columns."""

import motes
from motes.expressions import clamp, column, mix
from motes.shapes import Sphere

camera = motes.Camera((0, 0, 4), (0, 0, 0))
world = motes.World(seed=16, renderer=motes.Renderer(480, 270, camera=camera))
dots = world.system("dots", sprite=motes.Sprite(height=0.008))
dots.configure(alpha=0.5, velocity=Sphere((0, 0, 0), 0.2))
with world:
    for frame in world.frames(48):
        if frame == 0:
            dots.burst(Sphere((0, 0, 0), 1.4), count=8_000)
        dots.orbit_point((0.5, 0, 0), magnitude=1.5, epsilon=0.05)
        fast = clamp(column("velocity").length() / 3, 0, 1)
        dots.set(color=mix((0.1, 0.2, 1), (1, 0.4, 0.1), fast))
        dots.move()
        picture = world.render()
    picture.save("out/colour_by_speed.png")
