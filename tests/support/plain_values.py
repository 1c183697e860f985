"""Shared by tests of values: an image, a mesh, invalid numbers, and constructors of values."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

from motes.errors import NotAssignableError

__all__ = ["CORNERS", "FACES", "INF", "LEAF", "NAN", "equal_and_immutable"]

LEAF = np.arange(4 * 6 * 4, dtype=np.uint8).reshape(4, 6, 4)
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]

NAN, INF = float("nan"), float("inf")


def equal_and_immutable(one: Any, other: Any) -> None:
    """Check that two values made in the same way are equal, have equal copies, and refuse assignment."""
    assert one is not other
    assert one == other
    assert hash(one) == hash(other)
    for again in (copy.copy(one), copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert again == one
        assert hash(again) == hash(one)
    with pytest.raises(NotAssignableError):
        one.color = 3
