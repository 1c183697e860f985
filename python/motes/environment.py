"""What the environment says about a run: it goes before what the script says."""

from __future__ import annotations

import os
from typing import Any

from . import arguments
from .errors import ArgumentError

__all__ = ["alone", "births", "fan_out", "stall_s"]

STALL_S = 60.0
BIRTHS = ("manager", "calculators")
MOST_RANKS = 2**31 - 1


def stall_s() -> float:
    """Seconds without an answer after which a rank gives up: MOTES_STALL_S."""
    text = os.environ.get("MOTES_STALL_S", "")
    if not text:
        return STALL_S
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not 0 < seconds < float("inf"):
        raise ArgumentError("MOTES_STALL_S", text, "a number of seconds > 0")
    return seconds


def alone() -> bool:
    """Tell whether each process may run by itself under a launcher that started several: MOTES_ALONE."""
    text = os.environ.get("MOTES_ALONE", "")
    if text not in ("", "0", "1"):
        raise ArgumentError("MOTES_ALONE", text, "0 or 1")
    return text == "1"


def births(given: Any) -> str:
    """Return who makes births: MOTES_BIRTHS, or else World's `births`."""
    text = os.environ.get("MOTES_BIRTHS", "")
    if text:
        return arguments.choice("MOTES_BIRTHS", text, BIRTHS)
    return arguments.choice("births", given, BIRTHS)


def fan_out(given: Any) -> int:
    """Return to how many ranks one passes words on: MOTES_FAN_OUT, or else World's `fan_out`."""
    text = os.environ.get("MOTES_FAN_OUT", "")
    if not text:
        return arguments.integer("fan_out", given, low=1, high=MOST_RANKS)
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= MOST_RANKS:
        raise ArgumentError("MOTES_FAN_OUT", text, f"an integer 1..{MOST_RANKS}")
    return int(text)
