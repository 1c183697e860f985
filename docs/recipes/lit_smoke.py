"""Lit smoke: `lit` shades puffs by sun and lamps, `shadow` lets them darken what lies behind them."""

import motes
from motes.shapes import Disc, Plane, Sphere

camera = motes.Camera((0, 1, 4.5), (0, 0.95, 0))
lamp = motes.Light((-0.9, 0.3, 0.6), "#ff8a40", power=0.8)
renderer = motes.Renderer(
    480,
    270,
    camera=camera,
    background="#2b3646",
    sun=(1, 0.6, 0.2),
    lights=[lamp],
    objects=[motes.Solid(Plane((0, 0, 0), (0, 1, 0)), "#3c3a38")],
)
world = motes.World(seed=15, renderer=renderer)
puff = motes.Sprite(pixels=None, blend="alpha", softness=0.2, lit=True, shadow=0.25)
smoke = world.system("smoke", capacity=6_000, sprite=puff)
smoke.configure(velocity=Sphere((0, 0.9, 0), 0.2), color=(0.8, 0.8, 0.8), lifetime=3)
with world:
    for _ in world.frames(60):
        smoke.source(Disc((0, 0.05, 0), (0, 1, 0), 0.2), rate=700, jitter=True)
        smoke.curl_noise(1.5, scale=0.5, octaves=2, speed=0.3)
        smoke.size_over_life([(0, 0.1), (1, 0.6)])
        smoke.alpha_over_life([(0, 0), (0.1, 0.35), (1, 0)])
        smoke.kill_expired()
        smoke.move()
        picture = world.render()
    picture.save("out/lit_smoke.png")
