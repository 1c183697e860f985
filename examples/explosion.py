"""A barrel of fuel blows up: python -m motes run -n 4 examples/explosion.py."""

import motes
from motes import column
from motes.expressions import clamp, noise
from motes.shapes import Box, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-12,12", systems=3, particles=16000, frames=144, size="960x540")

ground = Plane((0, 0, 0), (0, 1, 0))
heart = (0, 1.2, 0)
barrels = [(-5.5, -2.5), (-4.6, -3.2), (5.2, -3), (6.6, 1.2)]
walls = [
    Box((-13, 0, -9), (-7.5, 5, -8)),
    Box((6.5, 0, -10), (14, 3.4, -9)),
    Box((-7.5, 0, -9), (6.5, 1.4, -8.4)),
]
solids = [motes.Solid(ground, (0.16, 0.14, 0.11))]
solids += [motes.Solid(wall, (0.22, 0.16, 0.12)) for wall in walls]
solids += [motes.Solid(Cylinder((x, 0, z), (x, 1.4, z), 0.5), (0.3, 0.06, 0.03)) for x, z in barrels]
camera = motes.Camera((0, 2.4, 25), (0, 6.3, 0), fov_deg=42)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.09, 0.12, 0.2),
    objects=solids,
    sun=(-0.6, 0.35, 0.5),
    exposure=0.9,
    shutter=0.5,
    bloom=0.15,
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

# Smoke is born as fire: its colours are those of hot gas that cools, brighter than white at first.
cooling = [(0, (12, 8, 3)), (0.08, (6, 2, 0.3)), (0.24, (1.6, 0.3, 0.03))]
cooling += [(0.36, (0.08, 0.03, 0.02)), (0.5, (0.03, 0.026, 0.025)), (1, (0.10, 0.09, 0.085))]
fading = [(0, 0.8), (0.25, 0.5), (0.6, 0.2), (1, 0)]
clouds = []
for i in range(args.systems):
    puff = motes.Sprite(pixels=None, blend="alpha", softness=0.5)
    cloud = world.system(f"cloud {i}", capacity=args.particles, sprite=puff, attributes={"shade": 1})
    cloud.configure(
        lifetime=motes.Uniform(1.6, 6),
        velocity=Sphere((0, 5 + 5 * i, 0), 15 - 3 * i),
        shade=motes.Uniform(0.75, 1.3),
    )
    clouds.append(cloud)
sparks = world.system("sparks", sprite=motes.Sprite(pixels=None))
sparks.configure(velocity=Sphere((0, 7, 0), 26), lifetime=motes.Uniform(0.5, 2.4), size=0.09)
debris = world.system("debris", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
debris.configure(velocity=Sphere((0, 11, 0), 12), color=(0.05, 0.04, 0.04))
debris.configure(size=motes.Uniform((0.08,) * 3, (0.3,) * 3))
trails = world.system("trails", sprite=motes.Sprite(pixels=None, blend="alpha", softness=0.3))
trails.configure(
    lifetime=motes.Uniform(0.8, 1.8),
    velocity=Sphere((0, 0.5, 0), 0.4),
    color=(3, 0.9, 0.15),
    size=0.12,
    alpha=0.5,
)

place = column("position")
every, fuse = 144, 6  # frames
with world, motes.Movie(f"{args.out}/explosion.mp4") as movie:
    for frame in world.frames(args.frames):
        age = (frame % every - fuse) * world.dt
        if age == 0:
            for cloud in clouds:
                cloud.burst(Sphere(heart, 1), count=args.particles)
            sparks.burst(Sphere(heart, 0.8), count=args.particles // 3)
            debris.burst(Sphere(heart, 0.8), count=70)
        flash = 900 * max(0, 1 - age / 1.6) ** 3 if age >= 0 else 0
        renderer.lights = [motes.Light((0, 3 + 2 * max(age, 0), 1), (1, 0.5, 0.16), power=flash)]
        for i, cloud in enumerate(clouds):
            cloud.wind(
                (0.4, 2.2 + 0.8 * i, 0), drag=2.6
            )  # the air stops the gas, and lifts it while it is hot
            cloud.curl_noise(16, scale=2.4, octaves=4, speed=0.5)
            cloud.color_over_life(cooling)
            lit = clamp(1 + (0.35 * place.y - place.x - 2) / 7, 0.35, 1.8)  # the sun stands on the left
            billow = clamp(0.75 + 1.5 * noise(place * 0.5, 0.8 * motes.time(), octaves=3), 0.12, 2)
            cloud.set(color=column("color") * (column("shade") * lit * billow))
            cloud.alpha_over_life(fading)
            cloud.size_over_life([(0, 0.3), (0.1, 0.7), (1, 2.2)])
            cloud.bounce(ground, restitution=0.1, friction=0.1)
        debris.trail(trails, every=world.dt, where=column("age") < 1.6)
        trails.color_over_life([(0, (3, 0.9, 0.15)), (0.1, (0.25, 0.12, 0.06)), (1, (0.13, 0.12, 0.11))])
        trails.size_over_life([(0, 0.12), (1, 0.9)])
        trails.alpha_over_life([(0, 0.5), (0.4, 0.22), (1, 0)])
        sparks.wind((0, 0, 0), drag=1.1)
        sparks.color_over_life([(0, (4, 2, 0.7)), (0.5, (2, 0.6, 0.08)), (1, (0.3, 0.03, 0))])
        for system in (sparks, debris):
            system.gravity((0, -9.81, 0))
            system.bounce(ground, restitution=0.35, friction=0.35)
        for system in (*clouds, sparks, trails, debris):
            if system is not debris:
                system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
