"""Hail on a parked car: python -m motes run -n 4 examples/hail.py."""

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Rectangle, Sphere, Union

args = motes.script.options(__doc__, space="-5,5", systems=1, particles=16000, frames=144, size="960x540")

# A car on a wet parking lot, in metres: body, cabin, wheels; lines on the asphalt.
lot = Plane((0, 0, 0), (0, 1, 0))
body = Union(
    Box((-2.1, 0.35, -0.85), (2.1, 0.9, 0.85)),
    Cylinder((-2.1, 0.62, -0.8), (-2.1, 0.62, 0.8), 0.27),
    Cylinder((2.1, 0.62, -0.8), (2.1, 0.62, 0.8), 0.27),
)
cabin = Union(
    Box((-1.0, 0.9, -0.72), (0.75, 1.38, 0.72)),
    Cylinder((-1.0, 0.95, -0.7), (-1.0, 0.95, 0.7), 0.42),
    Cylinder((0.75, 0.95, -0.7), (0.75, 0.95, 0.7), 0.42),
)
roof = Box((-1.05, 1.38, -0.74), (0.8, 1.44, 0.74))
wheels = [
    Cylinder((x, 0.33, z - 0.12), (x, 0.33, z + 0.12), 0.33) for x in (-1.35, 1.35) for z in (-0.75, 0.75)
]
hubs = [Cylinder((x, 0.33, 0.86), (x, 0.33, 0.89), 0.17) for x in (-1.35, 1.35)]
lines = [Box((x, 0, -2.2), (x + 0.12, 0.006, 2.4)) for x in (-5.4, -2.9, 2.78, 5.3)]
lights = [Cylinder((2.36, 0.68, z), (2.4, 0.68, z), 0.13) for z in (-0.55, 0.55)]

solids = [motes.Solid(lot, (0.035, 0.04, 0.046)), motes.Solid(Union(*lines), (0.5, 0.5, 0.45))]
solids += [motes.Solid(body, (0.42, 0.035, 0.03)), motes.Solid(cabin, (0.03, 0.04, 0.05))]
solids += [motes.Solid(roof, (0.42, 0.035, 0.03)), motes.Solid(Union(*wheels), (0.012, 0.012, 0.012))]
solids += [motes.Solid(Union(*hubs), (0.4, 0.4, 0.42)), motes.Solid(Union(*lights), (1, 0.9, 0.6), light=2)]
camera = motes.Camera((4.3, 1.7, 6.2), (0.1, 0.8, 0), fov_deg=36)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.15, 0.18, 0.21),
    objects=solids,
    sun=(-0.3, 0.9, 0.35),
    shutter=0.2,
)
world = motes.World(**args.world, substeps=4, renderer=renderer)

stone = motes.Sprite("sphere", pixels=None, blend="alpha")
storm = []
for i in range(args.systems):
    hail = world.system(f"hail {i}", capacity=args.particles, sprite=stone)
    hail.configure(
        velocity=Sphere((1.2, -15, 0.3), 1.2),
        size=motes.Uniform((0.014,) * 3, (0.036,) * 3),
        color=(0.85, 0.9, 0.95),
    )
    hail.configure(lifetime=motes.Uniform(2.5, 6))
    storm.append(hail)
spray = world.system("spray", capacity=20_000, sprite=motes.Sprite(pixels=None))
spray.configure(size=0.014, alpha=0.25, lifetime=motes.Uniform(0.08, 0.22), velocity=Sphere((0, 1, 0), 0.9))

with world, motes.Movie(f"{args.out}/hail.mp4") as movie:
    for frame in world.frames(args.frames):
        for hail in storm:
            if frame == 0:  # some already lie on the ground
                hail.burst(Box((-8, 0.02, -9), (7, 0.025, 4)), count=args.particles // 4)
                hail.set(velocity=(0, 0, 0))
            hail.source(
                Rectangle((-8, 6, -9), (15, 0, 0), (0, 0, 11)), rate=args.particles / 4.6, jitter=True
            )
            hail.spawn(spray, on="collision", count=2, where=column("velocity").length() > 2.5)
            hail.gravity((0, -9.81, 0))
            for part in (body, cabin, roof):
                hail.bounce(part, restitution=0.4, friction=0.25)
            hail.bounce(lot, restitution=0.33, friction=0.3)
            hail.kill_expired()
            hail.move()
        spray.gravity((0, -9.81, 0))
        spray.kill_expired()
        spray.move()
        motes.script.end_frame(world, movie, args)
