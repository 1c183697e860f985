"""Children: a shell bursts into stars where it dies, and stars leave sparks behind them."""

import motes
from motes.shapes import Sphere

camera = motes.Camera((0, 14, 50), (0, 14, 0))
world = motes.World(seed=11, renderer=motes.Renderer(480, 270, camera=camera, bloom=0.2))
shells, stars = world.system("shells"), world.system("stars", sprite=motes.Sprite(height=0.012))
sparks = world.system("sparks", capacity=60_000, sprite=motes.Sprite(height=0.006))
shells.configure(velocity=(0, 19, 0), lifetime=1.1)
stars.configure(velocity=Sphere((0, 2, 0), 14, inner_radius=12), lifetime=1.5, color=(1, 0.7, 0.4))
sparks.configure(velocity=Sphere((0, 0, 0), 0.6), lifetime=motes.Uniform(0.3, 1.2), color=(1, 0.35, 0.1))
with world:
    for frame in world.frames(48):
        if frame == 0:
            shells.emit(position=[(-9, 0, 0), (8, 1, 0)])
        shells.spawn(stars, on="death", count=90)
        stars.trail(sparks, every=0.3, count=2)
        sparks.alpha_over_life([(0, 0.5), (1, 0)])
        for system in (shells, stars, sparks):
            system.gravity((0, -9.8, 0))
            system.kill_expired()
            system.move()
        picture = world.render()
    picture.save("out/children.png")
