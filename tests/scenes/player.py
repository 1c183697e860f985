"""Plays scripts from a JSON file (see test_same_bits.random_scripts); prints one line of digests each."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

import motes
from motes import shapes

FRAMES = 8


def value_of(value: Any) -> Any:
    """Turn ["Uniform", lo, hi] or ["Normal", mean, sigma] into a distribution; leave others unchanged."""
    if isinstance(value, list) and value and isinstance(value[0], str):
        return getattr(motes, value[0])(*value[1:])
    return value


def write(system: motes.System) -> None:
    """Change particles from the script; each depends only on itself."""
    with system.local() as p:
        p.position[:] += np.float32(0.125) * (p.id % 3).astype(np.float32)[:, None]
        p.velocity[p.id % 4 == 0] *= np.float32(0.5)


def call(world: motes.World, system: motes.System, words: list[Any]) -> None:
    """Make one call of a script."""
    name, arguments = words[0], {key: value_of(value) for key, value in words[1].items()}
    shape = [getattr(shapes, form[0])(*form[1:]) for form in words[2:]]
    if name == "local":
        write(system)
    elif name == "digest":
        world.digest()
    elif name == "gravity":
        system.gravity(arguments["acceleration"])
    elif name == "damping":
        system.damping(arguments["damping"], min_speed=arguments["min_speed"])
    elif name == "kill_old":
        system.kill_old(arguments["age_limit"])
    else:
        getattr(system, name)(*shape, **arguments)


def play(script: dict[str, Any]) -> str:
    """Run one script; return its digests as one line."""
    world = motes.World(
        seed=script["seed"], substeps=script["substeps"], roles=script["roles"], progress="off"
    )
    systems = [
        world.system(
            f"system {i}",
            capacity=wish["capacity"],
            axis=wish["axis"],
            space=tuple(wish["space"]) if isinstance(wish["space"], list) else wish["space"],
        )
        for i, wish in enumerate(script["systems"])
    ]
    digests = []
    with world:
        for frame in world.frames(FRAMES):
            for system, calls in zip(systems, script["calls"][frame % 2], strict=True):
                for words in calls:
                    call(world, system, words)
            world.step()
            digests.append(world.digest())
    return " ".join(digests)


with open(Path(sys.argv[1])) as file:
    all_scripts = json.load(file)
for one in all_scripts:
    line = play(one)
    if motes.World(progress="off").rank == 0:
        print(line, flush=True)
