"""Starlings in the evening fly around a tower: python -m motes run -n 4 examples/flock.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Cone, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-25,25", systems=1, particles=3500, frames=320, size="960x540")


def bird(pixels=96):
    """Draw a bird from above, its beak up, as RGBA."""
    y, x = np.mgrid[-1 : 1 : pixels * 1j, -1 : 1 : pixels * 1j]
    wide = np.abs(x)
    body = (wide / 0.13) ** 2 + ((y - 0.05) / 0.5) ** 2 < 1
    front = -0.22 + 0.35 * wide * wide  # of the wings, which are swept back
    wings = (wide < 0.95) & (y > front) & (y < front + 0.34 * np.sqrt(np.maximum(1 - wide / 0.95, 0)))
    tail = (y > 0.3) & (y < 0.72) & (wide < 0.06 + 0.3 * (y - 0.3))
    light = np.ones_like(x)
    return (np.dstack([light, light, light, body | wings | tail]) * 255).astype(np.uint8)


ground = Plane((0, 0, 0), (0, 1, 0))
tower = Cylinder((0, 0, 0), (0, 15, 0), 2.2)
roof = Cone((0, 21, 0), (0, 15, 0), 2.7)
hills = [Sphere((x, -60, z), r) for x, z, r in ((-50, -70, 66), (20, -90, 67), (75, -60, 65))]
solids = [motes.Solid(ground, (0.03, 0.035, 0.03))]
solids += [motes.Solid(shape, (0.05, 0.045, 0.05)) for shape in (tower, roof)]
solids += [motes.Solid(Sphere((40, 9, -120), 11), (1, 0.45, 0.15), light=4)]  # the sun
solids += [motes.Solid(hill, (0.05, 0.05, 0.06)) for hill in hills]
camera = motes.Camera((0, 2.5, 48), (0, 11, 0), fov_deg=39)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.6, 0.27, 0.16), objects=solids, sun=(0.3, 0.12, -1)
)
world = motes.World(**args.world, renderer=renderer)

birds = world.system("birds", sprite=motes.Sprite("image", pixels=None, blend="alpha", image=bird()))
birds.configure(
    velocity=Sphere((2, 0, 7), 2), size=motes.Uniform((0.6,) * 3, (0.75,) * 3), color=(0.02, 0.018, 0.025)
)

with world, motes.Movie(f"{args.out}/flock.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            birds.burst(Sphere((-16, 12, 0), 7), count=args.particles)
        birds.match_velocity(1, epsilon=0.5, max_radius=2.5)
        birds.gravitate(-3, epsilon=0.2, max_radius=1.4)  # keep a distance
        birds.gravitate(0.09, epsilon=2, max_radius=6)  # but stay together
        birds.curl_noise(9, scale=8, octaves=2, speed=0.4)
        home = (column("position") - (0, 12, 0)) * (0.26, 0.6, 0.32)  # they return to the tower
        birds.set(velocity=column("velocity") - home * world.dt)
        birds.avoid(tower, magnitude=20, epsilon=0.1, look_ahead=1)
        birds.avoid(ground, magnitude=20, epsilon=0.1, look_ahead=1)
        birds.speed_clamp(6, 12)
        birds.set(up=column("velocity"))
        birds.move()
        motes.script.end_frame(world, movie, args)
