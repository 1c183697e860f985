"""Leaves that come to rest: `hits=True` notes hits, and `rest` lays down what is slow, z axis upright."""

import motes
from motes.shapes import Box, Plane

ground = Plane((0, 0, 0), (0, 1, 0))
camera = motes.Camera((0, 1.2, 5), (0, 0.7, 0), fov_deg=36)
renderer = motes.Renderer(
    480, 270, camera=camera, background="#8fb3c9", objects=[motes.Solid(ground, "#6b7a4a")]
)
world = motes.World(seed=2, renderer=renderer)
leaf = motes.Mesh([(0, -1, 0), (0.45, 0, 0.1), (0, 1, 0), (-0.45, 0, 0.1)], [(0, 1, 2), (0, 2, 3)])
card = motes.Sprite("mesh", mesh=leaf, facing="orientation", blend="opaque", lit=True)
leaves = world.system("leaves", sprite=card)
leaves.configure(size=0.12, orientation="random", spin=motes.shapes.Sphere((0, 0, 0), 6))
leaves.configure(color=motes.shapes.Triangle((0.7, 0.05, 0.02), (0.85, 0.2, 0.02), (0.9, 0.6, 0.05)))
with world:
    for _ in world.frames(120):
        leaves.source(Box((-2, 2.5, -1), (2, 2.6, 1.5)), rate=80, jitter=True)
        leaves.gravity((0, -9.8, 0))
        leaves.wind((0, 0, 0), drag=8)
        leaves.curl_noise(6, scale=0.8, speed=0.4)
        leaves.bounce(ground, restitution=0, friction=0.9, hits=True)
        leaves.rest(0.5)
        leaves.move()
        picture = world.render()
    picture.save("out/leaves_that_come_to_rest.png")
