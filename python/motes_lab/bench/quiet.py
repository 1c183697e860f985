"""How much of this machine other programs use. Ratios of times mean little while they do."""

from __future__ import annotations

import os
import platform
import time
from pathlib import Path

from motes.errors import MotesError

__all__ = ["LIMIT", "OthersAtWork", "processor", "require_quiet", "too_busy"]

LIMIT = 0.25
"""Processors that other programs may use on average; with more, figures are not judged."""
LOOK_S = 2.0
"""How long a look takes before a benchmark starts."""
_STAT, _CPUINFO = Path("/proc/stat"), Path("/proc/cpuinfo")


class OthersAtWork:
    """Counts the processor time of all other programs from its creation on.

    This program and its finished children do not count; the time that a hypervisor gave to others does.
    """

    def __init__(self) -> None:
        """Start to count."""
        self._since, self._all, self._own = time.monotonic(), _busy_s(), _own_s()

    def processors(self) -> float:
        """Return how many processors others have used on average; 0 where the system does not tell."""
        passed = time.monotonic() - self._since
        others = (_busy_s() - self._all) - (_own_s() - self._own)
        return max(others, 0.0) / passed if passed > 0 else 0.0


def require_quiet(*, busy: bool) -> None:
    """Look at the machine for a while. Raises MotesError if others are at work, unless `busy`."""
    if busy:
        return
    others = OthersAtWork()
    time.sleep(LOOK_S)
    if (used := others.processors()) > LIMIT:
        raise MotesError(too_busy(used))


def too_busy(used: float) -> str:
    """Say why figures are not judged."""
    return (
        f"other programs use {used:.2f} processors of this machine, at most {LIMIT} are allowed: ratios of "
        "times mean nothing. Wait until they have ended, or give --busy to see ratios that are not judged"
    )


def processor() -> str:
    """Return the processor's name, family and model, or the architecture where the system does not tell."""
    try:
        lines = _CPUINFO.read_text().partition("\n\n")[0].splitlines()
    except OSError:
        lines = []
    told = {name.strip(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
    if "model name" not in told:
        return platform.machine()
    return f"{told['model name']} (family {told.get('cpu family', '?')}, model {told.get('model', '?')})"


def _busy_s() -> float:
    """Return the seconds that all processors have worked since the machine started."""
    try:
        total = _STAT.read_text().split("\n", 1)[0].split()
    except OSError:
        return 0.0
    user, nice, system, _idle, _wait, interrupts, softly, stolen = map(int, total[1:9])
    return (user + nice + system + interrupts + softly + stolen) / os.sysconf("SC_CLK_TCK")


def _own_s() -> float:
    own = os.times()
    return own.user + own.system + own.children_user + own.children_system
