"""Coloured smoke curls up in the dark: python -m motes run -n 4 examples/smoke.py."""

import motes
from motes.shapes import Cylinder, Disc, Plane, Sphere

args = motes.script.options(
    __doc__, space="-1.6,1.6", systems=6, particles=250_000, frames=216, size="960x540"
)

ground = Plane((0, 0, 0), (0, 1, 0))
ball = Sphere((0.25, 1.75, 0), 0.42)  # hangs over the middle pot, in the way of its smoke
colors = [(1, 0.10, 0.32), (1, 0.42, 0.06), (0.10, 0.55, 1)]
mouths = [(-1.0, 0.22, 0.1), (0.2, 0.22, 0), (1.25, 0.22, -0.1)]
pots = [Cylinder((x, 0, z), (x, 0.3, z), 0.16, 0.12) for x, _, z in mouths]

solids = [motes.Solid(ground, (0.02, 0.02, 0.025)), motes.Solid(ball, (0.06, 0.06, 0.07))]
solids += [motes.Solid(pot, (0.05, 0.045, 0.05)) for pot in pots]
camera = motes.Camera((0, 1.3, 6.2), (0, 1.72, 0), fov_deg=33)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.001, 0.001, 0.003), objects=solids)
world = motes.World(seed=args.seed, space=args.space, renderer=renderer, log=args.log)

plumes = []
for i in range(args.systems):
    # Each pot emits several systems, of sprites of different sizes: fine threads in soft clouds.
    pot, size = i % 3, i // 3
    smoke = world.system(f"smoke {i}", capacity=args.particles, sprite=motes.Sprite(pixels=3 + 2 * size))
    smoke.configure(velocity=Sphere((0, 1.2, 0), 0.04), lifetime=motes.Uniform(3, 5.5))
    plumes.append((smoke, Disc(mouths[pot], (0, 1, 0), 0.1), colors[pot]))

with world, motes.Movie(f"{args.out}/smoke.mp4") as movie:
    for _ in world.frames(args.frames):
        for smoke, mouth, (r, g, b) in plumes:
            smoke.source(mouth, rate=args.particles / 4.5, jitter=True)
            smoke.wind((0, 0.8, 0), drag=1.1)  # warm air carries it up
            smoke.curl_noise(1.6, scale=0.6, octaves=3, speed=0.2)
            smoke.bounce(ball, restitution=0.1)
            smoke.color_over_life([(0, (r, g, b)), (1, (r / 2 + 0.1, g / 2 + 0.1, b / 2 + 0.2))])
            smoke.alpha_over_life([(0, 0.012), (0.12, 0.02), (0.5, 0.016), (1, 0)])
            smoke.kill_expired()
            smoke.move()
        motes.script.end_frame(world, movie, args)
