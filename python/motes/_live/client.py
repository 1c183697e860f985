"""The way of this computer's programs to a live run's server, for which they are viewers."""

from __future__ import annotations

import inspect
from typing import Any
from urllib.parse import urlsplit

from .. import _extras

__all__ = ["closed", "connect", "load"]


def load() -> None:
    """Import what `connect` needs. A library may not begin in two threads at once."""
    for part in ("asyncio.client", "exceptions"):
        _extras.websockets(part)


def connect(url: str, query: str = "") -> Any:
    """Return the connection to the run whose page has this address, to be entered; `query` is added to it."""
    start = _extras.websockets("asyncio.client").connect
    options: dict[str, Any] = {"max_size": None, "compression": None}
    if "proxy" in inspect.signature(start).parameters:
        options["proxy"] = None  # no proxy for this machine
    parts = urlsplit(url)
    return start(f"ws://{parts.netloc}/live?{parts.query}{query}", **options)


def closed() -> type[Exception]:
    """Return the exception that tells that a connection is closed."""
    error: type[Exception] = _extras.websockets("exceptions").ConnectionClosed
    return error
