"""A picture bursts and finds itself again: python -m motes run -n 4 examples/photo.py --picture yours.jpg."""

import numpy as np

import motes
from motes import column
from motes.shapes import Sphere

args = motes.script.options(
    __doc__, space="-8,8", particles=3_000_000, frames=168, size="960x540", picture=""
)


def planet(x, y):
    """Linear RGB at these places. Only + - * / and roots, which give the same on all machines."""
    along, across = 0.94 * x + 0.34 * y, 0.94 * y - 0.34 * x
    r, ring = np.sqrt(x * x + y * y) / 2.6, np.sqrt(along**2 + (across / 0.3) ** 2)
    height = np.sqrt(np.maximum(0, 1 - r * r))
    sun = np.clip(0.8 * height - 0.2 * x + 0.16 * y, 0.01, 1) * (r < 1)
    band = np.abs((across * 1.7 + 0.25 * height) % 2 - 1)[..., None]
    image = sun[..., None] * (band * (1, 0.52, 0.19) + (1 - band) * (0.62, 0.22, 0.07))
    plain = (ring > 3.3) & (ring < 6.2) & (np.abs(ring - 5) > 0.12) & ((r > 1) | (across < 0))
    grooves = (0.2 + 0.6 * np.abs(ring * 3.1 % 2 - 1)) * np.where((r < 1.12) & (across > 0), 0.15, 1)
    image = np.where(plain[..., None], grooves[..., None] * (1, 0.82, 0.58), image)
    stars = 2 * np.random.default_rng(args.seed).random(x.shape) ** 2000 * (r > 1) * ~plain
    return image + stars[..., None]


if args.picture:
    import av

    with av.open(args.picture) as file:
        image = (next(file.decode(video=0)).to_ndarray(format="rgb24") / 255) ** 2.2
    step = int(np.ceil((image.size / 3 / args.particles) ** 0.5))
    image = image[::step, ::step]
else:
    wide = int((args.particles * 16 / 9) ** 0.5)
    image = planet(*np.meshgrid(np.linspace(-8, 8, wide), np.linspace(4.5, -4.5, wide * 9 // 16)))
high, wide, _ = image.shape
row, col = np.nonzero(image.max(axis=2) > 0.01)
place = np.stack([col - wide / 2, high / 2 - row, 0 * row], axis=1) * 16 / wide

camera = motes.Camera((0, 0.5, 13.4), (0, 0, 0), fov_deg=38)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.001, 0.001, 0.004))
world = motes.World(seed=args.seed, space=args.space, renderer=renderer, log=args.log)
grains = world.system("grains", sprite=motes.Sprite(pixels=4))
grains.configure(alpha=min(1, 140_000 / (high * wide)))
burst, turn, home = args.frames // 4, args.frames * 3 // 5, args.frames * 11 // 12

with world, motes.Movie(f"{args.out}/photo.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            grains.emit(position=place, color=image[row, col].round(3))
        camera.position = (5 * (frame / args.frames - 0.5), 0.5, 13.4)
        if burst <= frame < turn:
            hit = column("velocity").length() > 0.05
            wave = 5 * (frame - burst) * world.dt
            grains.explosion((7, -3, -1.5), radius=wave, magnitude=260, sigma=0.5, epsilon=20)
            grains.curl_noise(8, scale=1.5, octaves=2, where=hit)
            grains.random_acceleration(Sphere((0, 0, 0), 2), where=hit)
            grains.damping((0.4, 0.4, 0.4))
        elif frame >= turn:
            grains.restore((home - frame) * world.dt)
        grains.move()
        motes.script.end_frame(world, movie, args)
