"""What viewers have set, equal on all ranks; it changes only at borders between two frames."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from typing import Any

from .._run import sweeping
from .._values.live import Live
from ..errors import MotesError
from .controls import Control, definition_of, made, settle
from .pose import Pose
from .steer_file import CHANGES

__all__ = ["Steering"]


class Steering:
    """The state of controls, camera and pauses. Never communicates: `hear` takes what all ranks received."""

    def __init__(self, live: Live | None = None) -> None:
        """Start paused or waiting for a viewer, as `live` says; None: there are no viewers."""
        self._live = live is not None
        self.controls: dict[str, Control] = {}
        self._values: dict[str, Any] = {}
        self._changes: dict[str, Any] = {}  # for the next frame
        self._left: dict[str, Any] = {}  # values from a checkpoint, for controls not yet made
        self._camera: Pose | None = None
        self._next: Pose | None = None
        self.paused = live is not None and live.paused
        self._steps = 0  # frames that a paused run may still make
        self._waiting = live is not None and live.wait
        self.stopped = False
        """Whether a viewer, or the run that is repeated, ends the run here."""
        self.shown = False
        """Whether the last picture shows the current particles from the viewers' current camera."""
        self.steered = False
        """Whether a viewer has given any order."""
        self.balancer: str | None = None
        """The call of the balancer that viewers chose; None: the script's."""
        self.speeds: dict[str, float] = {}
        """The speeds that viewers gave to ranks."""
        self._balancing: dict[str, Any] = {}  # balancer and speeds for the next frame
        self.stays = False
        """Whether the run waits at its end, so that viewers can look around."""
        self._again: dict[
            int, Mapping[str, Any]
        ] = {}  # rows of an earlier run, repeated where still possible
        self._to = 0
        self._text: str | None = None
        self.rows: Mapping[int, Mapping[str, Any]] = {}
        """The rows that are repeated, by frame."""

    # --- controls

    def control(
        self, name: Any, value: Any, low: Any, high: Any, step: Any, choices: Any, group: Any = None
    ) -> Control:
        """Make a control: see `controls.made`."""
        value = sweeping.default_of(name, value, choices)
        control = made(self._values, name, value, low, high, step, choices, group)
        self.controls[control.name] = control
        self._text = None
        if control.name in self._left:
            self._put(self._left, control.name)
        return control

    def agreement(self) -> str:
        """Return all controls as text: part of each frame's record, which must be equal on all ranks."""
        if not self.controls:
            return ""
        if self._text is None:
            self._text = "controls " + json.dumps({n: definition_of(c) for n, c in self.controls.items()})
        return self._text

    def wished(self, name: str) -> Any:
        """Return the value that a control will have in the next frame."""
        return self._changes.get(name, self._values[name])

    def wished_balancing(self) -> tuple[str | None, dict[str, float]]:
        """Return the balancer and the speeds that viewers have chosen for the next frame."""
        chosen = self._balancing.get("balancer", self.balancer)
        return chosen, {**self.speeds, **self._balancing.get("speeds", {})}

    # --- what all ranks hear

    @property
    def camera(self) -> Pose | None:
        """The camera of the next picture; None: the script's camera."""
        return self._next

    @property
    def held(self) -> bool:
        """Whether the next frame must wait."""
        return not self.stopped and (self._waiting or (self.paused and self._steps == 0))

    def hidden(self, frame: int) -> bool:
        """Return whether a frame is only stepped, on the way to where an earlier run was."""
        return frame < self._to - 1

    def hear(self, text: str) -> None:
        """Obey the text that `Orders.take` returned on the image generator."""
        for line in text.splitlines():
            self._obey(json.loads(line))

    def hold(self) -> None:
        """Pause before the next frame."""
        self.paused, self._steps = True, 0

    def release(self) -> None:
        """Undo pauses, stops and the camera once viewers are gone for good; controls keep their values."""
        self.paused = self._waiting = self.stopped = self.stays = False
        self._steps = self._to = 0
        self._next = None

    def _obey(self, order: Mapping[str, Any]) -> None:
        self.steered = self.steered or bool(set(order) - {"joined", "stay"})
        self._changes.update(order.get("set", {}))
        if "camera" in order:
            pose = None if order["camera"] is None else Pose.read(order["camera"])
            self.shown = self.shown and pose == self._next
            self._next = pose
        if "balancer" in order:
            self._balancing["balancer"] = order["balancer"]
        if "speeds" in order:
            self._balancing["speeds"] = {**self._balancing.get("speeds", {}), **order["speeds"]}
        if "pause" in order:
            self.paused, self._steps = order["pause"], 0
            self._to = 0 if self.paused else self._to
        if "again" in order:
            again = order["again"]
            self._again.update({row["frame"]: row for row in again["rows"]})
            self.paused = again["paused"]
            self._steps = self._to = again["to"]
        if "step" in order:  # after the pause: see Orders
            self.paused = True
            self._steps += order["step"]
        self.stays = order.get("stay", self.stays)
        self._waiting = self._waiting and "joined" not in order
        self.stopped = self.stopped or "stop" in order

    # --- the border

    def commit(self, frame: int) -> dict[str, Any]:
        """Begin a frame: apply the orders. Return what has changed, as a row of the log.

        Raises MotesError if a repeated row sets a control or value that the script does not have.
        """
        self._repeat(frame)
        self._repeat_loosely(frame)
        row: dict[str, Any] = {}
        changed = {
            name: value for name, value in self._changes.items() if not _same(self._values[name], value)
        }
        self._changes = {}
        if self.stopped:
            self._next = self._camera
            return {}
        if changed:
            row["set"] = changed
            self._values.update(changed)
        if self._next != self._camera:
            row["camera"] = None if self._next is None else self._next.to_dict()
            self._camera = self._next
        row |= self._rebalance()
        if self.paused and self._steps > 0:
            self._steps -= 1
        return row

    def _rebalance(self) -> dict[str, Any]:
        """Apply what viewers ordered of balancing, and return what has changed."""
        wish, self._balancing = self._balancing, {}
        row: dict[str, Any] = {}
        if wish.get("balancer", self.balancer) != self.balancer:
            self.balancer = row["balancer"] = wish["balancer"]
        speeds = {
            rank: speed for rank, speed in wish.get("speeds", {}).items() if self.speeds.get(rank) != speed
        }
        if speeds:
            self.speeds.update(speeds)
            row["speeds"] = speeds
        return row

    def _repeat(self, frame: int) -> None:
        row = self.rows.get(frame)
        if row is None:
            return
        for name, value in row.get("set", {}).items():
            if name not in self.controls:
                raise MotesError(
                    f"the repeated run sets {name!r} before frame {frame}: this run has no such control"
                )
            try:
                settled = settle(self.controls[name], value)
            except ValueError as error:
                raise MotesError(f"the repeated run, frame {frame}: {error}") from None
            if not _same(settled, value):
                raise MotesError(
                    f"the repeated run sets {name!r} to {value!r} before frame {frame}: not a value of "
                    "this control"
                )
        self._obey({name: part for name, part in row.items() if name in (*CHANGES, "stop")})

    def _repeat_loosely(self, frame: int) -> None:
        """Obey an earlier run's row, except for controls and values that the script no longer has."""
        row = self._again.pop(frame, {})
        for name, value in row.get("set", {}).items():
            if name in self.controls:
                with contextlib.suppress(ValueError):
                    self._changes[name] = settle(self.controls[name], value)
        self._obey({name: row[name] for name in CHANGES[1:] if name in row})

    # --- checkpoints

    def state(self) -> dict[str, Any]:
        """Return the state for a checkpoint, as in the frame before it."""
        camera = None if self._camera is None else self._camera.to_dict()
        left: dict[str, Any] = {"values": {**self._left, **self._values}, "camera": camera}
        if self.paused:
            left["paused"] = True
        if self._to:
            left["again"] = {"rows": list(self._again.values()), "to": self._to, "steps": self._steps}
        balancing = {"balancer": self.balancer, "speeds": self.speeds}
        return {**left, "balancing": balancing} if any(balancing.values()) else left

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from the state in a checkpoint."""
        self._left = dict(state.get("values", {}))
        for name in [name for name in self._left if name in self.controls]:
            self._put(self._left, name)
        balancing = state.get("balancing", {})  # a new process begins with the script's own
        self._balancing = {name: wish for name, wish in balancing.items() if wish}
        if state.get("paused") and self._live:
            self.hold()
        again = state.get("again", {"rows": [], "to": 0, "steps": 0})
        self._again = {row["frame"]: row for row in again["rows"]}
        if self._live:  # without viewers every frame is drawn, and none waits
            self._to, self._steps = again["to"], again["steps"]
        camera = state.get("camera")
        self._camera = self._next = None if camera is None else Pose.read(camera)

    def _put(self, left: dict[str, Any], name: str) -> None:
        value = left.pop(name)
        with contextlib.suppress(ValueError):  # the script has changed the control since
            self._values[name] = settle(self.controls[name], value)


def _same(a: Any, b: Any) -> bool:
    return type(a) is type(b) and bool(a == b)
