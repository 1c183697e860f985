"""The paper's snow (5.1): systems of particles that fall over all of a width, at any number of particles."""

import motes
from motes.shapes import Box, Plane, Rectangle

args = motes.script.options(__doc__, particles=2000, frames=40, size="64x36", space="-30,30", width=60.0)
width, top, life = args.width, 12.0, 12.0  # m, m, s
camera = motes.Camera((0, 6, 60), (0, 6, 0), fov_deg=60)
renderer = motes.Renderer(*args.size, camera=camera)
world = motes.World(seed=args.seed, space=args.space, renderer=renderer, log=args.log)
layers = [world.system(f"snow {i}", capacity=args.particles) for i in range(args.systems)]

with world:
    for frame in world.frames(args.frames):
        for snow in layers:
            snow.configure(velocity=Box((-0.4, -1.4, -0.3), (0.4, -1.2, 0.3)), age=0)
            if frame == 0:  # the air is full from the start
                snow.configure(age=motes.Uniform(0, life))
                snow.burst(Box((-width / 2, 0.1, -4), (width / 2, top, 4)), count=args.particles)
                snow.configure(age=0)
            snow.source(
                Rectangle((-width / 2, top, -4), (width, 0, 0), (0, 0, 8)), rate=args.particles / life
            )
            snow.random_acceleration(Box((-1, -1, -1), (1, 1, 1)))
            snow.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=0.1, friction=0.9)
            snow.kill_old(life)
            snow.move()
        world.render()
