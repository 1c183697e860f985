"""The paper's snow (5.1): systems of any number of particles, which fall over the whole width."""

import motes
from motes_lab.bench.snow import Snow

args = motes.script.options(
    __doc__, particles=2000, frames=40, size="64x36", space="-30,30", width=60.0, distance=60.0, faintest=1.0
)
camera = motes.Camera((0, 6, args.distance), (0, 6, 0), fov_deg=60)
renderer = motes.Renderer(*args.size, camera=camera, path="gather")
world = motes.World(seed=args.seed, space=args.space, renderer=renderer, log=args.log)
layers = [world.system(f"snow {i}", capacity=args.particles) for i in range(args.systems)]
snow = Snow(width=args.width)

with world:
    for frame in world.frames(args.frames):
        for layer in layers:
            if args.faintest < 1:  # each flake's look travels with it, as in the paper
                layer.configure(alpha=motes.Uniform(args.faintest, 1))
            snow.record(layer, frame, args.particles)
        world.render()
