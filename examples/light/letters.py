"""A word bursts into dust and finds itself again: python -m motes run -n 4 examples/light/letters.py."""

import numpy as np

import motes
from motes.expressions import clamp, column, mix
from motes.shapes import Plane

args = motes.script.options(
    __doc__, space="-4,4", systems=2, particles=30000, frames=144, size="960x540", word="motes"
)

# Letters as strokes: lines x, y to x, y, and arcs with centre x, y, radius, from and to an angle. Degrees.
STROKES = {
    "m": "0 0 0 1, .7 0 .7 .65, 1.4 0 1.4 .65, .35 .65 .35 0 180, 1.05 .65 .35 0 180",
    "o": ".5 .5 .5 0 360",
    "t": ".3 .27 .3 1.4, 0 1 .65 1, .57 .27 .27 180 300",
    "e": "0 .52 1 .52, .5 .5 .5 2 318",
    "s": ".34 .745 .255 30 270, .34 .255 .255 90 -150",
}


def dust(word, count, rng):
    """Draw random positions in the tubes of the word's letters, (count, 3)."""
    lines, start, t = [], 0.0, np.linspace(0, 1, 65)
    for letter in word:
        drawn = []
        for x, y, *rest in (map(float, stroke.split()) for stroke in STROKES[letter].split(",")):
            if len(rest) == 2:
                drawn.append((x + (rest[0] - x) * t, y + (rest[1] - y) * t))
            else:
                turn = np.deg2rad(rest[1] + (rest[2] - rest[1]) * t)
                drawn.append((x + rest[0] * np.cos(turn), y + rest[0] * np.sin(turn)))
        lines += [np.stack([x + start, y], axis=1) for x, y in drawn]
        start += max(x.max() for x, _ in drawn) + 0.36
    pieces = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    long = np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1)
    on = pieces[np.searchsorted(np.cumsum(long) / long.sum(), rng.uniform(0, 0.999, count))]
    middle = on[:, 0] + (on[:, 1] - on[:, 0]) * rng.uniform(size=(count, 1))
    ball = rng.normal(size=(count, 3))
    ball *= 0.105 * rng.uniform(size=(count, 1)) ** 0.4 / np.linalg.norm(ball, axis=1, keepdims=True)
    return (ball + np.pad(middle, ((0, 0), (0, 1))) - ((start - 0.36) / 2, 0, 0)).round(4)


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
rng = np.random.default_rng(args.seed)
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
                grains.emit(position=dust(args.word, args.particles, rng))
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
