"""Two discs of stars meet, each star pulling all others: python -m motes run -n 4 examples/galaxy.py."""

import numpy as np

import motes

args = motes.script.options(__doc__, space="fit", systems=1, particles=40_000, frames=240, size="960x540")

# The stars' mutual pull makes bridges and tails (Toomre and Toomre 1972).
pull, soft = 40 / args.particles, 0.02  # m3/s2, m2: a galaxy of the size of a room
dice = np.random.default_rng(args.seed)


def galaxy(count, normal, center, drift, colors):
    """Return positions, velocities and colours of a dense-centred disc of stars that turns about `normal`."""
    bulge = count // 3
    r = np.sort(np.concatenate([0.2 * dice.random(bulge), 0.2 + 1.6 * dice.random(count - bulge) ** 0.8]))
    inside = np.arange(count)  # stars nearer to the middle
    speed = np.sqrt(pull * inside * r / (r * r + soft))
    normal = np.array(normal) / np.linalg.norm(normal)
    across = dice.normal(size=(count, 3))
    across[bulge:] -= np.outer(across[bulge:] @ normal, normal)  # the bulge is a ball, the rest is flat
    across /= np.linalg.norm(across, axis=1)[:, None]
    along = np.cross(normal, across)
    along /= np.linalg.norm(along, axis=1)[:, None]
    along += 0.12 * dice.normal(size=(count, 3))  # stars on exact circles would clump
    place = center + r[:, None] * across + 0.04 * dice.normal(size=(count, 3))
    young = (r > 0.35)[:, None] & (dice.random((count, 1)) < 0.6)
    color = np.where(young, *colors)
    return place.round(4), (drift + speed[:, None] * along).round(4), color


half = args.particles // 2
kinds = [((0.35, 0.55, 1.0), (1.0, 0.62, 0.3)), ((1.0, 0.35, 0.5), (1.0, 0.8, 0.5))]
pair = [
    galaxy(half, (0.2, 1, 0.5), (-2.2, -0.5, 0.3), (1.6, 0.9, 0), kinds[0]),
    galaxy(half, (-0.7, 1, 0.9), (2.2, 0.5, -0.3), (-1.6, -0.9, 0), kinds[1]),
]
position, velocity, color = (np.concatenate(parts) for parts in zip(*pair, strict=True))

camera = motes.Camera((0, 2.2, 8), (0, 0, 0), fov_deg=38)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.001, 0.0012, 0.003), bloom=0.2)
world = motes.World(**args.world, dt=1 / 64, renderer=renderer)
stars = world.system("stars", sprite=motes.Sprite(height=0.006))
stars.configure(alpha=min(0.5, 8000 / args.particles))

with world, motes.Movie(f"{args.out}/galaxy.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            stars.emit(position=position, velocity=velocity, color=color)
        angle = 0.9 * frame / args.frames
        camera.position = (round(7.6 * np.sin(angle), 4), 2.2, round(7.6 * np.cos(angle), 4))
        stars.gravitate(pull, epsilon=soft, far="cells")  # groups of distant stars pull as one
        stars.move()
        motes.script.end_frame(world, movie, args)
