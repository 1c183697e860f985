"""The orders of all viewers, queued until the next border between two frames. The queue is bounded.

Any thread may put orders; the thread that runs the frames takes them. Orders are data: known names, and
numbers within bounds.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from typing import Any

from .._values.environment import MOST_RANKS
from .controls import Control, settle
from .pose import Pose
from .steer_file import is_speed

__all__ = ["Orders"]

MOST_STEPS = 1000
MOST_MOVES = 64
_NUMBERS = {"orbit": 2, "pan": 2, "zoom": 1}  # kinds of moves, and how many numbers each takes
_MOST = 1e3  # largest such number: an angle (rad) or a fraction of the picture


class Orders:
    """The orders that have arrived since the last border; the last value of each name counts."""

    def __init__(self, repeats: str | None = None) -> None:
        """`repeats` is the file whose orders the run repeats: viewers can then only watch, pause and step."""
        self._repeats = repeats
        self._controls: Mapping[str, Control] = {}
        self._arrived = threading.Condition()
        self._order: dict[str, Any] = {}
        self._moves: list[tuple[str, list[float]]] = []
        self._woken = False
        self.judge: Callable[[str], str] = _no_balancer
        """Returns a balancer's call as the log writes it, or raises ValueError, which says why not."""
        self.resize: Callable[[int], None] = _no_launcher
        """Asks for another number of ranks, or raises ValueError, which says why not."""
        self.paced = False
        """Whether viewers want no more frames per second than the film has."""
        self.accepted = 0
        """The number of orders given so far."""

    def know(self, controls: Mapping[str, Control]) -> None:
        """Let viewers set these controls from now on."""
        self._controls = dict(controls)

    def put(self, order: Any) -> None:
        """Queue a viewer's order. Raises ValueError, which says why, for an invalid one."""
        if not isinstance(order, dict) or len(order) != 1:
            raise ValueError("an order is an object with one name")
        (name, wish), *_ = order.items()
        if self._repeats is not None and name not in ("again", "pace", "pause", "resize", "stay", "step"):
            raise ValueError(
                f"this run repeats the orders of {self._repeats}; it can be paused, but not steered"
            )
        if self._repeats is not None and name == "again" and isinstance(wish, dict) and wish.get("rows"):
            raise ValueError(f"this run repeats the orders of {self._repeats}, and no others")
        if name in _NUMBERS:
            self._move(name, wish)
        elif name == "set":
            self._set(wish)
        elif name == "balancer" and isinstance(wish, str):
            self._say(name, self.judge(wish[:1000]))
        elif name == "speeds" and isinstance(wish, dict) and wish and all(map(is_speed, wish.items())):
            self._say(name, wish)
        elif name == "resize" and type(wish) is int and 0 < wish <= MOST_RANKS:
            self.resize(wish)
        elif name == "pace" and isinstance(wish, bool):
            self.paced = wish  # changes no frame, so other ranks need not know
            self.wake()
        else:
            self._say(name, _checked(name, wish))

    def joined(self) -> None:
        """Queue the notice, for all ranks, that a viewer has joined."""
        self._say("joined", True)

    def left(self) -> None:
        """Queue the notice that the desk has left, which wanted the run to wait at its end."""
        self._say("stay", False)

    def wake(self) -> None:
        """End a `wait` without an order."""
        with self._arrived:
            self._woken = True
            self._arrived.notify_all()

    def wait(self, seconds: float) -> bool:
        """Wait for an order; return whether there is one or `wake` was called."""
        with self._arrived:
            self._arrived.wait_for(lambda: self._woken or bool(self._order or self._moves), seconds)
            came = self._woken or bool(self._order or self._moves)
            self._woken = False
            return came

    def take(self, pose: Callable[[], Pose | None], near: float) -> tuple[str, int]:
        """Remove all orders; return them as text, empty if there are none, and `accepted`.

        `pose` returns the camera that they move, or None if there is no picture; `near` is the camera's near
        distance (m).
        """
        with self._arrived:
            order, self._order = self._order, {}
            moves, self._moves = self._moves, []
            accepted = self.accepted
        if moves:
            start = Pose.read(order["camera"]) if order.get("camera") else pose()
            moved = None if start is None else _moved(start, moves, near)
            if moved is not None:
                order["camera"] = moved.to_dict()
        return (json.dumps(order, separators=(",", ":")) + "\n" if order else ""), accepted

    def _set(self, wish: Any) -> None:
        if not isinstance(wish, dict) or not 0 < len(wish) <= len(self._controls):
            raise ValueError("set takes an object that maps names of controls to values")
        settled = {}
        for name, value in wish.items():
            if name not in self._controls:
                raise ValueError(f"there is no control {name!r}")
            settled[name] = settle(self._controls[name], value)
        with self._arrived:
            self._order.setdefault("set", {}).update(settled)
            self._note()

    def _move(self, kind: str, wish: Any) -> None:
        numbers = wish if isinstance(wish, list) else [wish]
        if len(numbers) != _NUMBERS[kind] or not all(map(_is_move, numbers)):
            raise ValueError(f"{kind} takes {_NUMBERS[kind]} numbers within {_MOST:g}")
        with self._arrived:
            same = [old for old_kind, old in self._moves if old_kind == kind]
            if self._moves and self._moves[-1][0] == kind:
                _add(self._moves[-1][1], numbers)
            elif len(self._moves) >= MOST_MOVES and same:
                _add(same[-1], numbers)
            else:
                self._moves.append((kind, [float(one) for one in numbers]))
            self._note()

    def _say(self, name: str, wish: Any) -> None:
        with self._arrived:
            if name == "camera":
                self._moves = []  # they applied to the old camera
            if name == "pause":
                self._order.pop("step", None)  # drop steps ordered before the pause
            if name == "again" and name in self._order:  # a long session's rows come in several orders
                wish = {**wish, "rows": self._order[name]["rows"] + wish["rows"]}
            if name == "speeds":
                wish = {**self._order.get(name, {}), **wish}
            if name == "step":
                wish = min(wish + self._order.get("step", 0), MOST_STEPS)
            self._order[name] = wish
            self._note()

    def _note(self) -> None:
        self.accepted += 1
        self._arrived.notify_all()


def _checked(name: str, wish: Any) -> Any:
    """Return an order's value in the form sent to all ranks. Raises ValueError for an invalid order."""
    if name == "camera":
        return None if wish is None else Pose.read(wish).rounded().to_dict()
    if name == "pause" and isinstance(wish, bool):
        return wish
    if name == "step" and type(wish) is int and 1 <= wish <= MOST_STEPS:
        return wish
    if name == "stop" and wish is True:
        return True
    if name == "stay" and isinstance(wish, bool):
        return wish
    if name == "again":
        return _again(wish)
    raise ValueError(f"there is no order {str(name)[:100]!r} with this value")


def _no_balancer(_: str) -> str:
    raise ValueError("this run cannot change its balancer")


def _no_launcher(_: int) -> None:
    raise ValueError("this run cannot change its number of ranks")


def _again(wish: Any) -> dict[str, Any]:
    """Return the order to repeat an earlier run's rows up to a frame, as far as the script allows."""
    names = {"rows", "to", "paused"}
    if not isinstance(wish, dict) or set(wish) != names or not isinstance(wish["rows"], list):
        raise ValueError(f"again takes {', '.join(sorted(names))}")
    to = wish["to"]
    if type(to) is not int or not 0 <= to < 2**31 or not isinstance(wish["paused"], bool):
        raise ValueError("again goes on to a frame >= 0")
    rows = []
    for row in wish["rows"]:
        if not isinstance(row, dict) or type(row.get("frame")) is not int:
            raise ValueError("again takes rows of a steer.jsonl")
        kept: dict[str, Any] = {name: row[name] for name in ("frame", "balancer", "speeds") if name in row}
        if isinstance(row.get("set"), dict):
            kept["set"] = row["set"]
        if "camera" in row:
            kept["camera"] = None if row["camera"] is None else Pose.read(row["camera"]).to_dict()
        rows.append(kept)
    return {"rows": rows, "to": to, "paused": wish["paused"]}


def _is_move(one: Any) -> bool:
    return type(one) in (int, float) and abs(one) <= _MOST  # False for NaN; ints may have any size


def _add(to: list[float], numbers: list[float]) -> None:
    for i, one in enumerate(numbers):
        to[i] = min(max(to[i] + one, -_MOST), _MOST)


def _moved(pose: Pose, moves: list[tuple[str, list[float]]], near: float) -> Pose | None:
    """Return the camera after all moves, rounded; None if it would see nothing."""
    try:
        for kind, numbers in moves:
            if kind == "zoom":
                pose = pose.zoom(numbers[0], near)
            else:
                pose = pose.orbit(*numbers) if kind == "orbit" else pose.pan(*numbers)
        pose = pose.rounded()
    except (ArithmeticError, ValueError):  # beyond the range of floats
        return None
    return pose if pose.possible() else None
