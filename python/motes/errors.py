"""Every error that motes raises on purpose. `MotesError` stands above all of them."""

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
    """Base of all errors of motes."""

    speaker: int | None = None
    """The one rank that prints, for an error that all ranks raise together by agreement; else None."""
    lost: bool = False
    """Whether ranks were lost with what they held: another start, from a checkpoint, may come to the end."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by attributes: ranks send errors to each other, and constructors take keywords."""
        return _rebuild, (type(self), self.args, self.__dict__)


def _rebuild(kind: type[MotesError], args: tuple[Any, ...], attributes: dict[str, Any]) -> MotesError:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(attributes)
    return error


class ArgumentError(MotesError, ValueError):
    """A call got a value that it cannot use; names the argument, the value and what is allowed."""

    def __init__(
        self, argument: str, value: object, allowed: str, *, known: Iterable[str] = (), hint: str = ""
    ) -> None:
        """Say what an argument must be, and what it is instead.

        Args:
            argument: its name.
            value: what was given.
            allowed: what it must be.
            known: names, of which the one nearest to `value` is suggested.
            hint: what else helps.
        """
        more = near(value, known) + (f"; {hint}" if hint else "")
        super().__init__(f"{argument} must be {allowed}, got {_short(value)}{more}")
        self.argument = argument
        self.value = value
        self.allowed = allowed


class RankError(MotesError, RuntimeError):
    """One rank failed; every rank raises this together at the end of the frame."""

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
            rank: that failed.
            role: of that rank.
            frame: in which it failed.
            action: in which it failed.
            line: of the script, as "snow.py:21".
            speaker: the one rank that prints the error.
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
    """Ranks recorded different lists in the same frame: the script does not do the same on every rank."""

    def __init__(self, text: str, *, frame: int, ranks: tuple[int, ...], speaker: int | None = None) -> None:
        """Say which ranks differ, and in what.

        Args:
            text: names the first of the ranks that differ from most others, the frame and what differs.
            frame: in which they differ.
            ranks: those that differ.
            speaker: the one rank that prints the error.
        """
        super().__init__(text)
        self.text = text
        self.frame = frame
        self.ranks = ranks
        self.speaker = speaker


class Stopped(SystemExit):
    """SIGINT, SIGTERM or SIGUSR1 has stopped the run: `render` and `step` raise this from then on.

    Like `sys.exit(code)` it ends the script, without an error: `with world:` ends the run in an orderly way
    on all ranks, and a movie is closed, not removed. The code is 130 after SIGINT, 143 after the other two.
    """


class NotHereError(MotesError, AttributeError):
    """What was asked for is on another rank."""


class NotAssignableError(MotesError, AttributeError):
    """An assignment to something that cannot be assigned; says what to do instead."""


class CheckpointError(MotesError):
    """A checkpoint cannot be written, or cannot be trusted."""


class LogError(MotesError):
    """A run's log cannot be written or read."""


EXTRAS = {
    "video": ("av>=15",),
    "analysis": ("pandas>=2", "matplotlib>=3.8"),
    "exr": ("OpenEXR>=3.3",),
    "image": ("Pillow>=10",),
    "live": ("websockets>=13", "simplejpeg>=1.8"),
    "mesh": ("DracoPy>=2.0",),
    "notebook": ("websockets>=13", "simplejpeg>=1.8", "anywidget>=0.9"),
    "usd": ("usd-core>=24.11",),
    "otf2": ("otf2>=3.0",),
}
"""The optional packages of `pip install ".[EXTRA]"`, as in pyproject.toml."""


class MissingExtraError(MotesError, ImportError):
    """A package that only this part of motes needs is not installed; says how to install it."""

    def __init__(self, need: str, *, extra: str, package: str, reason: object = None) -> None:
        """Say who needs the package and how to install it.

        Args:
            need: who needs it, such as "Movie".
            extra: a name of `EXTRAS`.
            package: that is missing.
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
        """Pickle the name, too, which ImportError does not keep among its attributes."""
        return _missing_extra, (self.args, self.name, self.extra)


def _missing_extra(args: tuple[Any, ...], package: str, extra: str) -> MissingExtraError:
    error = MissingExtraError.__new__(MissingExtraError, *args)
    error.args, error.name, error.extra = args, package, extra
    return error


class MotesWarning(UserWarning):
    """Something that runs, but is probably not what the script means."""


def near(name: object, known: Iterable[str]) -> str:
    """Suggest the known name that is nearest: "; did you mean 'velocity'?", or nothing."""
    if not isinstance(name, str) or name.startswith("__"):  # Python asks each module for `__path__`
        return ""
    import difflib

    names = list(known)
    meant = [one for one in _MEANT.get(name, ()) if one.partition("=")[0] in names]
    found = meant or difflib.get_close_matches(name, names, n=1)
    return f"; did you mean {found[0]!r}?" if found else ""


_MEANT = {
    **{"fps": ("dt=1/fps",), "frame_rate": ("dt=1/frame_rate",), "timestep": ("dt",), "time_step": ("dt",)},
    **{"size": ("pixels", "radius"), "diameter": ("pixels",), "width": ("pixels",), "texture": ("image",)},
    **{"colour": ("color",), "opacity": ("alpha",), "steps": ("substeps",), "bounds": ("space",)},
    **{"pos": ("position",), "vel": ("velocity",), "target": ("look_at",), "fov": ("fov_deg",)},
    **{"resolution": ("width",), "bg": ("background",), "n": ("count",), "number": ("count",)},
}
"""What scripts that were written for other programs say -> what may be meant, where it is known."""


def missing(owner: str, name: str, known: Iterable[str]) -> AttributeError:
    """Make the error for an attribute that does not exist, with the nearest one that does."""
    # With `name` given, Python itself adds no suggestion of its own.
    return AttributeError(f"{owner} has no attribute {name!r}{near(name, known)}", name=name, obj=None)


def argument_error(text: str, argument: str = "", value: str = "", allowed: str = "") -> ArgumentError:
    """Make the error of the engine's sentence and its parts; one about several values has none."""
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
    except Exception:  # of a user's class; of an int of more digits than Python shows
        text = f"a value of type {type(value).__name__}"
    return text if len(text) <= limit else text[: limit - 3] + "..."
