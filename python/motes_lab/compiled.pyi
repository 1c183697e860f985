"""
Benchmarks of the engine, and simulated disasters, for the package motes_lab.
"""

from __future__ import annotations

import typing

__all__: list[str] = [
    "act_bench",
    "action_bench",
    "birth_bench",
    "damaged_file",
    "disaster",
    "leaver_bench",
    "list_bench",
    "mesh_bench",
    "picture_bench",
    "render_bench",
    "scenery_bench",
]

def act_bench(scene: str, particles: int, steps: int) -> dict[str, typing.Any]: ...
def action_bench(particles: int, repeats: int) -> dict[str, typing.Any]: ...
def birth_bench(calculators: int, births: int, repeats: int) -> dict[str, typing.Any]: ...
def damaged_file(seed: int, directory: str) -> dict[str, typing.Any]:
    """
    Damage a file and try to read it; `broken`: what went wrong, or an empty text.
    """

def disaster(seed: int) -> dict[str, typing.Any]:
    """
    Run one disaster on simulated ranks; `broken`: the promise that was broken, or an empty text.
    """

def leaver_bench(particles: int, bins: int, steps: int) -> dict[str, typing.Any]: ...
def list_bench(particles: int, steps: int) -> dict[str, typing.Any]: ...
def mesh_bench(particles: int, repeats: int) -> dict[str, typing.Any]: ...
def picture_bench(particles: int, width: int, height: int, repeats: int) -> dict[str, typing.Any]: ...
def render_bench(
    particles: int, width: int, height: int, pixels: int, frames: int, fountain: bool
) -> dict[str, typing.Any]: ...
def scenery_bench(width: int, height: int, frames: int) -> dict[str, typing.Any]: ...
