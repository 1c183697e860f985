"""Photons in a slab of shielding, a Monte Carlo: python -m motes run -n 4 examples/shielding.py.

A photon flies straight on to its next collision; there it is absorbed, or flies on in any direction. What is
counted at the end is exact: the same bits on any number of ranks.
"""

import hashlib
import math

import motes
from motes import column
from motes.shapes import Blob, Cylinder, Disc

args = motes.script.options(__doc__, systems=2, particles=60_000, frames=144, size="960x540")

# A slab without end in y and z, from x = 0 on, between two screens; a lamp in front of it. Metres, m/s.
thick, screens, speed = 2.0, (-1.5, 4.0), 2.0
hole, shining = Disc((-0.6, 0, 0), (1, 0, 0), 0.12), max(1, args.frames // 2)  # frames
kinds = [("soft", 0.5, (0.35, 0.6, 1)), ("hard", 1.2, (1, 0.72, 0.3))]  # mean free paths, colours
half = 0.6745  # half of all normal numbers are farther from 0

bars = [Cylinder((-1.1, 0, 0), hole.center, 0.16)]
for x in (0, thick):
    corners = [(x, -1.3, -1.3), (x, 1.3, -1.3), (x, 1.3, 1.3), (x, -1.3, 1.3)]
    bars += [Cylinder(a, b, 0.014) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
solids = [motes.Solid(bar, (0.12, 0.13, 0.15)) for bar in bars]
camera = motes.Camera((4.3, 2.4, 7.4), (1.25, -0.1, 0), fov_deg=34)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.004, 0.005, 0.009), objects=solids, bloom=0.1
)
# Photons do not see each other: they are dealt out by id, and none ever changes its rank.
world = motes.World(seed=args.seed, axis=None, births="calculators", renderer=renderer, log=args.log)

# left: metres to the next collision. state: 1 collides now, or is new; 0 flies; -1 is absorbed.
own = {"left": 0.0, "state": 1.0, "hits": -1.0}
position, velocity, left, state, hits = map(column, ("position", "velocity", *own))
beams = []
for i in range(args.systems):
    name, path, color = kinds[i % 2]
    dot = motes.Sprite(height=0.0093)
    photons = world.system(f"{name} {i}", capacity=args.particles, sprite=dot, attributes=own)
    photons.configure(velocity=(speed, 0, 0), color=color, alpha=0.1)
    beams.append((photons, path))

with world, motes.Movie(f"{args.out}/shielding.mp4") as movie:
    for frame in world.frames(args.frames):
        for photons, path in beams:
            if frame < shining:
                photons.source(hole, rate=args.particles / (shining * world.dt), jitter=True)
            # Half the sum of two squared normal numbers is exponential; three numbers have no direction.
            now = state == 1
            photons.random_velocity(Blob((0, 0, 0), 1), where=now)
            way = path / 2 * (velocity.x * velocity.x + velocity.y * velocity.y)
            photons.set(left=way - motes.minimum(position.x, 0), hits=hits + 1, where=now)  # in the slab
            photons.set(state=-1, where=now & (hits > 0) & (abs(velocity.z) > half))
            photons.random_velocity(Blob((0, 0, 0), 1), where=now)
            photons.set(velocity=velocity * (speed / velocity.length()), where=now)
            photons.set(velocity=(speed, 0, 0), where=now & (hits == 0))
            photons.set(velocity=(0, 0, 0), left=1e30, color=(1, 0.07, 0.03), alpha=0.03, where=state == -1)
            photons.set(state=0, where=now)

            photons.move()
            photons.set(left=left - speed * world.dt)
            photons.set(position=position + velocity * (left / speed), where=left <= 0)  # its path's end
            photons.set(state=1, where=(left <= 0) & (position.x > 0) & (position.x < thick))
            photons.set(left=1e30, where=(left <= 0) & (state == 0))  # outside nothing stops it
            for x, beyond in zip(screens, (position.x < screens[0], position.x > screens[1]), strict=True):
                photons.set(position=position - velocity * ((position.x - x) / velocity.x), where=beyond)
        motes.script.end_frame(world, movie, args)

    for (photons, path), (name, _, _) in zip(beams, kinds * args.systems, strict=False):
        through = photons.total(1, where=position.x > thick)
        straight = photons.total(1, where=(position.x > thick) & (hits == 0))
        dose = photons.tally((0, -1.5, -1.5), (thick, 1.5, 1.5), (40, 60, 60), where=state == -1)
        world.say(
            f"{name}: {photons.born} photons, {through:.0f} through, {straight:.0f} of them straight on, "
            f"{math.exp(-thick / path):.4f} of all by the law; dose {hashlib.sha256(dose).hexdigest()[:16]}"
        )
