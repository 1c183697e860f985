"""Live: settings of a run that browsers show and steer."""

from __future__ import annotations

import re
from typing import Any

from ..errors import ArgumentError
from . import arguments, environment
from .values import Value, value

__all__ = ["Live"]

_HOST = r"[A-Za-z0-9.:_%-]{1,255}"
MOST_PORT = 65535


@value(init=False)
class Live(Value):
    """Settings of a run that can be seen and steered in a browser (docs/live.md).

    Attributes:
        port: the port of the page, which the image generator serves; if it is busy, the next ones are tried;
            0: any free port.
        host: the address to listen on; with any but a loopback address, everyone on the network can try to
            guess the token in the page's address.
        wait: whether the first frame waits for the first viewer.
        max_fps: the most pictures per second that a viewer gets.
        quality: JPEG quality, 1..100; a picture that stands still is sent again without loss.
        paused: whether the run starts paused.
    """

    port: int
    host: str
    wait: bool
    max_fps: float
    quality: int
    paused: bool

    def __init__(
        self,
        port: int = 8080,
        *,
        host: str = "127.0.0.1",
        wait: bool = False,
        max_fps: float = 30,
        quality: int = 85,
        paused: bool = False,
    ) -> None:
        """Check the fields."""
        if not isinstance(host, str) or not re.fullmatch(_HOST, host):
            raise ArgumentError("host", host, "an address or name of this machine, such as '127.0.0.1'")
        self.__dict__.update(
            port=arguments.integer("port", port, low=0, high=MOST_PORT),
            host=host,
            wait=arguments.flag("wait", wait),
            max_fps=arguments.number("max_fps", max_fps, low=0.1, high=1000),
            quality=arguments.integer("quality", quality, low=1, high=100),
            paused=arguments.flag("paused", paused),
        )


def checked(given: Any) -> Live | None:
    """Return MOTES_LIVE, or else `World`'s argument `live`, as a Live or None."""
    options = environment.read("MOTES_LIVE")
    if options is not None:
        return None if options == environment.LIVE_OFF else Live(**options)
    if given is None or isinstance(given, Live):
        return given
    if isinstance(given, bool) or not isinstance(given, int):
        raise ArgumentError("live", given, "None, a port or motes.Live(...)")
    if not 0 <= given <= MOST_PORT:
        raise ArgumentError("live", given, f"a port, 0..{MOST_PORT}")
    return Live(given)
