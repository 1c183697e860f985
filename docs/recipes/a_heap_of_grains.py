"""A heap of grains: `contact` gives springs and friction between grains and on walls."""

import numpy as np

import motes
from motes.shapes import Cylinder, Line, Plane

ground, post = Plane((0, 0, 0), (0, 1, 0)), Cylinder((0, 0, 0), (0, 0.4, 0), 0.5)
camera = motes.Camera((0, 1.5, 3), (0, 0.45, 0))
solids = [motes.Solid(ground, "#4a4038"), motes.Solid(post, "#8a8f98")]
renderer = motes.Renderer(480, 270, camera=camera, background="#aebbc6", objects=solids)
world = motes.World(seed=12, substeps=40, renderer=renderer)
grains = world.system("grains", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
grains.configure(size=0.1, mass=0.001, color=Line((0.8, 0.25, 0.1), (0.95, 0.8, 0.5)))
dice = np.random.default_rng(1)
layer = np.array([(0.12 * (i % 4) - 0.18, 1.6, 0.12 * (i // 4) - 0.18) for i in range(16)])
with world:
    for frame in world.frames(120):
        if frame % 3 == 0:
            grains.emit(
                position=layer + dice.uniform(-0.01, 0.01, layer.shape), velocity=np.full((16, 3), (0, -2, 0))
            )
        grains.gravity((0, -9.8, 0))
        grains.contact(
            stiffness=150, restitution=0.2, friction=0.6, rolling_friction=0.2, walls=[ground, post]
        )
        grains.move()
        picture = world.render()
    picture.save("out/a_heap_of_grains.png")
