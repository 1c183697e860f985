"""TargetsRecorder: a method for each action of `targets`. Written by `.ci/recorder`."""

from __future__ import annotations

import math
from collections.abc import Sequence

from numpy.typing import ArrayLike

from .. import actions
from .._values.curves import Number, Vector
from .._values.values import says_near_names
from ..actions.base import Where
from ..shapes import Shape
from .recording import Recording

__all__ = ["TargetsRecorder"]


class TargetsRecorder(Recording):
    """What sets or approaches given values."""

    @says_near_names
    def damping(
        self, damping: Vector, min_speed: Number = 0, max_speed: Number = math.inf, *, where: Where = None
    ) -> None:
        """Slows particles down, axis by axis, while their speed is in a range.

        Records `actions.Damping`.

        Args:
            damping: fraction of the velocity that remains after one second, per axis.
            min_speed: lower end of the range, m/s.
            max_speed: upper end of the range, m/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Damping(damping=damping, min_speed=min_speed, max_speed=max_speed, where=where))

    @says_near_names
    def rotational_damping(
        self, damping: Vector, min_speed: Number = 0, max_speed: Number = math.inf, *, where: Where = None
    ) -> None:
        """Slows rotations down, axis by axis, while their rotational speed is in a range.

        Records `actions.RotationalDamping`.

        Args:
            damping: fraction of the rotational velocity that remains after one second, per axis.
            min_speed: lower end of the range, 1/s.
            max_speed: upper end of the range, 1/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.RotationalDamping(damping=damping, min_speed=min_speed, max_speed=max_speed, where=where)
        )

    @says_near_names
    def speed_clamp(
        self, min_speed: Number = 0, max_speed: Number = math.inf, *, where: Where = None
    ) -> None:
        """Limits speeds to a range; directions do not change, and particles at rest stay at rest.

        Records `actions.SpeedClamp`.

        Args:
            min_speed: lower end of the range, m/s.
            max_speed: upper end of the range, m/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.SpeedClamp(min_speed=min_speed, max_speed=max_speed, where=where))

    @says_near_names
    def random_velocity(self, shape: Shape | ArrayLike, *, where: Where = None) -> None:
        """Gives each particle a new random velocity in each step.

        Records `actions.RandomVelocity`.

        Args:
            shape: distribution of the sample, m/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.RandomVelocity(shape=shape, where=where))

    @says_near_names
    def random_displacement(self, shape: Shape | ArrayLike, *, where: Where = None) -> None:
        """Shifts each particle by its own random displacement, redrawn in each step; velocities stay.

        Records `actions.RandomDisplacement`.

        Args:
            shape: distribution of the sample, m/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.RandomDisplacement(shape=shape, where=where))

    @says_near_names
    def random_rotational_velocity(self, shape: Shape | ArrayLike, *, where: Where = None) -> None:
        """Gives each particle a new random rotational velocity in each step.

        Records `actions.RandomRotationalVelocity`.

        Args:
            shape: distribution of the sample, 1/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.RandomRotationalVelocity(shape=shape, where=where))

    @says_near_names
    def target_color(self, color: Vector, alpha: Number, scale: Number, *, where: Where = None) -> None:
        """Moves color and alpha toward given values, by the same fraction of the difference in each step.

        Records `actions.TargetColor`.

        Args:
            color: target color, linear RGB.
            alpha: target alpha, 0..1.
            scale: fraction of the difference per second, 1/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.TargetColor(color=color, alpha=alpha, scale=scale, where=where))

    @says_near_names
    def target_size(self, size: Vector, scale: Vector, *, where: Where = None) -> None:
        """Moves the size toward a given one, each component by its own fraction of the difference per step.

        Records `actions.TargetSize`.

        Args:
            size: target size, one number or three, m.
            scale: fraction of the difference per second, one number or three, 1/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.TargetSize(size=size, scale=scale, where=where))

    @says_near_names
    def target_velocity(self, velocity: Vector, scale: Number, *, where: Where = None) -> None:
        """Moves the velocity toward a given velocity, by the same fraction of the difference in each step.

        Records `actions.TargetVelocity`.

        Args:
            velocity: target velocity, m/s.
            scale: fraction of the difference per second, 1/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.TargetVelocity(velocity=velocity, scale=scale, where=where))

    @says_near_names
    def target_rotational_velocity(
        self, rotational_velocity: Vector, scale: Number, *, where: Where = None
    ) -> None:
        """Moves the rotational velocity toward a given one, by the same fraction of the difference per step.

        Records `actions.TargetRotationalVelocity`.

        Args:
            rotational_velocity: target rotational velocity, 1/s.
            scale: fraction of the difference per second, 1/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.TargetRotationalVelocity(
                rotational_velocity=rotational_velocity, scale=scale, where=where
            )
        )

    @says_near_names
    def restore(
        self, time_left: Number, position: bool = True, up: bool = True, *, where: Where = None
    ) -> None:
        """Returns particles to position_b and up_b, where they come to rest after `time_left`.

        Records `actions.Restore`.

        Args:
            time_left: time until particles come to rest, s.
            position: whether positions go back.
            up: whether orientations go back.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Restore(time_left=time_left, position=position, up=up, where=where))

    @says_near_names
    def copy_vertex_b(self, position: bool = True, velocity: bool = False, *, where: Where = None) -> None:
        """Stores the current position, orientation or velocity as the target to which `restore` returns.

        Records `actions.CopyVertexB`.

        Args:
            position: whether positions and orientations are copied.
            velocity: whether velocities are copied.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.CopyVertexB(position=position, velocity=velocity, where=where))

    @says_near_names
    def color_over_life(self, ramp: Sequence[tuple[float, ArrayLike]], *, where: Where = None) -> None:
        """Sets each particle's color from the fraction of its lifetime that has passed.

        Records `actions.ColorOverLife`.

        Args:
            ramp: knots (ratio 0..1, linear RGB) in ascending order.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.ColorOverLife(ramp=ramp, where=where))

    @says_near_names
    def alpha_over_life(self, ramp: Sequence[tuple[float, float]], *, where: Where = None) -> None:
        """Sets each particle's alpha from the fraction of its lifetime that has passed.

        Records `actions.AlphaOverLife`.

        Args:
            ramp: knots (ratio 0..1, alpha) in ascending order.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.AlphaOverLife(ramp=ramp, where=where))

    @says_near_names
    def size_over_life(self, ramp: Sequence[tuple[float, ArrayLike]], *, where: Where = None) -> None:
        """Sets each particle's size from the fraction of its lifetime that has passed.

        Records `actions.SizeOverLife`.

        Args:
            ramp: knots (ratio 0..1, size) in ascending order; a size is one number or three, m.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.SizeOverLife(ramp=ramp, where=where))
