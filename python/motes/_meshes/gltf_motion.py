"""Animations of glTF files: where nodes are at a time. Of several that move a node, the first one counts."""

from __future__ import annotations

from typing import Any

import numpy as np

from .accessors import Accessors
from .polygons import Floats, Unreadable

__all__ = ["Motion"]

_PATHS = ("translation", "rotation", "scale", "weights")


class Motion:
    """The key frames of a document's nodes."""

    def __init__(self, document: dict[str, Any], accessors: Accessors) -> None:
        """Read all key frames. Raises Unreadable."""
        self._document = document
        self._moved: dict[tuple[int, str], tuple[Floats, Floats, str]] = {}
        for animation in document.get("animations", ()):
            for channel in animation["channels"]:
                target, sampler = channel["target"], animation["samplers"][channel["sampler"]]
                key = target.get("node", -1), target["path"]
                if key[0] < 0 or key[1] not in _PATHS or key in self._moved:
                    continue
                times = accessors.read(sampler["input"]).astype(np.float64)[:, 0]
                kind = sampler.get("interpolation", "LINEAR")
                rows = accessors.read(sampler["output"]).astype(np.float64)
                per = 3 if kind == "CUBICSPLINE" else 1
                if not len(times) or rows.size % (len(times) * per):
                    raise Unreadable(f"an animation has {rows.size} numbers for {len(times)} key frames")
                self._moved[key] = times, rows.reshape(len(times), per, -1), kind

    def times(self) -> list[float]:
        """Return the times of all key frames, s, ascending."""
        return sorted({float(time) for times, _, _ in self._moved.values() for time in times})

    def posed(self, time: float) -> dict[str, Any]:
        """Return the document with its nodes as they are at a time, s."""
        nodes = [dict(node) for node in self._document.get("nodes", ())]
        for (node, path), keys in self._moved.items():
            nodes[node].pop("matrix", None)  # nodes that are animated have none
            nodes[node][path] = _between(*keys, time, turns=path == "rotation").tolist()
        return self._document | {"nodes": nodes}


def _between(times: Floats, rows: Floats, kind: str, time: float, *, turns: bool) -> Floats:
    """Return the value of key frames at a time; `rows`: (keys, 1, width), of splines (keys, 3, width)."""
    values = rows[:, rows.shape[1] // 2]
    after = int(np.searchsorted(times, time, side="right"))
    if after in (0, len(times)):
        found = values[min(after, len(times) - 1)]
    elif kind == "STEP":
        found = values[after - 1]
    else:
        length = times[after] - times[after - 1]
        part, p, q = (time - times[after - 1]) / length, values[after - 1], values[after]
        if kind == "CUBICSPLINE":
            leave, arrive = rows[after - 1, 2] * length, rows[after, 0] * length
            left = 1 - part
            way = part * part * (3 - 2 * part)
            found = p + (q - p) * way + part * left * (leave * left - arrive * part)
        else:
            found = _turned(p, q, part) if turns else p + (q - p) * part
    return np.asarray(found / np.linalg.norm(found)) if turns else np.asarray(found)


def _turned(p: Floats, q: Floats, part: float) -> Floats:
    """Return the rotation between two, the shorter way at constant speed."""
    cosine = float(p @ q)
    q, cosine = (-q, -cosine) if cosine < 0 else (q, cosine)
    if cosine > 0.9995:
        return np.asarray(p + (q - p) * part)
    angle = np.arccos(cosine)
    return np.asarray((np.sin((1 - part) * angle) * p + np.sin(part * angle) * q) / np.sin(angle))
