"""Physics without absolute numbers: scenes scaled by powers of two, from nanometres to thousands of km.

If lengths, times and masses are multiplied by powers of two, and each parameter by its unit, particles get
exactly the scaled bits. Each action states the units of its parameters in SCENES; a new one fails until then.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import motes
from motes import actions
from motes.errors import ArgumentError
from motes.shapes import Box, Plane, Sphere

COUNT, DT = 200, 0.125
NO_UNITS = {
    "Action": "abstract",
    "Where": "a type",
    "Interact": "a law of the script",
    "Law": "a law of the script",
    "Set": "a value of the script",
}


class Scale:
    """Powers of two for lengths, times and masses."""

    def __init__(self, length: int, time: int, mass: int) -> None:
        """Take the exponents."""
        self.exponents = (length, time, mass)

    def of(self, value: Any, length: int = 0, time: int = 0, mass: int = 0) -> Any:
        """Return a value, scaled like m^length s^time kg^mass."""
        exponent = sum(a * b for a, b in zip(self.exponents, (length, time, mass), strict=True))
        if isinstance(value, tuple):
            return tuple(v * 2.0**exponent for v in value)
        return value * 2.0**exponent

    def box(self, low: float, high: float, length: int = 1, time: int = 0) -> Box:
        """Return a cube of lengths, velocities or the like."""
        return Box(self.of((low,) * 3, length, time), self.of((high,) * 3, length, time))


def grid(s: Scale) -> np.ndarray:
    values = np.random.default_rng(7).uniform(-1, 1, (3, 4, 5, 3))
    return np.asarray(s.of(values, 1, -2))


def ties(s: Scale) -> motes.Ties:
    return motes.Ties(np.arange(COUNT).reshape(-1, 2), s.of(0.5, 1))


def damp(s: Scale) -> tuple[float, float, float]:
    """Return the part kept per second: what is lost scales like 1/s."""
    return tuple(1 - s.of(lost, 0, -1) for lost in (2**-5, 2**-6, 2**-7))  # type: ignore[return-value]


SCENES: dict[str, Callable[[Scale], dict[str, Any]]] = {
    "Align": lambda s: {"to": "velocity", "rate": s.of(2, 0, -1)},
    "AlphaOverLife": lambda s: {"ramp": [(0, 1), (1, 0)]},
    "Avoid": lambda s: {
        "shape": Plane(s.of((0, -0.5, 0), 1), (0, 1, 0)),
        "magnitude": s.of(0.5, 0, 1),
        "epsilon": s.of(0.25, 0, 2),
        "look_ahead": s.of(2, 0, 1),
    },
    "Bounce": lambda s: {
        "shape": Plane(s.of((0.01, -0.2, 0), 1), (0.1, 1, 0.2)),
        "restitution": 0.6,
        "friction": 0.3,
        "min_tangential_speed": s.of(0.1, 1, -1),
        "exact_hit": True,
        "hits": False,
    },
    "Collide": lambda s: {
        "radius": s.of(0.15, 1),
        "restitution": 0.5,
        "friction": 0.3,
        "sleep": s.of(0.05, 1, -1),
        "other": None,
        "other_radius": None,
        "clear": 0,
    },
    "ColorOverLife": lambda s: {"ramp": [(0, (1, 1, 1)), (1, (0, 0, 0))]},
    "Contact": lambda s: {
        "stiffness": s.of(20, 0, -2, 1),
        "restitution": 0.5,
        "friction": 0.4,
        "rolling_friction": 0.1,
        "radius": s.of(0.15, 1),
        "walls": (Plane(s.of((0, -0.5, 0), 1), (0, 1, 0)),),
        "other": None,  # tests/actions/test_contact_scales.py scales two systems
        "other_radius": None,
    },
    "CopyVertexB": lambda s: {"position": True, "velocity": True},
    "CurlNoise": lambda s: {
        "strength": s.of(3, 1, -2),
        "scale": s.of(0.3, 1),
        "octaves": 3,
        "speed": s.of(0.7, 0, -1),
        "field": 2,
    },
    "Damping": lambda s: {
        "damping": damp(s),
        "min_speed": s.of(0.1, 1, -1),
        "max_speed": s.of(2, 1, -1),
    },
    "Explosion": lambda s: {
        "center": s.of((0.1, 0.2, 0.3), 1),
        "radius": s.of(0.5, 1),
        "magnitude": s.of(2, 4, -2),
        "sigma": s.of(0.3, 1),
        "epsilon": s.of(0.25, 2),
    },
    "Field": lambda s: {
        "grid": grid(s),
        "low": s.of((-1, -1, -1), 1),
        "high": s.of((1, 1, 1), 1),
        "strength": 2,
        "drag": None,
    },
    "Fluid": lambda s: {
        "radius": s.of(0.4, 1),
        "rest_density": s.of(20, -3, 0, 1),
        "viscosity": s.of(0.01, 2, -1),
        "cohesion": s.of(0.5, 1, -2),
    },
    "Follow": lambda s: {
        "magnitude": s.of(0.5, 3, -2),
        "epsilon": s.of(0.1, 2),
        "max_radius": s.of(3, 1),
    },
    "FollowPath": lambda s: {
        "points": [s.of(p, 1) for p in ((-1, 0, 0), (0, 0.5, 0), (1, 0, 0.25))],
        "speed": s.of(2, 1, -1),
        "strength": s.of(1.5, 0, -1),
        "look_ahead": s.of(0.25, 1),
        "radius": s.of(2, 1),
        "loop": False,
        "smooth": False,
    },
    "Gravitate": lambda s: {
        "magnitude": s.of(0.01, 3, -2),
        "epsilon": s.of(0.1, 2),
        "max_radius": s.of(0.5, 1),
        "far": "exact",
    },
    "Gravity": lambda s: {"acceleration": s.of((0.3, -9.81, 0.1), 1, -2)},
    "Jet": lambda s: {"shape": s.box(-0.5, 0.5), "acceleration": s.box(-2, 3, 1, -2)},
    "KillExpired": lambda s: {},
    "KillOld": lambda s: {"age_limit": s.of(0.3, 0, 1), "younger": False},
    "MatchRotationalVelocity": lambda s: {
        "magnitude": s.of(0.05, 2, -1),
        "epsilon": s.of(0.1, 2),
        "max_radius": s.of(0.5, 1),
    },
    "MatchVelocity": lambda s: {
        "magnitude": s.of(0.05, 2, -1),
        "epsilon": s.of(0.1, 2),
        "max_radius": s.of(0.5, 1),
    },
    "Move": lambda s: {"rotational": True},
    "OrbitLine": lambda s: {
        "point": s.of((0, 0.1, 0), 1),
        "axis": (0.2, 1, 0.3),
        "magnitude": s.of(2, 3, -2),
        "epsilon": s.of(0.1, 2),
        "max_radius": s.of(0.8, 1),
    },
    "OrbitPoint": lambda s: {
        "center": s.of((0, 0.1, 0), 1),
        "magnitude": s.of(2, 3, -2),
        "epsilon": s.of(0.1, 2),
        "max_radius": s.of(0.8, 1),
    },
    "RandomAcceleration": lambda s: {"shape": s.box(-1, 2, 1, -2)},
    "RandomDisplacement": lambda s: {"shape": s.box(-1, 2, 1, -1)},
    "RandomRotationalVelocity": lambda s: {"shape": s.box(-1, 2, 0, -1)},
    "RandomVelocity": lambda s: {"shape": s.box(-1, 2, 1, -1)},
    "Restore": lambda s: {"time_left": s.of(1.5, 0, 1), "position": True, "up": False},
    "Rest": lambda s: {"speed": s.of(0.5, 1, -1), "angle_deg": 20},
    "RotationalDamping": lambda s: {
        "damping": damp(s),
        "min_speed": s.of(0.1, 0, -1),
        "max_speed": s.of(2, 0, -1),
    },
    "Sink": lambda s: {"shape": Sphere(s.of((0, 0, 0), 1), s.of(0.5, 1)), "inside": True},
    "SinkVelocity": lambda s: {"shape": s.box(0.1, 0.9, 1, -1), "inside": True},
    "SizeOverLife": lambda s: {"ramp": [(0, s.of(0.1, 1)), (1, s.of(0.3, 1))]},
    "Sort": lambda s: {"eye": s.of((0, 0, 3), 1), "look": (0, 0, -1)},
    "SpeedClamp": lambda s: {"min_speed": s.of(0.5, 1, -1), "max_speed": s.of(1, 1, -1)},
    "TargetColor": lambda s: {"color": (1, 0, 0), "alpha": 0.5, "scale": s.of(0.7, 0, -1)},
    "TargetRotationalVelocity": lambda s: {
        "rotational_velocity": s.of((1, 2, 3), 0, -1),
        "scale": s.of(0.7, 0, -1),
    },
    "TargetSize": lambda s: {"size": s.of((0.1, 0.2, 0.3), 1), "scale": s.of((0.7, 0.5, 0.3), 0, -1)},
    "TargetVelocity": lambda s: {"velocity": s.of((1, 2, 3), 1, -1), "scale": s.of(0.7, 0, -1)},
    "Tie": lambda s: {
        "ties": ties(s),
        "stretch": s.of(1e-3, 0, 2, -1),
        "shear": 0,
        "bend": 0,
        "damping": s.of(0.5, 0, -1),
        "break_at": 3,
        "tethers": False,
    },
    "Vortex": lambda s: {
        "tip": s.of((0, -1, 0), 1),
        "axis": s.of((0, 2, 0), 1),
        "tightness": 1.5,
        "max_radius": s.of(0.8, 1),
        "in_speed": s.of(2, 1, -2, 1),
        "up_speed": s.of(1, 1, -2, 1),
        "around_speed": s.of(3, 1, -2, 1),
    },
    "Wind": lambda s: {"velocity": s.of((1, 2, 3), 1, -1), "drag": s.of(0.7, 0, -1)},
}
UNITS = {  # of the attributes, as powers of m, s and kg
    "position": (1, 0, 0),
    "velocity": (1, -1, 0),
    "rotational_velocity": (0, -1, 0),
    "size": (1, 0, 0),
    "age": (0, 1, 0),
    "color": (0, 0, 0),
    "alpha": (0, 0, 0),
}
SCALES = {
    "lengths": (5, 0, 0),
    "times": (0, -3, 0),
    "masses": (0, 0, 4),
    "all": (-4, 2, -7),
    "nanometres": (-30, -4, -80),
    "thousands of kilometres": (20, 4, 60),
}
EXTREME = ("nanometres", "thousands of kilometres")  # where a number may be refused at the call


def run(name: str, scale: Scale) -> motes.Particles:
    """Return the particles after three frames of an action."""
    dice = np.random.default_rng(11)
    position, velocity = dice.uniform(-1, 1, (2, COUNT, 3)).astype(np.float32)
    spin, copies = dice.uniform(-2, 2, (2, COUNT, 3)).astype(np.float32)
    world = motes.World(seed=5, dt=scale.of(DT, 0, 1), substeps=2, progress="off")
    s = world.system("s")
    listed = [getattr(actions, name)(**SCENES[name](scale))]
    if name == "Rest":
        listed.insert(0, actions.Bounce(**SCENES["Bounce"](scale) | {"hits": True}))
    with world:
        for frame in world.frames(3):
            if frame == 0:
                s.emit(
                    position=scale.of(position, 1),
                    velocity=scale.of(velocity, 1, -1),
                    rotational_velocity=scale.of(spin, 0, -1),
                    size=scale.of(np.full((COUNT, 3), np.float32(0.2)), 1),
                    mass=scale.of(dice.uniform(0.5, 2, COUNT).astype(np.float32), 0, 0, 1),
                    lifetime=scale.of(np.full(COUNT, np.float32(0.5)), 0, 1),
                    position_b=scale.of(copies, 1),
                )
            s.apply(listed)
            if name != "Move":
                s.move()
            world.step()
        return s.gather()


@pytest.mark.parametrize("size", SCALES)
@pytest.mark.parametrize("name", SCENES)
def test_scaled_scenes_have_scaled_bits(name: str, size: str):
    scale = Scale(*SCALES[size])
    if size in EXTREME:
        try:
            getattr(actions, name)(**SCENES[name](scale))
        except ArgumentError:
            return
    wanted, found = run(name, Scale(0, 0, 0)), run(name, scale)
    assert len(found.position) == len(wanted.position)
    for attribute, units in UNITS.items():
        if hasattr(wanted, attribute):
            np.testing.assert_array_equal(
                scale.of(getattr(wanted, attribute), *units), getattr(found, attribute), err_msg=attribute
            )


def test_every_action_states_its_units():
    assert set(SCENES) | set(NO_UNITS) == set(actions.__all__)
    for name, scene in SCENES.items():
        parameters = set(inspect.signature(getattr(actions, name)).parameters) - {"where"}
        assert set(scene(Scale(0, 0, 0))) == parameters, name
