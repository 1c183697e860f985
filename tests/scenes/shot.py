"""A film that needs earlier frames: births, meetings, ribbons, a moving camera and solid, an open shutter.

The argument is the folder of the film, the log and the checkpoints; OPTIONS holds options as JSON.
"""

import json
import os
import sys
from pathlib import Path

import numpy as np

import motes
from motes import shapes

place = Path(sys.argv[1])
told = {"frames": 60, "fps": 24, "every": 16, "digest": True} | json.loads(os.environ.get("OPTIONS", "{}"))
end_s = told["frames"] / 24
camera = motes.Camera(motes.Curve([(0, (-6, 2, 8)), (end_s, (6, 4, 7))]), (0, 1, 0))
stone = motes.Mesh(
    [(-1, 0, -1), (1, 0, -1), (0, 0, 1), (0, 1, 0)], [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]
)
ground = shapes.Plane((0, 0, 0), (0, 1, 0))
renderer = motes.Renderer(
    96, 64, camera=camera, shutter=motes.Curve([(0, 0), (end_s, 1)]), background=(0.02, 0.03, 0.05)
)
checkpoint = motes.Checkpoint(place / "checkpoints", every=told["every"], keep=100)
world = motes.World(
    seed=7,
    space=(-4, 4),
    renderer=renderer,
    digest=told["digest"],
    log=place / "log",
    progress="off",
    roles="shared",
    checkpoint=checkpoint if told["every"] else None,
)
dust = world.system("dust", sprite=motes.Sprite("disc", pixels=4))
tails = world.system("tails", sprite=motes.Sprite("ribbon", width=0.1, length=0.3))
with world, motes.Movie(place / "film.mp4", fps=told["fps"]) as film:
    for frame in world.frames(told["frames"]):

        def turned(number: int, **more: object) -> motes.Mesh:
            at = 3 * np.sin(0.2 * number), 0, 2 * np.cos(0.2 * number)
            return stone.at(at, angle_deg=6 * number, **more)

        renderer.objects = [ground, turned(frame, moving_from=turned(frame - 1))]
        dust.configure(velocity=shapes.Sphere((0, 2, 0), 1), lifetime=1, color=(1, 0.6, 0.2))
        dust.source(shapes.Sphere((0, 1, 0), 1.5), rate=700)
        dust.gravitate(-0.02, max_radius=0.3)
        dust.move()
        dust.kill_expired()
        tails.configure(velocity=shapes.Sphere((0, 0, 0), 2), color=(0.3, 0.6, 1), lifetime=2)
        tails.source((0, 2, 0), rate=30)
        tails.gravity((0, -2, 0))
        tails.move()
        tails.kill_expired()
        picture = world.render()
        film.write(picture)
        if picture:
            print(json.dumps({"frame": frame, "digest": picture.digest()}), flush=True)
