"""A word bursts into dust and finds itself again: python -m motes run -n 4 examples/light/letters.py."""

import numpy as np

import motes
from motes.expressions import clamp, column, mix
from motes.shapes import Plane, Text

args = motes.script.options(
    __doc__, space="-4,4", systems=2, particles=30000, frames=144, size="960x540", word="motes"
)

floor = motes.Solid(Plane((0, -0.25, 0), (0, 1, 0)), (0.3, 0.3, 0.34))
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((-0.7, 0.75, 7.6), (0, 0.62, 0), fov_deg=34),
    background=motes.Gradient((0.006, 0.008, 0.022), (0.001, 0.001, 0.006), (0.004, 0.005, 0.01)),
    objects=[floor],
    sun=(0, 0, 0),
    shutter=0.6,
    bloom=0.15,
)
world = motes.World(**args.world, renderer=renderer)
word = []
for i in range(args.systems):
    motes_ = world.system(f"motes {i}", sprite=motes.Sprite(height=0.0042))
    word.append(motes_)

place, home, velocity = column("position"), column("position_b"), column("velocity")
letters = Text(args.word, height=1.7, depth=0.2).at((0, 0.85, 0))
wait, burst, back, end = (
    0.6,
    2.1,
    3.4,
    5.6,
)  # seconds: at rest, bursting from left to right, blown about, returning
with world, motes.Movie(f"{args.out}/letters.mp4") as movie:
    for frame in world.frames(args.frames):
        time = world.time
        front = -3.7 + 7.4 * (time - wait) / (burst - wait)
        calm = min(1, abs(time - 0.5 * (wait + end)) / (0.5 * (end - wait)))  # 1 while the word is at rest
        tone = np.array((1, 0.55, 0.2)) * calm + np.array((0.3, 0.35, 1)) * (1 - calm)
        renderer.lights = [motes.Light((x, 0.7, 0.5), tone, power=0.35) for x in (-2, 0, 2)]
        for grains in word:
            if frame == 0:
                grains.burst(letters, count=args.particles)
            if time < back:
                loose = home.x < front
                grains.explosion(
                    (front, 0.45, 0), radius=0.1, magnitude=14, sigma=0.25, epsilon=0.4, where=loose
                )
                grains.curl_noise(6, scale=1.1, octaves=3, speed=0.4, where=loose)
                grains.wind((0.35, 0.25, 0), drag=1.6, where=loose)
            else:
                grains.restore(max(end - time, 0))
            far = clamp((place - home).length() / 1.1, 0, 1)
            fast = clamp(velocity.length() / 3, 0, 1)
            cool = mix((0.1, 0.4, 1.6), (1.3, 0.25, 1.2), clamp(0.5 + 0.4 * place.y, 0, 1))
            glow = mix((1, 0.55, 0.18), cool, far) + (1, 0.4, 0.1) * fast * (1 - far)
            grains.set(color=glow, alpha=0.16 + 0.25 * far)
            grains.move()
        motes.script.end_frame(world, movie, args)
