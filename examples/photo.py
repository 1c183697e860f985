"""A picture bursts and finds itself again: python -m motes run -n 4 examples/photo.py --picture yours.jpg."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Sphere

args = motes.script.options(
    __doc__, space="-8,8", particles=3_000_000, frames=168, size="960x540", picture=""
)
WIDTH = 16  # of the picture, in metres; its middle is the origin, and it faces z


def planet(x, y):
    """Paint a planet with a ring: linear RGB at the positions (x, y), in metres.

    Uses only + - * / and square roots, which give the same bits on all machines, unlike sines and powers.
    """
    # The planet is a ball of radius 2.6, tilted: `along` is parallel to its equator, `across` to its axis.
    along, across = 0.94 * x + 0.34 * y, 0.94 * y - 0.34 * x
    r = np.sqrt(x * x + y * y) / 2.6
    on_ball = r < 1
    bulge = np.sqrt(np.maximum(0, 1 - r * r))  # towards the viewer

    # Light from the upper left; bands of two colours, bent by the bulge.
    sun = np.clip(0.8 * bulge - 0.2 * x + 0.16 * y, 0.01, 1) * on_ball
    band = np.abs((across * 1.7 + 0.25 * bulge) % 2 - 1)[..., None]
    image = sun[..., None] * (band * (1, 0.52, 0.19) + (1 - band) * (0.62, 0.22, 0.07))

    # The ring is a circle seen at a slant, with a gap. It goes behind the upper half of the ball.
    ring = np.sqrt(along**2 + (across / 0.3) ** 2)
    in_front = (r > 1) | (across < 0)
    on_ring = (ring > 3.3) & (ring < 6.2) & (np.abs(ring - 5) > 0.12) & in_front
    shadow = np.where((r < 1.12) & (across > 0), 0.15, 1)
    grooves = (0.2 + 0.6 * np.abs(ring * 3.1 % 2 - 1)) * shadow
    image = np.where(on_ring[..., None], grooves[..., None] * (1, 0.82, 0.58), image)

    # A high power of numbers in 0..1 leaves few near 1: few stars are bright.
    stars = 2 * np.random.default_rng(args.seed).random(x.shape) ** 2000 * (r > 1) * ~on_ring
    return image + stars[..., None]


def photograph(path):
    """Read a picture as linear RGB, skipping rows and columns if it has more pixels than particles."""
    import av

    with av.open(path) as file:
        pixels = next(file.decode(video=0)).to_ndarray(format="rgb24")
    image = (pixels / 255) ** 2.2
    step = int(np.ceil((image.size / 3 / args.particles) ** 0.5))
    return image[::step, ::step]


if args.picture:
    image = photograph(args.picture)
else:
    columns = int((args.particles * 16 / 9) ** 0.5)
    rows = columns * 9 // 16
    image = planet(*np.meshgrid(np.linspace(-8, 8, columns), np.linspace(4.5, -4.5, rows)))

# One particle for each pixel that is not black.
high, wide, _ = image.shape
row, col = np.nonzero(image.max(axis=2) > 0.01)
place = np.stack([col - wide / 2, high / 2 - row, 0 * row], axis=1) * WIDTH / wide
color = image[row, col].round(3)

camera = motes.Camera((0, 0.5, 13.4), (0, 0, 0), fov_deg=38)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.001, 0.001, 0.004))
world = motes.World(**args.world, renderer=renderer)
grains = world.system("grains", sprite=motes.Sprite(height=0.0074))
grains.configure(alpha=min(1, 140_000 / (high * wide)))  # same brightness with few particles as with many

# The film in frames: it rests, bursts, turns back, and rests again.
burst, turn, home = args.frames // 4, args.frames * 3 // 5, args.frames * 11 // 12

with world, motes.Movie(f"{args.out}/photo.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            grains.emit(position=place, color=color)
        camera.position = (5 * (frame / args.frames - 0.5), 0.5, 13.4)  # passes by from left to right
        if burst <= frame < turn:
            # A wave starts from the lower right. Grains that it has hit whirl about, the others stay.
            wave = 5 * (frame - burst) * world.dt
            hit = column("velocity").length() > 0.05
            grains.explosion((7, -3, -1.5), radius=wave, magnitude=260, sigma=0.5, epsilon=20)
            grains.curl_noise(8, scale=1.5, octaves=2, where=hit)
            grains.random_acceleration(Sphere((0, 0, 0), 2), where=hit)
            grains.damping((0.4, 0.4, 0.4))
        elif frame >= turn:
            grains.restore((home - frame) * world.dt)  # all arrive at the same time
        grains.move()
        motes.script.end_frame(world, movie, args)
