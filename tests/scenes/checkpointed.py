"""A film with checkpoints, which a test kills and continues: a directory; options as JSON in OPTIONS."""

import json
import os
import resource
import sys

import motes
from motes import expressions as ex
from motes import shapes
from motes._checkpoint.saving import Saver

folder = sys.argv[1]
told = json.loads(os.environ.get("OPTIONS", "{}"))
balancers = {"pairwise": motes.balance.Pairwise(min_particles=10), "none": None}
world = motes.World(
    seed=told.get("seed", 5),
    space=told.get("space", "fit"),
    substeps=2,
    log=f"{folder}/log",
    digest=True,
    progress="off",
    axis=told.get("axis", "x"),
    roles=told.get("roles", "auto"),
    births=told.get("births", "manager"),
    balancer=balancers[told.get("balancer", "none")],
    checkpoint=motes.Checkpoint(f"{folder}/checkpoints", every=4),
    renderer=motes.Renderer(96, 54, camera=motes.Camera((0, 5, 20), (0, 3, 0)), shutter=0.5),
)
snow = world.system("snow", attributes={"heat": 0.5})
bits = world.system('bits "of" ice', capacity=1500)
grains = world.system("grains", space=(-3, 3))
snow.configure(velocity=motes.Normal((0, 1, 0), (1, 1, 1)), lifetime=motes.Uniform(0.5, 1.5))
grains.configure(size=(0.3, 0.3, 0.3), color=motes.Curve([(0, (1, 0, 0)), (1, (0, 0, 1))]))


def look(particles):
    particles.heat[:] = particles.position[:, 1] * 0.25


REMEMBERED = {"n": 1, "more": 3, "slip": 3}


def begin(saver, frame, describe, original=Saver.begin):
    """Begin a checkpoint; for the frame `full_at`, limit the disk space first."""
    saver.finish()  # the disk must be full for no other checkpoint; film and log are small
    room = 60_000 if frame == told.get("full_at", -1) else resource.RLIM_INFINITY
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY))
    original(saver, frame, describe)


Saver.begin = begin

with motes.Movie(f"{folder}/film.mp4") as movie, world:
    snow.burst(shapes.Box((-5, 0, -5), (5, 5, 5)), count=600)
    grains.burst(shapes.Box((-2, 0, -1), (2, 3, 1)), count=120)
    for frame in world.frames(told.get("frames", 20)):
        if frame == told.get("kill_at", -1) and world.rank == told.get("rank", world.size - 1):
            os.kill(os.getpid(), 9)
        if frame == 6:
            bits.configure(color=(1, 0.3, 0.1))  # applies to all later births
        snow.source(shapes.Disc((0, 8, 0), (0, 1, 0), 4), rate=700, jitter=True)
        snow.callback(look)
        snow.gravity((0, -5, 0))
        snow.random_acceleration(shapes.Sphere((0, 0, 0), 3))
        snow.spawn(into=bits, on="death", count=2)
        snow.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitution=0.5)
        snow.kill_expired()
        snow.move()
        bits.gravity((0, -2, 0))
        bits.kill_old(0.8)
        bits.move()
        grains.gravity((0, -9.8, 0))
        grains.contact(stiffness=200, restitution=0.4, friction=0.5)
        slip = ex.a.state.slip + ex.relative_velocity * 0.01
        grains.interact(0.4, acceleration=slip, set={"slip": slip, "n": 1 + ex.a.state.n}, state=REMEMBERED)
        grains.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)))
        grains.move()
        if frame > 10:
            snow.restore(1.0)  # needs birth values from before the checkpoint
        movie.write(world.render())
