"""A flame thrower turns and sweeps the ground: python -m motes run -n 4 examples/flamethrower.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cone, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-9,9", systems=3, particles=24_000, frames=144, size="960x540")

ground = Plane((0, 0, 0), (0, 1, 0))
wall = Box((-9, 0, -6.4), (9, 1.6, -6))
blocks = [
    Box((-5.2, 0, -2.6), (-4, 1.2, -1.4)),
    Box((4.4, 0, -1.4), (5.4, 1, -0.4)),
    Box((1.6, 0, -4.9), (2.8, 1.8, -3.9)),
]
foot = Cone((0, 1.6, 0), (0, 0, 0), 0.6)
solids = [motes.Solid(ground, (0.10, 0.09, 0.08)), motes.Solid(wall, (0.14, 0.12, 0.1))]
solids += [motes.Solid(block, (0.16, 0.13, 0.10)) for block in blocks]
solids += [motes.Solid(foot, (0.09, 0.1, 0.1))]
camera = motes.Camera((0, 4.6, 14.5), (0, 1.5, 0), fov_deg=36)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.004, 0.006, 0.013), sun=(0, 0, 0), bloom=0.2, shutter=0.4
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

burning = [
    (0, (0.25, 0.35, 1.1)),
    (0.06, (1, 0.75, 0.4)),
    (0.3, (1, 0.36, 0.06)),
    (0.7, (0.8, 0.11, 0.01)),
    (1, (0.3, 0.01, 0)),
]
flames = []
for i in range(args.systems):
    fire = world.system(f"fire {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None))
    fire.configure(lifetime=motes.Uniform(0.35, 1.5))
    flames.append(fire)
smoke = world.system("smoke", capacity=6000, sprite=motes.Sprite(pixels=None, blend="alpha", softness=0.4))
smoke.configure(lifetime=motes.Uniform(1.5, 3.2), velocity=Sphere((0, 1.5, 0), 0.4), alpha=0, size=0.3)
embers = world.system("embers", capacity=4000, sprite=motes.Sprite(pixels=None))
embers.configure(lifetime=motes.Uniform(0.6, 2.4), size=0.03)

with world, motes.Movie(f"{args.out}/flamethrower.mp4") as movie:
    for _ in world.frames(args.frames):
        # It turns once in six seconds. Round: sines differ in their last bit between machines.
        angle = 2 * np.pi * world.time / 6 + 0.7
        aim = np.array([np.cos(angle), -0.045, np.sin(angle)])
        muzzle = (np.array([0, 1.65, 0]) + 1.1 * aim).round(4)
        far = (np.array([0, 0.9, 0]) + 5.5 * aim).round(4)
        renderer.lights = [
            motes.Light((muzzle + 1.5 * aim + (0, 0.5, 0)).round(4), (1, 0.45, 0.12), power=5),
            motes.Light((far + (0, 0.6, 0)).round(4), (1, 0.35, 0.08), power=8),
        ]
        renderer.objects = [*solids, motes.Solid(Cylinder((0, 1.65, 0), muzzle, 0.09), (0.1, 0.1, 0.11))]
        for fire in flames:
            fire.configure(velocity=Cone((0, 0, 0), (19 * aim).round(4), 1.5))
            fire.source(Sphere(muzzle, 0.05), rate=args.particles / 0.95, jitter=True)
            fire.color_over_life(burning)
            fire.size_over_life([(0, 0.06), (0.3, 0.2), (1, 0.42)])
            light = min(1, 3000 / args.particles)
            fire.alpha_over_life([(0, 0.5 * light), (0.12, 0.35 * light), (0.5, 0.13 * light), (1, 0)])
            fire.gravity((0, 2.6, 0), where=column("age") > 0.25)  # hot gas rises when it has slowed down
            fire.curl_noise(12, scale=0.9, octaves=3, speed=1.5)
            fire.wind((0, 0.8, 0), drag=2.2)
            for solid in (ground, wall, *blocks):
                fire.bounce(solid, restitution=0.1, friction=0.15)
            fire.spawn(smoke, on="death", count=1, where=column("lifetime") > 1.45)
        embers.configure(velocity=Cone((0, 0, 0), (15 * aim + (0, 1, 0)).round(4), 4))
        embers.source(Sphere(muzzle, 0.05), rate=220, jitter=True)
        embers.gravity((0, -6, 0))
        embers.wind((0, 0.5, 0), drag=0.9)
        embers.bounce(ground, restitution=0.3, friction=0.3)
        embers.color_over_life([(0, (4, 1.5, 0.3)), (0.6, (3, 0.5, 0.04)), (1, (0.6, 0.02, 0))])
        smoke.color_over_life(
            [(0, (0.08, 0.03, 0.012)), (0.3, (0.035, 0.03, 0.03)), (1, (0.03, 0.03, 0.032))]
        )
        smoke.size_over_life([(0, 0.5), (1, 2.4)])
        smoke.alpha_over_life([(0, 0), (0.15, 0.02), (1, 0)])
        smoke.wind((0.4, 1.2, 0), drag=1)
        for system in (*flames, embers, smoke):
            system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
