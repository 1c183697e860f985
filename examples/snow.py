"""Snow falls on a house in the blue hour: python -m motes run -n 4 examples/snow.py."""

import argparse
from contextlib import nullcontext

import motes
from motes.shapes import Box, Plane, Rectangle, Sphere

parser = argparse.ArgumentParser(description=__doc__)
numbers = {"systems": 8, "particles": 400_000, "frames": 96, "seed": 1}
texts = {"size": "1280x720", "space": "-30,30", "out": "out", "log": ""}
for name, value in (numbers | texts).items():
    parser.add_argument(f"--{name}", type=type(value), default=value)
parser.add_argument("--digest", action="store_true", help="print frame, particles' and picture's fingerprint")
parser.add_argument("--no-images", action="store_true")
args = parser.parse_args()  # a space is infinite, fit or LO,HI, as in --space=-9,9

# A house and a snowman before a wood, in metres, and their paint, in linear light.
ground, walls = Plane((0, 0, 0), (0, 1, 0)), Box((-4, 0, -3), (4, 3.1, 3))
roof = [Rectangle((-4.3, 2.85, z), (8.6, 0, 0), (0, 2.75, -z)) for z in (-3.4, 3.4)]
gable = [Box((-4, 3 + i / 8, 0.152 * i - 3), (4, 3 + (i + 1) / 8, 3 - 0.152 * i)) for i in range(20)]
chimney = Box((2, 4, -1.6), (2.8, 6.4, -0.8))
panes = [Box((x, y, 2.9), (x + 0.5, y + 0.55, 3.03)) for x in (-2.9, -2.32, 1.8, 2.38) for y in (1.1, 1.73)]
snowman = [Sphere((6, y, 4.6), r) for y, r in ((0.6, 0.75), (1.6, 0.5), (2.3, 0.32))]
trees = [(i * 37 % 89 - 44, -14 - i * 23 % 17) for i in range(44)]
trunks = [Box((x, 0, z), (x + 0.4, 14, z + 0.4)) for x, z in trees]
obstacles = [ground, walls, chimney, *roof, *snowman]
solids = [motes.Solid(shape, (0.12, 0.15, 0.22)) for shape in (ground, *roof, *snowman)]
solids += [motes.Solid(shape, (0.05, 0.032, 0.028)) for shape in (walls, chimney, *gable)]
solids += [motes.Solid(trunk, (0.02, 0.022, 0.03)) for trunk in trunks]
solids += [motes.Solid(pane, (3.2, 1.3, 0.3)) for pane in panes]
camera = motes.Camera((7, 2.6, 17), (0.6, 3.1, 0), fov_deg=36)
width, height = map(int, args.size.split("x"))
renderer = motes.Renderer(width, height, camera=camera, background=(0.028, 0.045, 0.095), objects=solids)

top, fall = 12.0, 1.3  # m of air, m/s
life = top / fall + 3  # s; the last three on the ground
rate = args.particles / (life + 1 / 20)  # births that find a system full are dropped: leave a frame's room
share = rate * life / 64
words = {"infinite": None, "fit": "fit"}
space = words[args.space] if args.space in words else tuple(map(float, args.space.split(",")))
world = motes.World(seed=args.seed, space=space, renderer=renderer, log=args.log or None)
layers = []
for i in range(args.systems):  # from the wood to the camera: mist, flakes, flakes out of focus
    back, depth, near = -26 + 40 * i / args.systems, 40 / args.systems, (i + 0.5) / args.systems
    pixels, alpha = (5, motes.Normal(0, 0.015)) if near < 0.3 else (3, motes.Normal(-0.12, 0.16))
    sprite = motes.Sprite("disc", pixels=pixels + int(6 * near**4))
    snow = world.system(f"snow {i}", capacity=args.particles, sprite=sprite)
    snow.configure(color=(0.7, 0.82, 1), alpha=alpha)
    snow.configure(velocity=Box((-0.3, -fall - 0.1, -0.3), (0.4, -fall + 0.1, 0.3)))
    layers.append((snow, back, depth))

movie = nullcontext() if args.no_images else motes.Movie(f"{args.out}/snow.mp4")
with world, movie:
    for frame in world.frames(args.frames):
        for snow, back, depth in layers:
            if frame == 0:  # the air is full from the start
                for k in range(64):
                    young, old = life * k / 64, life * (k + 1) / 64
                    low, high = (max(top - fall * age, 0.02) for age in (old, young))
                    snow.configure(age=motes.Uniform(young, old))
                    snow.burst(
                        Box((-30, low, back), (30, high, back + depth)),
                        count=int(share * (k + 1)) - int(share * k),
                    )
                snow.configure(age=0)
            else:
                cloud = Rectangle((-30, top, back), (60, 0, 0), (0, 0, depth))
                snow.source(cloud, rate=rate, jitter=True)
            snow.random_acceleration(Box((-1, -1.03, -1), (1, 1, 1)))
            for shape in obstacles:
                snow.bounce(shape, restitution=0.1, friction=0.9)
            snow.kill_old(life)
            snow.move()
        if args.no_images:
            world.step()
        else:
            picture = world.render()
            movie.write(picture)
            if frame == args.frames // 2:
                picture.save(f"{args.out}/snow.png")
        if args.digest:
            line = f"{frame} {world.digest()}"
            if args.no_images:
                world.say(f"{line} -")
            elif picture:  # only where the image generator is
                print(line, picture.digest(), flush=True)
