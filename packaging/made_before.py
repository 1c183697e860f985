"""Finds a wheel in `dist` that was built from the same sources, for this Python and this kind of machine."""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from packaging.tags import sys_tags
from packaging.utils import InvalidWheelFilename, parse_wheel_filename

__all__ = ["sources", "wheel_of"]

ROOT = Path(__file__).resolve().parents[1]
_BUILT_FROM = "motes/built_from"  # cpp/CMakeLists.txt
_PARTS = (
    "CMakeLists.txt",
    "pyproject.toml",
    "README.md",
    "LICENSE",
    "cpp",
    "examples",
    "packaging",
    "python",
)


def sources(root: Path = ROOT) -> str:
    """Return a fingerprint of the files that a wheel depends on."""
    found = hashlib.sha256()
    files = [path for part in _PARTS for path in (root / part, *(root / part).rglob("*")) if path.is_file()]
    for path in sorted(files):
        if path.suffix not in (".so", ".pyc"):
            content = hashlib.sha256(path.read_bytes()).hexdigest()
            found.update(f"{path.relative_to(root)} {content}\n".encode())
    return found.hexdigest()


def wheel_of(config_settings: Mapping[str, Any] | None, root: Path = ROOT) -> Path | None:
    """Return a wheel of these sources, or None: also where the build is to have settings of its own."""
    wheels = sorted((root / "dist").glob("motes-*.whl"))
    if not wheels or config_settings or os.environ.get("MPICC"):
        return None
    wanted, tags = sources(root), set(sys_tags())
    return next((wheel for wheel in wheels if _fits(wheel, tags) and _built_from(wheel) == wanted), None)


def _fits(wheel: Path, tags: set[Any]) -> bool:
    try:
        return not tags.isdisjoint(parse_wheel_filename(wheel.name)[3])
    except InvalidWheelFilename:
        return False


def _built_from(wheel: Path) -> str:
    try:
        with zipfile.ZipFile(wheel) as archive:
            return archive.read(_BUILT_FROM).decode().strip()
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        return ""
