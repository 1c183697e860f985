"""Control: a value that viewers may change during a run."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

import numpy as np

from .._values import arguments
from .._values.colors import digits_of
from ..errors import ArgumentError, NotAssignableError

__all__ = ["Choice", "Control", "definition_of", "made", "settle"]

Choice = str | int | float

MOST_LETTERS = 100
MOST_CHOICES = 1000
_CHOICES = "strings or finite numbers, without repeats"


class Control:
    """A number, a flag or a choice that viewers may change between two frames.

    `World.control` makes it. `value` is the same on all ranks and does not change within a frame.
    """

    __slots__ = ("_values", "choices", "default", "group", "high", "low", "name", "step")

    name: str
    default: Any
    """Its value before a viewer sets it."""
    low: float | None
    high: float | None
    step: float | None
    choices: tuple[Choice, ...] | None
    group: str | None
    _values: Mapping[str, Any]

    def __init__(
        self,
        name: str,
        default: Any,
        values: Mapping[str, Any],
        *,
        low: float | None = None,
        high: float | None = None,
        step: float | None = None,
        choices: Sequence[Choice] | None = None,
        group: str | None = None,
    ) -> None:
        """Take checked arguments; scripts call `World.control`.

        Args:
            name: its name.
            default: its value before a viewer sets it.
            values: the current values of the world's controls, by name.
            low: the smallest number, or None.
            high: the largest number, or None.
            step: the distance between allowed numbers, or None.
            choices: the allowed values, or None.
            group: the heading under which pages show it, or None.
        """
        listed = None if choices is None else tuple(arguments.listed("choices", choices, _CHOICES))
        for slot, given in (
            *(("name", name), ("default", default), ("low", low), ("high", high), ("step", step)),
            *(("choices", listed), ("group", group), ("_values", values)),
        ):
            object.__setattr__(self, slot, given)

    @property
    def value(self) -> Any:
        """Its value in this frame, of the default's type: a float, an int, a bool, a colour or a choice."""
        return self._values[self.name]

    @property
    def _definition(self) -> dict[str, Any]:
        """The default and the allowed values, for viewers and for the log."""
        told: dict[str, Any] = {"value": self.default}
        if self.choices is not None:
            told["choices"] = list(self.choices)
        elif not isinstance(self.default, (bool, str)):
            told |= {"low": self.low, "high": self.high, "step": self.step}
        return told if self.group is None else {**told, "group": self.group}

    def _settled(self, wish: Any) -> Any:
        """Return the value that a viewer's wish sets; numbers are clamped, and rounded to a step.

        Raises ValueError, which says what is allowed, for a wish of another type.
        """
        if self.choices is not None:
            same = [
                one for one in self.choices if one == wish and isinstance(wish, str) == isinstance(one, str)
            ]
            if isinstance(wish, bool) or not same:
                raise ValueError(f"{self.name!r} must be one of {list(self.choices)!r}")
            return same[0]
        if isinstance(self.default, bool):
            if not isinstance(wish, bool):
                raise ValueError(f"{self.name!r} must be true or false")
            return wish
        if isinstance(self.default, str):
            if not isinstance(wish, str) or not re.fullmatch("#[0-9a-f]{6}", wish):
                raise ValueError(f"{self.name!r} must be a colour such as '#ff8800'")
            return wish
        if isinstance(wish, bool) or not isinstance(wish, (int, float)) or not _finite(wish):
            raise ValueError(f"{self.name!r} must be a finite number")
        return self._within(wish)

    def _within(self, wish: float) -> float:
        assert self.low is not None and self.high is not None
        inside = min(max(wish, self.low), self.high)
        if self.step is None:
            return float(inside)
        steps = round((inside - self.low) / self.step)
        last = math.floor((self.high - self.low) / self.step + 1e-9)
        if isinstance(self.default, int):
            return int(self.low) + int(min(steps, last)) * int(self.step)
        return float(f"{self.low + min(steps, last) * self.step:.12g}")  # 0.3, not 0.30000000000000004

    def __bool__(self) -> NoReturn:
        """Refuse: a control is not its value."""
        raise ArgumentError("control", self, f"tested as {self.name}.value")

    def __repr__(self) -> str:
        """Show its name and its current value."""
        return f"<Control {self.name!r}: {self.value!r}>"

    def __setattr__(self, name: str, _: object) -> NoReturn:
        """Refuse: viewers set its value."""
        hint = ": viewers set it, between frames" if name == "value" else ""
        raise NotAssignableError(f"Control.{name} cannot be assigned{hint}")

    def __delattr__(self, name: str) -> NoReturn:
        """Refuse."""
        raise NotAssignableError(f"Control.{name} cannot be deleted")


def definition_of(control: Control) -> dict[str, Any]:
    """Return a control's default and allowed values, for viewers and for the log."""
    return control._definition


def settle(control: Control, wish: Any) -> Any:
    """Return the value that a viewer's wish sets. Raises ValueError, which says what is allowed."""
    return control._settled(wish)


def made(
    values: dict[str, Any],
    name: Any,
    value: Any,
    low: Any,
    high: Any,
    step: Any,
    choices: Any,
    group: Any = None,
) -> Control:
    """Return a new control from the arguments of `World.control`, and set it to its default."""
    for argument, text in (("name", name), ("group", "-" if group is None else group)):
        if not isinstance(text, str) or not 0 < len(text) <= MOST_LETTERS or not text.isprintable():
            raise ArgumentError(argument, text, f"a printable string of 1..{MOST_LETTERS} characters")
    if name in values:
        error = ArgumentError("name", name, "a new one")
        error.args = (f"a control named {name!r} already exists; names are unique",)
        raise error
    if choices is not None:
        _no_bounds("choices", low, high, step)
        control = _choice(values, name, value, choices, group)
    elif isinstance(value, (bool, np.bool_)):
        _no_bounds("True or False", low, high, step)
        control = Control(name, bool(value), values, group=group)
    elif isinstance(value, str) and low is None and high is None:
        _no_bounds("a colour", low, high, step)
        control = Control(name, "#" + digits_of("value", value), values, group=group)
    else:
        control = _number(values, name, value, low, high, step, group)
    values[name] = control.default
    return control


def _no_bounds(kind: str, low: Any, high: Any, step: Any) -> None:
    for argument, given in (("low", low), ("high", high), ("step", step)):
        if given is not None:
            raise ArgumentError(argument, given, f"left out for a control of {kind}")


def _choice(values: dict[str, Any], name: str, value: Any, choices: Any, group: str | None) -> Control:
    listed = arguments.listed("choices", choices, _CHOICES)
    wrong = [one for one in listed if not _is_choice(one)]
    if (
        isinstance(choices, str)
        or wrong
        or not 0 < len(listed) <= MOST_CHOICES
        or len(set(listed)) < len(listed)
    ):
        raise ArgumentError("choices", choices, f"1..{MOST_CHOICES} {_CHOICES}")
    if not _is_choice(value) or value not in listed:
        raise ArgumentError("value", value, f"one of the choices, {listed!r}")
    return Control(name, listed[listed.index(value)], values, choices=listed, group=group)


def _is_choice(one: Any) -> bool:
    return isinstance(one, str) or (type(one) in (int, float) and _finite(one))


def _number(
    values: dict[str, Any], name: str, value: Any, low: Any, high: Any, step: Any, group: str | None
) -> Control:
    for argument, given in (("low", low), ("high", high)):
        if given is None:
            raise ArgumentError(argument, given, "given for a control that is a number")
    least = arguments.number("low", low, low=-1e300, high=1e300)
    most = arguments.number("high", high, low=-1e300, high=1e300)
    if not least < most:
        raise ArgumentError("high", high, f"more than low, {low!r}")
    first = arguments.number("value", value, low=least, high=most)
    if step is None:
        return Control(name, first, values, low=least, high=most, group=group)
    width = arguments.number("step", step, high=most - least)
    if width <= 0 or (most - least) / width > 1e9:
        raise ArgumentError("step", step, f"above 0, at most high - low, {most - least:g}")
    if all(_is_whole(one) for one in (value, low, high, step)):
        return Control(name, int(value), values, low=int(low), high=int(high), step=int(step), group=group)
    return Control(name, first, values, low=least, high=most, step=width, group=group)


def _is_whole(one: Any) -> bool:
    return isinstance(one, (int, np.integer)) and abs(int(one)) <= 2**53


def _finite(number: float) -> bool:
    try:
        return math.isfinite(number)
    except OverflowError:  # an int too large for a float
        return False
