"""Submissions that tests hand in."""

from __future__ import annotations

__all__ = ["BAD"]

_DECIDE = """from motes.balance import *
class Mine(Balancer):
  def __init__(self, **_): pass
  def decide(self, load):
"""

BAD = {
    "raises": (
        _DECIDE + "    return 1 / 0\n",
        r"raises ZeroDivisionError: division by zero \(mine\.py, line 5\)",
    ),
    "raises at once": ("raise ValueError('no')\n", r"raises ValueError: no \(mine\.py, line 1\)"),
    "does not parse": ("class Mine(:\n", r"does not parse: .* \(mine\.py, line 1\)"),
    "is not text": ("\x00", r"mine\.py is not Python|does not parse"),
    "has no Mine": ("x = 1\n", "the file does not define Mine"),
    "Mine is no balancer": ("Mine = int\n", "Mine is not a subclass of motes.balance.Balancer"),
    "is to be written": (_DECIDE + "    raise NotImplementedError()\n", "not been written yet"),
    "answers nonsense": (_DECIDE + "    return 'left'\n", "decide returns str, not Targets or Orders"),
    "too few shares": (_DECIDE + "    return Targets([1, 2])\n", "shares"),
    "infinite shares": (_DECIDE + "    return Targets([float('inf')] * len(load))\n", "shares"),
    "orders of strings": (_DECIDE + "    return Orders([('a', 'b', 'c')])\n", "orders"),
    "writes": (_DECIDE + "    open('x', 'w')\n", r"writes a file \('x'\)"),
    "writes, and hides it": (
        _DECIDE + "    try: open('x', 'w')\n    except BaseException: pass\n    return Orders([])\n",
        r"writes a file \('x'\)",
    ),
    "reads": (_DECIDE + "    open('/proc/self/environ').read()\n", "reads a file"),
    "starts a process": (_DECIDE + "    import os\n    os.system('true')\n", "starts a process"),
    "asks the network": (_DECIDE + "    import socket\n    socket.socket()\n", "uses the network"),
    "loads a library": (_DECIDE + "    import ctypes\n    ctypes.CDLL(None)\n", "loads C libraries"),
    "removes": (_DECIDE + "    import os\n    os.remove('x')\n", "changes files"),
    "sleeps": (_DECIDE + "    import time\n    time.sleep(100)\n", "sleeps"),
    "waits for input": (_DECIDE + "    input()\n", "raises EOFError"),
    "exits": (_DECIDE + "    import sys\n    sys.exit(0)\n", "raises SystemExit"),
    "ends the process": (_DECIDE + "    import os\n    os._exit(3)\n", r"ends the process \(exit code 3\)"),
    "crashes": (_DECIDE + "    import os\n    os.abort()\n", "ends the process: Aborted"),
    "takes all memory": (_DECIDE + "    return [0] * (1 << 36)\n", "raises MemoryError"),
    "prints without end": (_DECIDE + "    while True: print('x' * 1000)\n", "prints endlessly"),
    "throws dice": (
        _DECIDE + "    import numpy as np\n    return Targets(np.random.default_rng().random(len(load)))\n",
        "two runs of it give different results",
    ),
}
"""For each kind of error: the file, and a part of the grade's message."""
