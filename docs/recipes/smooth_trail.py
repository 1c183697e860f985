"""A smooth trail: a ribbon follows each particle for `length` seconds."""

import motes
from motes.expressions import column
from motes.shapes import Sphere

camera = motes.Camera((0, 0.8, 5.2), (0, 0, 0))
world = motes.World(seed=5, renderer=motes.Renderer(480, 270, camera=camera, bloom=0.2))
trails = world.system("trails", sprite=motes.Sprite("ribbon", width=0.03, length=1.2))
with world:
    for frame in world.frames(60):
        if frame == 0:
            for color in ("#ff5a36", "#ffb347", "#5ad1ff"):
                trails.configure(color=color, alpha=0.7)
                trails.burst(Sphere((0, 0, 0), 1), count=16)
        trails.orbit_line((0, 0, 0), (0.3, 1, 0), magnitude=5, epsilon=0.3)
        trails.curl_noise(3, scale=1, speed=0.4)
        trails.gravity(column("position") * -3)
        trails.damping((0.5, 0.5, 0.5))
        trails.move()
        picture = world.render()
    picture.save("out/smooth_trail.png")
