"""A shot with solids, lamps and sprites of each kind, exported as a scene, and its pictures.

Arguments: a folder, and how many frames. With --checkpoints, a second start continues; the last rank kills
itself before it writes frame DIE, a variable of the environment.
"""

import argparse
import os
import signal

import numpy as np

import motes
from motes.shapes import Box, Cone, Cylinder, Disc, Mesh, Plane, Rectangle, Sphere, Triangle

parser = argparse.ArgumentParser()
parser.add_argument("folder")
parser.add_argument("--frames", type=int, default=4)
parser.add_argument("--size", default="480x270")
parser.add_argument("--checkpoints", action="store_true")
args = parser.parse_args()
width, height = map(int, args.size.split("x"))

CHECKS = (np.indices((8, 8)).sum(axis=0) % 2 * 200 + 55).astype(np.uint8)
CARDS = [np.full((4, 8, 4), (*color, 255), np.uint8) for color in ((255, 0, 0), (0, 255, 0), (0, 0, 255))]
corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
piece = Mesh(corners, faces, colors=[(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)])
plate = Mesh(
    [(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)],
    [(0, 2, 1), (0, 3, 2)],
    uv=[(0, 0), (1, 0), (1, 1), (0, 1)],
)


def sheet(time):
    """Return a surface with more triangles at a later time."""
    cells = 2 + round(24 * time)
    at = np.linspace(-1, 1, cells + 1)
    x, z = np.meshgrid(at, at, indexing="ij")
    points = np.stack([x, 0.2 * np.sin(3 * x + 9 * time), z], axis=-1).reshape(-1, 3)
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).reshape(-1)
    b = a + cells + 1
    return Mesh(points, np.concatenate([np.stack([a, a + 1, b], 1), np.stack([b, a + 1, b + 1], 1)]))


camera = motes.Camera(
    motes.Curve([(0, (6, 5, 9)), (1, (9, 4, 7))]),
    (0, 1, 0),
    fov_deg=motes.Curve([(0, 40), (1, 30)]),
    focus=11,
    aperture=0.02,
)
renderer = motes.Renderer(
    width,
    height,
    camera=camera,
    background=motes.Gradient((0.6, 0.7, 0.9), (0.1, 0.2, 0.6), (0.2, 0.2, 0.2)),
    sun=(0.4, 0.8, 0.3),
    sun_size=2,
    lights=[
        motes.Light((3, 4, 3), color=(1, 0.5, 0.2), power=motes.Curve([(0, 5), (1, 9)]), radius=0.2),
        motes.Light((-3, 4, 3), power=9, spot=((0, -1, 0), 50)),
    ],
)
kept = motes.Checkpoint(f"{args.folder}/kept", every=1) if args.checkpoints else None
world = motes.World(seed=5, space=(-4, 4), renderer=renderer, progress="off", roles="shared", checkpoint=kept)
grains = world.system(
    "grains", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"), attributes={"heat": 0.5}
)
sparks = world.system("sparks of light", sprite=motes.Sprite("disc", pixels=8))
leaves = world.system(
    "leaves", sprite=motes.Sprite("image", image=CARDS, facing="orientation", blend="opaque", lit=True)
)
flags = world.system("flags", sprite=motes.Sprite("image", image=CARDS[0], pixels=20, blend="opaque"))
darts = world.system("darts", sprite=motes.Sprite("mesh", mesh=piece, facing="velocity", blend="opaque"))
trails = world.system("trails", sprite=motes.Sprite("ribbon", width=0.1, length=0.1, blend="alpha"))
water = world.system("water", sprite=motes.Sprite("surface", radius=0.1))
where = Box((-3, 0.5, -3), (3, 3, 3))

with world, motes.Export(f"{args.folder}/shot.usd", scene=True) as export:
    for frame in world.frames(args.frames):
        time = world.time
        thing = motes.Solid(Sphere((time, 1, 0), 0.6), color=(0.9, 0.2, 0.1), roughness=0.3)
        renderer.objects = [
            motes.Solid(Plane((0, 0, 0), (0, 1, 0)), image=np.dstack([CHECKS] * 3), scale=2),
            thing,
            motes.Solid(Box((-2, 0, -1), (-1, 1 + time, 0)), color=(0.2, 0.6, 0.3), metal=1),
            motes.Solid(Cylinder((2, 0, 0), (2, 1.5, 0.3), 0.4, 0.2), color=(0.3, 0.3, 0.9)),
            motes.Solid(Cone((-3, 2, 0), (-3, 0, 0), 0.5), glass=1.5),
            motes.Solid(Disc((0, 0.1, 2), (0, 1, 0.2), 0.7, 0.3), light=0.5),
            motes.Solid(Rectangle((-1, 0.2, 3), (1, 0, 0), (0.2, 1, 0))),
            motes.Solid(Triangle((1, 0, 3), (2, 0, 3), (1.5, 1, 3)), color=(0.1 + time, 0, 1)),
            motes.Solid(plate.at((0, 2.5, -2), axis=(1, 0, 1), angle_deg=40), image=np.dstack([CHECKS] * 3)),
            motes.Solid(piece.at((2, 1, 2 - time), axis=(0, 1, 0), angle_deg=90 * time)),
            motes.Solid(sheet(time).at((0, 3, 0))),
        ]
        if frame == 2:
            renderer.objects = renderer.objects[:3]
        if frame == 0:
            for system in (grains, sparks, leaves, flags, darts, trails, water):
                system.configure(
                    velocity=Sphere((0, 0, 0), 3),
                    size=motes.Uniform((0.1,) * 3, (0.3,) * 3),
                    color=motes.Uniform((0, 0, 0), (1, 1, 1)),
                    up=Sphere((0, 0, 0), 1),
                )
                if system is leaves:
                    system.configure(orientation=motes.euler(30, 20, 70), spin=Sphere((0, 0, 0), 4))
                system.burst(where, count=12)
        for system in (grains, sparks, leaves, flags, darts, trails, water):
            system.move()
        picture = world.render()
        if str(frame) == os.environ.get("DIE") and world.rank == world.size - 1:
            os.kill(os.getpid(), signal.SIGKILL)
        export.write(world)
        picture.save(f"{args.folder}/picture_{frame}.png")
        if frame == args.frames - 1:
            world.say(world.digest())
