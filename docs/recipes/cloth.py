"""Cloth: particles tied to their neighbours, shown as a mesh."""

import numpy as np

import motes
from motes.shapes import Sphere

rows = columns = 40
ball = Sphere((0, 0.6, 0), 0.6)
row, across = np.mgrid[: rows - 1, : columns - 1]
a = (row * columns + across).ravel()
faces = np.concatenate(
    [np.stack([a, a + 1, a + columns], 1), np.stack([a + 1, a + columns + 1, a + columns], 1)]
)
camera = motes.Camera((0, 1.7, 4), (0, 0.6, 0), fov_deg=34)
renderer = motes.Renderer(480, 270, camera=camera, background="#c4ccd4")
world = motes.World(seed=19, substeps=20, renderer=renderer)
cloth = world.system("cloth", sprite=motes.Sprite("point"))
with world:
    for frame in world.frames(30):
        if frame == 0:
            cloth.configure(alpha=0)
            ties = cloth.cloth(rows, columns, (-1, 1.4, -1), (0, 0, 2), (2, 0, 0))
        cloth.gravity((0, -9.8, 0))
        cloth.tie(ties, damping=1)
        cloth.bounce(ball, restitution=0, friction=0.8)
        cloth.move()
        world.step()
    sheet = motes.Mesh(cloth.gather(to="all").position, faces)
    renderer.objects = [motes.Solid(sheet, "#b5402f"), motes.Solid(Sphere((0, 0.6, 0), 0.57), "#e8e0d0")]
    world.render().save("out/cloth.png")
