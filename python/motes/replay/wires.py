"""How long messages take, from the links that a run measured when it started."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["Wires"]

BULK = 16384
"""Bytes from which a message waits for its receiver, and occupies the links of both hosts."""


class Wires:
    """The network: each host has a link, with full bandwidth both ways; ranks of one host use memory."""

    def __init__(self, links: DataFrame, hosts: Mapping[int, str]) -> None:
        """Set the network.

        Args:
            links: the log's table `links`; empty: messages take no time.
            hosts: host of each rank.
        """
        self._hosts = hosts
        self._known: dict[tuple[str, str], tuple[float, float]] = {}
        self._usual: dict[bool, tuple[float, float]] = {}
        self._links: dict[tuple[int, int], tuple[float, float]] = {}
        if len(links):
            rows = links[links["frame"] == links["frame"].min()]
            samples: dict[tuple[str, str], list[tuple[float, float]]] = {}
            for one, other, message_s, byte_s in zip(
                rows["rank"], rows["other"], rows["message_s"], rows["byte_s"], strict=True
            ):
                samples.setdefault(self._ends(int(one), int(other)), []).append((message_s, byte_s))
            self._known = {ends: _median(found) for ends, found in samples.items()}
            for same in (True, False):
                found = [
                    row for ends, rows in samples.items() if (ends[0] == ends[1]) == same for row in rows
                ]
                self._usual[same] = _median(found or [row for rows in samples.values() for row in rows])
        self.known = bool(self._known)
        self._up: dict[str, float] = {}
        self._down: dict[str, float] = {}

    def idle(self) -> Wires:
        """Return the same network, with nothing on its way."""
        other = copy.copy(self)
        other._up, other._down = {}, {}
        return other

    def arrive(self, sent: float, source: int, to: int, size: float, ready: float) -> float:
        """Send a message; return when its receiver has it, which is not before `ready`, s.

        Args:
            sent: when it is sent, s.
            source: rank that sends.
            to: rank that receives.
            size: bytes.
            ready: when the receiver starts to wait for it, s.
        """
        if source == to:
            return max(sent, ready)
        message_s, byte_s = self._link(source, to)
        took = message_s + size * byte_s
        if size < BULK:
            return max(ready, sent + took)
        start = max(sent, ready)
        source_host, host = self._host(source), self._host(to)
        if source_host == host:
            return start + took
        start = max(start, self._up.get(source_host, -np.inf), self._down.get(host, -np.inf))
        self._up[source_host] = self._down[host] = start + size * byte_s
        return start + took

    def _link(self, one: int, other: int) -> tuple[float, float]:
        if (one, other) not in self._links:
            ends = self._ends(one, other)
            self._links[one, other] = self._known.get(ends) or self._usual.get(ends[0] == ends[1], (0.0, 0.0))
        return self._links[one, other]

    def _host(self, rank: int) -> str:
        return self._hosts.get(rank, "")

    def _ends(self, one: int, other: int) -> tuple[str, str]:
        low, high = sorted((self._host(one), self._host(other)))
        return low, high


def _median(rows: list[tuple[float, float]]) -> tuple[float, float]:
    message_s, byte_s = np.median(np.asarray(rows, np.float64), axis=0)
    return float(message_s), float(byte_s)
