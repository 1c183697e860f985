"""A flag flies in a wind that grows until it tears: python -m motes run -n 4 examples/flag.py."""

import numpy as np

import motes
from motes.shapes import Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-0.2,3.2", systems=1, particles=6000, frames=192, size="960x540")

rows = max(4, round((args.particles / 1.5) ** 0.5))
columns = max(6, args.particles // rows)
height, width = 1.8, 2.7  # metres
rng = np.random.default_rng(4)
grass = rng.integers(120, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)
solids = [
    motes.Solid(Plane((0, -3.5, 0), (0, 1, 0)), (0.1, 0.16, 0.04), image=grass, scale=3),
    motes.Solid(Cylinder((-0.05, -3.5, 0), (-0.05, 1.2, 0), 0.045), (0.5, 0.5, 0.5)),
    motes.Solid(Sphere((-0.05, 1.24, 0), 0.09), (0.8, 0.5, 0.08)),
]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((2.9, -1.9, 4.9), (1.15, 0, 0), fov_deg=36),
    background=motes.Gradient((0.75, 0.72, 0.68), (0.06, 0.2, 0.55), (0.12, 0.12, 0.1)),
    objects=solids,
    sun=(-0.35, 0.5, 0.6),
    exposure=1.1,
)
# Ties pull once per sub-step: the more sub-steps, the stiffer the cloth.
world = motes.World(**args.world, substeps=30, renderer=renderer)
flag = world.system("flag", sprite=motes.Sprite("point"))

# The cloth is shown as three stripes of triangles between its particles, which are not drawn themselves.
row, column = np.mgrid[: rows - 1, : columns - 1]
corner = (row * columns + column).ravel()
corners = np.stack(
    [corner, corner + columns, corner + 1, corner + 1, corner + columns, corner + columns + 1], axis=1
)
stripes = [corners[row.ravel() * 3 // (rows - 1) == k].reshape(-1, 3) for k in range(3)]
tones = ["#e08010", "#f0ead8", "#0c7a80"]


def cloth(places):
    """Return the stripes as solids, without the triangles that a tear has stretched."""
    for stripe, tone in zip(stripes, tones, strict=True):
        sides = places[stripe] - places[np.roll(stripe, 1, axis=1)]
        whole = stripe[((sides * sides).sum(axis=2) < (2.2 * height / rows) ** 2).all(axis=1)]
        if len(whole):
            yield motes.Solid(motes.Mesh(places, whole), tone)


with world, motes.Movie(f"{args.out}/flag.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            flag.configure(alpha=0)
            pins = [(row, 0) for row in range(0, rows, 3)]
            ties = flag.cloth(rows, columns, (0, 1, 0), (0, -height, 0), (width, 0, 0.05), pinned=pins)
        else:
            renderer.objects = [*solids, *cloth(flag.gather(to="all").position)]
        storm = min(1, frame / (0.8 * args.frames))
        flag.gravity((0, -9.81, 0))
        flag.wind((9 + 12 * storm, storm, 1.5), drag=1.2)
        flag.curl_noise(9 + 45 * storm, scale=1.1, octaves=2, speed=3)
        flag.tie(ties, bend=1e-4, damping=3, break_at=1.9)
        flag.move()
        motes.script.end_frame(world, movie, args)
