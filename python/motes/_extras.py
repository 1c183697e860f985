"""Import optional packages when they are needed; raise `MissingExtraError` if they are not installed.

One of them is the laboratory, the package `motes_lab`. Nothing else in the engine knows it.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import os
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from .errors import MissingExtraError, missing_package

__all__ = [
    *("find_laboratory", "has_laboratory", "laboratory"),
    *("av", "draco", "matplotlib", "openexr", "pandas", "pillow", "require_av", "require_live"),
    *(
        "require_anywidget",
        "require_openexr",
        "require_pillow",
        "require_usd",
        "simplejpeg",
        "brotli",
        "otf2",
        "usd",
        "usd_writer",
        "websockets",
    ),
]

_EXR = "saving a picture as .exr"
_LIVE = "a live run"
_LABORATORY = "motes_lab"
_ROOMS = ("arena", "bench", "cluster", "course", "workloads")


def pandas(need: str = "a table of a run's log") -> Any:
    """Import pandas. Raises MissingExtraError if it is not installed."""
    return _import("pandas", need, "analysis")


def matplotlib(module: str = "matplotlib") -> Any:
    """Import matplotlib, or one of its modules. Raises MissingExtraError if it is not installed."""
    return _import(module, "a plot of a run's log", "analysis")


def require_av(need: str) -> None:
    """Raise MissingExtraError if PyAV is not installed; does not import it."""
    if importlib.util.find_spec("av") is None:
        raise MissingExtraError(need, extra="video", package="av")


def av(need: str) -> Any:
    """Import PyAV. Raises MissingExtraError if it is not installed."""
    return _import("av", need, "video")


def openexr() -> Any:
    """Import OpenEXR. Raises MissingExtraError if it is not installed."""
    return _import("OpenEXR", _EXR, "exr")


def require_openexr() -> None:
    """Raise MissingExtraError if OpenEXR is not installed; does not import it."""
    if importlib.util.find_spec("OpenEXR") is None:
        raise MissingExtraError(_EXR, extra="exr", package="OpenEXR")


def require_pillow(need: str) -> None:
    """Raise MissingExtraError if Pillow is not installed; does not import it."""
    if importlib.util.find_spec("PIL") is None:
        raise MissingExtraError(need, extra="image", package="Pillow")


def pillow(module: str = "PIL.Image", need: str = "a sprite image given as a path") -> Any:
    """Import a module of Pillow, which reads pictures. Raises MissingExtraError if it is not installed."""
    return _import(module, need, "image", package="Pillow")


def require_live(need: str = _LIVE) -> None:
    """Raise MissingExtraError if a package that live runs need is not installed; imports none of them."""
    for package in ("websockets", "simplejpeg"):
        if importlib.util.find_spec(package) is None:
            raise MissingExtraError(need, extra="live" if need == _LIVE else "notebook", package=package)


def require_anywidget() -> None:
    """Raise MissingExtraError if anywidget is not installed; does not import it."""
    if importlib.util.find_spec("anywidget") is None:
        raise MissingExtraError("the widget of a run", extra="notebook", package="anywidget")


def simplejpeg() -> Any:
    """Import simplejpeg. Raises MissingExtraError if it is not installed."""
    return _import("simplejpeg", _LIVE, "live")


def websockets(part: str) -> Any:
    """Import a part of websockets: "asyncio.server". Raises MissingExtraError if it is not installed."""
    return _import(f"websockets.{part}", _LIVE, "live")


def otf2() -> Any:
    """Import OTF2's package. Raises MissingExtraError if it is not installed."""
    module = _import("otf2", "writing OTF2 archives", "otf2")
    for part in ("enums", "writer"):
        _import(f"otf2.{part}", "writing OTF2 archives", "otf2")
    return module


def brotli() -> Any:
    """Import Brotli. Raises MissingExtraError if it is not installed."""
    return _import("brotli", "a compressed load file", "analysis")


def draco(need: str) -> Any:
    """Import DracoPy. Raises MissingExtraError if it is not installed."""
    return _import("DracoPy", need, "mesh")


def usd(need: str) -> Any:
    """Import the parts of USD that write and read layers. Raises MissingExtraError if it is not installed."""
    for part in ("Sdf", "Tf", "Vt"):
        _import(f"pxr.{part}", need, "usd", package="usd-core")
    return importlib.import_module("pxr")


def usd_writer(need: str) -> Any:
    """Import USD for writing, limited to one thread: USD's idle threads spin on cores that others need."""
    # USD reads these variables when it is first imported.
    with _environment(PXR_WORK_THREAD_LIMIT="1", TF_ENV_SETTING_ALERTS_ENABLED="0"):
        return usd(need)


@contextlib.contextmanager
def _environment(**wishes: str) -> Iterator[None]:
    """Set environment variables that are not set yet; remove them on exit."""
    own = {name: value for name, value in wishes.items() if name not in os.environ}
    os.environ.update(own)
    try:
        yield
    finally:
        for name in own:
            os.environ.pop(name, None)


def require_usd(need: str) -> None:
    """Raise MissingExtraError if USD is not installed; does not import it."""
    if importlib.util.find_spec("pxr") is None:
        raise MissingExtraError(need, extra="usd", package="usd-core")


def _import(module: str, need: str, extra: str, *, package: str | None = None) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        top = module.partition(".")[0]
        reason = None if isinstance(error, ModuleNotFoundError) and error.name == top else error
        raise MissingExtraError(need, extra=extra, package=package or top, reason=reason) from error


def laboratory(name: str, need: str) -> ModuleType:
    """Import a module of the laboratory, such as "cluster". Raises MissingExtraError if it is absent."""
    try:
        return importlib.import_module(f"{_LABORATORY}.{name}")
    except ModuleNotFoundError as error:
        if error.name != _LABORATORY:
            raise
        raise missing_package(need, _LABORATORY, "motes's laboratory") from None


def has_laboratory() -> bool:
    """Return whether the laboratory is installed; does not import it."""
    return importlib.util.find_spec(_LABORATORY) is not None


def find_laboratory() -> None:
    """Let `import motes.cluster` load `motes_lab.cluster`: both names then stand for one module."""
    sys.meta_path.insert(0, _Rooms())


class _Rooms:
    """Finds modules of the laboratory by their names in `motes`, and loads them."""

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return a spec for a room, or for a module in it; None for all others."""
        package, *parts = name.split(".")
        if package != __package__ or not parts or parts[0] not in _ROOMS:
            return None
        return ModuleSpec(name, self)  # type: ignore[arg-type]  # importlib.abc has the base, but loads slowly

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Import the module by its own name."""
        module = laboratory(spec.name.partition(".")[2], spec.name)
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Give the module back its own spec; it has run already."""
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state
