"""Photons in a slab of shielding, a Monte Carlo: python -m motes run -n 4 examples/shielding.py.

A photon flies straight to its next collision, where it is absorbed or scattered in any direction. The counts
at the end are exact, with the same bits on any number of ranks.
"""

import hashlib
import math

import motes
from motes.expressions import column, minimum
from motes.shapes import Blob, Box, Cylinder, Disc, Plane

args = motes.script.options(__doc__, systems=2, particles=60_000, frames=144, size="960x540")

# A slab from x = 0 on, infinite in y and z, between two screens; a lamp in front of it. Metres, m/s.
thick, screens, speed = 2.0, (-1.5, 4.0), 2.0
hole, shining = Disc((-0.6, 0, 0), (1, 0, 0), 0.12), max(1, args.frames // 2)  # frames
kinds = [("soft", 0.5, (0.35, 0.6, 1)), ("hard", 1.2, (1, 0.72, 0.3))]  # mean free paths, colours
half = 0.6745  # median of the absolute value of a normal number

bars = [Cylinder((-1.1, 0, 0), hole.center, 0.16), Box((-1.2, -1.5, -0.2), (-0.9, -0.1, 0.2))]
for x in (0, thick):
    corners = [(x, -1.3, -1.3), (x, 1.3, -1.3), (x, 1.3, 1.3), (x, -1.3, 1.3)]
    bars += [Cylinder(a, b, 0.018) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
bars += [Cylinder((0, y, z), (thick, y, z), 0.018) for y in (-1.3, 1.3) for z in (-1.3, 1.3)]
solids = [motes.Solid(bar, (0.4, 0.45, 0.55)) for bar in bars]
solids += [motes.Solid(Plane((0, -1.5, 0), (0, 1, 0)), (0.16, 0.17, 0.2))]
solids += [motes.Solid(Box((screens[1], -1.5, -1.5), (screens[1] + 0.06, 1.5, 1.5)), (0.25, 0.26, 0.3))]
glows = [((0.7, 0, 0), (1, 0.06, 0.02)), ((3.8, 0, 0), (1, 0.8, 0.45)), ((-1, 1, 1), (0.3, 0.5, 1))]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((3.1, 1.7, 6.4), (1.3, -0.1, 0), fov_deg=34),
    background=motes.Gradient((0.01, 0.014, 0.03), (0.003, 0.004, 0.012)),
    objects=solids,
    sun=(0, 0, 0),
    shutter=2.5,
    bloom=0.12,
)
# Photons do not see each other: they are assigned by id, and never change their rank.
world = motes.World(seed=args.seed, axis=None, births="calculators", renderer=renderer, log=args.log)

# left: metres to the next collision. state: 1 collides now, or is new; 0 flies; -1 is absorbed.
own = {"left": 0.0, "state": 1.0, "hits": -1.0}
position, velocity, left, state, hits = map(column, ("position", "velocity", *own))
beams = []
for i in range(args.systems):
    name, path, color = kinds[i % 2]
    dot = motes.Sprite(height=0.006)
    photons = world.system(f"{name} {i}", capacity=args.particles, sprite=dot, attributes=own)
    photons.configure(velocity=(speed, 0, 0), color=color, alpha=0.1)
    beams.append((photons, path))

with world, motes.Movie(f"{args.out}/shielding.mp4") as movie:
    for frame in world.frames(args.frames):
        bright = min(1, 1.6 * frame / shining, 1.5 - 0.5 * frame / shining)
        renderer.lights = [motes.Light(at, color, power=bright) for at, color in glows]
        for photons, path in beams:
            if frame < shining:
                photons.source(hole, rate=args.particles / (shining * world.dt), jitter=True)
            # Half the sum of two squared normal numbers is exponential; three have a random direction.
            now = state == 1
            photons.random_velocity(Blob((0, 0, 0), 1), where=now)
            way = path / 2 * (velocity.x * velocity.x + velocity.y * velocity.y)
            photons.set(left=way - minimum(position.x, 0), hits=hits + 1, where=now)  # in the slab
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
            photons.set(left=1e30, where=(left <= 0) & (state == 0))  # outside the slab nothing stops it
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
