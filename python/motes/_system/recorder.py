"""Recorder: a method for each action of `forces`, `guides` and `motion`. Written by `.ci/recorder`."""

from __future__ import annotations

import math
from typing import Literal

from numpy.typing import ArrayLike

from .. import actions
from .._values.curves import Number, Vector
from .._values.values import says_near_names
from ..actions.base import Where
from ..shapes import Shape
from .recorder_between import BetweenRecorder
from .recorder_targets import TargetsRecorder

__all__ = ["Recorder"]


class Recorder(TargetsRecorder, BetweenRecorder):
    """What scripts can tell the particles of a system."""

    @says_near_names
    def gravity(self, acceleration: Vector, *, where: Where = None) -> None:
        """Accelerates all particles by the same amount.

        Records `actions.Gravity`.

        Args:
            acceleration: acceleration of all particles, m/s^2.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Gravity(acceleration=acceleration, where=where))

    @says_near_names
    def random_acceleration(self, shape: Shape | ArrayLike, *, where: Where = None) -> None:
        """Gives each particle its own random acceleration, redrawn in each step.

        Records `actions.RandomAcceleration`.

        Args:
            shape: distribution of a, m/s^2.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.RandomAcceleration(shape=shape, where=where))

    @says_near_names
    def jet(self, shape: Shape, acceleration: Shape | ArrayLike, *, where: Where = None) -> None:
        """Accelerates the particles inside a shape, as a fan does.

        Records `actions.Jet`.

        Args:
            shape: where the jet blows, m.
            acceleration: a value, or a shape from which a is redrawn in each step, m/s^2.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Pushes particles away from a centre, most strongly at the shock wave: let `radius` grow with time.

        Records `actions.Explosion`.

        Args:
            center: centre of the explosion, m.
            radius: distance of the shock wave's crest from the centre, m.
            magnitude: strength, m^4/s^2.
            sigma: thickness of the wave, m.
            epsilon: softens the push near the centre, m^2.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Pulls particles toward a point, more strongly the nearer they are, which lets them orbit it.

        Records `actions.OrbitPoint`.

        Args:
            center: the point, m.
            magnitude: strength, m^3/s^2.
            epsilon: softens the pull near the centre, m^2.
            max_radius: no pull beyond this distance, m.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Pulls particles toward an infinite line, more strongly the nearer they are.

        Records `actions.OrbitLine`.

        Args:
            point: any point of the line, m.
            axis: the line's direction; any length.
            magnitude: strength, m^3/s^2.
            epsilon: softens the pull near the line, m^2.
            max_radius: no pull beyond this distance, m.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Whirls particles around an axis like a tornado: pulls them in, then carries them around and up.

        Records `actions.Vortex`.

        Args:
            tip: where the axis starts, m.
            axis: from the tip to the upper end, m.
            tightness: 1 makes a cone; larger values bend its side inward.
            max_radius: radius at the upper end, m; farther particles are not affected.
            in_speed: force toward the axis outside the whirl, kg m/s^2.
            up_speed: v m / dt along the axis inside the whirl, kg m/s^2.
            around_speed: v m / dt around the axis inside the whirl, kg m/s^2.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Drags particles along with moving air; the result does not depend on the step's length.

        Records `actions.Wind`.

        Args:
            velocity: the air's velocity, m/s.
            drag: rate, 1/s: a particle at rest reaches 63 % of the air's velocity in 1 / drag seconds.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Stirs particles like turbulent air: accelerates them along a random, divergence-free field.

        Records `actions.CurlNoise`.

        Args:
            strength: root mean square of the acceleration, m/s^2. Together with `wind`, particles reach
                speeds of about strength / drag.
            scale: edge length of a cell of the noise, about the distance between eddies, m. Along a periodic
                axis the cells are stretched or shrunk so that a whole number of them, at least one, fills the
                period: the field is the same at both ends.
            octaves: 1 to 8; each adds smaller eddies, at the cost of one more evaluation of the noise.
            speed: how many times per second the field changes smoothly into another one, 1/s; 0: never.
            field: number of the system's field, 0 to 65535. The same number gives the same field in every
                frame, wherever the action is in the list; give two actions different numbers for different
                fields.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(
            actions.CurlNoise(
                strength=strength, scale=scale, octaves=octaves, speed=speed, field=field, where=where
            )
        )

    @says_near_names
    def avoid(
        self, shape: Shape, magnitude: Number, epsilon: Number, look_ahead: Number, *, where: Where = None
    ) -> None:
        """Turns particles that would hit a shape within `look_ahead`, without changing their speed.

        Records `actions.Avoid`.

        Args:
            shape: the obstacle, m.
            magnitude: how sharply particles turn, s (Sphere: m^2/s).
            epsilon: softens the turn near the shape, s^2 (Sphere: m^2).
            look_ahead: how far ahead in time hits are predicted, s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Accelerates particles by the vectors of a grid, or drags them along as moving air.

        Records `actions.Field`.

        Args:
            grid: float32 (nx, ny, nz, 3), m/s^2, or m/s with `drag`; it is copied.
            low: the corner of node [0, 0, 0], m.
            high: the corner of node [-1, -1, -1], above `low` in each component, m.
            strength: factor that multiplies the vectors.
            drag: rate at which particles take on the field's velocity, 1/s; None: the vectors are
                accelerations.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Steers particles along a path, toward a point ahead of the nearest point of the path.

        Records `actions.FollowPath`.

        Args:
            points: waypoints, (n, 3), m; consecutive duplicates count once.
            speed: speed along the path, m/s.
            strength: rate at which velocities change, 1/s.
            look_ahead: distance of the point ahead, m; larger values cut corners, smaller ones follow more
                closely.
            radius: particles farther from the path are not affected, m.
            loop: whether the path continues from the last point to the first.
            smooth: whether the path is a Catmull-Rom spline through the points instead of straight lines; the
                spline is approximated by 16 straight pieces between two points.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Makes particles that hit the surface of a shape in this step rebound; record it before `move`.

        Records `actions.Bounce`.

        Args:
            shape: Plane (from above), Rectangle, Triangle and Disc (both sides), Box, Cylinder, Cone and
                Sphere (from outside and from inside; a Sphere's inner radius has no surface), or a Union of
                them, m.
            restitution: fraction of the speed across the surface that remains.
            friction: fraction of the speed along the surface that is lost, 0..1.
            min_tangential_speed: no friction up to this speed along the surface, m/s.
            exact_hit: whether the exact point and time of the hit are used.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
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
        """Kills particles inside a shape, or outside it with inside=False.

        Records `actions.Sink`.

        Args:
            shape: region of positions, m.
            inside: whether particles inside the shape die, or those outside.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Sink(shape=shape, inside=inside, where=where))

    @says_near_names
    def sink_velocity(self, shape: Shape, inside: bool = True, *, where: Where = None) -> None:
        """Kills particles whose velocity is inside a shape, or outside it: slow or fast ones.

        Records `actions.SinkVelocity`.

        Args:
            shape: region of velocities, m/s.
            inside: whether particles inside the shape die, or those outside.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.SinkVelocity(shape=shape, inside=inside, where=where))

    @says_near_names
    def kill_old(self, age_limit: Number, younger: bool = False, *, where: Where = None) -> None:
        """Kills particles that have reached an age; with younger=True, kills those that have not.

        Records `actions.KillOld`.

        Args:
            age_limit: the age, s.
            younger: whether younger particles die instead.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.KillOld(age_limit=age_limit, younger=younger, where=where))

    @says_near_names
    def kill_expired(self, *, where: Where = None) -> None:
        """Kills particles whose age has reached their lifetime.

        Records `actions.KillExpired`.

        Args:
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.KillExpired(where=where))

    @says_near_names
    def align(
        self, to: Literal["velocity"] | Vector = "velocity", rate: Number = math.inf, *, where: Where = None
    ) -> None:
        """Turns each particle by the shortest rotation until its own z axis points along a direction.

        Records `actions.Align`.

        Args:
            to: direction, "velocity" or a vector.
            rate: maximum angular speed, rad/s.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Align(to=to, rate=rate, where=where))

    @says_near_names
    def move(self, rotational: bool = True, *, where: Where = None) -> None:
        """Moves particles by their velocity, turns them by their rotational velocity and spin, and ages them.

        Records `actions.Move`.

        Args:
            rotational: whether particles turn.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Move(rotational=rotational, where=where))

    @says_near_names
    def sort(self, eye: Vector, look: Vector, *, where: Where = None) -> None:
        """Sorts particles for drawing: far ones first, so nearer ones cover them.

        Records `actions.Sort`.

        Args:
            eye: the viewer's position, m.
            look: the viewing direction; any length.
            where: which particles to act on: those inside a shape, or those that satisfy a comparison of
                columns; None: all.
        """
        self._record(actions.Sort(eye=eye, look=look, where=where))
