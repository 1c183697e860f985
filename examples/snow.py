"""Snow falls on a house in the blue hour: python -m motes run -n 4 examples/snow.py."""

import motes
from motes.shapes import Box, Plane, Rectangle, Sphere

args = motes.script.options(__doc__, space="-30,30")

# A house and a snowman before a wood, in metres, and their paint, in linear light.
ground, chimney = Plane((0, 0, 0), (0, 1, 0)), Box((2, 4, -1.6), (2.8, 6.4, -0.8))
walls = Box((-4, 0, -3), (4, 3.1, 3))
roof = [Rectangle((-4.3, 2.85, z), (8.6, 0, 0), (0, 2.75, -z)) for z in (-3.4, 3.4)]
gable = [Box((-4, 3 + i / 8, 0.152 * i - 3), (4, 3 + (i + 1) / 8, 3 - 0.152 * i)) for i in range(20)]
panes = [Box((x, y, 2.9), (x + 0.5, y + 0.55, 3.03)) for x in (-2.9, -2.32, 1.8, 2.38) for y in (1.1, 1.73)]
snowman = [Sphere((6, y, 4.6), r) for y, r in ((0.6, 0.75), (1.6, 0.5), (2.3, 0.32))]
trees = ((i * 37 % 89 - 44, -14 - i * 23 % 17) for i in range(44))
trunks = [Box((x, 0, z), (x + 0.4, 14, z + 0.4)) for x, z in trees]
paint = {
    (0.12, 0.15, 0.22): [ground, *roof, *snowman],
    (0.05, 0.032, 0.028): [walls, chimney, *gable],
    (0.02, 0.022, 0.03): trunks,
    (3.2, 1.3, 0.3): panes,
}
camera = motes.Camera((7, 2.6, 17), (0.6, 3.1, 0), fov_deg=36)
solids = [motes.Solid(shape, color) for color, shapes in paint.items() for shape in shapes]
renderer = motes.Renderer(*args.size, camera=camera, background=(0.028, 0.045, 0.095), objects=solids)
world = motes.World(seed=args.seed, space=args.space, balancer=args.balancer, renderer=renderer, log=args.log)

top, fall, rest = 12.0, 1.3, 3.0  # m of air, m/s, s on the ground
life = top / fall + rest
layers = []  # from the wood to the camera: mist, flakes, flakes out of focus
for i in range(args.systems):
    near = (i + 0.5) / args.systems
    pixels, alpha = (5, motes.Normal(0, 0.015)) if near < 0.3 else (3, motes.Normal(-0.12, 0.16))
    sprite = motes.Sprite(pixels=pixels + int(6 * near**4))
    snow = world.system(f"snow {i}", capacity=args.particles, sprite=sprite)
    snow.configure(color=(0.7, 0.82, 1), alpha=alpha)
    snow.configure(velocity=Box((-0.3, -fall - 0.1, -0.3), (0.4, -fall + 0.1, 0.3)))
    layers.append((snow, -26 + 40 * i / args.systems, -26 + 40 * (i + 1) / args.systems))

with world, motes.Movie(f"{args.out}/snow.mp4") as movie:
    for frame in world.frames(args.frames):
        for snow, back, front in layers:
            for k in range(64 if frame == 0 else 0):  # the air is full from the start
                young, old = life * k / 64, life * (k + 1) / 64
                low, high = max(top - fall * old, 0.02), max(top - fall * young, 0.02)
                snow.configure(age=motes.Uniform(young, old))
                snow.burst(Box((-30, low, back), (30, high, front)), count=args.particles * 63 // 64 // 64)
            snow.configure(age=0)
            cloud = Rectangle((-30, top, back), (60, 0, 0), (0, 0, front - back))
            snow.source(cloud, rate=args.particles * 63 / 64 / life, jitter=True)
            snow.random_acceleration(Box((-1, -1.03, -1), (1, 1, 1)))
            for shape in (ground, walls, chimney, *roof, *snowman):
                snow.bounce(shape, restitution=0.1, friction=0.9)
            snow.kill_old(life)
            snow.move()
        motes.script.end_frame(world, movie, args)
