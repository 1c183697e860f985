"""Fountains dance at night: python -m motes run -n 4 examples/fountain.py."""

import colorsys

import numpy as np

import motes
from motes.expressions import column, cos
from motes.shapes import Box, Plane, Sphere

args = motes.script.options(__doc__, space="-16,16")
gravity = np.array([0, -9.81, 0])  # m/s^2
life, spread = 2.3, 1.1  # s in the air; spread of velocities, m/s
# Leave room in the capacity, since the source emits a whole number per frame.
drops = args.particles * 47 / 48
batches = 96


def jet(x, time):
    """Return the velocity of water from the nozzle at x, m/s: a wave runs along the row of fountains."""
    phase = 2 * np.pi * (time / 4 - x / 16)
    # Round: sines differ in their last bit between machines, and all ranks must record the same numbers.
    return np.array([1.5 * np.sin(phase), 9.5 + 1.2 * np.cos(2 * phase), 0]).round(4)


# The fountains stand in a row along x, each on a ball in a basin, with a lamp of its colour at its foot.
parts = [(i + 0.5) / args.systems for i in range(args.systems)]
colors = [colorsys.hsv_to_rgb(0.47 + 0.55 * part, 0.7, 1) for part in parts]
pool = Plane((0, 0, 0), (0, 1, 0))
balls = [Sphere((26 * part - 13, 0.35, 0), 0.6) for part in parts]
nozzles = [np.array([26 * part - 13, 0.95, 0]) for part in parts]
rim = Box((-16.5, -0.5, 4), (16.5, 0.25, 4.5)) | Box((-16.5, -0.5, -4.5), (16.5, 0.25, -4))
rim |= Box((-16.5, -0.5, -4), (-16, 0.25, 4)) | Box((16, -0.5, -4), (16.5, 0.25, 4))
tiles = np.where((np.mgrid[:64, :64] % 16 == 0).any(0), 110, 255)[:, :, None].repeat(3, 2).astype(np.uint8)

solids = [motes.Solid(Plane((0, -0.5, 0), (0, 1, 0)), (0.3, 0.3, 0.32), image=tiles, scale=2.4)]
solids += [motes.Solid(rim, (0.4, 0.38, 0.36), roughness=0.4)]
solids += [motes.Solid(ball, (0.3, 0.28, 0.26), roughness=0.25) for ball in balls]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((-14.5, 5.2, 18.5), (-1.6, 2.9, 0), fov_deg=35),
    background=motes.Gradient((0.012, 0.016, 0.035), (0.001, 0.002, 0.006), (0.002, 0.002, 0.003)),
    objects=solids,
    lights=[motes.Light(at + (0, 0.2, 0.9), c, 3) for at, c in zip(nozzles, colors, strict=True)],
    sun=(0, 0, 0),
    occlusion=1,
    bloom=0.1,
)
world = motes.World(**args.world, renderer=renderer)

fountains = []
for part, color, ball, nozzle in zip(parts, colors, balls, nozzles, strict=True):
    water = world.system(f"at {part:.3f}", capacity=args.particles, sprite=motes.Sprite(height=0.0056))
    water.configure(color=color, alpha=motes.Normal(0.01, 0.02))
    fountains.append((water, ball, nozzle))
basin = world.system("basin", sprite=motes.Sprite("surface", radius=0.16))
basin.configure(color=(0.5, 0.7, 0.75), alpha=0.3)


def fill_the_air(water, nozzle):
    """Start the film with running fountains: put each drop where it is at its age."""
    for k in range(batches):
        age = (k + 0.5) * life / batches
        start = jet(nozzle[0], -age)  # its velocity when it left the nozzle
        place = nozzle + start * age + gravity * age * age / 2
        water.configure(age=motes.Uniform(age - life / 2 / batches, age + life / 2 / batches))
        water.configure(velocity=Sphere(start + gravity * age, spread))
        water.burst(Sphere(place, 0.1 + spread * age), count=args.particles * 47 // 48 // batches)
    water.configure(age=0)


with world, motes.Movie(f"{args.out}/fountain.mp4") as movie:
    place, age = column("position"), column("age")
    for frame in world.frames(args.frames):
        if frame == 0:
            x, z = np.mgrid[-15.9:15.9:0.26, -3.9:3.9:0.26].reshape(2, -1)
            basin.emit(position=np.stack([x, 0 * x - 0.16, z], 1).round(4))
        basin.set(
            velocity=(0, 0.12, 0) * (cos(3 * place.x + 5 * age) + cos(4 * place.z - 2 * place.x + 6 * age))
        )
        basin.move()
        for water, ball, nozzle in fountains:
            if frame == 0:
                fill_the_air(water, nozzle)
            water.configure(velocity=Sphere(jet(nozzle[0], world.time), spread))
            water.source(Sphere(nozzle, 0.1), rate=drops / life, jitter=True)
            water.gravity(gravity)
            water.random_acceleration(Sphere((0, 0, 0), 4))
            water.bounce(pool, restitution=0.3, friction=0.2)
            water.bounce(ball, restitution=0.3, friction=0.2)
            water.kill_old(life)
            water.move()
        motes.script.end_frame(world, movie, args)
