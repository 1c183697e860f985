"""A wand draws a trail of magic dust: python -m motes run -n 4 examples/wand.py."""

import colorsys

import numpy as np

import motes
from motes.expressions import column, sin
from motes.shapes import Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-4,4", systems=2, particles=24_000, frames=144, size="960x540")


def tip(time):
    """Return the position of the wand's tip, on a closed curve of six seconds."""
    turn = 2 * np.pi * time / 6
    place = (3.0 * np.sin(turn), 2.1 + 1.15 * np.sin(2 * turn + 0.4), 0.9 * np.cos(3 * turn))
    return np.array(place).round(4)  # sines differ in their last bit between machines


floor = Plane((0, 0, 0), (0, 1, 0))
columns = [Cylinder((x, 0, -3.4), (x, 6, -3.4), 0.35) for x in (-5, -3, -1, 1, 3, 5)]
solids = [motes.Solid(floor, (0.05, 0.05, 0.08))] + [motes.Solid(c, (0.07, 0.06, 0.09)) for c in columns]
camera = motes.Camera((0, 1.7, 9), (0, 1.85, 0), fov_deg=35)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.004, 0.003, 0.012), sun=(0, 0, 0), bloom=0.3, shutter=0.3
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

own = {"twinkle": 10.0, "phase": 0.0}
dusts = []
for i in range(args.systems):
    dust = world.system(
        f"dust {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None), attributes=own
    )
    dust.configure(lifetime=motes.Uniform(0.6, 4.2), size=motes.Uniform((0.008,) * 3, (0.03,) * 3))
    dust.configure(
        twinkle=motes.Uniform(6, 26), phase=motes.Uniform(0, 6.3), alpha=min(1, 14_000 / args.particles)
    )
    dusts.append(dust)
veil = world.system("veil", capacity=9000, sprite=motes.Sprite(pixels=None))
veil.configure(lifetime=motes.Uniform(0.4, 1.3), size=0.16, alpha=0.012, velocity=Sphere((0, 0, 0), 0.15))
glitter = 0.35 + 1.8 * sin(column("phase") + column("twinkle") * column("age")) ** 8

with world, motes.Movie(f"{args.out}/wand.mp4") as movie:
    for _ in world.frames(args.frames):
        old, new = tip(world.time - world.dt), tip(world.time)
        hue = (0.72 + world.time / 12) % 1
        tone = np.array(colorsys.hsv_to_rgb(hue, 0.75, 1)).round(4)
        swing = ((new - old) / world.dt).round(4)
        for dust in dusts:
            dust.configure(color=tone, velocity=Sphere(0.18 * swing, 0.5))
            dust.source(
                Sphere(new, 0.03), rate=args.particles / 2.5, jitter=True, moving_from=Sphere(old, 0.03)
            )
            dust.gravity((0, -0.55, 0))
            dust.curl_noise(1.6, scale=0.6, octaves=3, speed=0.5)
            dust.wind((0, 0, 0), drag=0.9)
            dust.bounce(floor, restitution=0.4, friction=0.2)
            dust.alpha_over_life([(0, 1), (0.3, 0.8), (0.7, 0.5), (1, 0)])
            dust.set(alpha=column("alpha") * glitter * min(1, 12_000 / args.particles))
        veil.configure(color=tone)
        veil.source(Sphere(new, 0.05), rate=6000, jitter=True, moving_from=Sphere(old, 0.05))
        veil.curl_noise(1.2, scale=0.8, octaves=2, speed=0.4)
        veil.alpha_over_life([(0, 0.03), (0.3, 0.012), (1, 0)])
        for system in (*dusts, veil):
            system.kill_expired()
            system.move()
        hand = (new + (0.25, -0.75, 0.35)).round(4)
        star = motes.Solid(Sphere(new, 0.035), (1, 0.9, 0.8), light=14)
        renderer.objects = [*solids, star, motes.Solid(Cylinder(hand, new, 0.022), (0.12, 0.06, 0.03))]
        renderer.lights = [motes.Light((new + (0, 0, 0.3)).round(4), tuple(0.4 + 0.6 * tone), power=3)]
        motes.script.end_frame(world, movie, args)
