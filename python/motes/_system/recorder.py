"""Recorder: a method for each action, which records it. `System` is one.

Written by `.ci/recorder` from the fields of the actions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from numpy.typing import ArrayLike

from .. import actions
from .._values.curves import Number, Vector
from .._values.values import says_near_names
from ..actions.base import Where
from ..shapes import Shape
from .recorder_between import BetweenRecorder

__all__ = ["Recorder"]


class Recorder(BetweenRecorder):
    """What a script can tell all particles of a system to do; `motes.actions` says what each means."""

    @says_near_names
    def gravity(self, acceleration: Vector, *, where: Where = None) -> None:
        """Record `actions.Gravity`."""
        self._record(actions.Gravity(acceleration=acceleration, where=where))

    @says_near_names
    def random_acceleration(self, shape: Shape | ArrayLike, *, where: Where = None) -> None:
        """Record `actions.RandomAcceleration`."""
        self._record(actions.RandomAcceleration(shape=shape, where=where))

    @says_near_names
    def jet(self, shape: Shape, acceleration: Shape | ArrayLike, *, where: Where = None) -> None:
        """Record `actions.Jet`."""
        self._record(actions.Jet(shape=shape, acceleration=acceleration, where=where))

    @says_near_names
    def explosion(
        self,
        center: Vector,
        radius: Number,
        magnitude: Number,
        sigma: Number,
        epsilon: Number,
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.Explosion`."""
        self._record(
            actions.Explosion(
                center=center, radius=radius, magnitude=magnitude, sigma=sigma, epsilon=epsilon, where=where
            )
        )

    @says_near_names
    def orbit_point(
        self,
        center: Vector,
        magnitude: Number,
        epsilon: Number,
        max_radius: Number = math.inf,
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.OrbitPoint`."""
        self._record(
            actions.OrbitPoint(
                center=center, magnitude=magnitude, epsilon=epsilon, max_radius=max_radius, where=where
            )
        )

    @says_near_names
    def orbit_line(
        self,
        point: Vector,
        axis: Vector,
        magnitude: Number,
        epsilon: Number,
        max_radius: Number = math.inf,
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.OrbitLine`."""
        self._record(
            actions.OrbitLine(
                point=point,
                axis=axis,
                magnitude=magnitude,
                epsilon=epsilon,
                max_radius=max_radius,
                where=where,
            )
        )

    @says_near_names
    def vortex(
        self,
        tip: Vector,
        axis: Vector,
        tightness: Number,
        max_radius: Number,
        in_speed: Number,
        up_speed: Number,
        around_speed: Number,
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.Vortex`."""
        self._record(
            actions.Vortex(
                tip=tip,
                axis=axis,
                tightness=tightness,
                max_radius=max_radius,
                in_speed=in_speed,
                up_speed=up_speed,
                around_speed=around_speed,
                where=where,
            )
        )

    @says_near_names
    def wind(self, velocity: Vector, drag: Number, *, where: Where = None) -> None:
        """Record `actions.Wind`."""
        self._record(actions.Wind(velocity=velocity, drag=drag, where=where))

    @says_near_names
    def curl_noise(
        self,
        strength: Number,
        scale: Number,
        octaves: int = 1,
        speed: Number = 0,
        field: int = 0,
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.CurlNoise`."""
        self._record(
            actions.CurlNoise(
                strength=strength, scale=scale, octaves=octaves, speed=speed, field=field, where=where
            )
        )

    @says_near_names
    def avoid(
        self, shape: Shape, magnitude: Number, epsilon: Number, look_ahead: Number, *, where: Where = None
    ) -> None:
        """Record `actions.Avoid`."""
        self._record(
            actions.Avoid(
                shape=shape, magnitude=magnitude, epsilon=epsilon, look_ahead=look_ahead, where=where
            )
        )

    @says_near_names
    def field(
        self,
        grid: ArrayLike,
        low: Vector,
        high: Vector,
        strength: Number = 1,
        drag: Number | None = None,
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.Field`."""
        self._record(actions.Field(grid=grid, low=low, high=high, strength=strength, drag=drag, where=where))

    @says_near_names
    def follow_path(
        self,
        points: ArrayLike,
        speed: Number,
        strength: Number = 2,
        look_ahead: Number = 0.5,
        radius: Number = math.inf,
        loop: bool = False,
        smooth: bool = False,
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.FollowPath`."""
        self._record(
            actions.FollowPath(
                points=points,
                speed=speed,
                strength=strength,
                look_ahead=look_ahead,
                radius=radius,
                loop=loop,
                smooth=smooth,
                where=where,
            )
        )

    @says_near_names
    def damping(
        self, damping: Vector, min_speed: Number = 0, max_speed: Number = math.inf, *, where: Where = None
    ) -> None:
        """Record `actions.Damping`."""
        self._record(actions.Damping(damping=damping, min_speed=min_speed, max_speed=max_speed, where=where))

    @says_near_names
    def rotational_damping(
        self, damping: Vector, min_speed: Number = 0, max_speed: Number = math.inf, *, where: Where = None
    ) -> None:
        """Record `actions.RotationalDamping`."""
        self._record(
            actions.RotationalDamping(damping=damping, min_speed=min_speed, max_speed=max_speed, where=where)
        )

    @says_near_names
    def speed_clamp(
        self, min_speed: Number = 0, max_speed: Number = math.inf, *, where: Where = None
    ) -> None:
        """Record `actions.SpeedClamp`."""
        self._record(actions.SpeedClamp(min_speed=min_speed, max_speed=max_speed, where=where))

    @says_near_names
    def random_velocity(self, shape: Shape | ArrayLike, *, where: Where = None) -> None:
        """Record `actions.RandomVelocity`."""
        self._record(actions.RandomVelocity(shape=shape, where=where))

    @says_near_names
    def random_displacement(self, shape: Shape | ArrayLike, *, where: Where = None) -> None:
        """Record `actions.RandomDisplacement`."""
        self._record(actions.RandomDisplacement(shape=shape, where=where))

    @says_near_names
    def random_rotational_velocity(self, shape: Shape | ArrayLike, *, where: Where = None) -> None:
        """Record `actions.RandomRotationalVelocity`."""
        self._record(actions.RandomRotationalVelocity(shape=shape, where=where))

    @says_near_names
    def target_color(self, color: Vector, alpha: Number, scale: Number, *, where: Where = None) -> None:
        """Record `actions.TargetColor`."""
        self._record(actions.TargetColor(color=color, alpha=alpha, scale=scale, where=where))

    @says_near_names
    def target_size(self, size: Vector, scale: Vector, *, where: Where = None) -> None:
        """Record `actions.TargetSize`."""
        self._record(actions.TargetSize(size=size, scale=scale, where=where))

    @says_near_names
    def target_velocity(self, velocity: Vector, scale: Number, *, where: Where = None) -> None:
        """Record `actions.TargetVelocity`."""
        self._record(actions.TargetVelocity(velocity=velocity, scale=scale, where=where))

    @says_near_names
    def target_rotational_velocity(
        self, rotational_velocity: Vector, scale: Number, *, where: Where = None
    ) -> None:
        """Record `actions.TargetRotationalVelocity`."""
        self._record(
            actions.TargetRotationalVelocity(
                rotational_velocity=rotational_velocity, scale=scale, where=where
            )
        )

    @says_near_names
    def restore(
        self, time_left: Number, position: bool = True, up: bool = True, *, where: Where = None
    ) -> None:
        """Record `actions.Restore`."""
        self._record(actions.Restore(time_left=time_left, position=position, up=up, where=where))

    @says_near_names
    def copy_vertex_b(self, position: bool = True, velocity: bool = False, *, where: Where = None) -> None:
        """Record `actions.CopyVertexB`."""
        self._record(actions.CopyVertexB(position=position, velocity=velocity, where=where))

    @says_near_names
    def color_over_life(self, ramp: Sequence[tuple[float, ArrayLike]], *, where: Where = None) -> None:
        """Record `actions.ColorOverLife`."""
        self._record(actions.ColorOverLife(ramp=ramp, where=where))

    @says_near_names
    def alpha_over_life(self, ramp: Sequence[tuple[float, float]], *, where: Where = None) -> None:
        """Record `actions.AlphaOverLife`."""
        self._record(actions.AlphaOverLife(ramp=ramp, where=where))

    @says_near_names
    def size_over_life(self, ramp: Sequence[tuple[float, ArrayLike]], *, where: Where = None) -> None:
        """Record `actions.SizeOverLife`."""
        self._record(actions.SizeOverLife(ramp=ramp, where=where))

    @says_near_names
    def bounce(
        self,
        shape: Shape,
        restitution: Number = 1,
        friction: Number = 0,
        min_tangential_speed: Number = 0,
        exact_hit: bool = True,
        *,
        where: Where = None,
    ) -> None:
        """Record `actions.Bounce`."""
        self._record(
            actions.Bounce(
                shape=shape,
                restitution=restitution,
                friction=friction,
                min_tangential_speed=min_tangential_speed,
                exact_hit=exact_hit,
                where=where,
            )
        )

    @says_near_names
    def sink(self, shape: Shape, inside: bool = True, *, where: Where = None) -> None:
        """Record `actions.Sink`."""
        self._record(actions.Sink(shape=shape, inside=inside, where=where))

    @says_near_names
    def sink_velocity(self, shape: Shape, inside: bool = True, *, where: Where = None) -> None:
        """Record `actions.SinkVelocity`."""
        self._record(actions.SinkVelocity(shape=shape, inside=inside, where=where))

    @says_near_names
    def kill_old(self, age_limit: Number, younger: bool = False, *, where: Where = None) -> None:
        """Record `actions.KillOld`."""
        self._record(actions.KillOld(age_limit=age_limit, younger=younger, where=where))

    @says_near_names
    def kill_expired(self, *, where: Where = None) -> None:
        """Record `actions.KillExpired`."""
        self._record(actions.KillExpired(where=where))

    @says_near_names
    def move(self, rotational: bool = True, *, where: Where = None) -> None:
        """Record `actions.Move`."""
        self._record(actions.Move(rotational=rotational, where=where))

    @says_near_names
    def sort(self, eye: Vector, look: Vector, *, where: Where = None) -> None:
        """Record `actions.Sort`."""
        self._record(actions.Sort(eye=eye, look=look, where=where))
