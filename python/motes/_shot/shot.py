"""Shot: what an export knows of the pictures' surroundings between its frames."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .._picture.rendering import Renderer
from .._picture.sprites import Sprite
from .facts import Scene
from .files import Files
from .looks import look_of
from .scene import scene_of

__all__ = ["Shot"]


class Shot:
    """Notes the scene of each frame on the script's thread, and writes its files on another."""

    def __init__(self) -> None:
        """Begin without a frame."""
        self._waiting: deque[Files] = deque()
        self._written: set[str] = set()
        self._looks: dict[int, tuple[Sprite, dict[str, Any]]] = {}

    def take(self, renderer: Renderer, time: float, sprites: Sequence[Sprite], before: Scene | None) -> Scene:
        """Return what a frame shows; `time`: of the renderer's curves, s; `before`: the frame before."""
        files = Files()
        scene = scene_of(renderer, time, files, before)
        for system, sprite in enumerate(sprites):
            if system not in self._looks or self._looks[system][0] is not sprite:
                self._looks[system] = sprite, look_of(sprite, files)
            scene["looks"][str(system)] = self._looks[system][1]
        self._waiting.append(files)
        return scene

    def write(self, folder: Path) -> None:
        """Write the files of all frames noted so far that the folder lacks."""
        while self._waiting:
            self._waiting[0].write(folder, self._written)
            self._waiting.popleft()
