"""Pairs: the argument of a script's own procedure between particles (paper 3.1.5)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._values import arguments
from ..errors import ArgumentError

__all__ = ["Pairs", "changes_of"]


class Pairs:
    """Pairs of particles within reach of each other, one row per pair; read-only, valid during the call.

    Each pair appears once for each of its particles. `id`, `position` and `velocity` belong to a particle of
    this calculator; `other_id`, `other_position` and `other_velocity` to the other one, possibly a ghost.
    Shapes (n,) and (n, 3); m, m/s.
    """

    def __init__(
        self,
        ids: NDArray[np.uint64],
        other_ids: NDArray[np.uint64],
        position: NDArray[np.float32],
        other_position: NDArray[np.float32],
        velocity: NDArray[np.float32],
        other_velocity: NDArray[np.float32],
    ) -> None:
        """Store the views that the engine provides."""
        self.id = ids
        self.other_id = other_ids
        self.position = position
        self.other_position = other_position
        self.velocity = velocity
        self.other_velocity = other_velocity

    def __len__(self) -> int:
        """Count the pairs."""
        return len(self.id)

    def __repr__(self) -> str:
        """Show the number of pairs."""
        return f"<{len(self)} pairs>"


def changes_of(pairs: Pairs, function: Callable[[Pairs], object]) -> NDArray[np.float32] | None:
    """Call a function of pairs; return its result, checked, as an array of changes of velocity, m/s."""
    changes: Any = function(pairs)
    if changes is None:
        return None
    shape = (len(pairs), 3)
    allowed = f"the velocity change of each pair's own particle: numbers of shape {shape}, or None"
    array = arguments.floats("the result of a procedure of pairs", changes, np.float32, allowed)
    if array.shape != shape:
        raise ArgumentError("the result of a procedure of pairs", array.shape, allowed)
    return np.ascontiguousarray(array)
