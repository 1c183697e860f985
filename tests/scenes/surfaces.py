"""Surfaces in the middle and at the end of frames, the same on every rank; each is drawn as a solid.

Each line holds a hash of the surface's arrays. Argument: arguments of World, as JSON.
"""

import hashlib
import json
import sys

from mpi4py import MPI

import motes
from motes.shapes import Box

world = motes.World(seed=5, progress="off", **json.loads(sys.argv[1]))
water = world.system("water")
water.configure(velocity=motes.Normal((0, 0, 0), (1, 1, 1)))
view = motes.Renderer(64, 48, camera=motes.Camera((0, 1, 6), (0, 0, 0)))
world.renderer = view


def bits_of(mesh):
    """Return a hash of the arrays."""
    return hashlib.sha256(mesh.vertices.tobytes() + mesh.triangles.tobytes()).hexdigest()


with world:
    for frame in world.frames(3):
        water.source(Box((-2, -1, -1), (2, 1, 1)), rate=20_000)
        water.gravity((0, -9.8, 0))
        middle = water.surface(0.1)
        water.move()
        behind = water.surface(0.06, radius=0.05)
        view.objects = [motes.Solid(behind, color=(0.2, 0.4, 0.8))]
        world.render()
        row = [bits_of(middle), bits_of(behind), bits_of(water.surface(0.1))]
        if len(set(MPI.COMM_WORLD.allgather(json.dumps(row)))) > 1:
            raise AssertionError(f"frame {frame}: ranks got different surfaces")
        world.say(json.dumps([*row, world.digest()]))
