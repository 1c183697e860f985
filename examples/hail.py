"""Hail on a parked car: python -m motes run -n 4 examples/hail.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Rectangle, Sphere, Union

args = motes.script.options(__doc__, space="-5,5", systems=1, particles=16000, frames=144, size="960x540")


def hull(stations, around=40):
    """Make a rounded body: at each x, a cross-section from low to high, so wide to both sides."""
    angle = np.arange(around) * (2 * np.pi / around)
    across, up = (np.sign(f(angle)) * np.abs(f(angle)) ** 0.45 for f in (np.cos, np.sin))
    x, low, high, half = np.array(stations).T[:, :, None]
    ring = np.stack([x + 0 * up, (low + high) / 2 + (high - low) / 2 * up, half * across], 2)
    ends = ring.mean(1)[[0, -1]]
    n, k = len(stations), np.arange(around)
    a = (np.arange(n - 1)[:, None] * around + k).ravel()
    b = (np.arange(n - 1)[:, None] * around + (k + 1) % around).ravel()
    faces = [np.stack([a, b, a + around], 1), np.stack([b, b + around, a + around], 1)]
    last = (n - 1) * around
    faces += [np.stack([k * 0 + n * around, (k + 1) % around, k], 1)]
    faces += [np.stack([k * 0 + n * around + 1, last + k, last + (k + 1) % around], 1)]
    corners = np.concatenate([ring.reshape(-1, 3), ends]).round(4)
    return motes.Mesh(corners, np.concatenate(faces), smooth=True)


# A car on a wet parking lot, in metres: body, cabin, roof; wheels, lamps and lines on the asphalt.
lot = Plane((0, 0, 0), (0, 1, 0))
body = hull(
    [(-2.15, 0.45, 0.75, 0.7), (-2.1, 0.36, 0.88, 0.8), (-1.6, 0.3, 0.97, 0.86), (-0.9, 0.28, 0.98, 0.88)]
    + [(0.7, 0.28, 0.96, 0.88), (1.4, 0.3, 0.9, 0.86), (2, 0.34, 0.78, 0.8), (2.15, 0.42, 0.66, 0.68)]
)
cabin = hull(
    [(-1.75, 0.8, 0.92, 0.6), (-1.4, 0.8, 1.15, 0.66), (-0.95, 0.8, 1.36, 0.68), (-0.3, 0.8, 1.42, 0.68)]
    + [(0.3, 0.8, 1.38, 0.68), (0.75, 0.8, 1.2, 0.67), (1.2, 0.8, 0.94, 0.62)]
)
roof = hull(
    [(-1.0, 1.3, 1.37, 0.55), (-0.9, 1.3, 1.4, 0.62), (-0.3, 1.34, 1.45, 0.64), (0.2, 1.32, 1.42, 0.62)]
    + [(0.35, 1.3, 1.37, 0.55)]
)
wheels = [Cylinder((x, 0.33, z - 0.1), (x, 0.33, z + 0.1), 0.33) for x in (-1.35, 1.35) for z in (-0.8, 0.8)]
hubs = [Cylinder((x, 0.33, 0.9), (x, 0.33, 0.92), 0.19) for x in (-1.35, 1.35)]
lines = [Box((x, 0, -2.2), (x + 0.12, 0.006, 2.4)) for x in (-5.4, -2.9, 2.78, 5.3)]
lamps = [Sphere((2.02, 0.62, z), 0.13) for z in (-0.52, 0.52)]
grit = np.random.default_rng(4).integers(150, 255, (128, 128, 1)).repeat(3, 2).astype(np.uint8)
paint = {"color": (0.5, 0.03, 0.025), "roughness": 0.15}
solids = [motes.Solid(lot, (0.06, 0.062, 0.068), image=grit, scale=1.5, roughness=0.3)]
solids += [motes.Solid(body, **paint), motes.Solid(roof, **paint)]
solids += [motes.Solid(cabin, (0.012, 0.016, 0.02), roughness=0.05)]
solids += [motes.Solid(Union(*wheels), (0.015, 0.015, 0.016)), motes.Solid(Union(*lines), (0.5, 0.5, 0.45))]
solids += [motes.Solid(Union(*hubs), (0.75, 0.75, 0.78), roughness=0.3, metal=1)]
solids += [motes.Solid(Union(*lamps), (1, 0.9, 0.65), light=3)]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((4.3, 1.55, 6.2), (0.1, 0.75, 0), fov_deg=34),
    background=motes.Gradient((0.17, 0.19, 0.21), (0.3, 0.33, 0.37), (0.05, 0.05, 0.05)),
    fog=((0.17, 0.19, 0.21), 60),
    objects=solids,
    sun=(-0.4, 0.9, 0.35),
    sun_power=1.5,
    sun_size=3,
    occlusion=1,
    exposure=1.2,
    shutter=0.3,
    bloom=0.05,
)
world = motes.World(**args.world, substeps=4, renderer=renderer)

ice = motes.Sprite("sphere", pixels=None, blend="opaque", lit=True, shadow=1, roughness=0.2)
storm = []
for i in range(args.systems):
    hail = world.system(f"hail {i}", capacity=args.particles, sprite=ice)
    hail.configure(velocity=Sphere((1.2, -15, 0.3), 1.2), color=(0.85, 0.9, 0.95))
    hail.configure(size=motes.Uniform(0.014, 0.04), lifetime=motes.Uniform(2.5, 6))
    storm.append(hail)
spray = world.system("spray", sprite=motes.Sprite(pixels=None, blend="alpha", lit=True))
spray.configure(size=0.012, alpha=0.5, lifetime=motes.Uniform(0.08, 0.25), velocity=Sphere((0, 1.2, 0), 0.9))

with world, motes.Movie(f"{args.out}/hail.mp4") as movie:
    for frame in world.frames(args.frames):
        for hail in storm:
            if frame == 0:  # some already lie on the ground
                hail.burst(Box((-8, 0.02, -9), (7, 0.025, 4)), count=args.particles // 4)
                hail.set(velocity=(0, 0, 0))
            cloud = Rectangle((-8, 6, -9), (15, 0, 0), (0, 0, 11))
            hail.source(cloud, rate=args.particles / 4.6, jitter=True)
            hail.spawn(spray, on="collision", count=3, where=column("velocity").length() > 4)
            hail.gravity((0, -9.81, 0))
            hail.bounce([body, cabin, roof], restitution=0.4, friction=0.2)
            hail.bounce(lot, restitution=0.33, friction=0.3)
            hail.kill_expired()
            hail.move()
        spray.gravity((0, -9.81, 0))
        spray.kill_expired()
        spray.move()
        motes.script.end_frame(world, movie, args)
