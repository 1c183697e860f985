"""Snakes of lanterns, each ball following the next: python -m motes run -n 4 examples/snake.py."""

import colorsys

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Cylinder, Plane

args = motes.script.options(__doc__, space="-5,5", systems=4, particles=44, frames=168, size="960x540")

floor = Plane((0, 0, 0), (0, 1, 0))
posts = [Cylinder((x, 0, z), (x, 3.4, z), 0.22) for x, z in ((-3, -1.4), (-1, 1.2), (1, -1.4), (3, 1.2))]
solids = [motes.Solid(floor, (0.16, 0.15, 0.17)), *(motes.Solid(post, (0.5, 0.45, 0.4)) for post in posts)]
camera = motes.Camera((1.5, 4.4, 9.6), (0, 1.45, 0), fov_deg=36)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.20, 0.22, 0.28), objects=solids, sun=(-0.4, 0.9, 0.5)
)
world = motes.World(**args.world, substeps=4, renderer=renderer)

# Paths between the posts, each at its own height.
turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
snakes = []
for i in range(args.systems):
    shift = 2 * np.pi * i / args.systems
    way = np.stack(
        [
            4.1 * np.sin(turn),
            1.0 + 0.45 * i + 0.35 * np.sin(3 * turn + shift),
            2.2 * np.sin(2 * turn + np.pi * (i % 2)),
        ],
        axis=1,
    )
    snake = world.system(
        f"snake {i}", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"), attributes={"order": 0.0}
    )
    snakes.append((snake, np.roll(way, -6 * i, axis=0).round(4), (0.02 + 0.24 * i) % 1))

with world, motes.Movie(f"{args.out}/snake.mp4") as movie:
    for frame in world.frames(args.frames):
        for snake, way, hue in snakes:
            n = args.particles
            if frame == 0:  # along the path, the head in front: it is the youngest, so it follows no other
                steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
                far = np.concatenate([[0], np.cumsum(steps)])
                start = np.stack(
                    [np.interp(0.3 * np.arange(n), far, way[:, axis]) for axis in range(3)], axis=1
                )
                order = np.arange(n)
                stripes = np.where(order % 6 < 3, 0.9, 0.45)
                color = np.array(
                    [
                        colorsys.hsv_to_rgb((hue + 0.12 * k / n) % 1, 0.8, s)
                        for k, s in zip(order, stripes, strict=True)
                    ]
                )
                size = 0.34 * np.clip(0.25 + 1.6 * order / n, 0, 1)
                size[-4:] = (0.38, 0.42, 0.40, 0.32)
                snake.emit(
                    position=start.round(4),
                    color=color,
                    size=np.repeat(size[:, None], 3, 1).round(4),
                    order=order,
                )
            head = column("order") == n - 1
            snake.follow(150, epsilon=0.1, where=~head)
            snake.follow_path(way, speed=2.6, strength=5, look_ahead=0.7, loop=True, smooth=True, where=head)
            snake.speed_clamp(2.6, 2.6)  # all have the same speed, so they keep their distance
            snake.move()
        motes.script.end_frame(world, movie, args)
