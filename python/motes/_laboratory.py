"""Leads from the engine to the laboratory, the package `motes_lab`, where it is installed.

Nothing else in the engine knows the laboratory. Its rooms are modules of `motes`, too: `import motes.cluster`
loads `motes_lab.cluster`, and both names stand for the same module.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType

__all__ = ["install", "load"]

LABORATORY = "motes_lab"
ROOMS = ("arena", "bench", "cluster", "course", "workloads")


def load(name: str, need: str) -> ModuleType:
    """Import a module of the laboratory. Raises MissingExtraError if it is not installed.

    Args:
        name: the module's name in the laboratory, such as "cluster".
        need: what needs the module, for the error.
    """
    try:
        return importlib.import_module(f"{LABORATORY}.{name}")
    except ModuleNotFoundError as error:
        if error.name != LABORATORY:
            raise
        from .errors import missing_package

        raise missing_package(need, LABORATORY, "motes's laboratory") from None


class _Rooms:
    """Finds modules of the laboratory by their names in `motes`, and loads them."""

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return a spec for a room, or for a module in it; None for all others."""
        package, *parts = name.split(".")
        if package != __package__ or not parts or parts[0] not in ROOMS:
            return None
        return ModuleSpec(name, self)  # type: ignore[arg-type]  # importlib.abc has the base, but loads slowly

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Import the module by its own name."""
        module = load(spec.name.partition(".")[2], spec.name)
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Give the module back its own spec; it has run already."""
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state


def install() -> None:
    """Let import statements find the rooms."""
    sys.meta_path.insert(0, _Rooms())
