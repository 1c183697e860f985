"""Opaque or alpha, and when: opaque hides all behind it; alpha lets it shine through; add is light."""

import motes
from motes.shapes import Line, Sphere

camera = motes.Camera((0, 0, 5), (0, 0, 0))
world = motes.World(seed=9, renderer=motes.Renderer(480, 270, camera=camera, background="#0e131c"))
places = []
for x, blend, alpha in ((-1.5, "opaque", 1), (0, "alpha", 0.5), (1.5, "add", 0.25)):
    balls = world.system(blend, sprite=motes.Sprite("disc", pixels=None, blend=blend))
    balls.configure(size=0.5, color=Line((0.9, 0.2, 0.1), (0.1, 0.4, 0.9)), alpha=alpha)
    places.append((balls, Sphere((x, 0, 0), 0.6)))
with world:
    for balls, place in places:
        balls.burst(place, count=24)
    world.render().save("out/opaque_or_alpha.png")
