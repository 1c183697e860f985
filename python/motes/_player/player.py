"""Player: a run in the background of a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .._values import arguments

if TYPE_CHECKING:
    from .plays import Play

__all__ = ["Player"]


class Player:
    """A run in the background of a notebook. `motes.show` and `motes.launch` return one.

    In a notebook it is a widget: the picture, which the mouse orbits; buttons to pause, step and stop; and
    the world's controls. Elsewhere a browser shows it at `url`.
    """

    _play: Play

    def __init__(self, play: Play) -> None:
        """Take the run to play; `motes.show` and `motes.launch` make players.

        Args:
            play: a loop in a thread, or a job.
        """
        self._play = play

    @property
    def running(self) -> bool:
        """Whether the run has not ended yet."""
        return not self._play.wait(0)

    @property
    def url(self) -> str | None:
        """The run's page for a browser on this machine; None before it has begun and after its end."""
        return self._play.url if self.running else None

    @property
    def output(self) -> list[str]:
        """The last lines that the ranks of `motes.launch` have printed, oldest first."""
        return self._play.output()

    def stop(self) -> None:
        """Ask the run to end at the next border between two frames; returns at once.

        A second call terminates a launched run.
        """
        self._play.stop()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the run's end. An interrupt asks the run to stop, and is raised once it has.

        Args:
            timeout: in seconds; None: no limit.

        Returns:
            Whether the run has ended.
        """
        seconds = None if timeout is None else arguments.number("timeout", timeout, low=0)
        try:
            return self._play.wait(seconds)
        except KeyboardInterrupt:
            self._play.stop()
            self._play.wait(None)
            raise

    def result(self) -> Any:
        """Wait for the run's end, and return the result of its loop, or raise its error.

        Returns:
            The loop's result; None for a launched run.

        Raises:
            MotesError: if a launched run has failed, with the last lines of its output.
        """
        self.wait()
        return self._play.result()

    def __repr__(self) -> str:
        """Name the run and its state."""
        return f"<Player of {self._play.title!r}, {'running' if self.running else self._play.ending}>"
