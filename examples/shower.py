"""A curtain of light falls and parts before a ball: python -m motes run -n 4 examples/shower.py."""

import motes
from motes.expressions import column, mix, noise, sin, smoothstep, time
from motes.shapes import Plane, Rectangle, Sphere

args = motes.script.options(__doc__, space="-5,5", systems=4, particles=50_000, frames=144, size="960x540")

ground = Plane((0, 0, 0), (0, 1, 0))
way = motes.Curve(
    [(0, (-1.6, 2.6, 0)), (2.5, (1.6, 3.3, 0)), (5, (-1.6, 2.6, 0)), (7.5, (1.6, 3.3, 0))], "smooth"
)
camera = motes.Camera((0, 2.5, 10.5), (0, 2.85, 0), fov_deg=33)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.004, 0.005, 0.012), sun=(0, 0, 0), shutter=0.5, bloom=0.3
)
world = motes.World(**args.world, substeps=3, renderer=renderer)

sheets = []
for i in range(args.systems):
    drops = world.system(f"drops {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None))
    drops.configure(velocity=(0, -2, 0), size=motes.Uniform((0.01,) * 3, (0.022,) * 3), lifetime=1.9)
    wide = 9.0 / args.systems
    sheets.append((drops, Rectangle((i * wide - 4.5, 6.2, -0.05), (wide, 0, 0), (0, 0, 0.1))))

place, speed = column("position"), column("velocity")
with world, motes.Movie(f"{args.out}/shower.mp4") as movie:
    for _ in world.frames(args.frames):
        ball = Sphere(way(world.time), 0.85)
        renderer.objects = [
            motes.Solid(ground, (0.05, 0.06, 0.09)),
            motes.Solid(Sphere(ball.center, 0.72), (0.25, 0.26, 0.3)),
        ]
        renderer.lights = [
            motes.Light((2.5, 6, 3.5), (0.5, 0.7, 1), 14),
            motes.Light((-4, 3, 3), (1, 0.3, 0.5), 9),
        ]
        # Waves of colour run through the curtain: teal and violet, gold where it is pushed aside.
        wave = 0.5 + 0.5 * sin(1.1 * place.x + 0.7 * place.y + 1.6 * time())
        veil = mix((0.01, 0.28, 0.6), (0.45, 0.03, 0.55), wave)
        pushed = smoothstep(0.25, 1.8, abs(speed.x))
        dense = smoothstep(-0.35, 0.4, noise(place * (2.2, 0.25, 0), 0.4 * time()))
        for drops, edge in sheets:
            drops.source(edge, rate=args.particles / 1.9, jitter=True)
            drops.gravity((0, -2.2, 0))
            drops.avoid(ball, magnitude=0.22, epsilon=0.08, look_ahead=0.8)
            drops.bounce(ball, restitution=0.2)
            drops.bounce(ground, restitution=0.25, friction=0.2)
            drops.random_acceleration(Sphere((0, 0, 0), 1.2))
            drops.set(color=mix(veil * (0.25 + 1.4 * dense), (2.2, 0.7, 0.08), pushed))
            drops.set(alpha=min(1, 60_000 / args.particles))
            drops.kill_expired()
            drops.move()
        motes.script.end_frame(world, movie, args)
