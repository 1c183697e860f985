"""Numbers from particles: `tally` counts them on a grid, exactly, on any number of ranks."""

import numpy as np

import motes
from motes.shapes import Sphere

world = motes.World(seed=18)
dots = world.system("dots")
with world:
    for frame in world.frames(28):
        if frame == 0:
            dots.burst(Sphere((0, 0, 0), 1), count=400_000)
        dots.curl_noise(3, scale=0.9)
        dots.damping((0.5, 0.5, 0.5))
        dots.move()
        world.step()
    counts = dots.tally((-2.4, -1.35, -9), (2.4, 1.35, 9), (480, 270, 1))[:, ::-1, 0].T
    shown = np.repeat(np.sqrt(np.minimum(counts / np.quantile(counts, 0.999), 1))[:, :, None], 3, axis=2) ** (
        1.2,
        0.8,
        0.5,
    )
    motes.Frame(0, 0.0, (shown * 255).astype(np.uint8)).save("out/numbers_from_particles.png")
