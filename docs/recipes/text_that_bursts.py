"""Text that bursts: letters are shapes for births; an explosion's front passes from left to right."""

import motes
from motes.expressions import column
from motes.shapes import Text

camera = motes.Camera((0, 0, 5), (0, 0, 0))
world = motes.World(seed=1, renderer=motes.Renderer(480, 270, camera=camera, bloom=0.15))
dust = world.system("dust", sprite=motes.Sprite(height=0.006))
dust.configure(color=(1, 0.5, 0.2), alpha=0.35)
with world:
    for frame in world.frames(17):
        if frame == 0:
            dust.burst(Text("motes", height=1.3, depth=0.1), count=30_000)
        dust.explosion((-2.2, -0.2, 0), radius=0.16 * frame, magnitude=14, sigma=0.2, epsilon=1)
        dust.curl_noise(5, scale=0.5, where=column("velocity").length() > 0)
        dust.move()
        picture = world.render()
    picture.save("out/text_that_bursts.png")
