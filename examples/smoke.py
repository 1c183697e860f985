"""Coloured smoke curls up around a ball: python -m motes run -n 4 examples/smoke.py."""

import motes
from motes.shapes import Cylinder, Disc, Plane, Sphere

args = motes.script.options(
    __doc__, space="-1.6,1.6", systems=6, particles=12_000, frames=216, size="960x540"
)

ground = Plane((0, 0, 0), (0, 1, 0))
ball = Sphere((0.25, 1.75, 0), 0.42)  # hangs over the middle pot, in its smoke
colors = [(1, 0.10, 0.32), (1, 0.42, 0.06), (0.10, 0.55, 1)]
mouths = [(-1.0, 0.22, 0.1), (0.2, 0.22, 0), (1.25, 0.22, -0.1)]
pots = [Cylinder((x, 0, z), (x, 0.3, z), 0.16, 0.12) for x, _, z in mouths]

solids = [motes.Solid(ground, (0.12, 0.11, 0.10)), motes.Solid(ball, (0.35, 0.35, 0.38))]
solids += [motes.Solid(pot, (0.16, 0.10, 0.07)) for pot in pots]
camera = motes.Camera((0, 1.3, 6.2), (0, 1.72, 0), fov_deg=33)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.30, 0.36, 0.44), objects=solids)
world = motes.World(**args.world, renderer=renderer)

plumes = []
for i in range(args.systems):
    # Puffs hide what is behind them, and fade where they touch the pots and the ball.
    pot, puff = i % 3, motes.Sprite(pixels=None, blend="alpha", softness=0.12)
    smoke = world.system(f"smoke {i}", capacity=args.particles, sprite=puff)
    smoke.configure(velocity=Sphere((0, 1.2, 0), 0.04), lifetime=motes.Uniform(3, 5.5))
    shade = 1 - 0.45 * (i // 3 % 2)  # darker puffs between the bright ones show the depth of a cloud
    fresh, old = [tuple(shade * (c / fade + 0.2 * (fade - 1)) for c in colors[pot]) for fade in (1, 2)]
    plumes.append((smoke, Disc(mouths[pot], (0, 1, 0), 0.1), [(0, fresh), (1, old)]))

with world, motes.Movie(f"{args.out}/smoke.mp4") as movie:
    for _ in world.frames(args.frames):
        for smoke, mouth, ageing in plumes:
            smoke.source(mouth, rate=args.particles / 4.5, jitter=True)
            smoke.wind((0, 0.8, 0), drag=1.1)  # warm air carries it up
            smoke.curl_noise(1.6, scale=0.6, octaves=3, speed=0.2)
            smoke.bounce(ball, restitution=0.1)
            smoke.color_over_life(ageing)
            smoke.alpha_over_life([(0, 0), (0.04, 0.24), (0.4, 0.12), (1, 0)])
            smoke.size_over_life([(0, 0.06), (0.3, 0.16), (1, 0.4)])
            smoke.kill_expired()
            smoke.move()
        motes.script.end_frame(world, movie, args)
