"""The build backend: scikit-build-core, unless `dist` has a wheel of the same sources for this Python.

So a checkout with such a wheel is installed in seconds, without a compiler, by the same command.
"""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from made_before import sources, wheel_of
from scikit_build_core import build
from scikit_build_core.build import (
    build_editable,
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]


def get_requires_for_build_wheel(config_settings: Mapping[str, Any] | None = None) -> list[str]:
    """Return what the build needs: CMake and Ninja, where there are none and a build is needed."""
    return [] if wheel_of(config_settings) else build.get_requires_for_build_wheel(config_settings)


def prepare_metadata_for_build_wheel(
    metadata_directory: str, config_settings: Mapping[str, Any] | None = None
) -> str:
    """Write the wheel's metadata; return the name of their folder."""
    if (made := wheel_of(config_settings)) is None:
        return build.prepare_metadata_for_build_wheel(metadata_directory, config_settings)
    with zipfile.ZipFile(made) as archive:
        names = [name for name in archive.namelist() if name.split("/")[0].endswith(".dist-info")]
        archive.extractall(metadata_directory, names)
    return names[0].split("/")[0]


def build_wheel(
    wheel_directory: str,
    config_settings: Mapping[str, Any] | None = None,
    metadata_directory: str | None = None,
) -> str:
    """Copy the wheel that was made before, or make one that knows its sources; return its name."""
    if (made := wheel_of(config_settings)) is not None:
        if made.parent != Path(wheel_directory).resolve():
            shutil.copy(made, wheel_directory)
        return made.name
    settings = {"cmake.define.MOTES_SOURCES": sources(), **(config_settings or {})}
    return build.build_wheel(wheel_directory, settings, metadata_directory)
