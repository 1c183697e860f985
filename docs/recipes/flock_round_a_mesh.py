"""A flock round a mesh: neighbours align and keep apart, `avoid` steers round the shape."""

import motes
from motes.expressions import column, cross
from motes.shapes import Sphere

rock = motes.Mesh(
    [(0, 1, 0), (0.8, 0, 0), (0, 0, 0.8), (-0.8, 0, 0), (0, 0, -0.8), (0, -1, 0)],
    [(0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 1, 4), (5, 1, 2), (5, 2, 3), (5, 3, 4), (5, 4, 1)],
)
camera = motes.Camera((0, 2, 7), (0, 0, 0), fov_deg=36)
solids = [motes.Solid(rock, "#7d6f63")]
world = motes.World(
    seed=6, renderer=motes.Renderer(480, 270, camera=camera, background="#c9d8e4", objects=solids)
)
fish = world.system("fish", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
fish.configure(size=0.07, color=(0.05, 0.2, 0.45), velocity=(1, 0, 0))
with world:
    for frame in world.frames(96):
        if frame == 0:
            fish.burst(Sphere((-2, 0, 0), 0.8), count=900)
        fish.match_velocity(2, epsilon=0.2, max_radius=0.6)
        fish.gravitate(-0.05, epsilon=0.05, max_radius=0.2)
        fish.orbit_line((0, 0, 0), (0, 1, 0), magnitude=3, epsilon=0.5)
        fish.gravity(cross((0, 1.2, 0), column("position")))
        fish.curl_noise(4, scale=0.8, speed=0.4)
        fish.avoid(rock, magnitude=14, epsilon=0.1, look_ahead=1)
        fish.speed_clamp(1, 2)
        fish.move()
        picture = world.render()
    picture.save("out/flock_round_a_mesh.png")
