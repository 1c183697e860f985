"""Three stars that pull each other, six times: python -m motes run -n 4 examples/three_bodies.py.

These orbits repeat: the figure eight (Moore 1993; Chenciner and Montgomery 2000) and others (Suvakov
and Dmitrasinovic 2013). The eight is stable: a pushed one only turns. The film has one period of the moth.
"""

import colorsys

import numpy as np

import motes

args = motes.script.options(__doc__, space="-6,6", systems=6, particles=1, frames=288, size="960x540")

# Two stars start at (-1, 0) and (1, 0) with this velocity, and one between them with minus twice that.
orbits = {
    "moth": (0.464445, 0.396060),
    "figure eight": (0.347111, 0.532728),
    "bumblebee": (0.184279, 0.587188),
    "pushed eight": (0.332, 0.526),
    "moth 2": (0.439166, 0.452968),
    "yin-yang": (0.513938, 0.304736),
}
# Orbits are given in units in which masses and the gravitational constant are 1; here time runs a bit faster.
fast, substeps = 1.5, 200
# Pulling and then moving is a leapfrog if velocities begin half a step early: the outer two fall at 1 + 1/4.
early = 1.25 * fast**2 / (24 * substeps) / 2

camera = motes.Camera((0, 0, 9), (0, 0, 0), fov_deg=38)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.001, 0.0013, 0.003), bloom=0.15)
world = motes.World(**args.world, substeps=substeps, renderer=renderer)

triples = []  # each triple is a separate system: its stars see only each other
for i in range(args.systems):
    name, velocity = list(orbits.items())[i % len(orbits)]
    place = np.array([(-1, 0, 0), (1, 0, 0), (0, 0, 0)]) + ((i % 3 - 1) * 3.4, (0.5 - i // 3 % 2) * 3.3, 0)
    velocity = fast * np.outer((1, 1, -2), (*velocity, 0)) - np.outer((early, -early, 0), (1, 0, 0))
    color = [colorsys.hsv_to_rgb((0.15 * i + tone) % 1, 0.75, 1) for tone in (0, 0.09, 0.18)]
    stars = world.system(f"{name} {i}", sprite=motes.Sprite(height=0.022))
    light = world.system(f"light of {name} {i}", sprite=motes.Sprite(height=0.007))
    light.configure(lifetime=9)
    triples.append((stars, light, place, velocity, color))


def way(x0, v0, x1, v1, parts=16):
    """Interpolate positions between two with given velocities, by a cubic Hermite spline."""
    s = np.linspace(0, 1, parts, endpoint=False)[:, None, None]
    out, back = s * (1 - s) ** 2 * world.dt, s**2 * (1 - s) * world.dt
    return ((1 - s) ** 2 * (1 + 2 * s) * x0 + s**2 * (3 - 2 * s) * x1 + out * v0 - back * v1).reshape(-1, 3)


with world, motes.Movie(f"{args.out}/three_bodies.mp4") as movie:
    for frame in world.frames(args.frames):
        for stars, light, place, velocity, color in triples:
            if frame == 0:
                stars.emit(position=place, velocity=velocity, color=color)
            stars.gravitate(fast**2, epsilon=0)
            stars.move()
            light.alpha_over_life([(0, 0.3), (0.3, 0.09), (1, 0)])
            light.kill_expired()
            light.move()
        motes.script.end_frame(world, movie, args)
        for i, (stars, light, place, velocity, color) in enumerate(triples):
            now = stars.gather(to="all")
            light.emit(position=way(place, velocity, now.position, now.velocity), color=color * 16)
            triples[i] = (stars, light, now.position, now.velocity, color)
