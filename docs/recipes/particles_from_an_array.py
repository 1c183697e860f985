"""Particles from an array: rows of NumPy arrays, equal on all ranks, become particles."""

import numpy as np

import motes

t = np.linspace(0, 2 * np.pi, 700)
knot = np.stack([np.cos(2 * t) * (2 + np.cos(3 * t)), np.sin(2 * t) * (2 + np.cos(3 * t)), np.sin(3 * t)], 1)
color = 0.5 + 0.5 * np.cos(t[:, None] + (0, 2, 4))
camera = motes.Camera((0, 0, 9), (0, 0, 0))
world = motes.World(seed=17, renderer=motes.Renderer(480, 270, camera=camera, background="#12141a"))
beads = world.system("beads", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
beads.configure(size=0.22)
with world:
    beads.emit(position=knot, color=color)
    world.render().save("out/particles_from_an_array.png")
