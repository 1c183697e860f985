"""The focus moves from a post to the sparks behind it: python -m motes run -n 4 examples/light/focus.py."""

import numpy as np

import motes
from motes.shapes import Box, Cone, Cylinder, Plane, Sphere, Union

args = motes.script.options(__doc__, space="-2,2", systems=1, particles=4000, frames=120, size="960x540")

# A post of iron and brass before the camera; a grindstone on its block five metres behind. Metres.
rng = np.random.default_rng(3)
setts = rng.integers(120, 255, (16, 16)).repeat(8, 0).repeat(8, 1)
setts[::8], setts[:, ::8] = 60, 60
setts = setts[:, :, None].repeat(3, 2).astype(np.uint8)
ground, block = Plane((0, 0, 0), (0, 1, 0)), Box((0.2, 0, -5.3), (1, 0.5, -4.8))
stone = Cylinder((0.6, 0.82, -5.1), (0.6, 0.82, -5), 0.32)
post = Union(Cylinder((-0.62, 0, 0), (-0.62, 1.3, 0), 0.05), Sphere((-0.62, 1.36, 0), 0.085))
rings = Union(*(Cylinder((-0.62, y, 0), (-0.62, y + 0.035, 0), 0.075) for y in (0.1, 0.7, 1.22)))
solids = [
    motes.Solid(ground, (0.14, 0.14, 0.15), image=setts, scale=1.6, roughness=0.5),
    motes.Solid(post, (0.05, 0.07, 0.06), roughness=0.3),
    motes.Solid(rings, (0.9, 0.6, 0.22), roughness=0.25, metal=1),
    motes.Solid(block, (0.3, 0.2, 0.12)),
    motes.Solid(stone, (0.3, 0.3, 0.3)),
]
focus = motes.Curve([(0, 2.9), (1.3, 2.9), (2.6, 7.9), (3.6, 7.9), (4.8, 2.9)], "smooth")
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0, 0.95, 2.9), (0, 0.85, 0), fov_deg=32, focus=focus, aperture=0.07),
    background=motes.Gradient((0.003, 0.0035, 0.007), (0.001, 0.0012, 0.003), (0.001, 0.001, 0.001)),
    fog=((0.002, 0.0025, 0.005), 30),
    objects=solids,
    lights=[
        motes.Light((-1.8, 2.2, 2.2), (0.55, 0.7, 1), 0.9, radius=0.2),  # a window behind the camera
        motes.Light((0.6, 0.75, -4.5), (1, 0.45, 0.12), 0.16, radius=0.2),  # the sparks
        motes.Light((-3.5, 2.4, -7), (1, 0.6, 0.25), 0.7, radius=0.2),  # a street lamp
    ],
    sun=(0, 0, 0),
    exposure=6,
    occlusion=1,
    shutter=0.5,
    bloom=0.15,
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

showers = []
for i in range(args.systems):
    sparks = world.system(f"sparks {i}", sprite=motes.Sprite(pixels=None))
    sparks.configure(velocity=Cone((-1, 2, 1), (-5, 4.5, 0.3), 2), size=motes.Uniform(0.012, 0.024))
    sparks.configure(lifetime=motes.Uniform(0.4, 1.6))
    showers.append(sparks)
lamps = world.system("lamps", sprite=motes.Sprite(pixels=None))
lamps.configure(size=0.12, color=motes.shapes.Line((1, 0.3, 0.06), (1, 0.8, 0.5)))

with world, motes.Movie(f"{args.out}/focus.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            lamps.burst(Box((-7, 1.2, -15), (7, 2.6, -11)), count=26)
        for sparks in showers:
            sparks.source(Box((0.52, 1.14, -5.2), (0.68, 1.16, -5.1)), rate=args.particles / 2, jitter=True)
            sparks.gravity((0, -9.81, 0))
            sparks.wind((0, 0, 0), drag=0.5)
            sparks.bounce([ground, block], restitution=0.4, friction=0.3)
            sparks.color_over_life([(0, (1, 0.7, 0.3)), (0.3, (1, 0.35, 0.06)), (1, (0.6, 0.04, 0))])
            sparks.kill_expired()
        for system in (*showers, lamps):
            system.move()
        motes.script.end_frame(world, movie, args)
