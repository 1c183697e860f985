"""Rain under a street lamp: python -m motes run -n 4 examples/rain.py."""

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Rectangle, Sphere

args = motes.script.options(__doc__, space="-7,7", systems=4, particles=40_000, frames=96, size="960x540")

# A lamp over a bench, and the wall of a house behind them.
ground = Plane((0, 0, 0), (0, 1, 0))
wall = Box((-9, 0, -4.2), (9, 6, -4))
seat = Box((-2.4, 0.42, -1.2), (-0.6, 0.5, -0.7))
feet = [Box((x, 0, -1.15), (x + 0.08, 0.42, -0.75)) for x in (-2.3, -0.78)]
post = Cylinder((0.9, 0, -1), (0.9, 3.3, -1), 0.05)
arm = Cylinder((0.9, 3.28, -1), (0.4, 3.28, -1), 0.035)
hood = Cylinder((0.4, 3.24, -1), (0.4, 3.34, -1), 0.24)
bulb = Sphere((0.4, 3.16, -1), 0.09)

solids = [motes.Solid(ground, (0.05, 0.055, 0.07)), motes.Solid(wall, (0.07, 0.045, 0.035))]
solids += [motes.Solid(shape, (0.09, 0.05, 0.025)) for shape in (seat, *feet)]
solids += [motes.Solid(shape, (0.02, 0.022, 0.025)) for shape in (post, arm, hood)]
solids += [motes.Solid(bulb, (1, 0.62, 0.25), light=9)]
lamp = motes.Light((0.4, 3.0, -1), (1, 0.62, 0.25), power=16)

camera = motes.Camera((-0.4, 1.35, 6.4), (-0.2, 1.65, 0), fov_deg=34)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.006, 0.009, 0.016),
    objects=solids,
    sun=(0, 0, 0),  # night
    lights=[lamp],
    shutter=0.5,  # a drop falls 19 cm while the shutter is open: a streak
    bloom=0.12,
)
world = motes.World(**args.world, renderer=renderer)

# Drops shine where the lamp reaches them: the nearer the lamp, the brighter.
top, fall = 4.6, 9.0  # m, m/s
drop = motes.Sprite(pixels=None)
falling = []
for i in range(args.systems):
    rain = world.system(f"rain {i}", capacity=args.particles, sprite=drop)
    z = 4.4 - 8 * i / args.systems
    falling.append((rain, Rectangle((-7, top, z), (14, 0, 0), (0, 0, -8 / args.systems))))
splashes = world.system("splashes", capacity=3 * args.particles, sprite=drop)
lit = [(Sphere((0.4, 3, -1), radius), light) for radius, light in ((5, 0.4), (2.8, 0.7), (1.6, 1), (0.8, 1))]

with world, motes.Movie(f"{args.out}/rain.mp4") as movie:
    for frame in world.frames(args.frames):
        for rain, cloud in falling:
            rain.configure(velocity=Box((0.5, -fall - 0.7, -0.1), (0.8, -fall + 0.7, 0.1)), size=0.01)
            if frame == 0:  # start with rain in the air
                low, depth = cloud.origin, cloud.v[2]
                rain.burst(Box((-7, 0.05, low[2] + depth), (7, top, low[2])), count=args.particles * 9 // 10)
            rain.source(cloud, rate=args.particles * 0.9 * fall / top, jitter=True)
            splashes.configure(
                velocity=Box((-0.7, 0.5, -0.7), (0.7, 1.5, 0.7)), size=0.009, lifetime=motes.Uniform(0.1, 0.3)
            )
            rain.spawn(splashes, on="death", count=1)
            for solid in (ground, seat, hood):
                rain.sink(solid)
        # A drop dies at the end of its path in this frame, up to 37 cm below the surface: move its splash up.
        splashes.set(position=column("position") * (1, 0, 1), where=column("age") == 0)
        splashes.gravity((0, -9.8, 0))
        splashes.kill_expired()
        for system in (*(rain for rain, _ in falling), splashes):
            system.set(color=(0.75, 0.85, 1), alpha=0.2)
            for near, light in lit:
                system.set(color=(1, 0.72, 0.4), alpha=light, where=near)
            system.move()
        motes.script.end_frame(world, movie, args)
