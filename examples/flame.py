"""A camp fire at night: python -m motes run -n 4 examples/flame.py."""

import motes
from motes.shapes import Cylinder, Disc, Plane, Sphere, Union

args = motes.script.options(
    __doc__, space="-0.6,0.6", systems=6, particles=120_000, frames=144, size="960x540"
)

# Logs that lean inwards, in a ring of stones. Directions are the cosine and sine of an angle.
ground = Plane((0, 0, 0), (0, 1, 0))
logs = []
for c, s in ((1, 0.15), (0.45, 0.9), (-0.55, 0.8), (-1, -0.1), (0.7, -0.75), (-0.6, -0.8)):
    logs.append(Cylinder((0.75 * c - 0.06, 0.07, 0.75 * s), (-0.12 * c, 0.30, -0.12 * s), 0.075))
stones = []
for c, s in ((1, 0), (0.81, 0.59), (0.31, 0.95), (-0.31, 0.95), (-0.81, 0.59)):
    for radius in (1.05, -1.05):  # and the one opposite
        stones.append(Sphere((radius * c, 0.05, radius * s), 0.12 + 0.07 * s * s))

solids = [
    motes.Solid(ground, (0.035, 0.022, 0.015)),
    motes.Solid(Union(*logs), (0.11, 0.04, 0.015)),
    motes.Solid(Union(*stones), (0.07, 0.05, 0.04)),
]
camera = motes.Camera((0, 1.15, 5.2), (0, 0.95, 0), fov_deg=30)
dark = (0.002, 0.003, 0.007)
renderer = motes.Renderer(
    *args.size, camera=camera, background=dark, objects=solids, sun=(0, 0, 0), bloom=0.1
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

# The colours of a flame over its life, as part of the lifetime: blue at the foot, white, orange, red, dark.
burning = [
    (0, (0.3, 0.35, 1)),
    (0.1, (1, 0.62, 0.25)),
    (0.4, (1, 0.36, 0.06)),
    (0.75, (0.9, 0.14, 0.02)),
    (1, (0.5, 0, 0)),
]
fading = [(0, 0), (0.1, 0.015), (0.5, 0.013), (0.8, 0.006), (1, 0)]
ember = [(0, (1, 0.8, 0.4)), (0.6, (1, 0.4, 0.08)), (1, (0.6, 0.05, 0))]

flames = []
for i in range(args.systems):
    fire = world.system(
        f"fire {i}", capacity=args.particles, sprite=motes.Sprite(height=0.0074 + 0.0037 * (i % 4))
    )
    fire.configure(lifetime=motes.Uniform(0.2, 0.9), velocity=Sphere((0, 0.5, 0), 0.1))
    flames.append(fire)
wind = world.control("wind", 0.0, low=-4, high=4, step=0.1)  # m/s; `motes live` has a slider for it
sparks = world.system("sparks", capacity=4000, sprite=motes.Sprite(height=0.0056))
sparks.configure(lifetime=motes.Uniform(0.8, 3), velocity=Sphere((0, 2.2, 0), 1.1))

with world, motes.Movie(f"{args.out}/flame.mp4") as movie:
    for frame in world.frames(args.frames):
        flicker = 1 + 0.25 * (frame * 5 % 7 / 3 - 1)  # the fire lights its logs and stones
        renderer.lights = [motes.Light((0.05 * flicker, 0.6, 0), (1, 0.42, 0.1), power=4 * flicker)]

        for fire in flames:
            fire.source(Disc((0, 0.15, 0), (0, 1, 0), 0.45), rate=args.particles / 0.6, jitter=True)
            fire.color_over_life(burning)
            fire.alpha_over_life(fading)
            fire.gravity((0, 3.6, 0))  # upwards: hot gas rises
            fire.orbit_line((0, 0, 0), axis=(0, 1, 0), magnitude=3.2, epsilon=0.35)  # pulled to the middle
            fire.curl_noise(12, scale=0.5, octaves=2, speed=1.2)
            fire.wind((wind.value, 1.5, 0), drag=2.5)

        sparks.source(Disc((0, 0.3, 0), (0, 1, 0), 0.35), rate=90, jitter=True)
        sparks.gravity((0, 0.5, 0))
        sparks.curl_noise(6, scale=0.5, octaves=2, speed=1)
        sparks.wind((wind.value, 0, 0), drag=abs(wind.value) / 4)
        sparks.color_over_life(ember)

        for system in (*flames, sparks):
            system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
