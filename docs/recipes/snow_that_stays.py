"""Snow that stays: what hits the roof or the ground lies there."""

import motes
from motes.expressions import column
from motes.shapes import Box, Cone, Plane

ground = Plane((0, 0, 0), (0, 1, 0))
house = [Box((-0.7, 0, -0.7), (0.7, 0.8, 0.7)), Cone((0, 1.7, 0), (0, 0.8, 0), 1.15)]
camera = motes.Camera((1.5, 1.6, 4.5), (0, 0.75, 0), fov_deg=38)
solids = [motes.Solid(ground, "#39424e"), motes.Solid(house[0], "#6d4c3d"), motes.Solid(house[1], "#57352e")]
world = motes.World(
    seed=4, renderer=motes.Renderer(480, 270, camera=camera, background="#2c3a52", objects=solids)
)
snow = world.system("snow", sprite=motes.Sprite("disc", pixels=None, blend="alpha", lit=True))
snow.configure(size=0.025, velocity=(0.3, -1.4, 0))
with world:
    for _ in world.frames(144):
        snow.source(Box((-3.6, 2.9, -2), (2.4, 3, 1.2)), rate=4_000, jitter=True)
        snow.bounce([ground, *house], restitution=0, friction=1, hits=True)
        snow.curl_noise(2, scale=1, speed=0.3, where=column("velocity").length() > 0)
        snow.rest(0.6)
        snow.move()
        picture = world.render()
    picture.save("out/snow_that_stays.png")
