"""Crowds that interact: each calculator has 400 000 particles, its part of a cube.

Only a sample is recorded, in which each particle stands for several; reach and speed are those of the whole
crowd. `heap`: grains at rest on each other, packed to 60 %; they interact within a diameter. `flock`: birds,
one per cubic metre, that circle the middle at up to 10 m/s and see 2 m far. `ball`: the same birds in a ball.
"""

import math

import motes
from motes.expressions import column
from motes.shapes import Box, Sphere

FULL = 400_000
"""Particles per calculator."""
DIAMETER = 0.02
SIGHT = 2.0

args = motes.script.options(__doc__, particles=1000, frames=4, crowd="heap", calculators=14)
each = math.pi / 6 * DIAMETER**3 / 0.6 if args.crowd == "heap" else 1.0  # cubic metres
half = round((FULL * each * args.calculators) ** (1 / 3) / 2, 6)
radius = round(half * (6 / math.pi) ** (1 / 3), 6)  # of a ball of the same volume
turn = round(10 / (half * math.sqrt(2)), 9)  # radians per second
place = Sphere((0, 0, 0), radius) if args.crowd == "ball" else Box((-half,) * 3, (half,) * 3)
world = motes.World(
    seed=args.seed,
    axis=args.axis,
    space=args.space,
    balancer=args.balancer,
    births="calculators",
    log=args.log,
)
crowd = world.system("crowd", capacity=args.particles * args.calculators)
x, z = column("position")[0], column("position")[2]

with world:
    for frame in world.frames(args.frames):
        if frame == 0:
            crowd.burst(place, count=args.particles * args.calculators)
        if args.crowd == "heap":
            crowd.collide(radius=DIAMETER / 2, clear=1e-6)  # grains of a sample touch only by chance
        else:
            if frame == 0:
                crowd.set(velocity=x * (0, 0, turn) + z * (-turn, 0, 0))
            crowd.match_velocity(1, epsilon=0.5, max_radius=SIGHT)
            crowd.set(velocity=column("velocity") - (x * (1, 0, 0) + z * (0, 0, 1)) * (turn**2 * world.dt))
            crowd.move()
        world.step()
