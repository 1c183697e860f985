"""Sand is poured over a knot that turns slowly: python -m motes run -n 4 examples/sand_on_mesh.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Cylinder, Disc, Plane, Sphere

args = motes.script.options(__doc__, space="-1.5,1.5", systems=3, particles=16000, frames=192, size="960x540")


def knot(along=240, around=24, thick=0.19):
    """Make a trefoil knot: a tube around a closed curve, as vertices and triangles."""
    t, a = np.meshgrid(
        np.linspace(0, 2 * np.pi, along + 1), np.linspace(0, 2 * np.pi, around + 1), indexing="ij"
    )

    def curve(t):
        return (
            np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=-1)
            / 3
        )

    ahead = curve(t + 1e-3) - curve(t - 1e-3)
    bend = curve(t + 1e-3) + curve(t - 1e-3) - 2 * curve(t)
    side = np.cross(ahead, bend)
    across = np.cross(side, ahead)
    side, across = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (side, across))
    points = curve(t) + thick * (np.cos(a)[..., None] * across + np.sin(a)[..., None] * side)
    corner = np.arange(points[..., 0].size).reshape(t.shape)
    p, q, r, s = (c.ravel() for c in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    return motes.Mesh(points.reshape(-1, 3), np.concatenate([np.stack([p, q, r], 1), np.stack([p, r, s], 1)]))


stone = knot()
floor = Plane((0, 0, 0), (0, 1, 0))
pipe = Cylinder((0, 2.9, 0), (0, 3.4, 0), 0.98, 0.92)
camera = motes.Camera((0.9, 2.7, 5.6), (0, 1.2, 0), fov_deg=36)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.42, 0.5, 0.6), shutter=0.2)
world = motes.World(**args.world, renderer=renderer)
tones = [(0.8, 0.52, 0.2), (0.62, 0.33, 0.12), (0.9, 0.72, 0.42)]
grains = []
for i in range(args.systems):
    sand = world.system(
        f"sand {i}", capacity=args.particles, sprite=motes.Sprite("sphere", pixels=None, blend="opaque")
    )
    sand.configure(
        color=tones[i % len(tones)],
        size=motes.Uniform((0.02,) * 3, (0.03,) * 3),
        velocity=Sphere((0, -2.5, 0), 0.25),
    )
    grains.append(sand)


def turned(frame, moving_from=None):
    """Return the knot at the start of a frame."""
    return stone.at((0, 1.1, 0), axis=(0.25, 1, 0.1), angle_deg=1.5 * frame, moving_from=moving_from)


with world, motes.Movie(f"{args.out}/sand_on_mesh.mp4") as movie:
    for frame in world.frames(args.frames):
        now = turned(frame + 1, moving_from=turned(frame))
        solids = [(floor, (0.1, 0.095, 0.09)), (now, (0.1, 0.2, 0.27)), (pipe, (0.05, 0.05, 0.06))]
        renderer.objects = [motes.Solid(shape, color) for shape, color in solids]
        for sand in grains:
            sand.source(Disc((0, 3.05, 0), (0, 1, 0), 0.88), rate=args.particles / 8, jitter=True)
            sand.gravity((0, -9.8, 0))
            sand.bounce(now, restitution=0.25, friction=0.15)
            sand.bounce(floor, restitution=0.2, friction=0.5)
            sand.set(
                velocity=(0, 0, 0), where=(column("position").y < 0.01) & (column("velocity").length() < 0.3)
            )
            sand.move()
        motes.script.end_frame(world, movie, args)
