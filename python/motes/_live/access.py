"""Decides who may view and steer: anyone with the token, from a page of this server."""

from __future__ import annotations

import hmac
import ipaddress
import socket
from urllib.parse import parse_qs, urlsplit

__all__ = ["from_afar", "has_token", "is_local", "own_page"]

_LOCAL_NAMES = ("localhost",)


def has_token(target: str, token: str) -> bool:
    """Return whether the requested address, such as /?k=..., has the token."""
    try:
        given = parse_qs(urlsplit(target).query).get("k", [""])[0]
    except ValueError:
        return False
    return hmac.compare_digest(given.encode(errors="replace"), token.encode())


def own_page(origin: str | None, host: str | None, *, local: bool) -> bool:
    """Return whether a connection comes from a page of this server, or from a program, which has no origin.

    `host` is the request's Host header; behind a tunnel its port may differ from the server's. `local`: the
    server listens on the loopback interface only, and refuses hosts of other names (DNS rebinding).
    """
    if local and not is_local(_name_of(f"//{host}")):
        return False
    if origin is None:
        return True
    parts = urlsplit(origin)
    return parts.scheme in ("http", "https") and host is not None and parts.netloc.lower() == host.lower()


def is_local(name: str | None) -> bool:
    """Return whether a name or an address is loopback."""
    if name is None:
        return False
    if name.lower() in _LOCAL_NAMES:
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False


def from_afar(host: str, port: int) -> str:
    """Return how a browser on another machine reaches a server here."""
    machine = socket.gethostname()
    if is_local(host):
        shown = f"[{host}]" if ":" in host else host
        return f"from another machine: ssh -L {port}:{shown}:{port} {machine}"
    return f"from another machine: the same, or ssh -L {port}:{machine}:{port} {machine}"


def _name_of(address: str) -> str | None:
    try:
        return urlsplit(address).hostname
    except ValueError:
        return None
