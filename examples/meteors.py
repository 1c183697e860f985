"""A shower of meteors over a lake: python -m motes run -n 4 examples/meteors.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cone, Plane, Sphere

args = motes.script.options(__doc__, space="-60,60", systems=1, particles=6000, frames=144, size="960x540")

# The scene is scaled 1:1000: the sky is a shell of stars, 200 m away.
lake = Plane((0, 0, 0), (0, 1, 0))
dice = np.random.default_rng(5)
peaks = []
for x in np.arange(-110, 111, 11.0):
    high = 9 + 9 * np.cos(x / 23) ** 2 + dice.uniform(-3, 3)
    peaks.append(Cone((x + dice.uniform(-3, 3), high, -95), (x, -1, -95), 1.5 * high))
solids = [motes.Solid(lake, (0.010, 0.014, 0.024))] + [
    motes.Solid(peak, (0.008, 0.010, 0.017)) for peak in peaks
]
camera = motes.Camera((0, 3.5, 42), (0, 24, -40), fov_deg=46)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.004, 0.008, 0.021),
    objects=solids,
    sun=(0, 0, 0),
    bloom=0.3,
    shutter=0.5,
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

skies = []
for i in range(args.systems):
    stars = world.system(f"stars {i}", sprite=motes.Sprite(height=0.0045))
    skies.append(stars)
haze = world.system("haze", sprite=motes.Sprite(height=0.11))
meteors = world.system("meteors", sprite=motes.Sprite(pixels=None))
meteors.configure(size=0.55, color=(9, 10, 9), lifetime=motes.Uniform(0.35, 0.95))
trails = world.system("trails", sprite=motes.Sprite(pixels=None), attributes={"late": 0.0})
trails.configure(size=0.22, lifetime=motes.Uniform(0.2, 1.5), late=motes.Uniform(0, world.dt))
radiant = np.array([-0.62, -0.30, 0.12])  # meteors fly parallel, so they seem to come from one point

with world, motes.Movie(f"{args.out}/meteors.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            for stars in skies:
                for tone, part in (((0.75, 0.85, 1), 3), ((1, 0.9, 0.75), 6), ((1, 0.65, 0.45), 12)):
                    stars.configure(color=tone, alpha=motes.Uniform(0, 0.5))
                    stars.burst(Box((-190, 5, -200), (190, 190, -190)), count=args.particles // part // 2)
                    stars.configure(alpha=motes.Uniform(0.3, 1.6))
                    stars.burst(Box((-190, 5, -200), (190, 190, -190)), count=args.particles // part // 30)
            for k in range(60):  # the Milky Way, from the lower left to the upper right
                x = -170 + 340 * k / 59
                haze.configure(color=(0.5, 0.55, 0.8), alpha=motes.Uniform(0, 0.007))
                haze.burst(Sphere((x, 45 + 0.5 * (x + 60), -200), 24), count=30)
                skies[0].configure(color=(0.8, 0.85, 1), alpha=motes.Uniform(0, 0.35))
                skies[0].burst(Sphere((x, 45 + 0.5 * (x + 60), -200), 20), count=args.particles // 90)
        chance = np.random.default_rng((args.seed, frame))
        for _ in range(chance.poisson(0.32)):
            x, y, z, speed = chance.uniform((-55, 40, -75, 90), (85, 75, -30, 150)).round(3)
            meteors.emit(position=[(x, y, z)], velocity=[(speed * radiant).round(3)])
        meteors.spawn(trails, on="frame", count=90, inherit_velocity=1)
        new = column("age") == 0
        trails.set(position=column("position") - column("velocity") * column("late"), where=new)
        trails.set(velocity=column("velocity") * 0.012, where=new)
        trails.random_acceleration(Sphere((0, 0, 0), 4))
        trails.color_over_life(
            [(0, (1.6, 1.7, 1.3)), (0.15, (0.3, 1.1, 0.6)), (0.5, (0.12, 0.3, 0.4)), (1, (0, 0, 0))]
        )
        for system in (meteors, trails):
            system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
