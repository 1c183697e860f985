"""A fountain on fast machines and a slow one: python -m motes run -n 4 examples/heterogeneous.py.

The last calculator is as slow as a machine of half the speed. Watch the work split 2:1; then try
--balancer static, and compare the seconds. Needs the extra [analysis].
"""

from mpi4py import MPI

import motes
from motes.shapes import Plane, Sphere

args = motes.script.options(
    __doc__, space="-16,16", systems=1, frames=48, balancer="pairwise", size="640x360"
)
log = args.log or f"{args.out}/heterogeneous"

# The paper's roles, given explicitly to name the slow rank: rank 0 draws, rank 1 manages, the others
# calculate. With fewer than three ranks, one rank has several roles.
ranks = MPI.COMM_WORLD.size
calculators = list(range(2, ranks)) or [ranks - 1]
roles = motes.Roles(
    image_generator=0,
    manager=min(1, ranks - 1),
    calculators=calculators,
    speeds={calculators[-1]: 0.5},
)

camera = motes.Camera((0, 5, 30), (0, 5, 0), fov_deg=35)
world = motes.World(
    seed=args.seed,
    space=args.space,
    roles=roles,
    balancer=args.balancer,
    renderer=motes.Renderer(*args.size, camera=camera),
    log=log,
)
ground = Plane((0, 0, 0), (0, 1, 0))
water = world.system("water", capacity=args.particles, sprite=motes.Sprite("disc", pixels=3))
water.configure(velocity=Sphere((0, 11, 0), 3), color=(0.3, 0.6, 1), alpha=0.03)

with world, motes.Movie(f"{args.out}/heterogeneous.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:  # start with enough particles to balance
            water.burst(Sphere((0, 6, 0), 4), count=args.particles // 2)
        water.source(Sphere((0, 0.5, 0), 0.3), rate=args.particles / 4)
        water.gravity((0, -9.81, 0))
        water.bounce(ground, restitution=0.4, friction=0.1)
        water.kill_old(2.2)
        water.move()
        motes.script.end_frame(world, movie, args)

if "manager" in world.role:  # one rank reads the log
    held = motes.open_run(log).by_rank("n_end")  # one row per frame, one column per calculator
    shares = 100 * held.div(held.sum(axis=1), axis=0)
    print("Each calculator's part of the particles, in %:")
    print(shares.iloc[::4].round(1).to_string(), flush=True)
