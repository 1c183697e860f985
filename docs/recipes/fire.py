"""Fire: light that adds up, and curves over each particle's life."""

import motes
from motes.shapes import Disc, Sphere

camera = motes.Camera((0, 0.9, 4), (0, 0.8, 0))
world = motes.World(seed=10, renderer=motes.Renderer(480, 270, camera=camera, bloom=0.1))
flame = world.system("flame", capacity=20_000, sprite=motes.Sprite(pixels=None))
flame.configure(velocity=Sphere((0, 0.6, 0), 0.3), lifetime=motes.Uniform(0.5, 1.3))
with world:
    for _ in world.frames(48):
        flame.source(Disc((0, 0, 0), (0, 1, 0), 0.35), rate=2_000, jitter=True)
        flame.gravity((0, 1.6, 0))
        flame.wind((0, 0, 0), drag=0.8)
        flame.curl_noise(4, scale=0.5, speed=1)
        flame.color_over_life([(0, (1, 0.6, 0.2)), (0.4, (1, 0.2, 0.03)), (1, (0.2, 0.02, 0))])
        flame.alpha_over_life([(0, 0), (0.1, 0.3), (1, 0)])
        flame.size_over_life([(0, 0.25), (1, 0.06)])
        flame.kill_expired()
        flame.move()
        picture = world.render()
    picture.save("out/fire.png")
