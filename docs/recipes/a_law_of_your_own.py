"""A law of your own: an acceleration written in columns, here a spring with a swirl."""

import motes
from motes.expressions import column, cross
from motes.shapes import Sphere

place, speed = column("position"), column("velocity")
camera = motes.Camera((0, 2.2, 5), (0, 0, 0))
world = motes.World(seed=7, renderer=motes.Renderer(480, 270, camera=camera, exposure=1.5))
dots = world.system("dots", sprite=motes.Sprite(height=0.01))
dots.configure(color=(0.3, 0.6, 1), alpha=0.25)
with world:
    for frame in world.frames(64):
        if frame == 0:
            dots.burst(Sphere((0, 0, 0), 1.5), count=20_000)
        swirl = cross((0, 2.5, 0), place)
        dots.law(acceleration=swirl - place * (7, 20, 7) - speed * 0.5)
        dots.move()
        picture = world.render()
    picture.save("out/a_law_of_your_own.png")
