"""The surface of a star boils and throws flares: python -m motes run -n 4 examples/star.py."""

import numpy as np

import motes
from motes.expressions import clamp, column, mix, noise, normalize, time
from motes.shapes import Sphere

args = motes.script.options(__doc__, space="-2,2", systems=3, particles=60_000, frames=144, size="960x540")

camera = motes.Camera((0, 0.7, 6), (0, 0, 0), fov_deg=34)
core = motes.Solid(Sphere((0, 0, 0), 0.97), (0.5, 0.08, 0.01), light=0.25)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.002, 0.001, 0.003), objects=[core], sun=(0, 0, 0), bloom=0.3
)
world = motes.World(**args.world, renderer=renderer)

shells = []
for i in range(args.systems):
    gas = world.system(f"gas {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None))
    gas.configure(lifetime=motes.Uniform(1.5, 5), size=motes.Uniform((0.012,) * 3, (0.03,) * 3))
    shells.append(gas)
flares = world.system("flares", capacity=60_000, sprite=motes.Sprite(pixels=None))
flares.configure(lifetime=motes.Uniform(0.8, 2.6), size=motes.Uniform((0.012,) * 3, (0.028,) * 3))
sky = world.system("sky", sprite=motes.Sprite(height=0.003))
sky.configure(alpha=motes.Uniform(0, 0.7))

place = column("position")
out = normalize(place)
# Convection: bright cells between dark lanes, and large regions that are hotter than others.
cells = clamp(
    1.6 * abs(noise(place * 4.5, 0.5 * time(), octaves=3)) + 0.9 * noise(place * 1.3, 0.15 * time(), field=1),
    0,
    1,
)
light = min(1, 30_000 / args.particles)

with world, motes.Movie(f"{args.out}/star.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            sky.burst(Sphere((0, 0, -10), 26, inner_radius=22), count=1500)
        angle = 0.25 * world.time
        camera.position = np.array([6 * np.sin(angle), 0.7, 6 * np.cos(angle)]).round(4)
        for gas in shells:
            if frame == 0:
                gas.burst(Sphere((0, 0, 0), 1.01, inner_radius=1), count=args.particles // 2)
            gas.source(Sphere((0, 0, 0), 1.01, inner_radius=1), rate=args.particles / 3.6, jitter=True)
            gas.curl_noise(1.2, scale=0.35, octaves=2, speed=0.4)
            gas.wind((0, 0, 0), drag=2.5)
            gas.move()
            gas.set(position=out * 1.0)  # it stays on the surface
            hot = mix((0.55, 0.06, 0.005), (1.6, 0.75, 0.16), cells)
            gas.set(color=hot * (0.25 + cells))
            gas.alpha_over_life([(0, 0), (0.2, light), (0.8, light), (1, 0)])
            gas.kill_expired()
            # The hottest gas leaves the surface along arches.
            chosen = (cells > 0.93) & (column("lifetime") > 4.6) & (column("age") < 0.4)
            gas.spawn(flares, on="frame", count=2, where=chosen)
        new = column("age") == 0
        flares.set(velocity=out * 0.75, where=new)
        flares.orbit_point((0, 0, 0), magnitude=0.85, epsilon=0.1)
        flares.curl_noise(2.2, scale=0.55, octaves=2, speed=0.15)
        flares.color_over_life([(0, (1.8, 0.7, 0.12)), (0.4, (1.2, 0.22, 0.03)), (1, (0.3, 0.01, 0.01))])
        flares.alpha_over_life([(0, 0.7), (0.6, 0.35), (1, 0)])
        flares.sink(Sphere((0, 0, 0), 0.98))
        flares.kill_expired()
        flares.move()
        motes.script.end_frame(world, movie, args)
