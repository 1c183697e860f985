"""Embers rise and bounce, and are written to files: python -m motes run -n 4 examples/export.py --kind .usd.

`--kind .usd` is for Blender and Houdini, `--kind .pvd` for ParaView; without it they are .npz, for NumPy.
"""

import motes
from motes.expressions import column, maximum
from motes.shapes import Cone, Disc, Plane

args = motes.script.options(__doc__, space="fit", systems=1, particles=20_000, frames=96, kind="", every=1)

ground = Plane((0, 0, 0), (0, 1, 0))
world = motes.World(seed=args.seed, space=args.space, balancer=args.balancer, log=args.log)
embers = world.system("embers", capacity=args.particles, attributes={"heat": 1.0})
path = f"{args.out}/embers{args.kind}"

with world, motes.Export(path, every=args.every) as export:
    for _ in world.frames(args.frames):
        embers.configure(
            velocity=Cone((0, 0, 0), (0, 9, 0), 2.2),
            color=motes.Uniform((1, 0.25, 0.03), (1, 0.6, 0.15)),
            # Metres. Other programs draw particles in this size by default.
            size=motes.Uniform((0.015,) * 3, (0.04,) * 3),
            lifetime=motes.Uniform(1, 2.2),
        )
        embers.source(Disc((0, 0.05, 0), (0, 1, 0), 0.15), rate=args.particles / 1.6, jitter=True)
        embers.gravity((0, -9.8, 0))
        embers.curl_noise(6, scale=0.8, octaves=2, speed=0.5)
        embers.bounce(ground, restitution=0.45, friction=0.2)
        embers.set(heat=maximum(0, 1 - column("age") / column("lifetime")))
        embers.move()
        embers.kill_expired()
        picture = world.step()
        export.write(world)  # each calculator its own particles, while the next frame is computed
        if args.digest:
            motes.script.print_digest(world, picture)

if world.rank == 0:
    files = motes.open_particles(path)
    last = files[-1]  # sorted by id, as embers.gather() would be
    print(f"{len(files)} frames in {path}; the last one has {len(last)} embers,", end=" ")
    print(f"the hottest {last.heat.max():.2f}, the highest at {last.position[:, 1].max():.2f} m")
