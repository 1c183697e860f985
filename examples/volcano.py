"""A volcano throws lava and ash by night: python -m motes run -n 4 examples/volcano.py."""

import numpy as np

import motes
from motes.expressions import clamp, column
from motes.shapes import Cone, Disc, Plane

args = motes.script.options(__doc__, space="-60,60", systems=3, particles=12_000, frames=168, size="960x540")

# Metres. The mountain is a heap of cones; its top is cut off by the crater.
sea = Plane((0, 0, 0), (0, 1, 0))
mountain = Cone((0, 92, 0), (0, -4, 0), 118)
dice = np.random.default_rng(11)
ridges = []
for angle in np.linspace(0.1, np.pi - 0.1, 9):
    for far in (22, 44, 68):
        x, z = (far + dice.uniform(-6, 6)) * np.array([np.cos(angle), np.sin(angle)]).round(3)
        high = 94 - 0.8 * far + dice.uniform(-2, 3)
        ridges.append(Cone((x, high, z), (x, -4, z), 1.1 * (high + 4)))
hills = [
    Cone((x, h, -150), (x, -4, -150), 2.6 * h) for x, h in ((-190, 42), (-120, 30), (130, 36), (205, 50))
]
solids = [motes.Solid(sea, (0.008, 0.012, 0.02)), motes.Solid(mountain, (0.05, 0.04, 0.04))]
solids += [motes.Solid(ridge, (0.05, 0.04, 0.04)) for ridge in ridges]
solids += [motes.Solid(hill, (0.012, 0.014, 0.02)) for hill in hills]
camera = motes.Camera((0, 26, 250), (0, 96, 0), fov_deg=42)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.008, 0.011, 0.024),
    objects=solids,
    sun=(-0.8, 0.3, 0.1),
    exposure=1,
    bloom=0.25,
    shutter=0.5,
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

fountains = []
for i in range(args.systems):
    lava = world.system(f"lava {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None))
    lava.configure(lifetime=motes.Uniform(4, 11), size=motes.Uniform((0.5,) * 3, (1.3,) * 3))
    fountains.append(lava)
ash = world.system(
    "ash", capacity=9000, sprite=motes.Sprite(pixels=None, blend="alpha", softness=4), attributes={"shade": 1}
)
ash.configure(
    lifetime=motes.Uniform(5, 9), velocity=Cone((0, 6, 0), (0, 40, 0), 22), shade=motes.Uniform(0.4, 1.5)
)

place = column("position")
with world, motes.Movie(f"{args.out}/volcano.mp4") as movie:
    for frame in world.frames(args.frames):
        pulse = 0.75 + 0.25 * np.sin(0.31 * frame) + 0.2 * np.sin(0.83 * frame + 1)
        renderer.lights = [motes.Light((0, 112, 30), (1, 0.25, 0.05), power=round(14_000 * pulse, 3))]
        for lava in fountains:
            lava.configure(velocity=Cone((0, 6, 0), (0, round(26 + 14 * pulse, 4), 0), 8))
            lava.source(
                Disc((0, 93, 0), (0, 1, 0), 3), rate=round(args.particles / 11 * pulse, 3), jitter=True
            )
            lava.gravity((0, -9.81, 0))
            for slope in (mountain, *ridges):
                lava.bounce(slope, restitution=0.12, friction=0.16)
            lava.bounce(sea, restitution=0, friction=1)
            lava.color_over_life(
                [(0, (5, 2.2, 0.4)), (0.2, (4, 0.8, 0.06)), (0.6, (1.8, 0.16, 0.01)), (1, (0.1, 0.004, 0))]
            )
        ash.source(Disc((0, 95, -4), (0, 1, 0), 9), rate=700, jitter=True)
        ash.wind((9, 14, 0), drag=0.45)
        ash.curl_noise(14, scale=20, octaves=4, speed=0.25)
        ash.size_over_life([(0, 9), (1, 52)])
        ash.alpha_over_life([(0, 0), (0.08, 0.5), (0.6, 0.3), (1, 0)])
        # Lit from below by the lava, by the moon from the left.
        glow = clamp(1.25 - (place.y - 88) / 78, 0, 1)
        ash.set(
            color=(column("shade") * (glow * glow)) * (0.75, 0.10, 0.015)
            + column("shade") * (0.035, 0.034, 0.04)
        )
        for system in (*fountains, ash):
            system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
