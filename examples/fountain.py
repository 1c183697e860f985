"""Fountains dance at night: python -m motes run -n 4 examples/fountain.py."""

import argparse
import colorsys
from contextlib import nullcontext

import numpy as np

import motes
from motes.shapes import Plane, Sphere

parser = argparse.ArgumentParser(description=__doc__)
numbers = {"systems": 8, "particles": 400_000, "frames": 96, "seed": 1}
texts = {"size": "1280x720", "space": "-16,16", "out": "out", "log": ""}
for name, value in (numbers | texts).items():
    parser.add_argument(f"--{name}", type=type(value), default=value)
parser.add_argument("--digest", action="store_true", help="print frame, particles' and picture's fingerprint")
parser.add_argument("--no-images", action="store_true")
args = parser.parse_args()  # a space is infinite, fit or LO,HI, as in --space=-9,9

gravity, life, spread = np.array([0, -9.81, 0]), 2.3, 1.1  # m/s^2, s, m/s
rate = args.particles / (life + 1 / 20)  # births that find a system full are dropped: leave a frame's room
share = rate * life / 96


def jet(x, time):
    """Velocity of the water that leaves the nozzle at x: a wave runs along the row."""
    turn = 2 * np.pi * (time / 4 - x / 16)
    # Rounded: sines differ in their last bit between machines, and all ranks must say the same.
    return np.array([1.5 * np.sin(turn), 9.5 + 1.2 * np.cos(2 * turn), 0]).round(4)


row = [(i + 0.5) / args.systems for i in range(args.systems)]
pool, balls = Plane((0, 0, 0), (0, 1, 0)), [Sphere((26 * part - 13, 0.35, 0), 0.6) for part in row]
solids = [motes.Solid(ball, (0.09, 0.085, 0.08)) for ball in balls]
solids += [motes.Solid(pool, (0.01, 0.018, 0.026))]
camera = motes.Camera((-14.5, 1.5, 18.5), (-1.9, 4.2, 0), fov_deg=35)
width, height = map(int, args.size.split("x"))
renderer = motes.Renderer(width, height, camera=camera, background=(0.002, 0.003, 0.008), objects=solids)
words = {"infinite": None, "fit": "fit"}
space = words[args.space] if args.space in words else tuple(map(float, args.space.split(",")))
world = motes.World(seed=args.seed, space=space, renderer=renderer, log=args.log or None)
fountains = []
for part, ball in zip(row, balls, strict=True):
    water = world.system(f"at {part:.3f}", capacity=args.particles, sprite=motes.Sprite("disc", pixels=4))
    water.configure(color=colorsys.hsv_to_rgb(0.47 + 0.55 * part, 0.7, 1), alpha=motes.Normal(0.01, 0.02))
    fountains.append((water, ball, np.array([26 * part - 13, 0.95, 0])))

movie = nullcontext() if args.no_images else motes.Movie(f"{args.out}/fountain.mp4")
with world, movie:
    for frame in world.frames(args.frames):
        for water, ball, nozzle in fountains:
            if frame == 0:  # the water is in the air from the start
                for k in range(96):
                    age = (k + 0.5) * life / 96
                    left = jet(nozzle[0], -age)
                    here = nozzle + left * age + gravity * age * age / 2
                    water.configure(age=motes.Uniform(age - life / 192, age + life / 192))
                    water.configure(velocity=Sphere(left + gravity * age, spread))
                    water.burst(Sphere(here, 0.1 + spread * age), count=int(share * (k + 1)) - int(share * k))
                water.configure(age=0)
            else:
                water.configure(velocity=Sphere(jet(nozzle[0], world.time), spread))
                water.source(Sphere(nozzle, 0.1), rate=rate, jitter=True)
            water.gravity(gravity)
            water.random_acceleration(Sphere((0, 0, 0), 4))
            for shape in (pool, ball):
                water.bounce(shape, restitution=0.3, friction=0.2)
            water.kill_old(life)
            water.move()
        if args.no_images:
            world.step()
        else:
            picture = world.render()
            movie.write(picture)
            if frame == args.frames // 2:
                picture.save(f"{args.out}/fountain.png")
        if args.digest:
            line = f"{frame} {world.digest()}"
            if args.no_images:
                world.say(f"{line} -")
            elif picture:  # only where the image generator is
                print(line, picture.digest(), flush=True)
