"""Every error that motes raises on purpose. Their common base is `MotesError`."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

__all__ = [
    "ArgumentError",
    "CheckpointError",
    "LogError",
    "MissingExtraError",
    "MotesError",
    "MotesWarning",
    "NotAssignableError",
    "NotHereError",
    "RankError",
    "ScriptMismatchError",
    "Stopped",
]


def __dir__() -> list[str]:
    return [*__all__]


class MotesError(Exception):
    """Base class of all errors of motes."""

    speaker: int | None = None
    """The only rank that prints this error, if all ranks raise it together; otherwise None."""
    lost: bool = False
    """Whether ranks were lost with their particles: a restart from a checkpoint may succeed."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by attributes: ranks send errors to each other, and the constructors take keywords."""
        return _rebuild, (type(self), self.args, self.__dict__)


def _rebuild(kind: type[MotesError], args: tuple[Any, ...], attributes: dict[str, Any]) -> MotesError:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(attributes)
    return error


class ArgumentError(MotesError, ValueError):
    """A call got an invalid value; the message names the argument, the value and what is allowed."""

    def __init__(
        self, argument: str, value: object, allowed: str, *, known: Iterable[str] = (), hint: str = ""
    ) -> None:
        """Say what an argument must be, and what was given.

        Args:
            argument: the argument's name.
            value: the value that was given.
            allowed: what the value must be.
            known: valid names; the one closest to `value` is suggested.
            hint: more advice, added to the message.
        """
        more = near(value, known) + (f"; {hint}" if hint else "")
        super().__init__(f"{argument} must be {allowed}, got {_short(value)}{more}")
        self.argument = argument
        self.value = value
        self.allowed = allowed


class RankError(MotesError, RuntimeError):
    """One rank failed; all ranks raise this together at the end of the frame."""

    def __init__(
        self,
        text: str,
        *,
        rank: int,
        role: str = "",
        frame: int | None = None,
        action: str | None = None,
        line: str | None = None,
        speaker: int | None = None,
    ) -> None:
        """Name who failed, when and in which action.

        Args:
            text: what went wrong.
            rank: the rank that failed.
            role: the role of that rank.
            frame: the frame in which it failed.
            action: the action in which it failed.
            line: the line of the script, as "snow.py:21".
            speaker: the only rank that prints the error.
        """
        where = place(rank, role=role, frame=frame)
        if action is not None:
            where += f", {action}"
        if line is not None:
            where += f" at {line}"
        super().__init__(f"{where}: {text}")
        self.text = text
        self.rank = rank
        self.role = role
        self.frame = frame
        self.action = action
        self.line = line
        self.speaker = speaker


class ScriptMismatchError(MotesError, RuntimeError):
    """Ranks recorded different lists in the same frame: the script did not make the same calls everywhere."""

    def __init__(self, text: str, *, frame: int, ranks: tuple[int, ...], speaker: int | None = None) -> None:
        """Say which ranks differ, and in what.

        Args:
            text: names the first rank that differs from the majority, the frame and what differs.
            frame: the frame in which they differ.
            ranks: the ranks that differ from the majority.
            speaker: the only rank that prints the error.
        """
        super().__init__(text)
        self.text = text
        self.frame = frame
        self.ranks = ranks
        self.speaker = speaker


class Stopped(SystemExit):
    """SIGINT, SIGTERM or SIGUSR1 has stopped the run: `render` and `step` raise this from then on.

    Like `sys.exit(code)`, it ends the script without an error: `with world:` ends the run cleanly on all
    ranks, and movies are closed, not removed. The exit code is 130 after SIGINT, 143 after the other two.
    """


class NotHereError(MotesError, AttributeError):
    """The requested data is on another rank."""


class NotAssignableError(MotesError, AttributeError):
    """An assignment to an attribute that cannot be assigned; the message says what to do instead."""


class CheckpointError(MotesError):
    """A checkpoint cannot be written, or cannot be trusted."""


class LogError(MotesError):
    """A run's log cannot be written or read."""


EXTRAS = {
    "video": ("av>=15",),
    "analysis": ("pandas>=2", "matplotlib>=3.8", "brotli>=1.1"),
    "exr": ("OpenEXR>=3.3",),
    "image": ("Pillow>=10.1",),
    "live": ("websockets>=13", "simplejpeg>=1.8"),
    "mesh": ("DracoPy>=2.0",),
    "notebook": ("websockets>=13", "simplejpeg>=1.8", "anywidget>=0.9"),
    "usd": ("usd-core>=24.11",),
    "otf2": ("otf2>=3.2",),
}
"""The optional packages of `pip install ".[EXTRA]"`, as in pyproject.toml."""


class MissingExtraError(MotesError, ImportError):
    """An optional package is not installed; the message says how to install it."""

    def __init__(self, need: str, *, extra: str, package: str, reason: object = None) -> None:
        """Say what needs the package and how to install it.

        Args:
            need: what needs the package, such as "Movie".
            extra: a name of `EXTRAS`.
            package: the missing package.
            reason: why it cannot be imported; None: it is not installed.
        """
        wanted = " ".join(f'"{name}"' for name in EXTRAS[extra])
        why = "which is not installed" if reason is None else f"which cannot be imported ({reason})"
        super().__init__(
            f"{need} needs {package}, {why}; install it with `{sys.executable} -m pip install {wanted}` "
            f'(in a clone of motes: pip install ".[{extra}]")'
        )
        self.name = package
        self.extra = extra

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the name too: ImportError does not keep it in `__dict__`."""
        return _missing_extra, (self.args, self.name, self.extra)


def _missing_extra(args: tuple[Any, ...], package: str, extra: str) -> MissingExtraError:
    error = MissingExtraError.__new__(MissingExtraError, *args)
    error.args, error.name, error.extra = args, package, extra
    return error


class MotesWarning(UserWarning):
    """The script runs, but probably does not do what its author intended."""


def near(name: object, known: Iterable[str]) -> str:
    """Return a suggestion of the closest known name, such as "; did you mean 'velocity'?", or ""."""
    if not isinstance(name, str) or name.startswith("__"):  # Python looks up `__path__` in each module
        return ""
    import difflib

    names = list(known)
    meant = [one for one in _MEANT.get(name, ()) if one.partition("=")[0] in names]
    matches = meant or difflib.get_close_matches(name, names, n=1)
    return f"; did you mean {matches[0]!r}?" if matches else ""


_MEANT = {
    **{"fps": ("dt=1/fps",), "frame_rate": ("dt=1/frame_rate",), "timestep": ("dt",), "time_step": ("dt",)},
    **{"size": ("pixels", "radius"), "diameter": ("pixels",), "width": ("pixels",), "texture": ("image",)},
    **{"colour": ("color",), "opacity": ("alpha",), "steps": ("substeps",), "bounds": ("space",)},
    **{"pos": ("position",), "vel": ("velocity",), "target": ("look_at",), "fov": ("fov_deg",)},
    **{"resolution": ("width",), "bg": ("background",), "n": ("count",), "number": ("count",)},
}
"""Names that other programs use -> the names that motes may have for them."""


def missing(owner: str, name: str, known: Iterable[str]) -> AttributeError:
    """Return the error for an attribute that does not exist, suggesting the closest one that does."""
    # Since `name` is given, Python adds no suggestion.
    return AttributeError(f"{owner} has no attribute {name!r}{near(name, known)}", name=name, obj=None)


def missing_package(need: str, package: str, what: str) -> MissingExtraError:
    """Return the error for a package of motes itself that this installation leaves out.

    Args:
        need: what needs the package.
        package: the missing package.
        what: what the package is.
    """
    text = (
        f"{need} needs {what}, the package {package}, which is not installed; in a clone of motes, "
        f"`{sys.executable} -m pip install .` installs it together with the engine"
    )
    return _missing_extra((text,), package, "")


def argument_error(text: str, argument: str = "", value: str = "", allowed: str = "") -> ArgumentError:
    """Return an error with the engine's message `text` and its parts; some messages have only a text."""
    error = ArgumentError.__new__(ArgumentError, text)
    error.args = (text,)
    error.argument, error.value, error.allowed = argument, value or None, allowed
    return error


def place(rank: int, *, role: str = "", frame: int | None = None) -> str:
    """Name a rank the way every message does: "rank 2 (calculator 0), frame 7"."""
    text = f"rank {rank} ({role})" if role else f"rank {rank}"
    return text if frame is None else f"{text}, frame {frame}"


def _short(value: object, *, limit: int = 200) -> str:
    try:
        text = repr(value)
    except Exception:  # raised by a user's class, or for an int with more digits than Python converts
        text = f"a value of type {type(value).__name__}"
    return text if len(text) <= limit else text[: limit - 3] + "..."
