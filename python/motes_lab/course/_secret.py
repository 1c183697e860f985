"""Random numbers from a key: unpredictable without it, and the same with every release of NumPy."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from typing import TypeVar

import numpy as np

from motes.replay.history import Floats

__all__ = ["PRACTICE", "Secret"]

T = TypeVar("T")

PRACTICE = "practice"
"""The public key, for practice."""


class Secret:
    """A stream of random numbers: SHA-256 of a key, a purpose and a counter."""

    def __init__(self, key: str, purpose: str) -> None:
        """`key` is the teacher's; `purpose`, such as "3 burst", selects one of many independent streams."""
        self._stream = _words(f"motes course\n{key}\n{purpose}")

    def uniform(self, low: float = 0.0, high: float = 1.0) -> float:
        """Draw a number in low..high."""
        return low + (high - low) * next(self._stream)

    def whole(self, low: int, high: int) -> int:
        """Draw a whole number in low..high, both included."""
        return low + int((high - low + 1) * next(self._stream))

    def one_of(self, choices: Sequence[T]) -> T:
        """Draw one of the choices."""
        return choices[self.whole(0, len(choices) - 1)]

    def shuffled(self, values: Sequence[T]) -> list[T]:
        """Return the values in random order."""
        left = list(values)
        return [left.pop(self.whole(0, len(left) - 1)) for _ in values]

    def noise(self, shape: tuple[int, int], deviation: float) -> Floats:
        """Draw nearly normal errors around 0: each is the sum of twelve uniform numbers."""
        count = 12 * shape[0] * shape[1]
        draws = np.fromiter((next(self._stream) for _ in range(count)), np.float64, count)
        errors: Floats = deviation * (draws.reshape(*shape, 12).sum(axis=-1) - 6.0)
        return errors


def _words(seed: str) -> Iterator[float]:
    counter = 0
    while True:
        block = hashlib.sha256(f"{seed}\n{counter}".encode()).digest()
        for at in range(0, len(block), 8):
            yield (int.from_bytes(block[at : at + 8]) >> 11) / 2.0**53
        counter += 1
