"""A moving emitter: a curve of places; `moving_from` fills the way between two frames."""

import motes
from motes.shapes import Sphere

path = motes.Curve(
    [(0, (-2, -0.6, 0)), (0.7, (-0.6, 0.9, 0)), (1.4, (0.7, -0.7, 0)), (2, (2, 0.7, 0))], "spline"
)
camera = motes.Camera((0, 0, 5), (0, 0, 0))
world = motes.World(seed=20, renderer=motes.Renderer(480, 270, camera=camera, bloom=0.15))
sparks = world.system("sparks", sprite=motes.Sprite(height=0.01))
sparks.configure(velocity=Sphere((0, 0, 0), 0.4), color=(0.5, 0.8, 1), lifetime=motes.Uniform(0.5, 1.6))
with world:
    for _ in world.frames(46):
        now, before = path(world.time), path(max(world.time - world.dt, 0))
        sparks.source(tuple(now), rate=9_000, jitter=True, moving_from=tuple(before))
        sparks.alpha_over_life([(0, 0.5), (1, 0)])
        sparks.gravity((0, -0.8, 0))
        sparks.kill_expired()
        sparks.move()
        picture = world.render()
    picture.save("out/moving_emitter.png")
