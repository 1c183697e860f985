"""A picture that shows no particle: said where all are behind the camera, or stay outside of what it sees."""

from __future__ import annotations

import warnings

import numpy as np
from launching import mpirun

import motes
from motes import in_picture


def said(
    position: tuple[float, float, float], frames: int, velocity: tuple[float, float, float] = (0, 0, 0)
) -> list[str]:
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    world = motes.World(seed=1, progress="off", renderer=motes.Renderer(32, 18, camera=camera))
    system = world.system("s")
    other = world.system("other")
    with warnings.catch_warnings(record=True) as caught, world:
        warnings.simplefilter("always")
        for frame in world.frames(frames):
            if frame == 0:
                system.emit(position=[position], velocity=[velocity])
            other.move()
            system.move()
            world.render()
    return [str(one.message) for one in caught]


def test_particles_behind_the_camera_are_said_at_once():
    (told,) = said((0, 0, 9), 3)
    assert told == "all particles are behind the camera, at (0.0, 0.0, 5.0), looking to (0.0, 0.0, 0.0)"


def test_particles_outside_of_the_picture_are_said_when_they_stay_there():
    for frames in (1, 3, 40):
        (told,) = said((0, 30, 0), frames)
        assert told.startswith("all particles are outside of what the camera sees, at (0.0, 0.0, 5.0)")
    assert said((0, 6, 0), 40, velocity=(0, -6, 0)) == [], "they come into it"
    assert said((0, 0, 0), 3) == said((0, 1.9, 0), 40) == []


def test_the_conditions_are_those_of_the_camera():
    camera = motes.Camera((1, 2, 3), (4, 1, -2), up=(0.2, 1, 0.1), fov_deg=50, near=0.5)
    renderer = motes.Renderer(64, 36, camera=camera, background=(0, 0, 0))
    world = motes.World(seed=1, progress="off", renderer=renderer)
    system = world.system("s", sprite=motes.Sprite("point"))
    ahead, inside = in_picture.in_view(renderer, 0)
    with world:
        for position in np.random.default_rng(4).uniform(-6, 6, (60, 3)).tolist():
            system.emit(position=[position])
            system.sink(motes.shapes.Sphere(position, 0.01), inside=False)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                lit = bool(world.render().pixels.any())
            assert not lit or (system.total(1, where=ahead) == 1 and system.total(1, where=inside) == 1)


def test_it_is_said_once_on_several_ranks():
    script = (
        "import motes\n"
        "camera = motes.Camera((0, 0, 5), (0, 0, 0))\n"
        "world = motes.World(seed=1, progress='off', renderer=motes.Renderer(32, 18, camera=camera))\n"
        "s = world.system('s')\n"
        "with world:\n"
        "    for frame in world.frames(2):\n"
        "        s.emit(position=[(0, 0, 9)]); s.move(); world.render()\n"
    )
    ended = mpirun(3, script, timeout=60)
    assert ended.code == 0 and ended.err.count("all particles are behind the camera") == 1, ended.text
