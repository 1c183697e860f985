"""Meshes in all their roles, still and moving; `--digest` prints the same as `motes_replay --digest`."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "support"))  # the tests' modules

from made_meshes import block, torus

import motes
from motes import shapes

FRAMES = 8
digest = "--digest" in sys.argv
ring = motes.Mesh(*torus(), resolution=48)
full = motes.Mesh(*torus(), solid=True, resolution=48)
paddle = motes.Mesh(*block((-0.2, -0.2, -1.5), (0.2, 0.2, 1.5)), resolution=40)
flame = motes.Mesh(*torus(20, 10, 3, 0.5))


def turning(frame: int, moving_from: motes.Mesh | None = None) -> motes.Mesh:
    """Return the paddle at the start of a frame."""
    place = (-1.6 + 0.05 * frame, 0.2, 0)
    return paddle.at(place, axis=(0, 1, 1), angle_deg=25 * frame, moving_from=moving_from)


renderer = motes.Renderer(
    96, 64, camera=motes.Camera((0, 3, 6), (0, 0, 0)), objects=[motes.Solid(ring, (0.6, 0.3, 0.1))]
)
world = motes.World(seed=5, dt=1 / 24, substeps=2, space=(-2, 2), renderer=renderer, progress="off")
sand = world.system("sand", capacity=4000)
glow = world.system("glow")

with world:
    for frame in world.frames(FRAMES):
        renderer.objects = [motes.Solid(ring, (0.6, 0.3, 0.1)), motes.Solid(turning(frame + 1))]
        sand.configure(velocity=flame if frame % 2 else shapes.Sphere((0, -3, 0), 4))
        sand.source(shapes.Box((-1.5, 0.6, -1.5), (1.5, 1, 1.5)), rate=20000)
        sand.gravity((0, -9.8, 0))
        sand.avoid(ring.at((0, -2, 0)), magnitude=4, epsilon=0.1, look_ahead=0.3)
        sand.bounce(ring, restitution=0.4, friction=0.1)
        sand.bounce(turning(0) | shapes.Sphere((0, 0, 0), 0.3), restitution=0.2)
        sand.bounce(turning(frame + 1, moving_from=turning(frame)), restitution=0.1)
        sand.set(color=(1, 0.2, 0), where=~ring.at((0, 0.3, 0)) & shapes.Box((-9, -9, -9), (0, 9, 9)))
        sand.spawn(into=glow, on="birth", count=1, where=full.at((0.5, 0.5, 0)))
        sand.move()
        sand.sink(full.at((0, -2.5, 0)))
        glow.burst(full, count=200)
        glow.source(ring, rate=3000, moving_from=ring.at((0, 0.5, 0)))
        glow.random_velocity(ring)
        glow.move()
        picture = world.render()
        if digest:
            motes.script.print_digest(world, picture)
