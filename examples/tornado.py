"""A tornado passes a farm: python -m motes run -n 4 examples/tornado.py."""

import numpy as np

import motes
from motes.expressions import column, maximum, minimum
from motes.shapes import Box, Cylinder, Plane, Rectangle, Sphere, Triangle, Union

args = motes.script.options(__doc__, space="-8,8", particles=150_000, frames=192, size="960x540")

# The farm, in metres: a barn with its gable and roof, a fence of posts and two rails before it.
ground = Plane((0, 0, 0), (0, 1, 0))
barn = Box((6, 0, -5), (12, 2.6, -1)) | Triangle((6, 2.6, -5), (6, 2.6, -1), (6, 4.4, -3))
roof = Union(*(Rectangle((5.7, 4.5, -3), (6.6, 0, 0), (0, -2.2, z)) for z in (-2.4, 2.4)))
posts = [Cylinder((x, 0, 8), (x, 0.9, 8), 0.06) for x in range(-14, 16, 2)]
rails = [Cylinder((-15, y, 8), (15, y, 8), 0.035) for y in (0.4, 0.75)]
solids = [
    motes.Solid(ground, (0.13, 0.11, 0.06)),
    motes.Solid(barn, (0.3, 0.05, 0.03)),
    motes.Solid(roof, (0.1, 0.1, 0.12)),
    motes.Solid(Union(*posts, *rails), (0.2, 0.18, 0.15)),
]
camera = motes.Camera((3, 1.7, 27), (1.5, 8, 0), fov_deg=44)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.035, 0.05, 0.075), exposure=0.5, objects=solids
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

cloud = world.system("cloud", sprite=motes.Sprite(height=0.028))
cloud.configure(alpha=0.018)
debris = world.system("debris", sprite=motes.Sprite(height=0.0056))
debris.configure(mass=motes.Uniform(0.8, 3), lifetime=motes.Uniform(3, 6), color=(0.3, 0.2, 0.1))
dust = []
for i in range(args.systems):
    grains = world.system(f"dust {i}", sprite=motes.Sprite(height=0.0037 + 0.0019 * (i % 4)))
    grains.configure(mass=motes.Uniform(0.8, 1.7), lifetime=motes.Uniform(2, 5))
    dust.append(grains)


def bright(light):
    """Limit a brightness to 0.1..1, for every particle."""
    return minimum(1, maximum(0.1, light))


def whirl(system, number, turn, foot, lean):
    """Tear particles off the ground around the foot, and let them circle upwards."""
    x, z = foot
    angle = 3 * turn + 2 * np.pi * number / len(dust)
    torn = np.array([x + 3 * np.cos(angle), 0.3, z + 3 * np.sin(angle)]).round(4)
    system.source(Sphere(torn, 2), rate=400 if system is debris else args.particles / 4, jitter=True)
    system.gravity((0, -1, 0))
    system.vortex(
        (x, -4, z),
        axis=(lean, 22, 0),
        tightness=2.2,
        max_radius=12,
        in_speed=26,
        up_speed=330,
        around_speed=600,
    )
    system.random_acceleration(Sphere((0, 0, 0), 25))
    system.bounce(ground, restitution=0.2)
    system.kill_expired()
    system.move()


def spread_the_cloud():
    """Lay puffs along a spiral, densest in the middle, 17 m above the ground."""
    for k in range(500):
        r, angle = 3 + 50 * (k / 500) ** 0.7, 2.4 * k  # 2.4: about the golden angle, which leaves no gaps
        puff = (r * np.cos(angle), 17 + 0.05 * r + 1.5 * np.sin(5 * angle + r), r * np.sin(angle) - 12)
        cloud.burst(Sphere(np.array(puff).round(4), 2.5), count=1 + args.particles // 2000)


with world, motes.Movie(f"{args.out}/tornado.mp4") as movie:
    place = column("position")
    for frame in world.frames(args.frames):
        # The foot moves along a curve, and the funnel leans in its direction. Round: sines differ in their
        # last bit between machines, and all ranks must record the same numbers.
        turn = 0.7 * world.time
        path = np.array([4 * np.sin(turn) - 2, 1.5 * np.cos(2 * turn), 3 * np.cos(turn)])
        x, z, lean = path.round(4).tolist()
        for number, system in enumerate([debris, *dust]):
            whirl(system, number, turn, (x, z), lean)
        for grains in dust:  # light comes from the left: grains right of the funnel's axis lie in its shadow
            light = bright(0.5 + (x + lean * place.y / 22 - place.x) / (1 + place.y / 3))
            grains.set(color=light * (1, 0.8, 0.58))
            grains.alpha_over_life([(0, 0), (0.25, 0.05), (0.6, 0.09), (1, 0)])
            grains.set(alpha=column("alpha") * minimum(1, 0.08 + place.y / 12))
        if frame == 0:
            spread_the_cloud()
        cloud.set(
            color=bright(0.45 - place.x / 50 + (place.y - 18) / 6) * (0.75, 0.78, 0.85),
            velocity=place.z * (0.1, 0, 0) - place.x * (0, 0, 0.1),  # rotation about the y axis
        )
        cloud.move()
        motes.script.end_frame(world, movie, args)
