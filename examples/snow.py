"""Snow falls on a house in the blue hour: python -m motes run -n 4 examples/snow.py."""

import motes
from motes.shapes import Box, Cone, Plane, Rectangle, Sphere, Triangle, Union

args = motes.script.options(__doc__, space="-30,30")

# The scene, in metres: a house and a snowman on a meadow, a wood behind them. y is up; -z is ahead.
ground = Plane((0, 0, 0), (0, 1, 0))
walls = Box((-4, 0, -3), (4, 3.1, 3))
chimney = Box((2, 4, -1.6), (2.8, 6.4, -0.8))
slopes = [Rectangle((-4.3, 2.85, z), (8.6, 0, 0), (0, 2.75, -z)) for z in (-3.4, 3.4)]  # of the roof
snowman = [Sphere((6, y, 4.6), radius) for y, radius in ((0.6, 0.75), (1.6, 0.5), (2.3, 0.32))]
gables = [Triangle((x, 3.1, -3), (x, 3.1, 3), (x, 5.55, 0)) for x in (-4, 4)]  # the walls under the roof
nose = Cone((6.2, 2.28, 5.2), (6.1, 2.3, 4.85), 0.06)
TIERS = ((1, 0.14), (0.78, 0.2), (0.55, 0.26))  # of a fir: heights of tips, radii, as parts of its height

panes = []  # two windows of four panes each
for x in (-2.9, -2.32, 1.8, 2.38):
    for y in (1.1, 1.73):
        panes.append(Box((x, y, 2.9), (x + 0.5, y + 0.55, 3.03)))

firs = []  # steps that share no factor with 89 and 17 scatter the trees evenly, without a pattern
for tree in range(44):
    x, z, high = tree * 37 % 89 - 44, -14 - tree * 23 % 17, 8 + tree * 7 % 6
    firs += [Cone((x, high * top, z), (x, high * (top - 0.45), z), high * wide) for top, wide in TIERS]

# Colours are linear light, not sRGB. The panes glow, and a lamp before them lights the snow.
white, timber = (0.66, 0.72, 0.82), (0.12, 0.07, 0.045)
solids = [motes.Solid(shape, white) for shape in (ground, *slopes, *snowman)]
solids += [motes.Solid(shape, timber) for shape in (walls, chimney, *gables)]
solids += [motes.Solid(Union(*firs), (0.09, 0.13, 0.14)), motes.Solid(nose, (0.8, 0.25, 0.04))]
solids += [motes.Solid(Union(*panes), (1, 0.45, 0.12), light=2.6)]
lamps = [motes.Light((x, 1.6, 4.2), (1, 0.5, 0.16), 2.2, radius=0.4) for x in (-2.3, 2.3)]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((7, 2.6, 17), (0.6, 3.1, 0), fov_deg=36),
    background=motes.Gradient((0.13, 0.17, 0.28), (0.02, 0.035, 0.09), (0.06, 0.08, 0.14)),
    fog=((0.085, 0.115, 0.2), 42),
    objects=solids,
    lights=lamps,
    sun=(-0.5, 0.6, 0.4),
    sun_color=(0.35, 0.5, 1),
    sun_power=0.25,
    occlusion=1,
    bloom=0.12,
)
world = motes.World(**args.world, renderer=renderer)

# A flake falls for life - rest seconds, and then lies on the ground.
top, fall, rest = 12.0, 1.3, 3.0  # m, m/s, s
life = top / fall + rest
# Leave room in the capacity, since the source emits a whole number per frame.
flakes = args.particles * 63 / 64
batches = 64

# Each system fills a layer between the wood and the camera: first a mist of faint, wide flakes, then single
# flakes, finally flakes so near that they are out of focus. Most of these have an alpha below 0: invisible.
back, depth = -26, 40
layers = []
for i in range(args.systems):
    near = (i + 0.5) / args.systems
    wide, alpha = (0.007, motes.Normal(0, 0.015)) if near < 0.3 else (0.0042, motes.Normal(-0.12, 0.16))
    sprite = motes.Sprite(height=wide + 0.0083 * near**4)
    snow = world.system(f"snow {i}", capacity=args.particles, sprite=sprite)
    snow.configure(color=(0.7, 0.82, 1), alpha=alpha)
    snow.configure(velocity=Box((-0.3, -fall - 0.1, -0.3), (0.4, -fall + 0.1, 0.3)))
    layers.append((snow, back + depth * i / args.systems, back + depth * (i + 1) / args.systems))


def fill_the_air(snow, z_low, z_high):
    """Start the film in the middle of the snowfall: older flakes are lower, the oldest on the ground."""
    for k in range(batches):
        youngest, oldest = life * k / batches, life * (k + 1) / batches
        low, high = max(top - fall * oldest, 0.02), max(top - fall * youngest, 0.02)
        snow.configure(age=motes.Uniform(youngest, oldest))
        snow.burst(Box((-30, low, z_low), (30, high, z_high)), count=args.particles * 63 // 64 // batches)
    snow.configure(age=0)


with world, motes.Movie(f"{args.out}/snow.mp4") as movie:
    for frame in world.frames(args.frames):
        for snow, z_low, z_high in layers:
            if frame == 0:
                fill_the_air(snow, z_low, z_high)
            cloud = Rectangle((-30, top, z_low), (60, 0, 0), (0, 0, z_high - z_low))
            snow.source(cloud, rate=flakes / life, jitter=True)
            # Flakes tumble. The box reaches further down than up, so they get a little faster.
            snow.random_acceleration(Box((-1, -1.03, -1), (1, 1, 1)))
            for shape in (ground, walls, chimney, *slopes, *snowman):
                snow.bounce(shape, restitution=0.1, friction=0.9)  # lands, slides a little, and stays
            snow.kill_old(life)
            snow.move()
        motes.script.end_frame(world, movie, args)
