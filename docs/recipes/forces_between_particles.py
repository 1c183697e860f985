"""Forces between particles: `a` feels `b`, `normal` leads from a to b, `r` is their distance."""

import motes
from motes.expressions import normal, r, relative_velocity
from motes.shapes import Box

camera = motes.Camera((0, 0, 5), (0, 0, 0))
world = motes.World(
    seed=8, substeps=4, renderer=motes.Renderer(480, 270, camera=camera, background="#10131c")
)
cells = world.system("cells", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
cells.configure(size=0.14, color=motes.shapes.Line((0.1, 0.7, 0.6), (0.9, 0.3, 0.5)))
with world:
    for frame in world.frames(72):
        if frame == 0:
            cells.burst(Box((-2, -1.1, -0.1), (2, 1.1, 0.1)), count=500)
        push = 120 * (r - 0.16)  # apart below 16 cm, together above
        cells.interact(0.3, acceleration=normal * push + relative_velocity * 3)
        cells.damping((0.4, 0.4, 0.4))
        cells.move()
        picture = world.render()
    picture.save("out/forces_between_particles.png")
