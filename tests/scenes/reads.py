"""Reads at any place in a frame with births, deaths, collisions and children; prints one line per frame."""

import argparse

import motes
from motes.expressions import column
from motes.shapes import Box, Plane, Sphere

parser = argparse.ArgumentParser()
parser.add_argument(
    "reads", help="letters: l(ocal), g(ather), a(ll), d(igest), s(um), each at the places that follow it"
)
parser.add_argument("--substeps", type=int, default=1)
parser.add_argument("--births", default="manager")
parser.add_argument("--combine", default="together")
parser.add_argument("--roles", default="auto")
args = parser.parse_args()

world = motes.World(
    seed=1,
    space=(-3, 3),
    progress="off",
    substeps=args.substeps,
    births=args.births,
    combine=args.combine,
    roles=args.roles,
    balancer=motes.balance.Pairwise(0.0, min_particles=1),
)
drops, chips = world.system("drops"), world.system("chips", capacity=2500)
drops.configure(velocity=Sphere((0, 0, 0), 4))
chips.configure(velocity=Sphere((0, 1, 0), 0.5), lifetime=0.3)
floor, ceiling = Plane((0, -1, 0), (0, 1, 0)), Plane((0, 1, 0), (0, -1, 0))
room = Box((-3, -1, -1), (3, 1, 1))


def read(place):
    """Perform the reads that the script's arguments request at this place."""
    for group in args.reads.split(","):
        if place not in group[1:]:
            continue
        for system in (drops, chips):
            if group[0] == "l":
                with system.local() as particles:
                    assert len(particles.position) == len(particles.id)
            elif group[0] == "s":
                system.tally((-3, -3, -3), (3, 3, 3), (4, 4, 4), where=column("age") > 0)
            elif group[0] in "ga":
                system.gather(to="all" if group[0] == "a" else 0)
        if group[0] == "d":
            world.digest()


with world:
    for frame in world.frames(7):
        if frame == 0:
            drops.burst(room, count=1500)
        chips.spawn(into=drops, on="death", count=1, where=column("position").y > 0.9)
        drops.source(room, rate=500)
        read("0")
        drops.gravity((0, -10, 0))
        drops.spawn(into=chips, on="collision", count=1, inherit_velocity=0.5)
        drops.random_acceleration(Sphere((0, 0, 0), 5))
        drops.bounce(floor)
        read("1")
        drops.bounce(ceiling)
        drops.kill_old(0.2)
        read("2")
        drops.spawn(into=chips, on="death", count=2)  # also for particles that died earlier in the frame
        drops.move()
        drops.bounce(floor)
        read("3")
        drops.spawn(into=chips, on="birth", count=1)
        chips.gravity((0, -10, 0))
        chips.kill_expired()
        chips.move()
        read("4")
        drops.move()
        world.step()
        if args.reads:
            read("5")
        world.say(f"{frame} {drops.count} {chips.count} {chips.dropped} {world.digest()}")
