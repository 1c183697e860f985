"""Motion blur: the shutter is open for this part of a frame."""

import motes
from motes.shapes import Plane, Sphere

ground = Plane((0, 0, 0), (0, 1, 0))
camera = motes.Camera((0, 1, 5), (0, 0.9, 0), fov_deg=34)
renderer = motes.Renderer(480, 270, camera=camera, objects=[motes.Solid(ground, "#15171c")], shutter=0.6)
world = motes.World(seed=14, renderer=renderer)
sparks = world.system("sparks", sprite=motes.Sprite(pixels=None))
sparks.configure(size=0.035, color=(1, 0.5, 0.15), velocity=Sphere((1.2, 4.5, 0), 1.6))
with world:
    for _ in world.frames(36):
        sparks.source((-1.4, 0.05, 0), rate=500, jitter=True)
        sparks.gravity((0, -9.8, 0))
        sparks.bounce(ground, restitution=0.5)
        sparks.kill_old(1.4)
        sparks.move()
        picture = world.render()
    picture.save("out/motion_blur.png")
