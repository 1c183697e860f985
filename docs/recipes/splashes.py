"""Splashes: a drop that hits dies and leaves children there."""

import motes
from motes.shapes import Box, Plane, Sphere

ground, stone = Plane((0, 0, 0), (0, 1, 0)), Sphere((0, 0, 0), 0.8)
camera = motes.Camera((0, 1.1, 4.5), (0, 0.7, 0), fov_deg=36)
solids = [motes.Solid(ground, "#23282f"), motes.Solid(stone, "#4d5560")]
renderer = motes.Renderer(480, 270, camera=camera, background="#2d3845", objects=solids, shutter=0.5)
world = motes.World(seed=21, renderer=renderer)
rain = world.system("rain", sprite=motes.Sprite(pixels=None, blend="alpha"))
splash = world.system("splash", sprite=motes.Sprite(pixels=None, blend="alpha"))
rain.configure(size=0.012, color=(0.7, 0.8, 0.9), alpha=0.4, velocity=(0.4, -7, 0))
splash.configure(size=0.014, color=(0.8, 0.88, 0.95), velocity=Sphere((0, 1.1, 0), 0.7), lifetime=0.25)
with world:
    for _ in world.frames(36):
        rain.source(Box((-3, 3, -2), (3, 3.2, 2.5)), rate=4_000, jitter=True)
        rain.spawn(splash, on="collision", count=3)
        rain.bounce([ground, stone], restitution=0, hits=True)
        rain.kill_old(0.8)
        splash.gravity((0, -9.8, 0))
        splash.kill_expired()
        rain.move()
        splash.move()
        picture = world.render()
    picture.save("out/splashes.png")
