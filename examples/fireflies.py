"""Fireflies over a meadow at dusk: python -m motes run -n 4 examples/fireflies.py."""

import numpy as np

import motes
from motes.expressions import column, maximum, sin
from motes.shapes import Box, Cone, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-7,7", systems=1, particles=420, frames=144, size="960x540")


def blade(pixels=64):
    """Draw a tuft of grass as RGBA: blades that bend outwards, their tips at the top."""
    y, x = np.mgrid[0 : 1 : pixels * 1j, -1 : 1 : pixels * 1j]
    up = 1 - y
    inside = np.zeros_like(x, bool)
    for lean, high in ((-0.9, 0.7), (-0.45, 0.95), (0.05, 1.0), (0.4, 0.85), (0.85, 0.75)):
        inside |= (np.abs(x - lean * up**2 - 0.12 * lean) < 0.07 * (1 - up / high)) & (up < high)
    light = 0.35 + 0.65 * up
    return (np.dstack([light, light, light, inside]) * 255).astype(np.uint8)


def tree(x, z, high):
    """Return a trunk, and the centres and radii of balls of leaves."""
    dice = np.random.default_rng(abs(int(10 * x)))
    trunk, crown = Cylinder((x, 0, z), (x, 0.7 * high, z), 0.035 * high), []
    for dx, dy, dz in dice.uniform(-1, 1, (9, 3)).round(3):
        place = (x + 0.26 * high * dx, high * (0.72 + 0.2 * dy), z + 0.2 * high * dz)
        crown.append(Sphere(place, 0.17 * high))
    return trunk, crown


meadow = Plane((0, 0, 0), (0, 1, 0))
solids = [
    motes.Solid(meadow, (0.007, 0.014, 0.008)),
    motes.Solid(Sphere((12.3, 17.5, -60), 1.9), (1, 0.93, 0.75), light=1.2),
]
crowns = []
for x, z, high in ((-7.5, -5, 6), (-4.4, -9, 7.5), (6.6, -7, 6.5), (10.5, -11, 8), (1.5, -15, 7)):
    trunk, crown = tree(x, z, high)
    solids.append(motes.Solid(trunk, (0.006, 0.006, 0.008)))
    crowns += crown
solids += [
    motes.Solid(Cone((x, 14 + x % 5, -40), (x, -2, -40), 9), (0.008, 0.012, 0.02)) for x in range(-40, 44, 7)
]
camera = motes.Camera((0, 1.15, 8.5), (0, 1.75, 0), fov_deg=36)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.016, 0.035, 0.075),
    objects=solids,
    sun=(0.25, 0.3, -0.9),
    bloom=0.35,
    shutter=1,
)
world = motes.World(**args.world, renderer=renderer)

grass = world.system("grass", sprite=motes.Sprite("image", pixels=None, blend="alpha", image=blade()))
grass.configure(up=Box((-0.25, 1, 0), (0.25, 1, 0)), color=(0.012, 0.03, 0.012))
leaves = world.system("leaves", sprite=motes.Sprite(pixels=None, blend="opaque"))
leaves.configure(size=motes.Uniform((0.1,) * 3, (0.22,) * 3), color=(0.004, 0.008, 0.009))
flies = world.system("flies", sprite=motes.Sprite(pixels=None), attributes={"rhythm": 3.0})
flies.configure(velocity=Sphere((0, 0, 0), 0.3), rhythm=motes.Uniform(1.6, 2.9), age=motes.Uniform(0, 60))
flies.configure(size=0.035)
glow = world.system("glow", sprite=motes.Sprite(pixels=None), attributes={"late": 0.0})
glow.configure(lifetime=0.6, size=0.016, color=(1.6, 2, 0.3), late=motes.Uniform(0, world.dt))

with world, motes.Movie(f"{args.out}/fireflies.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            for z in np.arange(-6, 7, 0.5):
                grass.configure(size=motes.Uniform((0.35,) * 3, (0.75,) * 3))
                grass.burst(Box((-8, 0.12, z), (8, 0.2, z + 0.5)), count=90)
            for ball in crowns:
                leaves.burst(ball, count=260)
            flies.burst(Box((-6.5, 0.2, -7), (6.5, 2.6, 6)), count=args.particles)
        # Each firefly flashes in its own rhythm.
        flash = maximum(0, sin(column("rhythm") * column("age"))) ** 4
        flies.set(color=flash * (7, 8.5, 1.2) + (0.02, 0.03, 0.0))
        flies.curl_noise(1.6, scale=1.6, octaves=2, speed=0.3)
        flies.wind((0, 0, 0), drag=1.5)
        home = (column("position") - (0, 1.2, 0)) * (0.01, 0.25, 0.01)
        flies.set(velocity=column("velocity") - home * world.dt)
        flies.bounce(meadow)
        flies.spawn(glow, on="frame", count=5, inherit_velocity=1, where=flash > 0.25)
        # Children are born at the end of the fly's path in the frame: spread them along it.
        glow.set(
            position=column("position") - column("velocity") * column("late"),
            velocity=(0, 0, 0),
            where=column("age") == 0,
        )
        glow.color_over_life([(0, (0.8, 1, 0.15)), (0.3, (0.3, 0.4, 0.04)), (1, (0, 0, 0))])
        glow.kill_expired()
        for system in (flies, glow):
            system.move()
        motes.script.end_frame(world, movie, args)
