"""Fireworks over a harbour: python -m motes run -n 4 examples/fireworks.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Disc, Plane, Sphere

args = motes.script.options(__doc__, space="-90,90", particles=160_000, frames=264, size="960x540")

# What rockets carry: colour and number of stars, how these fly apart (m/s), how long their sparks burn (s).
shells = [
    ((1.0, 0.14, 0.08), 170, Sphere((0, 0, 0), 58, inner_radius=54), 2.5),
    ((1.0, 0.46, 0.12), 90, Sphere((0, 9, 0), 46, inner_radius=43), 4.4),
    ((0.12, 0.38, 1.0), 150, Sphere((0, 0, 0), 50, inner_radius=47), 2.7),
    ((0.14, 1.0, 0.36), 80, Disc((0, 0, 0), (0.35, 1, 0.6), 52, inner_radius=51), 2.4),
    ((0.70, 0.16, 1.0), 190, Sphere((0, 0, 0), 46, inner_radius=12), 2.7),
]
every, delay = 52, 13  # frames between rockets from one place, and between places

# The town is a black skyline against the sky. The water (below y = 0) is a mirror made of particles:
# lamps, rockets, stars and sparks have dimmer twins, upside down.
water = Plane((0, 0, 0), (0, 1, 0))
dice = np.random.default_rng(args.seed)
houses = dice.uniform((-230, 3, 6), (220, 15, 15), (64, 3)).round(2)  # left edge, height, width
solids = [motes.Solid(Box((x, -h, -40), (x + w, h, -30)), (0, 0, 0)) for x, h, w in houses]
camera = motes.Camera((0, 9, 290), (0, 45, 0), fov_deg=38)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.003, 0.005, 0.014), objects=solids)
world = motes.World(**args.world, renderer=renderer)

lamps = world.system("lamps", sprite=motes.Sprite(height=0.0056))
lamps.configure(color=(1, 0.5, 0.2), alpha=motes.Uniform(0, 1))
crackle = world.system("crackle", sprite=motes.Sprite(height=0.0056))
crackle.configure(velocity=Sphere((0, 0, 0), 9), lifetime=motes.Uniform(0.04, 0.3), color=(1, 0.9, 0.7))

# A rocket leaves a trail of sparks and bursts into stars. Stars live briefly and emit the visible sparks.
fleet = []
for i in range(2 * args.systems):
    color, stars, leave, life = shells[i // 2 % len(shells)]
    mirrored = i % 2 == 1
    rocket = world.system(f"rocket {i}")
    rocket.configure(alpha=0)
    star = world.system(f"star {i}")
    star.configure(alpha=0, velocity=leave, lifetime=0.01)
    spark = world.system(f"spark {i}", sprite=motes.Sprite(height=0.0019), attributes={"drag": 1})
    spark.configure(color=color, velocity=Sphere((0, 0, 0), 0.8), drag=motes.Uniform(0.9, 3))
    spark.configure(lifetime=motes.Uniform(0.3 * life, life))
    fleet.append((i // 2, mirrored, rocket, star, spark, stars))


def light_the_town():
    """Put lamps into all windows, and their mirror images into the water."""
    for x, high, wide in houses:
        lamps.burst(Box((x, 0, -29), (x + wide, high, -29)), count=12)
        lamps.burst(Box((x, -1.3 * high, -29), (x + wide, -1, -29)), count=12)


def launch(rocket, place, frame, up):
    """Launch a rocket; it and its mirror image draw the same random numbers."""
    chance = np.random.default_rng((args.seed, frame, place))
    x, z, speed, fuse = chance.uniform((-90, -20, 47, 1.5), (90, 20, 62, 2)).round(3)
    rocket.emit(position=[(x, 0, z)], velocity=[(-0.1 * x, up * speed, 0)], lifetime=[fuse])


with world, motes.Movie(f"{args.out}/fireworks.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            light_the_town()
        for place, mirrored, rocket, star, spark, stars in fleet:
            up, light = (-1, 0.4) if mirrored else (1, 1.0)
            if (frame + every + 1 - place * delay) % every == 0:
                launch(rocket, place, frame, up)
            rocket.spawn(spark, on="birth", count=1 + args.particles // 200, inherit_velocity=1)
            rocket.spawn(star, on="death", count=stars)
            star.spawn(spark, on="birth", count=1 + args.particles // stars // 3, inherit_velocity=1)
            # The sparks of a star start together and differ only in drag, so they spread out into its tail.
            spark.set(velocity=column("velocity") * (1 - column("drag") * world.dt))
            spark.alpha_over_life([(0, light), (0.12, 0.3 * light), (0.7, 0.13 * light), (1, 0)])
            spark.spawn(crackle, on="death", count=2, where=(column("drag") < 0.95) & ~water)
            spark.random_displacement(Box((-8, -36, 0), (8, 36, 0)), where=water)  # waves blur the mirror
            for system in (rocket, star, spark):
                system.gravity((0, -9.81 * up, 0))
                system.kill_expired()
                system.move()
        crackle.kill_expired()
        crackle.move()
        motes.script.end_frame(world, movie, args)
