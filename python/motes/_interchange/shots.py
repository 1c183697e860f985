"""The part of a stage that `Export(scene=True)` adds: scenery, and sprites in their own forms."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from .._shot import stage
from .._shot.facts import ATTRIBUTES, CURVES, INSTANCES, Scene
from .._shot.words import asset
from .clips import clipped, declared
from .manifest import FrameParts, SystemColumns

__all__ = ["DRAWN", "Looks"]

DRAWN = "/drawn"
"""The path of what sprites make of particles in each layer."""


class Looks:
    """The looks that the sprites of systems have over the frames of an export."""

    def __init__(self, frames: Sequence[FrameParts], systems: Sequence[SystemColumns]) -> None:
        """Begin without looks: `number` collects them."""
        self._frames = [(frame.frame, frame.scene) for frame in frames if frame.scene is not None]
        self._systems = systems
        self._known: list[list[dict[str, Any]]] = [[] for _ in systems]

    def number(self, system: int, scene: Scene | None) -> int:
        """Return the number of a system's look in a frame; -1 if the frame has no scene."""
        if scene is None:
            return -1
        look, known = scene["looks"][str(system)], self._known[system]
        if look not in known:
            known.append(look)
        return known.index(look)

    def prim(
        self,
        name: str,
        system: int,
        look: int,
        primvars: Iterable[tuple[str, str]],
        files: Sequence[tuple[int, str]],
        folder: str,
    ) -> list[str]:
        """Return the prim of a part of a system.

        `primvars`: types and names of the system's own; `files`: the layer of each frame.
        """
        owner, facts = self._systems[system], self._known[system][look]
        form = facts["form"]
        whole = f"/World/{owner.stem}/{name}"
        lines = [line for names in _attributes(form, primvars) for line in declared(*names)]
        if form == CURVES:
            lines += ['uniform token type = "linear"']
        lines += [f"rel material:binding = <{stage.LOOKS}/{self._material(system, look)}>"]
        if form == INSTANCES:
            lines += _prototypes(facts["prototypes"], whole, folder)
        made = clipped(form, name, DRAWN, lines, owner.stem, files, folder)
        made.insert(1, '    prepend apiSchemas = ["MaterialBindingAPI"]')
        return made

    def scenery(self, folder: str) -> list[str]:
        """Return camera, lights, sky, solids and materials."""
        if not self._frames:
            return []
        looks = {
            self._material(system, number): look
            for system, known in enumerate(self._known)
            for number, look in enumerate(known)
        }
        return stage.scenery(self._frames, folder, looks)

    def settings(self) -> list[str]:
        """Return the prim, beside the world, that says how pictures are made."""
        return stage.settings(self._frames) if self._frames else []

    def _material(self, system: int, look: int) -> str:
        """Return the name of a material, which no solid has: theirs end in a number of one figure or more."""
        return f"of_{self._systems[system].stem}" + (f"_look{look + 1}" if look else "")


def _attributes(form: str, primvars: Iterable[tuple[str, str]]) -> Iterable[tuple[str, str, str]]:
    """Return type, name and interpolation of the attributes of a form."""
    each = "uniform" if form == CURVES else "vertex"
    for name, kind in ATTRIBUTES[form].items():
        fades = form == CURVES and name in ("widths", "primvars:displayOpacity")
        shaded = name == "widths" or name.startswith("primvars:")
        yield kind, name, ("vertex" if fades else each) if shaded else ""
    for kind, name in primvars:
        yield kind, name, each


def _prototypes(meshes: Sequence[str], whole: str, folder: str) -> list[str]:
    """Return the prototypes of instances, below them: elsewhere they would be seen themselves."""
    targets = ", ".join(f"<{whole}/Prototypes/Mesh_{number}>" for number in range(len(meshes)))
    lines = [f"rel prototypes = [{targets}]", 'def Scope "Prototypes"', "{"]
    for number, mesh in enumerate(meshes):
        lines += [
            f'    def Mesh "Mesh_{number}" (',
            f"        prepend references = {asset(folder, mesh)}",
            "    )",
            "    {",
            "    }",
        ]
    return [*lines, "}"]
