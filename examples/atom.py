"""Electrons run around a nucleus and leave trails: python -m motes run -n 4 examples/atom.py."""

import colorsys

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Sphere

args = motes.script.options(__doc__, space="-3,3", systems=6, particles=3, frames=144, size="960x540")

turn = 2 * np.pi / 24  # radians per second, for the camera
camera = motes.Camera((0, 1.6, 8.6), (0, 0, 0), fov_deg=36)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.003, 0.004, 0.012), sun=(-0.4, 0.6, 0.7), bloom=0.3, shutter=0.5
)
world = motes.World(**args.world, substeps=8, renderer=renderer)

# Protons and neutrons are balls that attract each other and may not overlap.
nucleus = world.system("nucleus", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
nucleus.configure(size=0.3)
halo = world.system("halo", sprite=motes.Sprite(pixels=None))
halo.configure(size=2.4, color=(1, 0.35, 0.12), alpha=0.12)

shells = []
for i in range(args.systems):
    electrons = world.system(f"electrons {i}", sprite=motes.Sprite(pixels=None))
    electrons.configure(size=0.10, color=(3, 3.4, 4))
    trail = world.system(f"trail {i}", sprite=motes.Sprite(pixels=None), attributes={"late": 0.0})
    tone = colorsys.hsv_to_rgb(0.48 + 0.36 * i / args.systems, 0.75, 1)
    trail.configure(size=0.035, color=tone, lifetime=motes.Uniform(0.5, 1.7), late=motes.Uniform(0, world.dt))
    shells.append((electrons, trail))

pull, soft = 9.0, 0.05  # m3/s2, m2
with world, motes.Movie(f"{args.out}/atom.mp4") as movie:
    for frame in world.frames(args.frames):
        angle = turn * world.time
        camera.position = np.array([8.6 * np.sin(angle), 1.6, 8.6 * np.cos(angle)]).round(4)
        if frame == 0:
            place = 0.32 * (np.stack(np.mgrid[:3, :3, :3], axis=-1).reshape(-1, 3) - 1)
            color = np.where(np.arange(27)[:, None] % 2, (0.75, 0.06, 0.04), (0.1, 0.2, 0.65))
            nucleus.emit(position=place, color=color)
            halo.burst((0, 0, 0))
        for i, (electrons, trail) in enumerate(shells):
            tilt = np.pi * i / args.systems
            normal = np.array([np.cos(tilt), 0.45, np.sin(tilt)]) / np.hypot(1, 0.45)
            along = np.cross(normal, (0, 1, 0)) / np.linalg.norm(np.cross(normal, (0, 1, 0)))
            across = np.cross(normal, along)
            if frame == 0:
                phases = 2 * np.pi * (np.arange(args.particles) + i / 6) / args.particles
                radius = 1.5 + 0.22 * i
                c, s = np.cos(phases)[:, None], np.sin(phases)[:, None]
                speed = np.sqrt(pull * radius / (radius**2 + soft))
                electrons.emit(
                    position=(radius * (c * along + s * across)).round(4),
                    velocity=(speed * (c * across - s * along)).round(4),
                )
            electrons.orbit_point((0, 0, 0), magnitude=pull, epsilon=soft)
            electrons.move()
            electrons.spawn(trail, on="frame", count=40, inherit_velocity=1)
            # Children are born at the end of the electron's path in the frame: spread them along it.
            new = column("age") == 0
            trail.set(position=column("position") - column("velocity") * column("late"), where=new)
            trail.set(velocity=column("velocity") * 0.03, where=new)
            trail.random_acceleration(Sphere((0, 0, 0), 1))
            trail.alpha_over_life([(0, 0.5), (0.3, 0.2), (1, 0)])
            trail.kill_expired()
            trail.move()
        nucleus.orbit_point((0, 0, 0), magnitude=6, epsilon=0.3)
        nucleus.random_acceleration(Sphere((0, 0, 0), 25))
        nucleus.wind((0, 0, 0), drag=3)
        nucleus.collide(restitution=0.3, sleep=0.1277)
        nucleus.move()
        motes.script.end_frame(world, movie, args)
