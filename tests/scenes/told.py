"""Two worlds that a script changes on the way: `told.py OUT PLAN`, a plan as JSON.

"changes": [owner, attribute, expression], each made in one frame. "often": those of the renderer and the
camera are made again in each later frame, as a script must that continues from checkpoints. "recover":
survive losses. "checkpoint": one after this many frames. KILL in the environment: world, frame and place of
the last rank's death.
Prints the digests of each frame: particles, picture, and the last frame's picture drawn once more.
"""

import json
import os
import signal
import sys

import motes
from motes.shapes import Box, Sphere

FRAMES = 17

out, plan = sys.argv[1], json.loads(sys.argv[2])


def play(number: int) -> None:
    """Play one world to its end."""

    def die(frame: int, place: str) -> None:
        if os.environ.get("KILL") == f"{number} {frame} {place}" and world.rank == world.size - 1:
            os.kill(os.getpid(), signal.SIGKILL)

    checkpoint = motes.Checkpoint(f"{out}/{number}", every=plan["checkpoint"] or 1)
    camera = motes.Camera((0, 0, 4), (0, 0, 0))
    renderer = motes.Renderer(64, 48, camera=camera, shutter=0.5)
    world = motes.World(
        seed=1 + number,
        space=(-1, 1),
        on_loss="recover" if plan["recover"] else "stop",
        progress="off",
        renderer=renderer,
        checkpoint=checkpoint if plan["checkpoint"] else None,
    )
    grains = world.system("grains", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
    dust = world.system("dust", attributes={"heat": 0.0})
    owners = {"World": world, "Renderer": renderer, "Camera": camera, "grains": grains, "dust": dust}

    def change(frames: range, among: tuple[str, ...]) -> None:
        """Make the changes of these frames to some owners."""
        for i, (owner, name, expression) in enumerate(plan["changes"]):
            if owner in among and (i % (FRAMES - 2) if owner != "grains" else 0) in frames:
                value = eval(expression, {"motes": motes, "camera": camera, "world": world})
                if name.endswith("()"):
                    value(owners[owner])
                else:
                    setattr(owners[owner], name, value)

    with world:
        die(-1, "start")
        for frame in world.frames(FRAMES):
            die(frame, "start")
            if plan["often"]:
                change(range(frame), ("Renderer", "Camera"))
            camera.position = (0.1 * frame - 0.1, 0, 4)
            once_more = world.redraw() if frame > 0 else None
            die(frame, "redrawn")
            camera.position = (0.1 * frame, 0, 4)
            change(range(frame, frame + 1), tuple(owners))
            die(frame, "told")
            if frame == 0:
                grains.burst(Box((-1, -0.6, 0), (1, 0.6, 0)), 8)
            grains.contact(100)
            grains.move()
            dust.configure(velocity=Sphere((0, 0, 0), 1))
            dust.source(Box((-1, -1, -1), (1, 1, 1)), rate=480)
            dust.kill_old(0.3)
            dust.move()
            die(frame, "recorded")
            picture = world.render()
            die(frame, "rendered")
            digest = world.digest()
            if picture:
                drawn = once_more.digest()[:12] if once_more else ""
                print(number, frame, digest[:12], picture.digest()[:12], drawn, flush=True)


for number in range(2):
    play(number)
