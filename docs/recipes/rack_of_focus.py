"""A rack of focus: the camera's `focus` is a curve over time, `aperture` the width of its lens."""

import motes
from motes.shapes import Box, Cylinder, Plane

focus = motes.Curve([(0, 3), (1, 3), (2, 7)], "smooth")
camera = motes.Camera((0, 0.8, 4), (0, 0.55, 0), fov_deg=30, focus=focus, aperture=0.12)
ground, post = Plane((0, 0, 0), (0, 1, 0)), Cylinder((-0.5, 0, 1), (-0.5, 1, 1), 0.12)
solids = [motes.Solid(ground, "#26262c"), motes.Solid(post, "#b8894f")]
world = motes.World(seed=13, renderer=motes.Renderer(480, 270, camera=camera, objects=solids, bloom=0.1))
lights = world.system("lights", sprite=motes.Sprite("disc", pixels=None))
lights.configure(size=0.05, color=motes.shapes.Line((1, 0.3, 0.1), (0.3, 0.5, 1)), alpha=0.9)
with world:
    for frame in world.frames(24):
        if frame == 0:
            lights.burst(Box((-2, 0.1, -4), (2, 1.4, 1.5)), count=150)
        lights.move()
        picture = world.render()
    picture.save("out/rack_of_focus.png")
