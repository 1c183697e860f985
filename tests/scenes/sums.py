"""Totals, histograms and tallies in the middle and at the end of frames, the same on every rank.

Each line holds the bits of all results of a frame. Argument: arguments of World, as JSON.
"""

import hashlib
import json
import sys

import numpy as np
from mpi4py import MPI

import motes
from motes.expressions import column
from motes.shapes import Box, Sphere

world = motes.World(seed=5, progress="off", **json.loads(sys.argv[1]))
photons = world.system("photons", attributes={"weight": 1.0})
photons.configure(velocity=Sphere((0, 0, 0), 9), weight=motes.Uniform(-1, 1))
x, weight, speed = column("position").x, column("weight"), column("velocity").length()
squares = column("velocity") * column("velocity")


def sums():
    """Yield all kinds of sums, as NumPy arrays."""
    yield np.array(photons.total(0.5 * squares))
    yield np.array(photons.total(weight * 1e30 - weight, where=Sphere((0, 0, 0), 2)))
    yield np.array(photons.total(1, where=weight > 0))
    yield np.array(photons.total(1 / (x * 0)))
    yield photons.histogram(x, np.linspace(-2, 2, 40), where=column("age") > 0)
    yield photons.histogram(speed, [0, 1, 5, np.inf], weights=weight * squares.x)
    yield photons.tally((-2, -2, -2), (2, 2, 2), (9, 7, 5))
    yield photons.tally((-2, -2, -2), (2, 2, 2), (9, 7, 5), weights=weight, where=weight < 0.5)


def bits_of(found):
    """Return a text that identifies all bits."""
    shown = found.tobytes().hex() if found.size < 9 else hashlib.sha256(found.tobytes()).hexdigest()
    return f"{found.dtype}{list(found.shape)}:{shown}"


with world:
    for frame in world.frames(4):
        photons.source(Box((-2, -1, -1), (2, 1, 1)), rate=30_000)
        photons.gravity((0, -9.8, 0))
        middle = [bits_of(one) for one in sums()]
        photons.sink(Sphere((1, 0, 0), 0.5))
        photons.move()
        behind = [bits_of(one) for one in sums()]
        world.step()
        row = [middle, behind, [bits_of(one) for one in sums()], photons.count, world.digest()]
        if len(set(MPI.COMM_WORLD.allgather(json.dumps(row)))) > 1:
            raise AssertionError(f"frame {frame}: ranks got different sums")
        world.say(json.dumps(row))
