"""ActionMethods: one method per action, with the parameters and the documentation of the action's class."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from inspect import Parameter, Signature
from typing import Any, Concatenate, ParamSpec

from .. import actions
from .._values.values import text_of
from ..actions.base import Action, Where, as_action

__all__ = ["ActionMethods", "recorded"]

P = ParamSpec("P")
SECTION = "Attributes:\n"
"""The heading of an action's fields in its docstring."""
INDENT = text_of(Action).partition(SECTION)[0].rpartition("\n")[2]
"""The indentation of docstrings, which some releases of Python remove."""
SELF = Parameter("self", Parameter.POSITIONAL_OR_KEYWORD)


def recorded(kind: Callable[P, Action]) -> Callable[Concatenate[ActionMethods, P], None]:
    """Return the method that records an action of a class. It takes the class's fields, as the class does."""

    def method(self: ActionMethods, /, *args: P.args, **keywords: P.kwargs) -> None:
        try:
            action = kind(*args, **keywords)
        except TypeError as error:
            call, _, text = str(error).partition("()")
            if call == f"{kind.__name__}.__init__":  # the arguments are those of this method
                error.args = (f"{method.__qualname__}(){text}",)
            raise
        self._record(action)

    _describe(method, kind)
    return method


def _describe(method: Any, kind: Any) -> None:
    """Give a method the name, signature and documentation that follow from an action's class."""
    method.__name__ = re.sub("(?<!^)(?=[A-Z])", "_", kind.__name__).lower()
    method.__qualname__ = f"System.{method.__name__}"
    fields = dict(kind.__signature__.parameters)
    where = fields.pop("where")
    method.__signature__ = Signature([SELF, *fields.values(), where], return_annotation="None")
    summary = text_of(kind).partition("\n")[0]
    described = [text_of(each).partition(SECTION)[2].partition("\n\n")[0].rstrip() for each in (kind, Action)]
    arguments = "\n".join(filter(None, described))
    method.__doc__ = (
        f"{summary}\n\n{INDENT}Records `actions.{kind.__name__}`.\n\n{INDENT}Args:\n{arguments}\n{INDENT}"
    )


class ActionMethods:
    """Base of `System`, independent of systems: a subclass supplies the function that records an action.

    The sentence below each method is what editors show; it is the first one of the action's docstring.
    """

    def __init__(self, record: Callable[[Action], None]) -> None:
        """Store the function that records actions; the script's line is two calls above it."""
        self._record = record

    def apply(self, action: Action | Sequence[Action]) -> None:
        """Record an action, or each action of a list.

        Args:
            action: an action of `motes.actions`, or a list of them.
        """
        for one in action if isinstance(action, (list, tuple)) else (action,):
            self._record(as_action(one))

    def set(self, *, where: Where = None, **attributes: Any) -> None:
        """Set attributes to values, or to expressions of columns, in turn. Records `actions.Set` for each.

        Args:
            where: which particles: those inside a shape, or those that satisfy a comparison of columns; None:
                all.
            **attributes: a number, a vector or an expression for each: `s.set(heat=column("age") * 2)`.
        """
        for name, value in attributes.items():
            self._record(actions.Set(attribute=name, value=value, where=where))

    gravity = recorded(actions.Gravity)
    """Accelerates all particles by the same amount, or each by the value of an expression."""
    random_acceleration = recorded(actions.RandomAcceleration)
    """Gives each particle its own random acceleration, redrawn in each step."""
    jet = recorded(actions.Jet)
    """Accelerates the particles inside a shape, as a fan does."""
    explosion = recorded(actions.Explosion)
    """Pushes particles away from a centre, most strongly at the shock wave: let `radius` grow with time."""
    orbit_point = recorded(actions.OrbitPoint)
    """Pulls particles toward a point, more strongly the nearer they are, which lets them orbit it."""
    orbit_line = recorded(actions.OrbitLine)
    """Pulls particles toward an infinite line, more strongly the nearer they are."""
    vortex = recorded(actions.Vortex)
    """Whirls particles around an axis like a tornado: pulls them in, then carries them around and up."""
    wind = recorded(actions.Wind)
    """Drags particles along with moving air; the result does not depend on the step's length."""
    curl_noise = recorded(actions.CurlNoise)
    """Stirs particles like turbulent air: accelerates them along a random, divergence-free field."""
    avoid = recorded(actions.Avoid)
    """Turns particles that would hit a shape within `look_ahead`, without changing their speed."""
    field = recorded(actions.Field)
    """Accelerates particles by the vectors of a grid, or drags them along as moving air."""
    follow_path = recorded(actions.FollowPath)
    """Steers particles along a path, toward a point ahead of the nearest point of the path."""
    damping = recorded(actions.Damping)
    """Slows particles down, axis by axis, while their speed is in a range."""
    rotational_damping = recorded(actions.RotationalDamping)
    """Slows rotations down, axis by axis, while their rotational speed is in a range."""
    speed_clamp = recorded(actions.SpeedClamp)
    """Limits speeds to a range; directions do not change, and particles at rest stay at rest."""
    random_velocity = recorded(actions.RandomVelocity)
    """Gives each particle a new random velocity in each step."""
    random_displacement = recorded(actions.RandomDisplacement)
    """Shifts each particle by its own random displacement, redrawn in each step; velocities stay."""
    random_rotational_velocity = recorded(actions.RandomRotationalVelocity)
    """Gives each particle a new random rotational velocity in each step."""
    target_color = recorded(actions.TargetColor)
    """Moves color and alpha toward given values, by the same fraction of the difference in each step."""
    target_size = recorded(actions.TargetSize)
    """Moves the size toward a given one, each component by its own fraction of the difference per step."""
    target_velocity = recorded(actions.TargetVelocity)
    """Moves the velocity toward a given velocity, by the same fraction of the difference in each step."""
    target_rotational_velocity = recorded(actions.TargetRotationalVelocity)
    """Moves the rotational velocity toward a given one, by the same fraction of the difference per step."""
    restore = recorded(actions.Restore)
    """Returns particles to position_b and up_b, where they come to rest after `time_left`."""
    copy_vertex_b = recorded(actions.CopyVertexB)
    """Stores the current position, orientation or velocity as the target to which `restore` returns."""
    color_over_life = recorded(actions.ColorOverLife)
    """Sets each particle's color from the fraction of its lifetime that has passed."""
    alpha_over_life = recorded(actions.AlphaOverLife)
    """Sets each particle's alpha from the fraction of its lifetime that has passed."""
    size_over_life = recorded(actions.SizeOverLife)
    """Sets each particle's size from the fraction of its lifetime that has passed."""
    bounce = recorded(actions.Bounce)
    """Makes particles that hit the surface of a shape in this step rebound; record it before `move`."""
    rest = recorded(actions.Rest)
    """Lays down what has come to rest on a surface, and holds it there: leaves, snow, confetti."""
    sink = recorded(actions.Sink)
    """Kills particles inside a shape, or outside it with inside=False."""
    sink_velocity = recorded(actions.SinkVelocity)
    """Kills particles whose velocity is inside a shape, or outside it: slow or fast ones."""
    kill_old = recorded(actions.KillOld)
    """Kills particles that have reached an age; with younger=True, kills those that have not."""
    kill_expired = recorded(actions.KillExpired)
    """Kills particles whose age has reached their lifetime."""
    align = recorded(actions.Align)
    """Turns each particle by the shortest rotation until its own z axis points along a direction."""
    move = recorded(actions.Move)
    """Moves particles by their velocity, turns them by their rotational velocity and spin, and ages them."""
    sort = recorded(actions.Sort)
    """Sorts particles for drawing: far ones first, so nearer ones cover them."""
    gravitate = recorded(actions.Gravitate)
    """Pulls particles toward each other, more strongly the nearer they are."""
    follow = recorded(actions.Follow)
    """Pulls each particle toward the next living particle born after it; the last particle is free."""
    match_velocity = recorded(actions.MatchVelocity)
    """Pulls each particle's velocity toward the velocities of others within reach, as in a flock."""
    match_rotational_velocity = recorded(actions.MatchRotationalVelocity)
    """Pulls each particle's rotational velocity toward those of others within reach."""
    collide = recorded(actions.Collide)
    """Keeps spheres apart, with friction: they push each other until none would overlap after this step."""
    contact = recorded(actions.Contact)
    """Lets spheres press, rub and roll on each other like grains (discrete elements)."""
    fluid = recorded(actions.Fluid)
    """Keeps a liquid's density: particles push each other apart until they are no denser than at rest."""
    tie = recorded(actions.Tie)
    """Holds particles at the distances given by their ties, as in cloth and ropes."""
    law = recorded(actions.Law)
    """Applies a custom law, written as expressions of columns, to each particle."""
    interact = recorded(actions.Interact)
    """Applies a custom law, written as expressions, to pairs of particles."""
